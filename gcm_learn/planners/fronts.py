"""Planners that let a front spread from the hand: the paper's wave, and causal marching."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

import numpy as np

from gcm_learn.arm.lattice import LARGEST_LATTICE
from gcm_learn.maps import CognitiveMap, build_map, descend
from gcm_learn.planners.completion import Problem, checked, finish, straight_plan
from gcm_learn.planners.plan import Plan
from gcm_learn.situation import Situation
from gcm_learn.wave import MarchingParams, WaveParams

HALF_DIAGONAL = 0.71  # [cells]: slack with which no target is lost between the centres of cells
Params = TypeVar("Params", WaveParams, MarchingParams)
Way = tuple[np.ndarray, np.ndarray]  # hand positions (n, 2) and when the front was there (n,) [s]


@dataclass(frozen=True)
class FrontPlanner(Generic[Params]):
    """Map, way, verification; and again with more care when the verification fails.

    A map knows the cells' centres only.  With obstacles widened by half a cell its paths mostly
    hold, but narrow gaps are lost; without, gaps are found and the verification rejects what
    touches.  So both are tried, then both again on a finer lattice.
    """

    name: str
    rungs: tuple[Params, ...]
    """Parameters of the maps to try, in order."""
    explore: Callable[[Problem, Params, float], tuple[CognitiveMap, Way | None]]
    """Makes a map, ignoring contacts before a time [s], and the way to its contact."""
    contacts: int = 3
    """How many contacts of one map to try before the next map."""
    direct: bool = False
    """Try the straight line first: where it holds, no way is faster, and no map is needed."""

    def plan(self, situation: Situation) -> Plan:
        """Answer a situation."""
        problem = Problem(situation, self.name)
        answer = problem.early_answer()
        if answer is None and self.direct:
            answer = straight_plan(problem)[0]
        return self.climb(problem) if answer is None else answer

    def climb(self, problem: Problem) -> Plan:
        """Answer by maps, after what can be said without one has been said."""
        first: CognitiveMap | None = None
        reason = ""
        for params in self.rungs:
            ignore = 0.0
            for attempts in range(self.contacts):
                cognitive_map, way = self.explore(problem, params, ignore)
                first = cognitive_map if first is None else first
                if cognitive_map.contact is None:
                    reason = reason or "the front meets no target within the horizon"
                    break
                attempt = None if way is None else finish(problem, *way)
                if attempt is None:
                    reason = "no target can be met from where the front made contact"
                else:
                    plan, reason = checked(problem, attempt, cognitive_map)
                    if plan is not None:
                        return plan
                # Contacts that fail come in rows: skip ever more of them.
                crossing = cognitive_map.lattice.spacing / problem.situation.arm.max_hand_speed
                ignore = cognitive_map.contact.time + 2**attempts * crossing
        return problem.answer("unreachable", reason, first)


def gcm(params: WaveParams | None = None) -> FrontPlanner[WaveParams]:
    """The paper's planner: the wave of Eq. 10, its map and the descent on it."""
    params = WaveParams() if params is None else params
    bare = replace(params, margin=0.0, slack=HALF_DIAGONAL)
    return FrontPlanner("gcm", (params, bare, finer(params), finer(bare)), _explore)


def marching(params: MarchingParams | None = None) -> FrontPlanner[MarchingParams]:
    """The same idea with causal marching instead of the wave."""
    return FrontPlanner("marching", marching_rungs(params), _explore)


def marching_rungs(params: MarchingParams | None = None) -> tuple[MarchingParams, ...]:
    """Parameters of ever more careful marching, by default from the defaults on."""
    params = MarchingParams() if params is None else params
    bare = replace(params, margin=0.0, lookback=0.0, slack=HALF_DIAGONAL)
    return (params, bare, finer(params), finer(bare))


def finer(params: Params) -> Params:
    """The same parameters on a lattice of half the spacing."""
    return replace(params, n=min(2 * params.n, LARGEST_LATTICE))


def _explore(
    problem: Problem, params: WaveParams | MarchingParams, ignore: float
) -> tuple[CognitiveMap, Way | None]:
    """First-arrival map and the descent on it."""
    cognitive_map = build_map(problem.situation, params, bodies=problem.bodies, ignore=ignore)
    return cognitive_map, descend(cognitive_map)
