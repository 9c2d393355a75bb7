"""The planner of first choice for spatial arms: straight moves, then search over the joints."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from gcm_learn.motion import Failure, SpatialTrajectory
from gcm_learn.planners.completion import Attempt, SpatialProblem, checked
from gcm_learn.planners.plan import Plan
from gcm_learn.planners.space.accelerated import plan_accelerated
from gcm_learn.planners.space.goals import (
    Goals,
    add_more,
    add_spread,
    no_goals,
    straight,
    straight_to,
)
from gcm_learn.planners.space.moves import Study, study_of
from gcm_learn.planners.space.sides import Effort, two_sided
from gcm_learn.planners.space.straight import at_once, earliest_straight
from gcm_learn.planners.space.ways import Way, hasten, new_way, samples_of, shorten, write
from gcm_learn.scene import HAND, PART
from gcm_learn.situation import AnySituation

COARSE = Effort(10**4, (600, 2400))
FINE = Effort(10**4, (2000, 8000))
SPREAD = 72
"""Postures that are pulled to a target without goals, at each of four times as many instants."""
GAIN = 0.01  # of the horizon, by which a catch must be earlier to be looked for


@dataclass(frozen=True)
class LayeredInSpace:
    """Straight moves to postures that catch; where none is free, A* over the joints with waits.

    It is tried with few goals on a coarse lattice, then with more of them on a finer one. Each
    search goes from the start to the goals and from the goals to the start in turn.
    """

    name: str = "layered"
    instants: int = 32
    """Times at which interceptions are tried; twice as many when that is not enough."""
    swivels: int = 12
    """Of the elbow that are tried at each of them; likewise."""
    coarse: Effort = COARSE
    fine: Effort = FINE
    earliest: bool = False
    """Whether catches before the first one that is found are looked for, until there is none that
    is earlier by a hundredth of the horizon."""

    takes_space: ClassVar[bool] = True

    def plan(self, situation: AnySituation, bound: float | None = None) -> Plan[SpatialTrajectory]:
        """Answer a situation.

        Parameters
        ----------
        situation : Situation
        bound : float, optional
            Only catches before this time are wanted [s]; e.g. that of a catch that is known.
        """
        if bound is not None and not bound > 0.0:
            raise ValueError(f"bound: must be positive (got {bound:g})")
        problem = SpatialProblem(situation, self.name)
        early = problem.early_answer(keeps_acceleration=True)
        if early is not None:
            return early
        end = min(situation.horizon, np.inf if bound is None else bound)
        if problem.accelerates:
            tried = self._room_for_goals(problem), self._times(end)
            caught = at_once(problem)
            return caught or plan_accelerated(problem, tried, self.swivels, self.plan)
        return self._planned(problem, end)

    def _planned(self, problem: SpatialProblem, end: float) -> Plan[SpatialTrajectory]:
        """A catch before `end` [s], or the earliest one.

        No movement is sooner than a straight line to the first interception, so if that is free
        nothing else is looked for.
        """
        line = earliest_straight(problem)
        if line.catch_time is not None and line.catch_time <= end:
            return line
        study = study_of(problem.scene, problem.rules)
        best: Plan[SpatialTrajectory] | None = None
        while True:
            way = self._way(problem, study, end, thorough=best is None)
            if way is None:
                return best or problem.answer(Failure.NO_INTERCEPTION)
            plan = finished(problem, study, way)
            if plan.catch_time is None or not self.earliest:
                return best or plan
            best = plan
            end = plan.catch_time - GAIN * problem.situation.horizon
            if end <= 0.0:
                return best

    def _times(self, end: float, more: int = 1) -> np.ndarray:
        """When interceptions are tried [s]."""
        count = more * self.instants
        times = end * np.arange(1, count + 1) / count
        times[-1] = end
        return times

    def _room_for_goals(self, problem: SpatialProblem, more: int = 1) -> Goals:
        targets = int((problem.bodies.rows[:, PART] == HAND).sum())
        return no_goals(targets, more * self.instants, more * self.swivels)

    def _way(
        self, problem: SpatialProblem, study: Study, end: float, *, thorough: bool
    ) -> Way | None:
        """A way to a catch before `end` [s]; a thorough search also grazes targets."""
        goals, ends = self._room_for_goals(problem), np.zeros(2)
        goal = straight(study, goals, self._times(end), self.swivels, ends)
        if goal >= 0:
            return _direct(study, goals, goal, ends)
        way = two_sided(study, goals, self.coarse)
        if way is None:
            goals = self._room_for_goals(problem, 2)
            add_more(study, goals, self._times(end, 2), 2 * self.swivels)
            effort = self.fine
            if goals.size[0] == 0 and thorough:
                add_spread(study, goals, self._times(end, 4), SPREAD)
                effort = self.coarse
            goal = straight_to(study, goals, ends)
            if goal >= 0:
                return _direct(study, goals, goal, ends)
            way = two_sided(study, goals, effort)
        if way is None:
            return None
        short = new_way()
        shorten(study, way, short)
        return short


def _direct(study: Study, goals: Goals, goal: int, ends: np.ndarray) -> Way:
    """The straight move from the start to a goal that begins and ends (2,) when it should [s]."""
    way = new_way()
    write(way, 0, study.scene.limb.start, 0.0, ends[0])
    write(way, 1, goals.joints[goal], ends[1], goals.time[goal])
    way.body[0] = goals.body[goal]
    return way


def finished(problem: SpatialProblem, study: Study, way: Way) -> Plan[SpatialTrajectory]:
    """The way as a plan: its catch made as early as it can be, and verified."""
    hasten(study, way)
    time, joints, body = samples_of(study, way)
    path = SpatialTrajectory(problem.situation.arm, time, joints)
    plan, reason = checked(problem, Attempt(path, int(body)))
    return problem.answer(reason or Failure.NO_INTERCEPTION) if plan is None else plan
