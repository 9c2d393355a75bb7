"""Tables of a comparison, as rows of text."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from gcm_learn.evaluation import (
    DELAYS,
    Cost,
    Interval,
    Measures,
    Results,
    beyond_chance,
    chance,
    charged_curve,
    costs_of,
    declines,
    measured,
    pairs,
    under_noise,
)
from gcm_learn.planners import FAULTS
from gcm_learn.plots.figures.comparison import catchable_strata, of_stratum, reachable
from gcm_learn.plots.reports.page import Table, number

STRATA = {
    "L": "a straight line works",
    "W": "a detour is needed",
    "Q": "waiting is needed",
    "U": "no catch is possible",
}
MOST_REASONS = 20  # that are listed
MEASURES = (
    "method", "caught [%]", "touched by forearm [%]", "by upper arm [%]", "time / oracle",
    "path [forearms]", "clearance [forearms]", "peak hand [forearms/s]", "peak joint [rad/s]",
    "latency [ms]", "latency, 95 % [ms]", "broken promises [%]", "errors [%]",
)  # fmt: skip


def percent(interval: Interval | None) -> str:
    """A share with its interval, in per cent."""
    if interval is None or not np.isfinite(interval.value):
        return "–"
    low, high = 100 * interval.low, 100 * interval.high
    return f"{100 * interval.value:.1f}\u00a0({low:.0f}–\u2060{high:.0f})"  # unbroken


def measures_table(results: Results, fold: str = "") -> Table:
    """Everything that is measured, a row for each method."""
    rows = [_row(measured(results, name)) for name in results.methods]
    return Table(MEASURES, rows, fold)


def _row(m: Measures) -> list[str]:
    return [
        m.method, percent(m.caught), number(100 * m.forearm, ".1f"),
        number(100 * m.upper_arm, ".1f"), number(m.ratio, ".3f"), number(m.length),
        number(m.clearance, ".3f"), number(m.peak_hand), number(m.peak_joint, ".0f"),
        number(m.latency, ".1f"), number(m.latency_95, ".1f"), number(100 * m.broken, ".1f"),
        number(100 * m.errors, ".1f"),
    ]  # fmt: skip


def strata_table(results: Results) -> Table:
    """Catches by stratum, and what is declined of the unreachable."""
    strata = catchable_strata(results)
    with_u = "U" in results.strata
    rows = []
    for name in results.methods:
        cells = [percent(measured(of_stratum(results, s), name).caught) for s in strata]
        rows.append([name, *cells, *([percent(declines(results, name))] if with_u else [])])
    headings = [f"{s} caught [%]" for s in strata] + ["U declined [%]"] * with_u
    return Table(("method", *headings), rows)


def faults_table(results: Results) -> Table | None:
    """Reasons of broken promises and errors, by method; None without any."""
    if "reason" not in results.columns:  # of an older comparison
        return None
    faulty = results.where(np.isin(results["outcome"].astype(str), FAULTS))
    found = Counter(
        (str(name), str(outcome), str(reason))
        for name, outcome, reason in zip(
            faulty["entrant"], faulty["outcome"], faulty["reason"], strict=True
        )
    )
    rows = [[*words, str(count)] for words, count in found.most_common(MOST_REASONS)]
    return Table(("method", "outcome", "reason", "situations"), rows) if rows else None


def by_stratum(results: Results) -> list[Table]:
    """Everything measured in each stratum, folded."""
    return [_folded(of_stratum(results, s), f"{s}: {STRATA[s]}") for s in results.strata]


def by_family(results: Results) -> list[Table]:
    """Everything measured in each family's reachable situations, folded."""
    there = reachable(results)
    return [_folded(there.where(there["family"] == name), name) for name in there.families]


def _folded(results: Results, heading: str) -> Table:
    count = len(results.of_method(results.methods[0]))
    return measures_table(results, f"{heading} ({count} situation{'s' * (count != 1)})")


def pairs_table(results: Results, reference: str, fold: str = "") -> Table:
    """Each method against one of them."""
    columns = ("method", "difference [points]", "95 %", "only it", f"only {reference}", "p",
               "beyond chance")  # fmt: skip
    rows = []
    for pair in pairs(results, reference):
        d = pair.difference
        p = chance(pair.p)
        span = f"{100 * d.low:+.1f} to {100 * d.high:+.1f}"
        more = f"{100 * d.value:+.1f}"
        rows.append([pair.first, more, span, str(pair.only_first), str(pair.only_second), p,
                     beyond_chance(d, pair.p)])  # fmt: skip
    return Table(columns, rows, fold)


def charged_table(results: Results, fold: str = "") -> Table:
    """Catches over charged time, and with the own latency charged."""
    delays = [f"{1e3 * delay:.0f} ms" for delay in DELAYS]
    rows = []
    for name in results.methods:
        curve = [percent(point) for point in charged_curve(results, name)] or ["–"] * len(DELAYS)
        mine = measured(results, name)
        rows.append([name, *curve, percent(mine.own), str(mine.charged)])
    return Table(("method, caught [%]", *delays, "own latency", "situations"), rows, fold)


def noise_table(noise: Results) -> Table:
    """Catches under inexact perception."""
    rows = [
        [b.method, f"{b.noise:g}", b.way if b.noise else "exact", percent(b.caught),
         number(100 * b.collisions, ".1f"), number(100 * b.lost, ".1f")]
        for b in under_noise(noise)
    ]  # fmt: skip
    columns = (
        "method", "deviation [forearms]", "plans", "caught [%]", "touched [%]", "lost [points]",
    )  # fmt: skip
    return Table(columns, rows, "All numbers")


def costs_table(names: Sequence[str]) -> Table | None:
    """Stored data of methods and the cost of making it; None without any.

    Steps are those in the arena.
    """
    found = costs_of(names)
    if not found:
        return None
    columns = ("method", "holds", "files [MB]", "learned from", "training [min]")
    rows = [
        [", ".join(c.methods), _holds(c), number(c.size and c.size / 1e6), _learned(c),
         number(c.minutes, ".0f")]
        for c in found
    ]  # fmt: skip
    return Table(columns, rows)


def _holds(cost: Cost) -> str:
    if cost.memories is not None:
        return f"{cost.memories:,} catches"
    return f"{cost.weights:,} weights"


def _learned(cost: Cost) -> str:
    parts = []
    if cost.situations:
        kind = "situations" if cost.memories is None else "catches (its encoder)"
        parts.append(f"{cost.situations:,} {kind}")
    if cost.steps:
        parts.append(f"{cost.steps:,} steps")
    if cost.start:
        parts.append(f"begun as {cost.start}")
    return ", ".join(parts) or "–"
