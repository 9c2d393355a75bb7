"""Questions of the tree planner about joints and time: if a straight leg holds, where goals are.

Places are joints in units of what each turns in a second, so that distances are times.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from gcm_learn.arms.limbs import dof
from gcm_learn.arms.spatial_limb import limb_at
from gcm_learn.arms.swivels import inverse
from gcm_learn.collision.postures import distance_at
from gcm_learn.compiled import njit
from gcm_learn.motion.joint_interception import target_room
from gcm_learn.planners.completion import Attempt, SpatialProblem
from gcm_learn.planners.joints.moves import (
    Study,
    time_of,
    timed_move_is_free,
    turning_time,
)
from gcm_learn.planners.joints.straight import attempt_along, soonest_straight
from gcm_learn.scene import Scene
from gcm_learn.scene.bodies import HAND, PART, REACH, centre_at

SPEED = 1.0
"""Of places, with which OMPL reckons. It leaves out legs on which several joints turn at their
fastest; 2 would leave out none. Of 44 situations 1, 1.4 and 2 caught 38, 34 and 31 within 100 ms,
and 41, 39 and 39 within a second."""
_SLACK = 1e-6  # of the bounds of places, which must not be empty [s]


@njit(_nrt=False)
def leg_holds_in_space(study, q, since, p, until):
    """Tell whether the joints may go straight from q at `since` to p (dof,) at `until` [s]."""
    took, pieces = time_of(study, q, p)
    if until - since < took or until <= since:
        return False
    return timed_move_is_free(study, q, since, p, until, pieces)


@njit(_nrt=False)
def draw_posture(study, since, until, chances, q):
    """Draw an interception: an instant, and joints (dof,) whose hand is then on a target, into q.

    Parameters
    ----------
    since, until : float
        The instants to draw from [s].
    chances : (n, 7) ndarray
        Uniform in [0, 1): the numbers for n tries.

    Returns
    -------
    time : float
        -1 if all tries fail [s].
    """
    scene, poses = study.scene, study.desk.poses
    limb, rows = scene.limb, scene.bodies.rows
    targets = 0
    for b in range(rows.shape[0]):
        targets += rows[b, PART] == HAND
    for k in range(chances.shape[0]):
        left, b = int(chances[k, 0] * targets), -1
        while left >= 0:
            b += 1
            left -= rows[b, PART] == HAND
        t = since + chances[k, 1] * (until - since)
        centre_at(scene.bodies, b, t, poses)
        r = chances[k, 2] ** (1.0 / 3.0) * (rows[b, REACH] + max(study.catch, 0.0))
        up, turn = 2.0 * chances[k, 3] - 1.0, 2.0 * np.pi * chances[k, 4]
        wide = r * np.sqrt(1.0 - up * up)
        x, y = poses[b, 0] + wide * np.cos(turn), poses[b, 1] + wide * np.sin(turn)
        z = poses[b, 2] + r * up
        if x * x + y * y + z * z > (limb.rho + limb.length) ** 2:
            continue
        if target_room(scene, b, x, y, z, t, poses) > study.catch:
            continue
        swivel = 2.0 * np.pi * chances[k, 5]
        found = inverse(limb, x, y, z, swivel, limb.start, study.branches)
        if found == 0:
            continue
        branch = int(chances[k, 6] * found)
        for j in range(dof(limb)):
            q[j] = study.branches[branch, j]
        _, _, _, x, y, z = limb_at(limb, q)  # the inverse is exact but for rounding
        if target_room(scene, b, x, y, z, t, poses) > study.catch:
            continue
        if turning_time(scene.limits.joint_speed, limb.start, q) > t:
            continue
        if distance_at(scene, q, t, study.desk) > study.touch:
            return t
    return -1.0


@dataclass(frozen=True)
class JointTask:
    """Task of the search and its budget."""

    study: Study
    unhindered: float
    """No goal is before [s]."""
    seed: int
    budget_ms: float
    """Of processor time."""
    iterations: int

    draws: ClassVar[int] = 7
    speed: ClassVar[float] = SPEED

    @property
    def scene(self) -> Scene:
        """Scene of the task."""
        return self.study.scene

    @property
    def start(self) -> tuple[float, ...]:
        """The joints at t = 0."""
        return tuple(self.scene.limb.start / self.scene.limits.joint_speed)

    @property
    def bounds(self) -> tuple[tuple[float, float], ...]:
        """Lowest and highest places of each joint that it may come to before the horizon."""
        limb, rate, end = self.scene.limb, self.scene.limits.joint_speed, self.scene.limits.horizon
        ends = zip(limb.low / rate, limb.high / rate, self.start, strict=True)
        return tuple((max(a, s - end) - _SLACK, min(b, s + end) + _SLACK) for a, b, s in ends)

    def joints(self, place: Sequence[float]) -> np.ndarray:
        """Joints (dof,) of a place; those at t = 0 to the bit."""
        limb, rate = self.scene.limb, self.scene.limits.joint_speed
        here = np.array([place[j] for j in range(limb.start.size)])
        if (here == self.start).all():
            return np.array(limb.start)
        return np.clip(here * rate, limb.low, limb.high)

    def holds(self, p: Sequence[float], since: float, q: Sequence[float], until: float) -> bool:
        """Return whether the leg from p to q holds; see `leg_holds_in_space`."""
        ends = self.joints(p), since, self.joints(q), until
        return bool(leg_holds_in_space(self.study, *ends))

    def draw(self, until: float, chances: np.ndarray) -> tuple[float, ...]:
        """An interception before `until` [s]: when (-1 if all tries fail) and where."""
        q = np.zeros_like(self.scene.limb.start)
        time = draw_posture(self.study, self.unhindered, until, chances, q)
        return (float(time), *(q / self.scene.limits.joint_speed).tolist())


def task_in_space(
    problem: SpatialProblem, seed: int, budget_ms: float, iterations: int
) -> JointTask:
    """Return the task of the search."""
    study = problem.study
    soonest = max(soonest_straight(study) - problem.rules.instant, 0.0)
    return JointTask(study, soonest, seed, budget_ms, iterations)


def ways_along(problem: SpatialProblem, paths: list[np.ndarray]) -> list[Attempt]:
    """Paths between states (n, dof + 1), the earliest catch first; targets may cut them short."""
    study, limb = problem.study, problem.scene.limb
    body = int(np.flatnonzero(problem.bodies.rows[:, PART] == HAND)[0])
    attempts = []
    for path in paths:
        joints = path[:, :-1] * problem.scene.limits.joint_speed
        joints = np.clip(joints, limb.low, limb.high)
        joints[0] = limb.start
        attempts.append(attempt_along(problem, study, path[:, -1], joints, body))
    return sorted(attempts, key=lambda attempt: attempt.trajectory.duration)
