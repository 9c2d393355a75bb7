"""The leaderboard: result files of the benchmark on one page."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from gcm_learn.benchmark import (
    BUDGETS_MS,
    SUITES,
    Loaded,
    Standing,
    asks_for_several,
    load_suite,
    runs_by_suite,
    standings,
)
from gcm_learn.errors import SuiteError
from gcm_learn.evaluation import chance
from gcm_learn.planners import is_registered
from gcm_learn.plots.figures.standings import standings_figure
from gcm_learn.plots.reports.page import (
    Section,
    Table,
    number,
    picture_of,
    render,
    section,
    words,
)
from gcm_learn.plots.reports.tables import percent

WORDS = words("leaderboard")
BUDGETS = tuple(f"in {budget:g} ms [%]" for budget in BUDGETS_MS)
COLUMNS = (
    "method", "caught [%]", *BUDGETS, "median time [ms]", "catch time / earliest",
    "broken promises", "errors", "nodes", "p to the first",
)  # fmt: skip


def write_leaderboard(
    results: Sequence[Mapping[str, Any]],
    out: Path,
    given: Sequence[Loaded] = (),
    marked: Sequence[str] = (),
) -> None:
    """Judge all answers again and write the page.

    Parameters
    ----------
    results : sequence of mapping
        Values of result files.
    out : Path
        The page; it needs no other file.
    given : sequence of Loaded
        Files of situations that results name and the package does not ship.
    marked : sequence of str
        Methods that the figure stresses.

    Raises
    ------
    SuiteError
        If a suite is missing, or a result has other situations.
    """
    runs = runs_by_suite(results)
    order = sorted(runs, key=lambda name: (list(SUITES) + [name]).index(name))
    suites = {name: _suite(name, given) for name in order}
    found = {name: standings(suites[name], runs[name]) for name in order}
    with TemporaryDirectory() as folder:
        drawn = standings_figure(found, marked)
        opening = picture_of(drawn, Path(folder, "p.png"), WORDS["caption"], embed=True)
    parts = [_section(suites[name], found[name]) for name in order]
    parts += [section(WORDS, "protocol"), section(WORDS, "machines", [_machines(results)])]
    answers = sum(one.answers for methods in found.values() for one in methods)
    told = {
        "results": _several(len(results), "result file"),
        "suites": _several(len(order), "suite"),
        "answers": f"{answers:,}",
    }
    lead = [text.format(**told) for text in WORDS["lead"]]
    out.write_text(render(WORDS["title"], lead, opening, (), parts), "utf-8")


def _several(count: int, noun: str) -> str:
    """Return a number and a noun."""
    return f"{count} {noun}{'s' * (count != 1)}"


def _suite(name: str, given: Sequence[Loaded]) -> Loaded:
    """Return a suite of the package, or one of the given files."""
    for suite in given:
        if suite.name == name:
            return suite
    if name not in SUITES:
        raise SuiteError(f"suite {name!r}: is not shipped; give its file with --suite")
    return load_suite(name)


def _section(suite: Loaded, methods: Sequence[Standing]) -> Section:
    """Return the card of a suite, its methods, and their catches by stratum."""
    known = SUITES.get(suite.name)
    heading = suite.name if known is None else f"{suite.name}, version {suite.version}"
    told = f"{len(suite.cases)} situations, hash `{suite.sha256[:16]}`."
    card = told if known is None else f"{known.card} {told} Licence: {known.licence}."
    tables = [Table(COLUMNS, [_row(one) for one in methods])]
    if asks_for_several(suite):
        rows = [[one.method, f"{100 * one.targets:.1f}"] for one in methods]
        tables.append(Table(("method", "targets caught [%]"), rows))
    if set(methods[0].strata) != {""}:
        tables.append(_strata(methods))
    return Section(suite.name, heading, [card], tables)


def _row(one: Standing) -> list[str]:
    nodes = f"{one.nodes:,.0f}" if is_registered(one.method) else "–"
    p = "–" if math.isnan(one.p) else chance(one.p)
    return [
        one.method, percent(one.caught), *(f"{100 * share:.0f}" for share in one.within),
        number(one.median_ms, ".1f"), number(one.ratio, ".3f"), str(one.broken), str(one.errors),
        nodes, p,
    ]  # fmt: skip


def _strata(methods: Sequence[Standing]) -> Table:
    columns = [name if name != "U" else "U, rightly declined" for name in methods[0].strata]
    rows = [[m.method, *(f"{hit} of {n}" for hit, n in m.strata.values())] for m in methods]
    return Table(("method", *columns), rows, "By stratum")


def _machines(results: Sequence[Mapping[str, Any]]) -> Table:
    columns = ("method", "package", "processor", "system", "Python", "factor")
    rows = [
        [
            str(r["method"]), str(r["package"]),
            *(str(r["machine"].get(key, "–")) for key in ("processor", "system", "python")),
            f"{r['calibration']['factor']:.3f}",
        ]
        for r in results
    ]  # fmt: skip
    return Table(columns, rows)
