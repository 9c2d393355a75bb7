"""The comparison of planners that see inexactly: one row for each way to deal with it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from gcm_learn.errors import SuiteError
from gcm_learn.evaluation.crew import Rows, rows_of
from gcm_learn.evaluation.methods import Method, PlannerMethod, get_method
from gcm_learn.evaluation.noise import Habit, Noise, under_noise
from gcm_learn.evaluation.statistics import Interval, wilson
from gcm_learn.evaluation.suites import Entry
from gcm_learn.evaluation.table import Results

HABITS = {
    "plans once": (Habit(), 0.0),
    "again at every look": (Habit(replan=True), 0.0),
    "again, by all looks": (Habit(replan=True, remember=True), 0.0),
    "again, by all looks, margin": (Habit(replan=True, remember=True), 2.0),
}
"""Ways to deal with inexact perception, with the margin in deviations of what is known."""
EXACT = "plans once"  # says all if nothing is inexact
_CHUNK = 5  # situations that a process takes at once


def compare_blurred(
    names: Sequence[str],
    entries: Sequence[Entry],
    deviations: Sequence[float],
    *,
    workers: int | None = None,
    cluster: str | None = None,
    progress: Callable[[int], object] = lambda count: None,
) -> Results:
    """Let planners answer the same situations, seen with the same errors.

    Parameters
    ----------
    names : sequence of str
        Planners; actors act on what they see and are not asked here.
    entries : sequence of Entry
    deviations : sequence of float
        Of places [forearms]; 0 is done too, for what is lost.
    workers, cluster
        See `processes.crew_of`.
    progress : callable
        Told how many episodes are new.

    Raises
    ------
    SuiteError
        If a name is no planner, or a deviation negative.
    """
    for name in names:
        _planner_of(get_method(name))
    for place in deviations:
        if not 0.0 <= place <= 1.0:
            raise SuiteError(f"noise: must be from 0 to 1 forearms (got {place})")
    ordered = sorted(entries, key=lambda entry: (entry.suite, entry.index))
    calls = [
        partial(_answers, name, place, way, ordered[first : first + _CHUNK])
        for name in names
        for place in sorted({0.0, *deviations})
        for way in (HABITS if place > 0.0 else (EXACT,))
        for first in range(0, len(ordered), _CHUNK)
    ]
    return Results.of(rows_of(calls, workers, cluster, progress))


def episodes(names: Sequence[str], entries: Sequence[Entry], deviations: Sequence[float]) -> int:
    """How many episodes `compare_blurred` plays."""
    return len(names) * len(entries) * (1 + len(HABITS) * len({*deviations} - {0.0}))


def _planner_of(made: Method) -> Any:
    if not isinstance(made, PlannerMethod):
        raise SuiteError(f"noise: {made.name!r} is no planner")
    return made.planner


def _answers(name: str, place: float, way: str, entries: Sequence[Entry]) -> Rows:
    """A planner's rows for some situations."""
    habit, caution = HABITS[way]
    planner = _planner_of(get_method(name))
    outcomes = under_noise(planner, entries, Noise(place, caution), habit)
    return [
        {
            "entrant": name, "noise": place, "way": way, "suite": entry.suite,
            "index": entry.index, "family": entry.family, "stratum": entry.stratum,
            "outcome": outcome,
        }
        for entry, outcome in zip(entries, outcomes, strict=True)
    ]  # fmt: skip


@dataclass(frozen=True)
class Blurred:
    """Catches of a planner that sees inexactly in some way."""

    method: str
    noise: float
    """Deviation of places [forearms]."""
    way: str
    caught: Interval
    collisions: float
    """Share that touches an obstacle."""
    lost: float
    """Share of all that is caught with exact perception, less that caught so."""


def blurred(results: Results) -> list[Blurred]:
    """Every planner, deviation and way, on reachable situations."""
    there = results.where(results["stratum"] != "U")
    out = []
    for name in results.methods:
        mine = there.where(there["entrant"] == name)
        exact = mine.where(mine["noise"] == 0.0)["outcome"]
        best = float((exact == "caught").mean())
        for place in sorted(set(mine["noise"].tolist())):
            for way in HABITS:
                rows = mine.where((mine["noise"] == place) & (mine["way"] == way))
                if not len(rows):
                    continue
                outcome = rows["outcome"]
                caught = wilson(int((outcome == "caught").sum()), len(rows))
                collisions = float((outcome == "touched").mean())
                out.append(Blurred(name, place, way, caught, collisions, best - caught.value))
    return out
