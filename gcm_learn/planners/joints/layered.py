"""The planner of first choice for spatial arms: straight moves, then search over the joints."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from gcm_learn.motion import Failure, Movement
from gcm_learn.planners.completion import Attempt, SpatialProblem, checked
from gcm_learn.planners.joints.accelerated import plan_accelerated
from gcm_learn.planners.joints.goals import (
    Goals,
    add_more,
    add_spread,
    no_goals,
    straight,
    straight_to,
)
from gcm_learn.planners.joints.moves import Study
from gcm_learn.planners.joints.sides import Effort, two_sided
from gcm_learn.planners.joints.straight import at_once, earliest_straight
from gcm_learn.planners.joints.ways import Way, hasten, new_way, samples_of, shorten, write
from gcm_learn.planners.plan import Deadline, Plan, deadline_of, spatial_only
from gcm_learn.scene import HAND, PART
from gcm_learn.situation import AnySituation

COARSE = Effort(10**4, (600, 2400))
FINE = Effort(10**4, (2000, 8000))
SPREAD = 72
"""Postures that are pulled to a target without goals, at each of four times as many instants."""
INSTANTS, GOALS = 16, 100
"""Instants and goals that are tried between two readings of the clock."""


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
    """True to search for catches before the first one that is found, until none is earlier by a
    hundredth of the horizon."""

    takes = staticmethod(spatial_only)

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
            See `Anytime`.
        """
        if bound is not None and not bound > 0.0:
            raise ValueError(f"bound: must be positive (got {bound:g})")
        problem = SpatialProblem(situation, self.name, deadline=deadline_of(deadline))
        early = problem.early_answer(keeps_acceleration=True)
        if early is not None:
            return early
        end = min(situation.horizon, np.inf if bound is None else bound)
        if not problem.accelerates:
            return self._planned(problem, end, self.earliest or problem.deadline is not None)
        plan = at_once(problem) or self._accelerated(problem, end)
        while plan.catch_time is not None and problem.deadline is not None:
            end = plan.catch_time - problem.gain
            sooner = self._accelerated(problem, end) if end > 0.0 and not problem.over else None
            if sooner is None or not sooner.caught:
                return replace(plan, nodes=problem.nodes)
            plan = sooner
        return plan

    def _accelerated(self, problem: SpatialProblem, end: float) -> Plan:
        """A catch before `end` [s] under limits of acceleration."""

        def unlimited(situation: AnySituation) -> Plan:
            eased = SpatialProblem(situation, self.name, deadline=problem.deadline)
            plan = eased.early_answer() or self._planned(eased, end, self.earliest)
            problem.nodes += eased.nodes
            return plan

        tried = self._room_for_goals(problem), self._times(end)
        return plan_accelerated(problem, tried, self.swivels, unlimited)

    def _planned(self, problem: SpatialProblem, end: float, earliest: bool) -> Plan:
        """A catch before `end` [s], or the earliest one.

        No movement is sooner than a straight line to the first interception, so if that is free
        nothing else is looked for.
        """
        line = earliest_straight(problem)
        if line.catch_time is not None and line.catch_time <= end:
            return line
        study = problem.study
        best: Plan | None = None
        while True:
            thorough, way = best is None, None
            if not problem.over:
                way = self._way(problem, study, end, thorough=thorough)
            if way is None:
                why = Failure.OUT_OF_TIME if problem.over else Failure.NO_INTERCEPTION
                return replace(best, nodes=problem.nodes) if best else problem.answer(why)
            plan = finished(problem, study, way)
            if plan.catch_time is None or not earliest:
                return best or plan
            best, end = plan, plan.catch_time - problem.gain
            if end <= 0.0:
                return best

    def _times(self, end: float, more: int = 1) -> np.ndarray:
        """Instants at which interceptions are tried [s]."""
        count = more * self.instants
        times = end * np.arange(1, count + 1) / count
        times[-1] = end
        return times

    def _room_for_goals(self, problem: SpatialProblem, more: int = 1) -> Goals:
        targets = int((problem.bodies.rows[:, PART] == HAND).sum())
        joints = len(problem.situation.arm.joints)
        return no_goals(joints, targets, more * self.instants, more * self.swivels)

    def _way(
        self, problem: SpatialProblem, study: Study, end: float, *, thorough: bool
    ) -> Way | None:
        """A way to a catch before `end` [s]; a thorough search also grazes targets."""
        goals, ends = self._room_for_goals(problem), np.zeros(2)
        goal = straight(study, goals, self._times(end), self.swivels, ends)
        if goal >= 0:
            return _direct(study, goals, goal, ends)
        way = two_sided(problem, study, goals, self.coarse)
        if way is None and not problem.over:
            goals, effort = self._more_goals(problem, study, end, thorough=thorough)
            goal = _straight_to_any(problem, study, goals, ends)
            if goal >= 0:
                return _direct(study, goals, goal, ends)
            way = two_sided(problem, study, goals, effort)
        if way is None:
            return None
        short = new_way(study.goal.size)
        shorten(study, way, short)
        return short

    def _more_goals(
        self, problem: SpatialProblem, study: Study, end: float, *, thorough: bool
    ) -> tuple[Goals, Effort]:
        """More goals than at first, and how hard to try for them."""
        goals = self._room_for_goals(problem, 2)
        add_more(study, goals, self._times(end, 2), 2 * self.swivels)
        if goals.size[0] > 0 or not thorough:
            return goals, self.fine
        times = self._times(end, 4)
        size = problem.slices(INSTANTS, times.size)
        for k in range(0, times.size, size):
            if not problem.over:
                add_spread(study, goals, times[k : k + size], SPREAD)
        return goals, self.coarse


def _straight_to_any(problem: SpatialProblem, study: Study, goals: Goals, ends: np.ndarray) -> int:
    """First of the goals to which there is a straight move from the start, -1 if none."""
    count, goal = int(goals.size[0]), -1
    size = problem.slices(GOALS, max(count, 1))
    for first in range(0, count, size):
        if goal < 0 and not problem.over:
            goal = straight_to(study, goals, first, first + size, ends)
    return goal


def posture_layered(effort: float = 1.0) -> LayeredInSpace:
    """The planner with a share of the tries after which its searches give up."""
    return LayeredInSpace(coarse=COARSE.times(effort), fine=FINE.times(effort))


def _direct(study: Study, goals: Goals, goal: int, ends: np.ndarray) -> Way:
    """The straight move from the start to a goal that begins and ends (2,) when it should [s]."""
    way = new_way(study.goal.size)
    write(way, 0, study.scene.limb.start, 0.0, ends[0])
    write(way, 1, goals.joints[goal], ends[1], goals.time[goal])
    way.body[0] = goals.body[goal]
    return way


def finished(problem: SpatialProblem, study: Study, way: Way) -> Plan:
    """The way as a plan: its catch made as early as it can be, and verified."""
    hasten(study, way)
    time, joints, body = samples_of(study, way)
    path = Movement(problem.situation.arm, time, joints)
    plan, reason = checked(problem, Attempt(path, int(body)))
    return problem.answer(reason or Failure.NO_INTERCEPTION) if plan is None else plan


def search() -> LayeredInSpace:
    """Return the default planner of spatial arms: `layered` by its general name."""
    return LayeredInSpace(name="search")
