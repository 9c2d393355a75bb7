"""The direct naive solution of the paper's introduction: stretch out your hand towards it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, overload

from gcm_learn.arms import SpatialArm
from gcm_learn.motion import SpatialTrajectory
from gcm_learn.planners.completion import Problem, SpatialProblem, straight_plan
from gcm_learn.planners.plan import AnyPlan, Plan
from gcm_learn.planners.space.straight import earliest_straight
from gcm_learn.situation import AnySituation, Situation


@dataclass(frozen=True)
class StraightPlanner:
    """A straight line to the earliest interception at the speed limit.

    The hand goes straight in the plane, the joints do in space; there all postures are tried with
    which the earliest interception can be met.
    """

    name: str = "straight"
    takes_space: ClassVar[bool] = True

    @overload
    def plan(self, situation: Situation) -> Plan: ...
    @overload
    def plan(self, situation: Situation[SpatialArm]) -> Plan[SpatialTrajectory]: ...
    def plan(self, situation: AnySituation) -> AnyPlan:
        """Answer a situation."""
        if situation.is_spatial:
            task = SpatialProblem(situation, self.name)
            return task.early_answer() or earliest_straight(task)
        problem = Problem(situation, self.name)
        return problem.early_answer() or straight_plan(problem)
