"""One sheet of answers: whatever acts, on any situations, judged by the referee.

>>> from gcm_learn.evaluation import Condition, ask, cases, page, pairs, shares
>>> sheet = ask(["search", "recall"], cases("gate", count=50), keep="out")  # doctest: +SKIP
>>> print(shares(sheet, "entrant"))                                        # doctest: +SKIP
>>> page(sheet, "out")                                                     # doctest: +SKIP
"""

from typing import TYPE_CHECKING

from gcm_learn.late import late_names

if TYPE_CHECKING:
    from gcm_learn.evaluation.asking import ask, asked_for
    from gcm_learn.evaluation.conditions import Condition, after
    from gcm_learn.evaluation.entrants import ActorMethod, Entrant, get_method
    from gcm_learn.evaluation.judging import complaints, judged_again, read_sheets
    from gcm_learn.evaluation.machine import passes
    from gcm_learn.evaluation.measures import Table, pairs, ready, shares
    from gcm_learn.evaluation.report import page
    from gcm_learn.evaluation.sheet import Sheet
    from gcm_learn.evaluation.sources import Case, cases, check_sources, suite_lines
    from gcm_learn.evaluation.statistics import (
        Interval,
        beyond_chance,
        chance,
        difference,
        hierarchical,
        holm,
        mcnemar,
        stratified,
        wilson,
    )
    from gcm_learn.evaluation.suites import FROZEN, SHIPPED, draw_suite, hash_of

# Loaded when they are asked for, so that wrong arguments are refused soon.
__getattr__ = late_names(__name__, {
    "asking": ("ask", "asked_for",),
    "sources": ("Case", "cases", "check_sources", "suite_lines",),
    "conditions": ("Condition", "after",),
    "entrants": ("ActorMethod", "Entrant", "get_method",),
    "judging": ("complaints", "judged_again", "read_sheets",),
    "machine": ("passes",),
    "measures": ("Table", "pairs", "ready", "shares",),
    "report": ("page",),
    "sheet": ("Sheet",),
    "statistics": ("Interval", "beyond_chance", "chance", "difference", "hierarchical",
        "holm", "mcnemar", "stratified", "wilson",),
    "suites": ("FROZEN", "SHIPPED", "draw_suite", "hash_of",),
})  # fmt: skip

__all__ = [
    "ActorMethod", "after", "ask", "asked_for", "beyond_chance", "Case", "cases", "chance",
    "check_sources", "complaints", "Condition", "difference", "draw_suite", "Entrant",
    "FROZEN", "get_method", "hash_of", "hierarchical", "holm", "Interval", "judged_again",
    "mcnemar", "page", "pairs", "passes", "read_sheets", "ready", "shares", "Sheet", "SHIPPED",
    "stratified", "suite_lines", "Table", "wilson",
]  # fmt: skip
