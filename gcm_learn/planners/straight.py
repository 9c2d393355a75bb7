"""The direct naive solution of the paper's introduction: stretch out your hand towards it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gcm_learn.planners.completion import Problem, attempt_of, checked, straight_catch
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
        way = straight_catch(problem, np.array(situation.arm.hand), 0.0)
        if way is None:
            return problem.answer("unreachable", "no straight line meets a target in time")
        time, hand, body = way
        if time[-1] <= 0.0:
            time, hand = time[:1], hand[:1]
        plan, reason = checked(problem, attempt_of(problem, time, hand, body))
        return plan if plan is not None else problem.answer("unreachable", reason)
