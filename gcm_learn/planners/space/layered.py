"""The planner of first choice for spatial arms: straight moves, then search over the joints."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from gcm_learn.handspace import joint_lattice
from gcm_learn.motion import Failure, SpatialTrajectory
from gcm_learn.planners.completion import Attempt, SpatialProblem, checked
from gcm_learn.planners.plan import Plan
from gcm_learn.planners.space.accelerated import plan_accelerated
from gcm_learn.planners.space.goals import Goals, no_goals, straight
from gcm_learn.planners.space.moves import NEVER, Study, study_of
from gcm_learn.planners.space.search import new_tree, plant, search
from gcm_learn.planners.space.straight import at_once
from gcm_learn.planners.space.ways import (
    Way,
    hasten,
    new_way,
    samples_of,
    shorten,
    trace,
    write,
)
from gcm_learn.scene import HAND, PART
from gcm_learn.situation import AnySituation


@dataclass(frozen=True)
class LayeredInSpace:
    """Straight moves to postures that catch; where none is free, A* over the joints with waits."""

    name: str = "layered"
    nodes: int = 16**4
    """Of the lattice over the joints, about."""
    instants: int = 32
    """Times at which interceptions are tried."""
    swivels: int = 12
    """Of the elbow that are tried at each of them."""
    tries: int = 20_000
    """Moves that the search looks at before it gives up."""
    weight: float = 1.0
    """Of the motion that is left, beside the time of the catch."""

    takes_space: ClassVar[bool] = True

    def plan(self, situation: AnySituation) -> Plan[SpatialTrajectory]:
        """Answer a situation."""
        problem = SpatialProblem(situation, self.name)
        early = problem.early_answer(keeps_acceleration=True)
        if early is not None:
            return early
        caught = at_once(problem)
        if caught is not None:
            return caught
        if problem.accelerates:
            return plan_accelerated(
                problem, self._goals_and_times(problem), self.swivels, self.plan
            )
        study = study_of(problem.scene, problem.rules)
        goals = self._room_for_goals(problem)
        way = self._straight(study, goals, problem.situation.horizon)
        if way is None:
            way = self._search(study, goals)
        if way is None:
            return problem.answer(Failure.NO_INTERCEPTION)
        return finished(problem, study, way)

    def _goals_and_times(self, problem: SpatialProblem) -> tuple[Goals, np.ndarray]:
        """Room for goals, and when interceptions are tried."""
        times = problem.situation.horizon * np.arange(1, self.instants + 1) / self.instants
        return self._room_for_goals(problem), times

    def _room_for_goals(self, problem: SpatialProblem) -> Goals:
        targets = int((problem.bodies.rows[:, PART] == HAND).sum())
        return no_goals(targets, self.instants, self.swivels)

    def _straight(self, study: Study, goals: Goals, horizon: float) -> Way | None:
        """A straight move from the start."""
        times = horizon * np.arange(1, self.instants + 1) / self.instants
        times[-1] = horizon
        ends = np.zeros(2)
        goal = straight(study, goals, times, self.swivels, ends)
        if goal < 0:
            return None
        way, start = new_way(), study.scene.limb.start
        write(way, 0, start, 0.0, ends[0])
        write(way, 1, goals.joints[goal], ends[1], goals.time[goal])
        way.body[0] = goals.body[goal]
        return way

    def _search(self, study: Study, goals: Goals) -> Way | None:
        """What A* finds first."""
        if goals.size[0] == 0:
            return None
        lattice = joint_lattice(study.scene, self.nodes)
        tree, ends = new_tree(int(lattice.counts.prod()), self.tries), np.zeros(2)
        if not plant(study, lattice, goals, tree, NEVER, self.weight):
            return None
        state, goal, _ = search(study, lattice, goals, tree, self.tries, NEVER, self.weight, ends)
        if state < 0:
            return None
        found, way = new_way(), new_way()
        if not trace(study, goals, tree, state, goal, ends, found):
            return None
        shorten(study, found, way)
        return way


def finished(problem: SpatialProblem, study: Study, way: Way) -> Plan[SpatialTrajectory]:
    """The way as a plan: its catch made as early as it can be, and verified."""
    hasten(study, way)
    time, joints, body = samples_of(study, way)
    path = SpatialTrajectory(problem.situation.arm, time, joints)
    plan, reason = checked(problem, Attempt(path, int(body)))
    return problem.answer(reason or Failure.NO_INTERCEPTION) if plan is None else plan
