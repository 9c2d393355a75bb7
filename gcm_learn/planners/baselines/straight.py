"""Straight lines to where a target will be, at once or with a wait at either end."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from gcm_learn import motion
from gcm_learn.arms import PLANAR, ByKind
from gcm_learn.planners.completion import JointProblem, Problem, checked, finish, straight_plan
from gcm_learn.planners.joints.straight import any_straight, earliest_straight
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
    accelerates = False

    def plan(self, situation: AnySituation) -> Plan:
        """Answer a situation."""
        problem, straight = _BY_KIND.of(situation)
        task = problem(situation, self.name)
        return task.early_answer() or straight(task)


_BY_KIND: ByKind[tuple[Callable[..., Any], Callable[[Any], Plan]]] = ByKind(
    {PLANAR: (Problem, straight_plan)}, default=(JointProblem, earliest_straight)
)


@dataclass(frozen=True)
class StraightWaitPlanner:
    """A straight line at the speed limit to an interception, the earlier the better, and a wait.

    Spare time is spent before leaving, after arriving, or in parts at both ends.  Arms that are not
    planar go straight in their joints.  All postures that meet a target are tried at every instant,
    and the move may be slow as well.
    """

    name: str = "straight-wait"
    instants: int = 24
    """Interceptions that are tried, evenly from the first to the horizon."""
    shares: tuple[float, ...] = (0.0, 1.0, 0.5)
    """Shares of the spare time that are spent before leaving, in the order of trying."""

    takes = staticmethod(any_arm)
    accelerates = False

    def plan(self, situation: AnySituation) -> Plan:
        """Answer a situation."""
        return _WAITING.of(situation)(self, situation)

    def _in_joints(self, situation: AnySituation) -> Plan:
        problem = JointProblem(situation, self.name)
        answer = problem.early_answer()
        if answer is not None:
            return answer
        answer = earliest_straight(problem)
        return answer if answer.caught else any_straight(problem, self.instants, self.shares)

    def _in_plane(self, situation: AnySituation) -> Plan:
        problem = Problem(situation, self.name)
        answer = problem.early_answer()
        if answer is not None:
            return answer
        at_once = StraightPlanner(self.name).plan(problem.situation)
        if at_once.caught:
            return at_once
        reason: motion.Reason | None = motion.Reason(motion.Failure.NO_STRAIGHT_LINE)
        for path, leave, end in self._interceptions(problem):
            spare = max(end - leave[-1], 0.0)
            for share in self.shares if spare > problem.rules.instant else (0.0,):
                wait = share * spare
                time = np.concatenate([[0.0], wait + leave, [max(end, leave[-1])]])
                attempt = finish(problem, np.vstack([path[:1], path, path[-1:]]), time)
                if attempt is None:
                    continue
                plan, reason = checked(problem, attempt)
                if plan is not None:
                    return plan
        return problem.answer(reason or motion.Failure.NO_STRAIGHT_LINE)

    def _interceptions(self, problem: Problem) -> Iterator[tuple[np.ndarray, np.ndarray, float]]:
        """Straight paths (m, 2) to interceptions, their times (m,) without waits, and when."""
        horizon, arm = problem.situation.horizon, problem.situation.arm
        start, last = np.array(arm.hand), -1.0
        first = self._meet(problem, 0.0)[0]
        if first < 0.0:
            return
        for since in np.linspace(first, horizon, self.instants):
            t, x, y = self._meet(problem, float(since))
            if t <= last:  # the target is away for a while, or for good
                continue
            last = t
            path = motion.straight_path(start, np.array([x, y]))
            leave = np.concatenate([[0.0], np.cumsum(motion.segment_times(arm, path))])
            if leave[-1] <= t * (1.0 + 1e-9):
                yield path, leave, t

    def _meet(self, problem: Problem, since: float) -> tuple[float, float, float]:
        """Earliest interception from some time on: when (-1 if never) and where."""
        situation, rules = problem.situation, problem.rules
        t, _, x, y = motion.first_interception(
            problem.scene, rules, *situation.arm.hand, 0.0, since, situation.horizon
        )
        return float(t), float(x), float(y)


_WAITING: ByKind[Any] = ByKind(
    {PLANAR: StraightWaitPlanner._in_plane}, default=StraightWaitPlanner._in_joints
)
