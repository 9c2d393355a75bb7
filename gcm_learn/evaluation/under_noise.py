"""The comparison of planners under inexact perception: one row for each episode of the closed loop.

Thinking takes no time here, so rows depend on the seed only.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from gcm_learn.errors import SuiteError
from gcm_learn.evaluation.entrants import Entrant, Rows, entrants_of, is_alone, rows_of
from gcm_learn.evaluation.methods import Method, PlannerMethod
from gcm_learn.evaluation.statistics import Interval, wilson
from gcm_learn.evaluation.suites import Entry
from gcm_learn.evaluation.table import Results
from gcm_learn.execution import (
    HABITS,
    OUTCOMES,
    ExactPlant,
    Loop,
    Perception,
    Planning,
    run_closed_loop,
)
from gcm_learn.planners import LIMIT

EXACT = "once"  # habit of a planner with exact perception
SEED = 0  # of the errors, the same for all planners
_CHUNK = 5  # situations that a process takes at once


def compare_under_noise(
    names: Sequence[str | Any],
    entries: Sequence[Entry],
    deviations: Sequence[float],
    *,
    limit: float | None = LIMIT,
    workers: int | None = None,
    cluster: str | None = None,
    progress: Callable[[int], object] = lambda count: None,
) -> Results:
    """Let planners act in the same situations, with the same errors of perception.

    Parameters
    ----------
    names : sequence of str or object
        Planners, as `compare` takes them; policies are refused.
    entries : sequence of Entry
    deviations : sequence of float
        Of places [forearms], see `Perception`; exact perception is added.
    limit : float, optional
        As `compare` has it.
    workers, cluster
        See `processes.crew_of`.
    progress : callable
        Called with the number of new episodes.

    Raises
    ------
    SuiteError
        If a name is no planner, or a deviation is not from 0 to 1.
    """
    calls_in_all = len(names) * -(-len(entries) // _CHUNK)
    entrants = entrants_of(names, limit, alone=is_alone(calls_in_all, workers, cluster))
    for entrant in entrants:
        _planner_of(entrant.method())
    for place in deviations:
        if not 0.0 <= place <= 1.0:
            raise SuiteError(f"noise: must be from 0 to 1 forearms (got {place})")
    ordered = sorted(entries, key=lambda entry: (entry.suite, entry.index))
    calls = [
        partial(_answers, entrant, place, habit, ordered[first : first + _CHUNK])
        for entrant in entrants
        for place in sorted({0.0, *deviations})
        for habit in (HABITS if place > 0.0 else (EXACT,))
        for first in range(0, len(ordered), _CHUNK)
    ]
    return Results.of(rows_of(calls, workers, cluster, progress))


def noise_episodes(
    names: Sequence[str | Any], entries: Sequence[Entry], deviations: Sequence[float]
) -> int:
    """Return the number of episodes of `compare_under_noise`."""
    return len(names) * len(entries) * (1 + len(HABITS) * len({*deviations} - {0.0}))


def _planner_of(made: Method) -> Any:
    if not isinstance(made, PlannerMethod):
        raise SuiteError(f"noise: {made.name!r} is no planner")
    return made.planner


def _answers(entrant: Entrant, place: float, habit: Any, entries: Sequence[Entry]) -> Rows:
    """A planner's rows for some situations."""
    mind = Planning(_planner_of(entrant.method()), habit)
    loop = Loop(Perception(place), thinking=0.0)
    return [
        {
            "entrant": entrant.name, "noise": place, "way": habit, "suite": entry.suite,
            "index": entry.index, "family": entry.family, "stratum": entry.stratum,
            "outcome": _outcome(mind, loop, entry),
        }
        for entry in entries
    ]  # fmt: skip


def _outcome(mind: Planning, loop: Loop, entry: Entry) -> str:
    """Outcome of an episode: caught, touched or late."""
    situation = entry.situation
    course = run_closed_loop(mind, ExactPlant(situation), situation, loop, SEED, entry.index)
    return OUTCOMES[course.outcome]


@dataclass(frozen=True)
class UnderNoise:
    """Catches of a planner under inexact perception."""

    method: str
    noise: float
    """Standard deviation of places [forearms]."""
    way: str
    """Habit of planning anew."""
    caught: Interval
    collisions: float
    """Share that collides with an obstacle."""
    lost: float
    """Share caught with exact perception, less the share caught here."""


def under_noise(results: Results) -> list[UnderNoise]:
    """Return every planner, deviation and habit, on reachable situations."""
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
                out.append(UnderNoise(name, place, way, caught, collisions, best - caught.value))
    return out
