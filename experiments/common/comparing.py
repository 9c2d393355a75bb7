"""Tables that are computed from outcomes: shares, paired differences and quantiles."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from experiments.common.outcomes import Outcomes
from experiments.common.tables import percent, points, table
from gcm_learn.evaluation import chance, difference, holm, mcnemar, stratified, wilson

COUNTS = ("checks", "looks", "bends")
STRATA = ("W", "Q")


def within(rows: Outcomes, checks: int | None = None) -> np.ndarray:
    """Mark the rows (n,) that are caught, with so many checks if a number is given."""
    caught = rows["caught"]
    return caught if checks is None else caught & (rows["checks"] <= checks)


def share(rows: Outcomes, digits: int = 0, checks: int | None = None) -> str:
    """Return the share that is caught with its interval within families [%].

    A bootstrap of equal outcomes has zero width; the interval is Wilson's then.
    """
    caught = within(rows, checks)
    if len(rows) == 0:
        return ""
    if caught.all() or not caught.any():
        return percent(wilson(int(caught.sum()), len(rows)), digits)
    return percent(stratified(caught, rows["family"]), digits)


def complaints(rows: Outcomes) -> str:
    """Return of how many catches the referee complains."""
    return f"{np.sum(rows['complaints'] > 0)} of {rows['caught'].sum()}"


def times(rows: Outcomes, shares: Sequence[float] = (0.5, 0.9)) -> list[str]:
    """Return quantiles of the processor time [ms]."""
    return [f"{np.quantile(rows['ms'], share):.1f}" for share in shares]


def counts(rows: Outcomes) -> list[str]:
    """Return mean numbers of checks, looks and bends of a situation, empty if not counted."""
    return [
        "" if np.isnan(rows[name]).all() else f"{np.nanmean(rows[name]):.1f}" for name in COUNTS
    ]


def pairs(found: Outcomes, asked: Sequence[tuple[str, str]]) -> str:
    """Compare methods on the situations that both answered, by the exact test and after Holm.

    Parameters
    ----------
    found : Outcomes
    asked : sequence of (str, str)
        Methods; Holm's correction is over all of these.
    """
    head = ["pair", "situations", "points", "only the first", "only the second", "p", "p (Holm)"]
    lines, chances = [], []
    for first, second in asked:
        one, other = found.by_situation((first, second))
        more, less, p = mcnemar(one["caught"], other["caught"])
        apart = points(difference(one["caught"], other["caught"], one["family"]))
        lines.append([f"{first} less {second}", str(len(one)), apart, str(more), str(less)])
        chances.append(p)
    corrected = zip(lines, chances, holm(chances), strict=True)
    return table(head, [[*line, chance(p), chance(q)] for line, p, q in corrected])
