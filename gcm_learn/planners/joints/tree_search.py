"""The search in joints and time for any arm: straight moves, then trees from both ends."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar

from gcm_learn.motion import Failure, Movement
from gcm_learn.planners.completion import Attempt, SpatialProblem, checked
from gcm_learn.planners.joints.layered import finished
from gcm_learn.planners.joints.meeting_trees import new_trees, search_trees
from gcm_learn.planners.joints.ramped_ways import hasten_ramped, ramped_samples, shorten_ramped
from gcm_learn.planners.joints.straight import at_once
from gcm_learn.planners.joints.ways import Way, new_way, shorten
from gcm_learn.planners.plan import Deadline, Plan, deadline_of, in_joints
from gcm_learn.situation import AnySituation

SLICE = 100
"""Postures that catch to draw between two readings of the clock."""


@dataclass(frozen=True)
class TreeSearch:
    """Straight moves to postures that catch and trees from both ends, grown in turn.

    Every posture that catches is first tried by a straight move from the start.  Limits of
    acceleration are kept by every move.
    """

    name: str = "search"
    rounds: int = 4000
    """Postures that catch to draw; the limit of work."""
    seed: int = 1

    takes = staticmethod(in_joints)

    anytime: ClassVar[bool] = True

    def plan(
        self,
        situation: AnySituation,
        bound: float | None = None,
        deadline: float | Deadline | None = None,
    ) -> Plan:
        """Answer a situation.

        Parameters
        ----------
        situation : Situation
        bound : float, optional
            Only catches before this time are wanted [s]; e.g. that of a catch that is known.
        deadline : float or Deadline, optional
            See `Anytime`.  With it new trees look for an earlier catch until then.
        """
        if bound is not None and not bound > 0.0:
            raise ValueError(f"bound: must be positive (got {bound:g})")
        problem: Any = SpatialProblem(situation, self.name, deadline=deadline_of(deadline))
        early = problem.early_answer(keeps_acceleration=True) or at_once(problem)
        if early is not None:
            return early
        end = situation.horizon if bound is None else min(situation.horizon, bound)
        plan, seed = self._before(problem, end, self.seed), self.seed
        while plan.catch_time is not None and problem.deadline is not None and not problem.over:
            end, seed = plan.catch_time - problem.gain, seed + 1
            sooner = self._before(problem, end, seed) if end > 0.0 else plan
            plan = sooner if sooner.caught else plan
            if end <= 0.0 or problem.budget[0] < 0:
                break
        return replace(plan, planning_ms=problem.elapsed_ms)

    def _before(self, problem: SpatialProblem, end: float, seed: int) -> Plan:
        """A catch until `end` [s], by trees that are grown from new."""
        study = problem.study
        trees = new_trees(study, self.rounds + 2, seed, problem.accelerates)
        way, left = new_way(study.goal.size), self.rounds
        while left > 0 and not problem.over:
            size = problem.slices(SLICE, left)
            if search_trees(study, trees, size, end, way):
                return _finished(problem, trees.moves, way)
            left -= size
        return problem.answer(Failure.OUT_OF_TIME if problem.over else Failure.NO_TREE)


def _finished(problem: SpatialProblem, moves: Any, way: Way) -> Plan:
    """The way as a plan: without postures that are not needed, its catch made earlier, verified."""
    study, short = problem.study, new_way(problem.study.goal.size)
    if not problem.accelerates:
        shorten(study, way, short)
        return finished(problem, study, short)
    shorten_ramped(study, way, moves, short)
    hasten_ramped(study, short, moves)
    *samples, body = ramped_samples(study, short, moves)
    path = Movement(problem.situation.arm, *samples)
    plan, reason = checked(problem, Attempt(path, int(body)))
    return problem.answer(reason or Failure.NO_INTERCEPTION) if plan is None else plan
