"""Answers of planners with their processor time, and verdicts of the referee on them."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from time import process_time
from typing import Any

import numpy as np

from experiments.common.counting import counted
from gcm_learn.planners import Plan, plan_to_json
from gcm_learn.recall import HybridPlanner, RecallPlanner
from gcm_learn.referee import judge
from gcm_learn.situation import situation_to_json
from gcm_learn.storage import content_hash


@dataclass
class Referee:
    """Judge of catches; each catch of a situation is judged once."""

    known: dict[str, bool] = field(default_factory=dict)

    def broken(self, situation: Any, plan: Plan) -> bool:
        """Return whether a catch breaks its promise."""
        path: Any = plan.trajectory
        parts = (path.time, path.joints, np.array([plan.clearance, plan.catch_time]))
        key = content_hash(repr(situation), *(np.ascontiguousarray(a).tobytes() for a in parts))
        if key not in self.known:
            self.known[key] = bool(complaints(situation, plan))
        return self.known[key]


def complaints(situation: Any, plan: Plan) -> list[str]:
    """Complaints of the referee, each as a field and what is wrong with it."""
    records = situation_to_json(situation), plan_to_json(plan, situation)
    return [str(replace(c, name="")).removeprefix(": ") for c in judge(*records)]


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
    return row | {"complaints": int(referee.broken(situation, plan))}


def counts(planner: Any, situation: Any) -> dict[str, int]:
    """Checks, looks and bends of a planner that recalls, or none."""
    first = planner.recall if isinstance(planner, HybridPlanner) else planner
    return counted(first, situation) if isinstance(first, RecallPlanner) else {}
