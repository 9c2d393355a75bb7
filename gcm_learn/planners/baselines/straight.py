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
        answer = problem.early_answer()
        if answer is not None:
            return answer
        plan, reason = straight_plan(problem)
        return plan if plan is not None else problem.answer("unreachable", reason)
