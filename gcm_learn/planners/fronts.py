"""Planners that let a front spread from the hand: the paper's wave, and causal marching."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Generic, TypeAlias, TypeVar

from gcm_learn.charts import LARGEST_LATTICE
from gcm_learn.maps import CognitiveMap, build_map, descend
from gcm_learn.motion import Failure, Reason, Verdict
from gcm_learn.planners import completion
from gcm_learn.planners.feedback import Exploration, Feedback
from gcm_learn.planners.plan import GAIN, Deadline, Plan, deadline_of
from gcm_learn.situation import Situation
from gcm_learn.wave import MarchingParams, WaveParams

HALF_DIAGONAL = 0.71  # [cells]: slack with which no target is lost between the centres of cells
Params = TypeVar("Params", WaveParams, MarchingParams)
Explore: TypeAlias = Callable[[completion.Problem, Params, Feedback], Exploration]


@dataclass(frozen=True)
class Level(Generic[Params]):
    """Kind of map for a planner to try."""

    params: Params
    explore: Explore[Params]
    """Makes a map and paths that end at its interception."""
    trials: int = 3
    """Maps to make at most, each with the feedback of the maps before."""
    beyond: float = 0.0
    """Time after the horizon at which the front stops [crossings of a cell]: paths are a little
    shorter than from centre to centre."""
    decisive: bool = False
    """Stop at this level if its first map has no interception."""


@dataclass(frozen=True)
class FrontPlanner:
    """Map, path, verification; and again with more care when the verification fails.

    A map knows the cells' centres only.  With obstacles widened by half a cell its paths mostly
    hold, but narrow gaps are lost; without, gaps are found, and the verification rejects
    collisions.  So both are tried, then both again on a finer lattice, and where a path is touched
    the margin is widened (`feedback`).
    """

    name: str
    levels: tuple[Level[Any], ...]
    """The maps to try, in order."""
    direct: bool = False
    """Try the straight line first, which is fastest where it holds."""
    find: Callable[[completion.Problem], Plan | None] | None = None
    """A search without a map, whose answer is final; where it has none, maps are made."""

    anytime: ClassVar[bool] = True

    def plan(
        self,
        situation: Situation,
        bound: float | None = None,
        deadline: float | Deadline | None = None,
    ) -> Plan:
        """Answer a situation.

        Parameters
        ----------
        situation : Situation
        bound : float, optional
            Only catches until then count [s], as where the caller has one already.  What cannot
            meet a target by then is not explored.
        deadline : float or Deadline, optional
            See `Anytime`.  Searches stop then; a map that was begun is made whole.
        """
        limit = deadline_of(deadline)
        problem = completion.Problem(completion.until(situation, bound), self.name, deadline=limit)
        problem.gain = GAIN * situation.horizon  # whatever the bound
        answer = problem.early_answer()
        if answer is None and self.direct:
            straight = completion.straight_plan(problem)
            answer = straight if straight.caught else None
        return self.search(problem) if answer is None else answer

    def search(
        self, problem: completion.Problem, keep: Callable[[CognitiveMap], object] | None = None
    ) -> Plan:
        """Answer a problem that no straight line solves.

        Parameters
        ----------
        problem : Problem
        keep : callable, optional
            Called with the first map.
        """
        answer = None if self.find is None else self.find(problem)
        return self._by_maps(problem, keep) if answer is None else answer

    def _by_maps(
        self, problem: completion.Problem, keep: Callable[[CognitiveMap], object] | None
    ) -> Plan:
        """Make one map after the other until an attempt holds."""
        first: CognitiveMap | None = None
        reason: Reason | None = None
        for level in self.levels:
            feedback = Feedback(beyond=level.beyond)
            for trial in range(level.trials):
                if problem.over:
                    return problem.answer(Failure.OUT_OF_TIME, first)
                found = level.explore(problem, level.params, feedback)
                if first is None:
                    first = found.map
                    if keep is not None:
                        keep(first)
                if found.map.interception is None:
                    reason = reason or Reason(Failure.NO_INTERCEPTION)
                    if level.decisive and trial == 0:
                        return problem.answer(reason or Failure.NO_INTERCEPTION, first)
                    break
                plan, failures = _first_that_holds(problem, found)
                if plan is not None:
                    return plan
                reason = failures[0][1].reason if failures else Reason(Failure.NO_ENDING)
                feedback = feedback.after(found, failures, problem.situation.arm.max_hand_speed)
        return problem.answer(reason or Failure.NO_INTERCEPTION, first)


def _first_that_holds(
    problem: completion.Problem, found: Exploration
) -> tuple[Plan | None, list[tuple[completion.Attempt, Verdict]]]:
    """Return the plan of the first attempt that holds, if any, and the failures before it."""
    failures: list[tuple[completion.Attempt, Verdict]] = []
    for attempt in found.attempts:
        plan, verdict = completion.judged(problem, attempt, found.map)
        if plan is not None:
            return plan, failures
        failures.append((attempt, verdict))
        if verdict.collision_time is not None and verdict.collision_time < found.shared:
            break  # the others begin in the same way
    return None, failures


def gcm(params: WaveParams | None = None) -> FrontPlanner:
    """Make the paper's planner: the wave of Eq. 10, its map, and the descent on that map."""
    return FrontPlanner(
        "gcm", wave_levels(WaveParams() if params is None else params, first_arrival)
    )


def wave_levels(params: WaveParams, explore: Explore[WaveParams]) -> tuple[Level[WaveParams], ...]:
    """Ever more careful waves."""
    return levels_of(params, replace(params, margin=0.0, slack=HALF_DIAGONAL), explore)


def marching(params: MarchingParams | None = None) -> FrontPlanner:
    """Make a front planner with causal marching instead of the wave."""
    params = MarchingParams() if params is None else params
    return FrontPlanner("marching", levels_of(params, without_margin(params), first_arrival))


def without_margin(params: MarchingParams) -> MarchingParams:
    """Return the parameters with cells that are checked at their centres and at once only."""
    return replace(params, margin=0.0, lookback=0.0, slack=HALF_DIAGONAL)


def levels_of(params: Params, bare: Params, explore: Explore[Params]) -> tuple[Level[Params], ...]:
    """Maps with margin and without, then both on a finer lattice."""
    return tuple(Level(kind, explore) for kind in (params, bare, finer(params), finer(bare)))


def finer(params: Params) -> Params:
    """Return the parameters on a lattice of half the spacing."""
    return replace(params, n=min(2 * params.n, LARGEST_LATTICE))


def first_arrival(
    problem: completion.Problem, params: WaveParams | MarchingParams, feedback: Feedback
) -> Exploration:
    """Make the first-arrival map, and an attempt by descent on this map."""
    cognitive_map = build_map(
        problem.situation,
        params,
        scene=problem.scene,
        ignore=feedback.ignore,
        widening=feedback.widening,
    )
    path = descend(cognitive_map)
    attempt = None if path is None else completion.finish(problem, *path)
    if attempt is None or cognitive_map.interception is None:
        return Exploration(cognitive_map)
    return Exploration(cognitive_map, (attempt,), arrived=cognitive_map.interception.time)
