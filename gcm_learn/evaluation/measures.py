"""Measures of a sheet: shares of outcomes, paired differences and times, grouped by columns."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np

from gcm_learn.errors import SuiteError
from gcm_learn.evaluation import statistics
from gcm_learn.evaluation.sheet import Sheet

BUDGETS_MS = (1.0, 10.0, 20.0, 100.0, 1000.0)
"""Processor times within which catches are counted [ms, calibrated]."""
UNDER = ("thinking", "noise")
"""Columns of conditions; rows under different conditions are never joined."""
SHARES = ("caught", "touched", "broken", "error")


@dataclass(frozen=True)
class Table:
    """Rows of values under names; as text a table in Markdown."""

    columns: Sequence[str]
    rows: Sequence[Sequence[Any]]

    def __getitem__(self, name: str) -> list[Any]:
        """Return the values of a column."""
        place = list(self.columns).index(name)
        return [row[place] for row in self.rows]

    def text(self) -> list[list[str]]:
        """Return the cells as text."""
        return [[cell(*pair) for pair in zip(self.columns, row, strict=True)] for row in self.rows]

    def __str__(self) -> str:
        lines = [list(self.columns), ["---"] * len(self.columns), *self.text()]
        return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def cell(name: str, value: Any) -> str:
    """Return a value as text; shares in per cent, differences in points."""
    if isinstance(value, str):
        return value
    if isinstance(value, statistics.Interval):
        if not math.isfinite(value.value):
            return "–"
        middle, low, high = (100.0 * one for one in value)
        if "points" in name:
            return f"{middle:+.1f} ({low:+.1f} to {high:+.1f})"
        return f"{middle:.1f} ({low:.0f}–{high:.0f})"
    if value is None or (isinstance(value, float) and not math.isfinite(value)):
        return "–"
    if isinstance(value, (int, np.integer)):
        return f"{value:,}"
    if name.startswith("p"):
        return statistics.chance(value)
    if "[%]" in name:
        return f"{100.0 * value:.1f}"
    return f"{value:.3g}" if abs(value) < 100.0 else f"{value:,.0f}"


def shares(sheet: Sheet, by: str | Sequence[str] = "entrant") -> Table:
    """Return shares of outcomes and processor times, grouped by columns of the sheet.

    Situations of stratum U count only where `by` has the stratum; there the first share is that of
    right refusals. Several seeds of an entrant give a hierarchical interval, one gives Wilson's.

    Parameters
    ----------
    sheet : Sheet
    by : str or sequence of str
        Columns of the sheet; conditions are told apart where there are several.

    Returns
    -------
    Table
        Columns of `by`, then situations, shares [%] and processor times [ms, calibrated].
    """
    names = (by,) if isinstance(by, str) else tuple(by)
    whole = sheet if "stratum" in names else sheet.reachable
    names = (*names, *_varied(whole, names))
    rows = [(*key, *_shares(part)) for key, part in groups(whole, names)]
    told = ("situations", *(f"{name} [%]" for name in SHARES), "median [ms]", "95 % [ms]")
    return Table((*names, *told), rows)


def _shares(part: Sheet) -> tuple[Any, ...]:
    outcome, times = part["outcome"].astype(str), part["ms"] * part["factor"]
    right = right_of(part)
    seeds = len(part.each("seed"))
    count = len(part) // seeds
    if seeds > 1:
        caught = statistics.hierarchical(right.reshape(seeds, count).astype(float))
    else:
        caught = statistics.wilson(int(right.sum()), len(part))
    others = (float(np.mean(outcome == name)) for name in SHARES[1:])
    return (count, caught, *others, *(quantile(times, share) for share in (0.5, 0.95)))


def right_of(part: Sheet) -> np.ndarray:
    """Return (n,) bool: True for catches, and for refusals where nothing can be caught."""
    refused = np.isin(part["outcome"].astype(str), ("declined", "start_blocked"))
    return np.where(part["stratum"] == "U", refused, part.caught)


def pairs(
    sheet: Sheet, against: str | Sequence[tuple[str, str]], by: str | Sequence[str] = ()
) -> Table:
    """Compare entrants on the same situations, by the exact test of McNemar.

    Where several targets are wanted, a situation counts for the entrant that catches more of them.

    Parameters
    ----------
    sheet : Sheet
    against : str or sequence of (str, str)
        Entrant with which all others are compared; or pairs, of each of which the second is
        subtracted from the first.
    by : str or sequence of str
        Columns by which situations are told apart.

    Returns
    -------
    Table
        Differences in points with 95 % intervals, and p after Holm over all rows.

    Raises
    ------
    SuiteError
        If two entrants have not answered the same situations.
    """
    names = (by,) if isinstance(by, str) else tuple(by)
    names = (*names, *_varied(sheet.reachable, names))
    if isinstance(against, str):
        asked = [(name, against) for name in sheet.each("entrant") if name != against]
    else:
        asked = list(against)
    rows = []
    for key, part in groups(sheet.reachable, names):
        for first, second in asked:
            mine, other = (part.where(entrant=name).paired() for name in (first, second))
            if not len(mine) or not len(other):
                continue
            rows.append((*key, f"{first} – {second}", *_pair(mine, other, first, second)))
    chances = statistics.holm([row[-1] for row in rows])
    told = ("situations", "difference [points]", "only first", "only second", "p", "p (Holm)")
    return Table((*names, "pair", *told), [(*row, p) for row, p in zip(rows, chances, strict=True)])


def _pair(mine: Sheet, other: Sheet, first: str, second: str) -> tuple[Any, ...]:
    """Return the number of situations, the difference, the situations won by each, and p."""
    same = len(mine) == len(other) and all(
        mine[name].tolist() == other[name].tolist() for name in ("suite", "key")
    )
    if not same:
        raise SuiteError(f"{first!r} and {second!r} have not answered the same situations")
    several = bool((mine["wanted"] > 1).any())
    a, b = (s["targets"] * s.caught if several else s.caught for s in (mine, other))
    more, less, p = statistics.mcnemar(a > b, b > a)
    seeds = len(mine.each("seed"))
    if seeds > 1:
        one, two = (part.caught.reshape(seeds, -1) for part in (mine, other))
        found = statistics.hierarchical(one.astype(float) - two)
        p = max(statistics.mcnemar(*rows)[2] for rows in zip(one, two, strict=True))  # of each seed
    elif several:
        found = statistics.difference(a / mine["wanted"], b / other["wanted"], mine["family"])
    else:
        found = statistics.difference(a, b, mine["family"])
    return len(mine) // seeds, found, more, less, p


def mark_late(sheet: Sheet) -> Sheet:
    """Return the sheet with outcome `late` for catches that took longer than the charged time."""
    late = sheet.caught & (sheet["charged"] > 0.0) & (sheet["ms"] > 1e3 * sheet["charged"])
    outcome = np.where(late & (sheet["thinking"] != "own"), "late", sheet["outcome"])
    return replace(sheet, columns={**sheet.columns, "outcome": outcome.astype(object)})


def curve(part: Sheet) -> tuple[np.ndarray, np.ndarray]:
    """Return processor times of catches [ms, calibrated], and shares caught by then."""
    times = np.sort((part["ms"] * part["factor"])[part.caught])
    return times, np.arange(1, len(times) + 1) / max(len(part), 1)


def within(part: Sheet) -> list[float]:
    """Return the shares that are caught within `BUDGETS_MS`."""
    times, _ = curve(part)
    return [float((times <= budget).sum() / max(len(part), 1)) for budget in BUDGETS_MS]


def ratios(sheet: Sheet) -> dict[str, float]:
    """Return each entrant's mean ratio of catch time to earliest known catch time.

    The earliest is the yardstick's, or that of all entrants; NaN where several targets are wanted,
    since a later catch may then be one more. Beside a catch at t = 0 only another one counts.
    """
    best: dict[Any, float] = {}
    keys = list(zip(sheet["suite"], sheet["key"], strict=True))
    for key, time, known in zip(keys, sheet["catch_time"], sheet["earliest"], strict=True):
        best[key] = np.fmin(best.get(key, np.inf), np.fmin(time, known))
    found: dict[str, list[float]] = {name: [] for name in sheet.each("entrant")}
    rows = zip(
        keys, sheet["entrant"], sheet["catch_time"], sheet["wanted"], sheet.caught, strict=True
    )
    for key, name, time, wanted, caught in rows:
        first = best[key]
        if caught and wanted == 1 and (first > 0.0 or time == first):
            found[name].append(1.0 if time == first else time / first)
    return {name: float(np.mean(r)) if r else math.nan for name, r in found.items()}


def best_of(sheet: Sheet) -> str:
    """Return the entrant that catches most targets in reachable situations, the first of equals."""
    whole = sheet.reachable if len(sheet.reachable) else sheet
    counts = {n: int(whole.where(entrant=n)["targets"].sum()) for n in sheet.each("entrant")}
    return max(counts, key=lambda name: counts[name])


def groups(sheet: Sheet, by: Sequence[str]) -> Iterator[tuple[tuple[Any, ...], Sheet]]:
    """Yield the values of columns that occur together, in order of appearance, and their rows."""
    for key in product(*(sheet.each(name) for name in by)):
        part = sheet.where(**dict(zip(by, key, strict=True)))
        if len(part):
            yield key, part.paired()


def _varied(sheet: Sheet, but: Sequence[str]) -> tuple[str, ...]:
    """Return the columns of conditions that have several values."""
    return tuple(name for name in UNDER if name not in but and len(sheet.each(name)) > 1)


def quantile(values: np.ndarray, share: float) -> float:
    """Return a quantile of the finite values, NaN without any."""
    finite = values[np.isfinite(values)]
    return float(np.quantile(finite, share)) if len(finite) else math.nan
