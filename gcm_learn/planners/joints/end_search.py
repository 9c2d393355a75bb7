"""The search where a touch will not do: holds, stops and limits of jerk."""

from __future__ import annotations

import numpy as np

from gcm_learn.motion import Failure, Movement, Reason, half_width, smoothed, start_before
from gcm_learn.planners.completion import Attempt, JointProblem, checked
from gcm_learn.planners.joints.endings import FAST, FORCED, new_endings
from gcm_learn.planners.joints.meeting_trees import hastened, plant_stop, search_trees
from gcm_learn.planners.joints.ramped_ways import ramped_samples, shorten_ramped
from gcm_learn.planners.joints.ramps import GIVEN
from gcm_learn.planners.joints.tree_moves import FROM_START
from gcm_learn.planners.joints.trees import Trees, new_trees, roomier
from gcm_learn.planners.joints.ways import JointWay, new_way
from gcm_learn.planners.plan import Plan

SLICE = 50
"""Ends to draw between two readings of the clock."""
SOONER = 20
"""Earlier ends that are tried once there is a way."""
ROOM = 1000
"""Nodes that new trees can hold, and ends that are kept."""


class EndSearch:
    """Search by two trees; roots of the second are whole ends of movements, see `endings`."""

    def __init__(self, problem: JointProblem, seed: int) -> None:
        limits = problem.scene.limits
        self.problem, arm = problem, problem.situation.arm
        jerk = arm.max_joint_jerk
        self.half = 0.0 if jerk is None else half_width(limits.joint_acceleration, np.array(jerk))
        self.forces = np.array(arm.joint_accelerations or (0.0,) * len(arm.joints))
        joints, rates = np.array(arm.joints), np.array(arm.joint_rates)
        self.before = start_before(joints, rates, self.forces, self.half)
        if self.half > 0.0:
            joints, rates = self.before[0] + rates * self.half, rates + self.forces * self.half
            joints += 0.5 * self.forces * self.half**2
        limb = problem.scene.limb._replace(start=joints, rates=rates)
        self.study = problem.study._replace(scene=problem.scene._replace(limb=limb))
        self.trees = self._new_trees(seed)
        self.ends = new_endings(self.study, problem.situation, ROOM, self.half)

    def _new_trees(self, seed: int) -> Trees:
        trees = new_trees(self.study, ROOM, seed, True)
        trees.time[FROM_START, 0] = self.half
        plant_stop(self.study, trees)
        return trees

    def plan(self, end: float, rounds: int) -> Plan:
        """Return a plan with a catch until `end` [s], or the reason for its absence."""
        problem, way, left = self.problem, new_way(self.study.goal.size), rounds
        plan = None
        while left > 0 and plan is None and not problem.over and problem.budget[0] >= 0:
            size = min(SLICE, left)
            left -= size
            if int(self.trees.size.max()) + 4 * size + SOONER > self.trees.time.shape[1]:
                self.trees = roomier(self.trees)
            if search_trees(self.ends, self.study, self.trees, size, end, way):
                hastened(self.ends, self.study, self.trees, SOONER, way)
                plan = self._finished(way)
        problem.nodes += int(self.trees.size.sum()) - 1
        if plan is not None:
            return plan
        return problem.answer(self._reason())

    def _reason(self) -> Failure | Reason:
        """Return the reason for a missing catch."""
        ends, limits = self.ends, self.study.scene.limits
        if ends.made[0] == 0 and ends.why[FAST] > max(ends.why[FORCED:].max(), 0):
            share, j = float(ends.need[0]), int(ends.need[1])
            most = limits.joint_speed[j]
            speeds = {"rate": f"{share * most:.3g}", "most": f"{most:.3g}"}
            return Failure.TOO_FAST.with_numbers(joint=j + 1, **speeds)
        return Failure.OUT_OF_TIME if self.problem.over else Failure.NO_TREE

    def _finished(self, way: JointWay) -> Plan | None:
        """Return the plan of a way and its end; None if the movement fails verification."""
        attempt = self.attempt(way)
        return None if attempt is None else checked(self.problem, attempt)[0]

    def attempt(self, way: JointWay) -> Attempt | None:
        """Return a way and its end as a movement within the limit of jerk; None if impossible."""
        moves = self._joined(way)
        e = int(way.body[0])
        catch = self.ends.span[e]
        if self.half > 0.0:
            averaged = smoothed(moves, self.forces, self.half, np.unique(catch))
            if averaged is None:
                return None
            arm, moves = self.problem.situation.arm, averaged
            assert moves.rates is not None
            moves.joints[0], moves.rates[0] = arm.joints, arm.joint_rates  # to the last digit
        return Attempt(moves, int(self.ends.body[e]), *map(float, catch))

    def _joined(self, way: JointWay) -> Movement:
        """Join the start, a way without needless postures, and the way's end to one movement."""
        short, e, ends = new_way(self.study.goal.size), int(way.body[0]), self.ends
        shorten_ramped(self.study, way, self.trees.moves, GIVEN, short)
        time, joints, rates = ramped_samples(self.study, short, self.trees.moves)
        last = slice(int(ends.first[e]) + 1, int(ends.size[e]))
        parts = [[time, joints, rates]]
        parts.append([ends.time[e, last], ends.joints[e, last], ends.rates[e, last]])
        if self.half > 0.0:
            parts.insert(0, [np.zeros(1), self.before[0][None], self.before[1][None]])
        arrays = [np.concatenate(column) for column in zip(*parts, strict=True)]
        return Movement(self.problem.situation.arm, *arrays)
