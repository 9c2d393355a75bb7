"""Answers of planners with their processor time, and verdicts of the tests' referees on them."""

from __future__ import annotations

from dataclasses import dataclass, field
from time import process_time
from typing import Any

import numpy as np

from experiments.common.counting import counted
from gcm_learn.arms import CHAIN, SPATIAL, ByKind
from gcm_learn.planners import Plan, plan_to_json
from gcm_learn.recall import HybridPlanner, RecallPlanner
from gcm_learn.situation import situation_to_json
from gcm_learn.storage import content_hash
from tests import referee, referee_of_chains, referee_of_spatial_arms

CLOSER = (1000, 8000)  # instants of further checks: the referee of planar arms samples time


@dataclass
class Referee:
    """Judge of catches; each catch of a situation is judged once."""

    known: dict[str, bool] = field(default_factory=dict)

    def broken(self, situation: Any, plan: Plan) -> bool:
        """Return whether a catch breaks its promise, in the plane at every density of samples."""
        path: Any = plan.trajectory
        places = path.joints if JUDGES.takes(situation) else path.hand
        parts = (path.time, places, np.array([plan.clearance, plan.catch_time]))
        key = content_hash(repr(situation), *(np.ascontiguousarray(a).tobytes() for a in parts))
        if key not in self.known:
            self.known[key] = self._broken(situation, plan)
        return self.known[key]

    def _broken(self, situation: Any, plan: Plan) -> bool:
        if JUDGES.takes(situation):
            return bool(JUDGES.of(situation)(situation, plan))
        looks = (referee.judge(situation, plan, *more) for more in ((), *((n,) for n in CLOSER)))
        return all(look.complaints for look in looks)


def complaints_in_space(situation: Any, plan: Plan) -> list[str]:
    """Complaints of the referee of spatial arms."""
    records = situation_to_json(situation), plan_to_json(plan, situation)
    return referee_of_spatial_arms.judge(*records).complaints


def complaints_of_chains(situation: Any, plan: Plan) -> list[str]:
    """Complaints of the referee of chains."""
    records = situation_to_json(situation), plan_to_json(plan, situation)
    return referee_of_chains.judge(*records).complaints


JUDGES = ByKind({SPATIAL: complaints_in_space, CHAIN: complaints_of_chains})
"""Referees of arms in joints, which are exact."""


def outcome(planner: Any, situation: Any, referee: Referee) -> dict[str, Any]:
    """Answer of a planner as a row of outcomes, without what the situation and the method are.

    Processor time is that of one plan; memories are counted in a second one.
    """
    since = process_time()
    plan = planner.plan(situation)
    took = 1e3 * (process_time() - since)
    return judged(plan, situation, referee, took) | counts(planner, situation)


def judged(plan: Plan, situation: Any, referee: Referee, ms: float) -> dict[str, Any]:
    """Plan and processor time [ms] as a row of outcomes, with what the referee finds."""
    row = {"caught": plan.caught, "catch_time": plan.catch_time, "ms": ms}
    if not plan.caught:
        return row
    if not JUDGES.takes(situation):
        return row | {"complaints": int(referee.broken(situation, plan))}
    return row | {"complaints": len(JUDGES.of(situation)(situation, plan))}


def counts(planner: Any, situation: Any) -> dict[str, int]:
    """Checks, looks and bends of a planner that recalls, or none."""
    first = planner.recall if isinstance(planner, HybridPlanner) else planner
    return counted(first, situation) if isinstance(first, RecallPlanner) else {}


def first_answer(planner: Any, situation: Any) -> dict[str, Any]:
    """First answer of a spatial arm's planner: catch time [s], processor time [ms], complaints."""
    since = process_time()
    plan = planner.plan(situation)
    took = 1e3 * (process_time() - since)
    row: dict[str, Any] = {"catch": plan.catch_time, "ms": round(took, 3)}
    if plan.caught:
        row["complaints"] = complaints_in_space(situation, plan)
    return row
