"""Cases: a situation with the planners' answers to it: stratum, plans, map and label."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from typing import Any, Literal

from gcm_learn import planners
from gcm_learn.arms import CHAIN, PLANAR, Arm, ByKind
from gcm_learn.dataset.spec import DatasetSpec
from gcm_learn.maps import CognitiveMap, build_map
from gcm_learn.motion import Failure
from gcm_learn.situation import AnySituation, Body, Disc, PlanarQuadratic, Situation
from gcm_learn.wave import MarchingParams, WaveParams

Verdict = Literal["L", "W", "Q", "U", "blocked", "other"]
INSTANTS = 32  # of the horizon, at which straight lines to interceptions are tried in space
FRONTS = ("gcm", "marching", "layered")
ENGINES = {"wave": "gcm", "marching": "marching", "layered": "layered"}
"""The planner whose first map is the map of an engine."""


@dataclass(frozen=True)
class OracleLabel:
    """Label of a situation by the oracle."""

    stratum: str
    lower: float
    """No movement catches before [s]; infinite if none does."""
    upper: float
    """Catch time of the oracle's plan [s]; infinite without a catch."""

    @property
    def decided(self) -> bool:
        """True if a catch was found or ruled out."""
        return math.isinf(self.lower) or not math.isinf(self.upper)


@lru_cache(maxsize=64)
def planner_of(name: str, n: int, rungs: int) -> planners.Planner:
    """Return a planner by name; planners with fronts have n cells and their first levels only."""
    if name not in FRONTS:
        return planners.get_planner(name)
    made: planners.FrontPlanner = (
        planners.gcm(WaveParams(n=n))
        if name == "gcm"
        else (planners.marching if name == "marching" else planners.layered)(MarchingParams(n=n))
    )
    return replace(made, levels=made.levels[:rungs])


class BaseCase(ABC):
    """Situation with planners' answers; each planner is asked at most once, cheap ones first."""

    problem: Any

    def __init__(self, situation: AnySituation, spec: DatasetSpec) -> None:
        self.situation: Any = situation
        self.spec = spec
        self._early = self._begin()
        self._plans: dict[str, planners.Plan] = {}
        self._first_maps: dict[str, CognitiveMap] = {}
        self._bounds: planners.Bounds | planners.Yardstick | None = None

    @classmethod
    def examples(cls) -> tuple[AnySituation, ...]:
        """Return situations that take all levels of all planners."""
        return ()

    @abstractmethod
    def _begin(self) -> planners.Plan | None:
        """Make the problem; return the answer that needs no planner."""

    @abstractmethod
    def _caught_straight(self) -> bool:
        """Return whether a straight line catches."""

    @abstractmethod
    def _caught_without_waiting(self) -> bool:
        """Return whether a movement without waits catches."""

    @abstractmethod
    def _asked(self, name: str) -> planners.Plan:
        """Return the answer of planner `name` to a situation without an early answer."""

    @abstractmethod
    def _bounded(self) -> planners.Bounds | planners.Yardstick:
        """Return the bounds on the earliest catch."""

    @property
    def blocked(self) -> bool:
        """True if the limb touches an obstacle at t = 0."""
        return self._early is not None and self._early.status == "start_blocked"

    def verdict(self, wanted: str | None = None) -> Verdict:
        """Return the stratum, or "other" as soon as the wanted stratum is ruled out.

        Straight line, a method that never waits and waiting are tried in this order until one
        catches. The oracle decides the rest if it is to label, and U if no movement can catch.
        """
        if self.blocked:
            return "blocked"
        if self._caught_straight():
            return "L"
        if wanted == "L":
            return "other"
        if self._caught_without_waiting():
            return "W"
        if self.spec.label == "oracle":
            return planners.stratum(self.situation, self.bounds())
        if wanted == "W":
            return "other"
        if self.plan(self.spec.persistent).caught:
            return "Q"
        if wanted not in (None, "U"):
            return "U"
        # A record must not hold a catch and say that there is none.
        return "Q" if any(self.plan(name).caught for name in self.spec.planners) else "U"

    def plan(self, name: str) -> planners.Plan:
        """Return the answer of a planner."""
        if name not in self._plans:
            self._plans[name] = self._planned(name)
        return self._plans[name]

    def _planned(self, name: str) -> planners.Plan:
        """Return a planner's plan: the early answer, the plan of the bounds, or a new plan."""
        if self._early is not None:
            return replace(self._early, planner=name)
        if name == "oracle":
            return replace(self.bounds().plan, planner=name)
        return self._asked(name)

    def map(self) -> CognitiveMap | None:
        """Return the map of the specification's engine, with default parameters and full margin."""
        if self.spec.map == "none" or self.blocked:
            return None
        name = ENGINES[self.spec.map]
        if name in self.spec.planners:
            self.plan(name)
        if name not in self._first_maps:
            self._first_maps[name] = self._explored()
        return self._first_maps[name]

    def _explored(self) -> CognitiveMap:
        """Build the map, for a situation in which no planner made one."""
        kind = WaveParams if self.spec.map == "wave" else MarchingParams
        wait, scene = self.spec.map == "layered", self.problem.scene
        return build_map(self.situation, kind(n=self.spec.n), wait=wait, scene=scene)

    def bounds(self) -> planners.Bounds | planners.Yardstick:
        """Return the bounds on the earliest catch."""
        if self._bounds is None:
            self._bounds = self._bounded()
        return self._bounds

    def oracle(self) -> OracleLabel:
        """Return the oracle's label."""
        known = self.bounds()
        return OracleLabel(planners.stratum(self.situation, known), known.lower, known.upper)


class PlanarCase(BaseCase):
    """A situation of a planar arm; the oracle bounds the earliest catch."""

    @classmethod
    def examples(cls) -> tuple[AnySituation, ...]:
        """Return two situations: one with a free target, one with a covered target."""
        still = PlanarQuadratic((0.4, 1.4), (0.0, 0.0), (0.0, 0.0))
        ball = Body("target", "ball", Disc(0.08), still)
        lid = Body("obstacle", "lid", Disc(0.4), still)
        arm = Arm((1.3, 0.0), 3.0)
        return Situation("free", 1.0, arm, (ball,)), Situation("covered", 1.0, arm, (ball, lid))

    def _begin(self) -> planners.Plan | None:
        self.problem = planners.Problem(self.situation, "case")
        return self.problem.early_answer()

    def _caught_straight(self) -> bool:
        """Return whether the straight line to the earliest interception catches."""
        return self.plan("straight").caught

    def _caught_without_waiting(self) -> bool:
        """Return whether first arrivals catch."""
        return self.plan("marching").caught

    def _asked(self, name: str) -> planners.Plan:
        problem = planners.Problem(self.situation, name, self.problem.scene)
        if name == "straight":
            return planners.straight_plan(problem)
        planner = planner_of(name, self.spec.n, self.spec.rungs)
        if not isinstance(planner, planners.FrontPlanner):
            return planner.plan(self.situation)
        if planner.direct and self.plan("straight").caught:
            return replace(self.plan("straight"), planner=name)
        return planner.search(problem, partial(self._first_maps.setdefault, name))

    def _bounded(self) -> planners.Bounds:
        return planners.bounds(self.situation)


class JointCase(BaseCase):
    """Situation of an arm that moves in its joints; any catch is the label's upper bound."""

    @property
    def _several(self) -> bool:
        return self.situation.catch != "any" and len(self.situation.targets) > 1

    def _begin(self) -> planners.Plan | None:
        self.problem = planners.JointProblem(self.situation, "case")
        early = self.problem.early_answer(keeps_acceleration=True, keeps_ends=True)
        untaken = early is not None and early.failure is Failure.SEVERAL_UNTAKEN
        return None if untaken else early

    def _caught_straight(self) -> bool:
        """Return whether a straight line catches, of several targets by the planner only."""
        if self.plan("straight").caught:
            return True
        if self._several or self.problem.accelerates:
            return False
        return self._early is None and planners.any_straight(self.problem, INSTANTS).caught

    def _caught_without_waiting(self) -> bool:
        """Return whether the catch of the persistent planner holds without its rests."""
        plan = self.plan(self.spec.persistent)
        if self._several:
            return plan.trajectory is not None and not plan.trajectory.rests
        if plan.trajectory is None or not plan.trajectory.until(plan.catch_time).rests:  # type: ignore[arg-type]
            return plan.caught
        return planners.without_waits(self.problem, plan) is not None

    def _explored(self) -> CognitiveMap:
        params = MarchingParams(n=self.spec.n, margin=0.0)
        return build_map(self.situation, params, scene=self.problem.scene)

    def _asked(self, name: str) -> planners.Plan:
        effort = self.spec.effort if name == self.spec.persistent else None
        brief = None if effort is None else planners.as_ours(planners.search_in_space(effort))
        return planners.solve(self.situation, brief or name)

    def _bounded(self) -> planners.Yardstick:
        return planners.yardstick(self.situation, 0.0, earliest=False)


CASES: ByKind[type[BaseCase]] = ByKind({PLANAR: PlanarCase, CHAIN: JointCase}, who="dataset")
