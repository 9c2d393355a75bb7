"""The search in joints and time for any arm: straight moves, then trees from both ends."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from gcm_learn.motion import Failure, Movement
from gcm_learn.planners.completion import Attempt, SpatialProblem, checked
from gcm_learn.planners.joints.layered import finished
from gcm_learn.planners.joints.meeting_trees import new_trees, search_trees
from gcm_learn.planners.joints.ramped_ways import hasten_ramped, ramped_samples, shorten_ramped
from gcm_learn.planners.joints.straight import at_once
from gcm_learn.planners.joints.ways import Way, new_way, shorten
from gcm_learn.planners.plan import Plan, in_joints
from gcm_learn.situation import AnySituation


@dataclass(frozen=True)
class TreeSearch:
    """Straight moves to postures that catch and trees from both ends, grown in turn.

    Every posture that catches is first tried by a straight move from the start.
    """

    name: str = "search"
    rounds: int = 4000
    """Postures that catch to draw; the limit of work."""
    seed: int = 1

    takes = staticmethod(in_joints)

    def plan(self, situation: AnySituation) -> Plan:
        """Answer a situation."""
        problem: Any = SpatialProblem(situation, self.name)
        early = problem.early_answer(keeps_acceleration=True) or at_once(problem)
        if early is not None:
            return early
        study = problem.study
        trees = new_trees(study, self.rounds + 2, self.seed, problem.accelerates)
        way, short = new_way(study.goal.size), new_way(study.goal.size)
        if not search_trees(study, trees, self.rounds, situation.horizon, way):
            return problem.answer(Failure.NO_TREE)
        if problem.accelerates:
            shorten_ramped(study, way, trees.moves, short)
            return _finished(problem, trees.moves, short)
        shorten(study, way, short)
        return finished(problem, study, short)


def _finished(problem: SpatialProblem, moves: Any, way: Way) -> Plan:
    """The way under limits of acceleration as a plan, its catch made earlier, and verified."""
    hasten_ramped(problem.study, way, moves)
    *samples, body = ramped_samples(problem.study, way, moves)
    path = Movement(problem.situation.arm, *samples)
    plan, reason = checked(problem, Attempt(path, int(body)))
    return problem.answer(reason or Failure.NO_INTERCEPTION) if plan is None else plan
