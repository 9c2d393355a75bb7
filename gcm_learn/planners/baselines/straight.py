"""The direct naive solution of the paper's introduction: stretch out your hand towards it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from gcm_learn.arms import PLANAR, ByKind
from gcm_learn.planners.completion import Problem, SpatialProblem, straight_plan
from gcm_learn.planners.joints.straight import earliest_straight
from gcm_learn.planners.plan import Plan, any_arm
from gcm_learn.situation import AnySituation


@dataclass(frozen=True)
class StraightPlanner:
    """A straight line to the earliest interception at the speed limit.

    The hand of a planar arm goes straight, and the joints of other arms do.  All postures are tried
    with which the earliest interception can be met.
    """

    name: str = "straight"
    takes = staticmethod(any_arm)

    def plan(self, situation: AnySituation) -> Plan:
        """Answer a situation."""
        problem, straight = _BY_KIND.of(situation)
        task = problem(situation, self.name)
        return task.early_answer() or straight(task)


_BY_KIND: ByKind[tuple[Callable[..., Any], Callable[[Any], Plan]]] = ByKind(
    {PLANAR: (Problem, straight_plan)}, default=(SpatialProblem, earliest_straight)
)
