"""Item k of a dataset, from nothing but the specification and k."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from functools import lru_cache, partial
from typing import Any, Literal

from gcm_learn.dataset.parameters import parameters_of, quantities_of, structure_of, twin_key
from gcm_learn.dataset.record import OracleLabel, Record
from gcm_learn.dataset.spec import DatasetSpec
from gcm_learn.dataset.splits import lot_of, split_of
from gcm_learn.maps import CognitiveMap, build_map
from gcm_learn.planners import (
    Bounds,
    FrontPlanner,
    Plan,
    Planner,
    Problem,
    SpatialProblem,
    Yardstick,
    any_straight,
    bounds,
    gcm,
    get_planner,
    layered,
    layered_in_space,
    marching,
    straight_plan,
    stratum,
    without_waits,
    yardstick,
)
from gcm_learn.scene import TOP_SPEED
from gcm_learn.seeding import rng
from gcm_learn.situation import AnySituation, Frame, SpatialFrame, canonical
from gcm_learn.wave import MarchingParams, WaveParams

AUDIT = 1  # salt of the lot that decides which items the oracle labels as well
LONGEST_ERROR = 300  # characters
Verdict = Literal["L", "W", "Q", "U", "blocked", "other"]
INSTANTS = 32  # of the horizon, at which straight lines to interceptions are tried in space
FRONTS = ("gcm", "marching", "layered")
ENGINES = {"wave": "gcm", "marching": "marching", "layered": "layered"}
"""The planner whose first map is the map of an engine."""


@lru_cache(maxsize=64)
def planner_of(name: str, n: int, rungs: int) -> Planner:
    """A planner by name; those with fronts on lattices of n cells, on their first levels only."""
    if name not in FRONTS:
        return get_planner(name)
    made: FrontPlanner = (
        gcm(WaveParams(n=n))
        if name == "gcm"
        else (marching if name == "marching" else layered)(MarchingParams(n=n))
    )
    return replace(made, levels=made.levels[:rungs])


def make_item(spec: DatasetSpec, k: int) -> Record:
    """Make item k.  Errors are recorded, so a bad item never stops a run."""
    record = no_item(spec, k)
    values = record.values
    try:
        if not _find(spec, values):
            wanted = spec.wanted(k)
            kind = "situation" if wanted is None else f"situation of stratum {wanted}"
            values["error"] = f"no {kind} in {spec.attempts} draws"
    except Exception as error:
        values["error"] = f"{type(error).__name__}: {error}"[:LONGEST_ERROR]
    return record


def no_item(spec: DatasetSpec, k: int, error: str | None = None) -> Record:
    """Item k of which nothing is known, and why."""
    return Record(spec, {"index": k, "attempts": 0, "rejected": Counter(), "error": error})


def _find(spec: DatasetSpec, values: dict[str, Any]) -> bool:
    """Draw until the situation is of the wanted stratum, and add what is known of it."""
    k = values["index"]
    wanted = spec.wanted(k)
    while values["attempts"] < spec.attempts:
        source = rng(spec.seed, k, values["attempts"])
        values["attempts"] += 1
        family = spec.choose(source)
        situation, frame = canonical(family.draw(source, f"{spec.name}-{k}"))
        case = Case(situation, spec)
        verdict = case.verdict(wanted)
        if verdict == "blocked" or (wanted is not None and verdict != wanted):
            values["rejected"][verdict] += 1
            continue
        values |= _known(spec, k, family.family, case, frame) | {"stratum": verdict}
        return True
    return False


def _known(
    spec: DatasetSpec, k: int, family: str, case: Case, frame: Frame | SpatialFrame
) -> dict[str, Any]:
    """The parts of a record of an accepted situation."""
    situation = case.situation
    # A record keeps one map: those of the plans would be most of a shard's memory.
    plans = {name: replace(case.plan(name), map=None) for name in spec.planners}
    audited = spec.label == "oracle" or lot_of(spec.seed, k, AUDIT) < spec.audit
    structure, parameters = structure_of(situation), parameters_of(situation)
    top_speed = float(case.problem.bodies.rows[:, TOP_SPEED].max())
    quantities = quantities_of(situation, top_speed)
    return {
        "family": family,
        "situation": situation,
        "frame": frame,
        "base": frame.base if isinstance(frame, SpatialFrame) else None,
        "map": case.map(),
        "plans": plans,
        "oracle": case.oracle() if audited else None,
        "structure": structure,
        "parameters": parameters,
        "twin_key": twin_key(structure, parameters),
        "quantities": quantities,
        "split": split_of(spec.split, spec.holdouts, spec.seed, k, family, quantities),
    }


class Case:
    """A situation and what planners say of it, each asked at most once and the cheap ones first."""

    def __init__(self, situation: AnySituation, spec: DatasetSpec) -> None:
        self.situation: Any = situation
        self.spec = spec
        self.problem: Any
        if situation.is_spatial:
            self.problem = SpatialProblem(situation, "case")
            self._early = self.problem.early_answer(keeps_acceleration=True)
        else:
            self.problem = Problem(situation, "case")
            self._early = self.problem.early_answer()
        self._plans: dict[str, Plan[Any]] = {}
        self._first_maps: dict[str, CognitiveMap] = {}
        self._bounds: Bounds | Yardstick | None = None

    @property
    def blocked(self) -> bool:
        """Return whether the limb touches an obstacle at t = 0."""
        return self._early is not None and self._early.status == "start_blocked"

    def verdict(self, wanted: str | None = None) -> Verdict:
        """The stratum; "other" as soon as it is known that it is not the wanted one.

        Straight line, a method that never waits and waiting are tried in this order until one
        catches. The oracle decides what is left of them if it is to label, and U if no movement
        can catch.
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
            return stratum(self.situation, self.bounds())
        if wanted == "W":
            return "other"
        if self.plan("layered").caught:
            return "Q"
        if wanted not in (None, "U"):
            return "U"
        # A record must not hold a catch and say that there is none.
        return "Q" if any(self.plan(name).caught for name in self.spec.planners) else "U"

    def _caught_straight(self) -> bool:
        """Return whether a straight line catches: to the earliest interception, in space to any."""
        if self.plan("straight").caught:
            return True
        if not self.situation.is_spatial or self.problem.accelerates:
            return False
        return self._early is None and any_straight(self.problem, INSTANTS).caught

    def _caught_without_waiting(self) -> bool:
        """Return whether first arrivals catch; in space, whether `layered` catches without rest."""
        if not self.situation.is_spatial:
            return self.plan("marching").caught
        plan = self.plan("layered")
        if plan.trajectory is None or not plan.trajectory.rests:
            return plan.caught
        return without_waits(self.problem, plan) is not None

    def plan(self, name: str) -> Plan[Any]:
        """Answer of a planner."""
        if name not in self._plans:
            self._plans[name] = self._planned(name)
        return self._plans[name]

    def _planned(self, name: str) -> Plan[Any]:
        """Answer as the planner does, sharing what all of them need."""
        if self._early is not None:
            return replace(self._early, planner=name)
        if name == "oracle":
            return replace(self.bounds().plan, planner=name)
        if self.situation.is_spatial:
            effort = self.spec.effort if name == "layered" else None
            known: Any = get_planner(name) if effort is None else layered_in_space(effort)
            return known.plan(self.situation)
        problem = Problem(self.situation, name, self.problem.scene)
        if name == "straight":
            return straight_plan(problem)
        planner = planner_of(name, self.spec.n, self.spec.rungs)
        if not isinstance(planner, FrontPlanner):
            return planner.plan(self.situation)
        if planner.direct and self.plan("straight").caught:
            return replace(self.plan("straight"), planner=name)
        return planner.search(problem, partial(self._first_maps.setdefault, name))

    def map(self) -> CognitiveMap | None:
        """The map of the specification's engine, with its default parameters and full margin."""
        if self.spec.map == "none" or self.blocked:
            return None
        name = ENGINES[self.spec.map]
        if name in self.spec.planners:
            self.plan(name)
        if name not in self._first_maps:
            self._first_maps[name] = self._explored()
        return self._first_maps[name]

    def _explored(self) -> CognitiveMap:
        """The map on its own, where no planner needed one."""
        kind = WaveParams if self.spec.map == "wave" else MarchingParams
        wait, scene = self.spec.map == "layered", self.problem.scene
        return build_map(self.situation, kind(n=self.spec.n), wait=wait, scene=scene)

    def bounds(self) -> Bounds | Yardstick:
        """The oracle's bounds on the earliest catch; in space some catch, by what keeps no time."""
        if self._bounds is None:
            if self.situation.is_spatial:
                self._bounds = yardstick(self.situation, 0.0, earliest=False)
            else:
                self._bounds = bounds(self.situation)
        return self._bounds

    def oracle(self) -> OracleLabel:
        """The oracle's label."""
        known = self.bounds()
        return OracleLabel(stratum(self.situation, known), known.lower, known.upper)
