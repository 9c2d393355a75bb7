"""Sections of the page of a sheet."""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from gcm_learn.evaluation import measures
from gcm_learn.evaluation.conditions import OWN
from gcm_learn.evaluation.judging import movement_of
from gcm_learn.evaluation.measures import BUDGETS_MS, cell
from gcm_learn.evaluation.sheet import OUTCOMES, Sheet
from gcm_learn.evaluation.statistics import wilson
from gcm_learn.evaluation.suites import SHIPPED
from gcm_learn.plots import MissedCatch, failure_figure, pages, sheet_figures as figures
from gcm_learn.situation import situation_from_json

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WORDS = pages.words("sheet")
FAILURES = 6  # that are drawn
REASONS = 20  # of broken promises and errors that are listed
STRATA = ("L", "W", "Q", "U", "open", "")


class SectionPart(NamedTuple):
    """Content of a section."""

    tables: Sequence[pages.PageTable] = ()
    pictures: Sequence[pages.Picture] = ()


@dataclass(frozen=True)
class SheetView:
    """A sheet with the settings of its page: reference, folder and marked entrants."""

    sheet: Sheet
    reference: str
    out: Path
    marked: Sequence[str]

    @cached_property
    def plain(self) -> Sheet:
        """Rows under the first condition."""
        first = {name: self.sheet.each(name)[0] for name in measures.UNDER}
        return self.sheet.where(**first)

    @cached_property
    def names(self) -> list[str]:
        """Entrants, in order of appearance."""
        return self.sheet.each("entrant")

    @cached_property
    def colours(self) -> dict[str, Any]:
        """Colours of entrants."""
        return figures.colours_of(self.names)

    def panels(self, sheet: Sheet) -> Iterator[tuple[str, Sheet]]:
        """Yield heading and reachable rows of each suite or, of a single suite, of each stratum."""
        there = sheet.reachable
        by = "suite" if len(there.each("suite")) > 1 else "stratum"
        names = _in_order(there) if by == "stratum" else there.each(by)
        for name in names:
            part = there.where(**{by: name})
            count = len(set(part["key"].tolist()))
            told = figures.STRATA.get(name, name or there.each("suite")[0])
            yield f"{told} ({count})", part

    def drawn(self, name: str, figure: Figure, about: str = "") -> pages.Picture:
        """Return a figure as a picture within the page, with the caption stored under `name`."""
        caption = WORDS["captions"][name].format(about=about, reference=self.reference)
        return pages.picture_within(figure, caption)


def _in_order(sheet: Sheet) -> list[Any]:
    """Return the strata of a sheet in the order of `STRATA`; a user's own come last."""
    order = {stratum: place for place, stratum in enumerate(STRATA)}
    return sorted(sheet.each("stratum"), key=lambda stratum: order.get(stratum, len(order)))


def opening(view: SheetView) -> list[pages.Picture]:
    """Return shares of catches, a picture for each panel."""
    return [
        view.drawn("caught", figures.spans_figure(heading, "caught [%]", spans, view.colours))
        for heading, part in view.panels(view.plain)
        if (spans := _spans(part))
    ] or [view.drawn("outcomes", figures.outcomes_figure("all", _outcomes(view.plain)))]


def _spans(part: Sheet) -> dict[str, Any]:
    """Return each entrant's share of catches with its interval."""
    found = measures.shares(part, "entrant")
    return dict(zip(found["entrant"], found["caught [%]"], strict=True))


def _outcomes(part: Sheet) -> dict[str, dict[str, float]]:
    """Return each entrant's shares of outcomes."""
    return {
        name: {word: float(np.mean(mine["outcome"] == word)) for word in OUTCOMES}
        for (name,), mine in measures.groups(part, ("entrant",))
    }


def _table(found: measures.Table, fold: str = "") -> pages.PageTable:
    return pages.PageTable(found.columns, found.text(), fold)


def _who(view: SheetView) -> SectionPart:
    """Return a table of the entrants with a summary of each."""
    rows = [[name, view.sheet.entrants.get(name, "")] for name in view.names]
    return SectionPart([pages.PageTable(("entrant", "what it does"), rows)])


def _standings(view: SheetView) -> SectionPart:
    """A table for each suite, the best first."""
    budgets = tuple(f"in {budget:g} ms [%]" for budget in BUDGETS_MS)
    columns = (
        "entrant", "situations", "caught [%]", *budgets, "median [ms]", "time / earliest",
        "targets [%]", "broken", "errors", "touched", "nodes",
    )  # fmt: skip
    tables, cards = [], []
    for (suite,), part in measures.groups(view.plain.reachable, ("suite",)):
        late, spans = measures.ratios(part), _spans(part)
        rows = []
        for name in sorted(spans, key=lambda n: (-_targets(part.where(entrant=n)), n)):
            mine = part.where(entrant=name)
            times, faults = mine["ms"] * mine["factor"], Counter(mine["outcome"].tolist())
            several = bool((mine["wanted"] > 1).any())
            values = (
                name, len(mine), spans[name], *measures.within(mine),
                measures.quantile(times, 0.5), late[name],
                _targets(mine) if several else math.nan, faults["broken"], faults["error"],
                faults["touched"], float(mine["nodes"].mean()) or math.nan,
            )  # fmt: skip
            rows.append([cell(*pair) for pair in zip(columns, values, strict=True)])
        told = "" if len(view.plain.each("suite")) == 1 else suite
        tables.append(pages.PageTable((told or columns[0], *columns[1:]), rows))
        if suite in SHIPPED:
            known = SHIPPED[suite]
            cards.append([f"{suite}, version {known.version}", f"{known.card} {known.licence}."])
    if cards:
        tables.append(pages.PageTable(("suite", "card"), cards, "Suites"))
    pictures = [view.drawn("outcomes", figures.outcomes_figure("all", _outcomes(view.plain)))]
    pictures += [
        view.drawn("budget", figures.times_figure(heading, curves, view.colours, view.marked))
        for heading, part in view.panels(view.plain)
        if (curves := _curves(part))
    ]
    return SectionPart(tables, pictures)


def _targets(mine: Sheet) -> float:
    """Return the share of wanted targets that are caught."""
    return float((mine["targets"] * mine.caught).sum() / max(mine["wanted"].sum(), 1))


def _curves(part: Sheet) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    return {n: measures.curve(mine) for (n,), mine in measures.groups(part, ("entrant",))}


def _strata(view: SheetView) -> SectionPart:
    """Right answers by stratum, where strata are known."""
    strata = _in_order(view.plain)
    if strata == [""]:
        return SectionPart()
    headings = [f"{s or 'unknown'}{' declined' * (s == 'U')} [%]" for s in strata]
    rows = []
    for name in view.names:
        mine = [view.plain.where(entrant=name, stratum=stratum) for stratum in strata]
        spans = [wilson(int(measures.right_of(part).sum()), len(part)) for part in mine]
        rows.append([name, *(cell("[%]", span) for span in spans)])
    return SectionPart([pages.PageTable(("entrant", *headings), rows)])


def _paired(view: SheetView) -> SectionPart:
    """Differences to the reference, by suite and by stratum."""
    if len(view.names) < 2 or not len(view.plain.reachable):
        return SectionPart()
    tables = [_table(measures.pairs(view.plain, view.reference, "suite"))]
    if len(view.plain.reachable.each("stratum")) > 1:
        found = measures.pairs(view.plain, view.reference, ("suite", "stratum"))
        tables.append(_table(found, "By stratum"))
    pictures = []
    for heading, part in view.panels(view.plain):
        found = measures.pairs(part, view.reference)
        names = [pair.partition(" – ")[0] for pair in found["pair"]]
        spans = dict(zip(names, found["difference [points]"], strict=True))
        if spans:
            label = f"points against {view.reference}"
            drawn = figures.spans_figure(heading, label, spans, view.colours)
            pictures.append(view.drawn("pairs", drawn))
    return SectionPart(tables, pictures)


def _thinking(view: SheetView) -> SectionPart:
    """Return shares of catches by charged thinking time; empty if only one time was measured."""
    sheet = view.sheet.where(noise=0.0)
    if len(sheet.each("thinking")) < 2:
        return SectionPart()
    pictures = []
    for heading, part in view.panels(sheet):
        lines, stars = {}, {}
        for (name,), mine in measures.groups(part, ("entrant",)):
            fixed = mine.where(mine["thinking"] != OWN)
            lines[name] = _line(fixed, "charged", 1e3)
            own = mine.where(thinking=OWN)
            if len(own):
                place = 1e3 * float(np.median(own["charged"]))
                stars[name] = (place, float(own.caught.mean()))
        drawn = figures.lines_figure(heading, "thinking [ms]", lines, view.colours, stars)
        pictures.append(view.drawn("thinking", drawn))
    return SectionPart([_across(sheet, "thinking")], pictures)


def _line(mine: Sheet, column: str, scale: float) -> tuple[list[float], list[Any]]:
    """Return values of a condition and shares of catches there."""
    values = sorted(mine.each(column))
    there = [mine.where(**{column: value}) for value in values]
    return [scale * value for value in values], [wilson(int(p.caught.sum()), len(p)) for p in there]


def _across(sheet: Sheet, column: str) -> pages.PageTable:
    """Return shares of catches, a column for each value of a condition."""
    found = measures.shares(sheet, ("suite", "entrant", column))
    cells = {row[:3]: cell("[%]", row[found.columns.index("caught [%]")]) for row in found.rows}
    values = sheet.each(column)
    rows = [
        [entrant, suite, *(cells.get((suite, entrant, value), "–") for value in values)]
        for suite, entrant in dict.fromkeys((row[0], row[1]) for row in found.rows)
    ]
    return pages.PageTable(("entrant, caught [%]", "suite", *map(str, values)), rows)


def _noise(view: SheetView) -> SectionPart:
    """Return shares of catches by noise of perception; empty if no noise was measured."""
    sheet = view.sheet.where(thinking=view.sheet.each("thinking")[0])
    if not sheet["noise"].any():
        return SectionPart()
    pictures = []
    for heading, part in view.panels(sheet):
        lines = {n: _line(m, "noise", 1.0) for (n,), m in measures.groups(part, ("entrant",))}
        drawn = figures.lines_figure(heading, "deviation [forearms]", lines, view.colours)
        pictures.append(view.drawn("noise", drawn))
    return SectionPart([_across(sheet, "noise")], pictures)


SPREADS = {
    "ms": ("thinking", "processor time [ms]"),
    "catch_time": ("catches", "catch time [s]"),
    "path": ("catches", "path of the hand [forearms]"),
    "clearance": ("catches", "least clearance [forearms]"),
    "peak_joint": ("catches", "fastest joint [rad/s]"),
}


def _times(view: SheetView) -> SectionPart:
    """Spreads of times and movements."""
    pictures, rows = [], []
    for column, (heading, label) in SPREADS.items():
        values = {}
        for (name,), mine in measures.groups(view.plain.reachable, ("entrant",)):
            found = mine["ms"] * mine["factor"] if column == "ms" else mine[column][mine.caught]
            values[name] = found[np.isfinite(found) & (found > 0.0)]
        if any(len(found) for found in values.values()):
            drawn = figures.spread_figure(heading, label, values, view.colours)
            pictures.append(view.drawn("spread", drawn, f"{label}.".capitalize()))
            medians = {n: measures.quantile(found, 0.5) for n, found in values.items()}
            rows.append([label, *(cell("", medians.get(name)) for name in view.names)])
    listed = pages.PageTable(("median", *view.names), rows, "All medians")
    return SectionPart([listed] if rows else (), pictures)


def _families(view: SheetView) -> SectionPart:
    """Shares of catches by family."""
    there = view.plain.reachable
    families = [name for name in sorted(there.each("family")) if name]
    if len(families) < 2:
        return SectionPart()
    shares = np.full((len(families), len(view.names)), np.nan)
    for (family, name), mine in measures.groups(there, ("family", "entrant")):
        if family:
            shares[families.index(family), view.names.index(name)] = mine.caught.mean()
    counts = Counter(there.where(entrant=view.reference)["family"].tolist())
    told = [f"{name} ({counts[name]})" for name in families]
    drawn = figures.shares_figure("caught [%]", told, view.names, shares)
    return SectionPart(pictures=[view.drawn("families", drawn)])


def _failures(view: SheetView) -> SectionPart:
    """Reasons of broken promises and errors, and pictures of touches and misses."""
    faulty = view.sheet.where(outcome=("broken", "error"))
    columns = [faulty[name].tolist() for name in ("entrant", "outcome", "reason")]
    found = Counter(zip(*columns, strict=True)).most_common(REASONS)
    rows = [[*words, str(count)] for words, count in found]
    columns_of = ("entrant", "outcome", "reason", "situations")
    tables = [pages.PageTable(columns_of, rows)] if rows else []
    return SectionPart(tables, [_failure(view, k) for k in _shown(view.plain)])


def _shown(plain: Sheet) -> list[int]:
    """Return rows of failures: touches first, entrants in turns, new families first."""
    lost = np.flatnonzero(~plain.caught & (plain["stratum"] != "U")).tolist()
    lost.sort(key=lambda k: plain["outcome"][k] != "touched")
    chosen: list[int] = []
    while lost and len(chosen) < FAILURES:
        seen = Counter(plain[n][k] for k in chosen for n in ("entrant", "family", "key"))
        best = min(lost, key=lambda k: sum(seen[plain[n][k]] for n in ("entrant", "family", "key")))
        lost.remove(best)
        chosen.append(best)
    return chosen


def _failure(view: SheetView, k: int) -> pages.Picture:
    """Return the picture of a row, with the movement of another that catches."""
    plain = view.plain
    situation = situation_from_json(json.loads(plain["situation"][k]))
    here = plain.where((plain["key"] == plain["key"][k]) & plain.caught)
    example = movement_of(situation, here["solution"][0]) if len(here) else None
    outcome, name = plain["outcome"][k], plain["entrant"][k]
    moves = movement_of(situation, plain["solution"][k]) if outcome == "touched" else None
    about = ", ".join(filter(None, (plain["family"][k], plain["stratum"][k])))
    drawn = failure_figure(MissedCatch(name, about, situation, outcome, moves, example))
    better = f"; {here['entrant'][0]} catches" if len(here) else ""
    part = f" with the {plain['part'][k]}" if plain["part"][k] else ""
    told = f"{name} in {plain['name'][k]}: {outcome.replace('_', ' ')}{part}{better}."
    return view.drawn("failure", drawn, told)


def _machines(view: SheetView) -> SectionPart:
    """Conditions of all rows, and machines of all runs."""
    under = [
        [f"{t}", f"{n:g}", f"{s:g} s", f"{len(part):,}"]
        for (t, n, s), part in measures.groups(view.sheet, ("thinking", "noise", "limit"))
    ]
    rows = [
        [
            ", ".join(run["entrants"]), f"{run['calibration']['factor']:.3f}",
            str(run["package"]), str(run["protocol"]),
            *(str(run["machine"].get(name, "–")) for name in ("processor", "system", "python")),
        ]
        for run in view.sheet.runs
    ]  # fmt: skip
    told = ("entrants", "factor", "package", "protocol", "processor", "system", "Python")
    conditions = pages.PageTable(("thinking", "deviation [forearms]", "limit", "rows"), under)
    return SectionPart([conditions, pages.PageTable(told, rows)])


SECTIONS: Sequence[tuple[str, Callable[[SheetView], SectionPart]]] = (
    ("standings", _standings),
    ("who", _who),
    ("strata", _strata),
    ("pairs", _paired),
    ("thinking", _thinking),
    ("noise", _noise),
    ("families", _families),
    ("times", _times),
    ("failures", _failures),
    ("machines", _machines),
)
"""Sections of the page, in their order; one without tables and pictures is left out."""
