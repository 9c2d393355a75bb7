"""Comparison of methods: one sheet of their answers to situations, judged by the referee.

>>> from gcm_learn.evaluation import Condition, ask, cases, page, pairs, shares
>>> sheet = ask(["search", "recall"], cases("gate", count=50), keep="out")  # doctest: +SKIP
>>> print(shares(sheet, "entrant"))                                        # doctest: +SKIP
>>> page(sheet, "out")                                                     # doctest: +SKIP
"""

from typing import TYPE_CHECKING

from gcm_learn import late

if TYPE_CHECKING:
    from gcm_learn.evaluation.asking import ask as ask, asked_for as asked_for
    from gcm_learn.evaluation.calibration import Calibration as Calibration, calibrate as calibrate
    from gcm_learn.evaluation.conditions import Condition as Condition, after as after
    from gcm_learn.evaluation.entrants import (
        ActorMethod as ActorMethod,
        Entrant as Entrant,
        get_method as get_method,
    )
    from gcm_learn.evaluation.judging import (
        complaints as complaints,
        judged_again as judged_again,
        read_sheets as read_sheets,
    )
    from gcm_learn.evaluation.machine import passes as passes
    from gcm_learn.evaluation.measures import (
        Table as Table,
        mark_late as mark_late,
        pairs as pairs,
        shares as shares,
    )
    from gcm_learn.evaluation.report import page as page
    from gcm_learn.evaluation.sheet import Sheet as Sheet
    from gcm_learn.evaluation.sources import (
        Case as Case,
        cases as cases,
        check_sources as check_sources,
        suite_lines as suite_lines,
    )
    from gcm_learn.evaluation.statistics import (
        Interval as Interval,
        chance as chance,
        difference as difference,
        hierarchical as hierarchical,
        holm as holm,
        mcnemar as mcnemar,
        wilson as wilson,
    )
    from gcm_learn.evaluation.suites import (
        FROZEN as FROZEN,
        SHIPPED as SHIPPED,
        draw_suite as draw_suite,
        hash_of as hash_of,
    )

# Loaded when they are asked for, so that wrong arguments are refused soon.
__getattr__ = late.late_names(__name__, {
    "asking": ("ask", "asked_for",),
    "calibration": ("Calibration", "calibrate",),
    "sources": ("Case", "cases", "check_sources", "suite_lines",),
    "conditions": ("Condition", "after",),
    "entrants": ("ActorMethod", "Entrant", "get_method",),
    "judging": ("complaints", "judged_again", "read_sheets",),
    "machine": ("passes",),
    "measures": ("Table", "pairs", "mark_late", "shares",),
    "report": ("page",),
    "sheet": ("Sheet",),
    "statistics": ("Interval", "chance", "difference", "hierarchical",
        "holm", "mcnemar", "wilson",),
    "suites": ("FROZEN", "SHIPPED", "draw_suite", "hash_of",),
})  # fmt: skip
