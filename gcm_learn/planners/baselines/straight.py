"""The direct naive solution of the paper's introduction: stretch out your hand towards it."""

from __future__ import annotations

from dataclasses import dataclass

from gcm_learn.planners.completion import Problem, straight_plan
from gcm_learn.planners.plan import Plan
from gcm_learn.situation import Situation


@dataclass(frozen=True)
class StraightPlanner:
    """A straight line to the earliest interception at the speed limit."""

    name: str = "straight"

    def plan(self, situation: Situation) -> Plan:
        """Answer a situation."""
        problem = Problem(situation, self.name)
        return problem.early_answer() or straight_plan(problem)
