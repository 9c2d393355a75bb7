"""An artificial potential field over the joints of a spatial arm, step by step.

Joints count in what each turns in a second, so that the field leads where the arm is quick.  It
pulls towards the posture of the soonest interception, as seen from the present posture.  It pushes
by the distance of the whole limb to every obstacle (Khatib's potential).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.arms.limbs import dof
from gcm_learn.collision.postures import distance_at
from gcm_learn.compiled import njit
from gcm_learn.motion import Failure
from gcm_learn.motion.joint_interception import fastest_hand, met_at
from gcm_learn.planners.completion import JointProblem, checked
from gcm_learn.planners.joints.moves import time_of
from gcm_learn.planners.joints.pull import met_from
from gcm_learn.planners.joints.straight import attempt_along
from gcm_learn.planners.plan import Plan
from gcm_learn.scene.bodies import HAND, PART

STEPS = 200  # of the horizon
_AHEAD = 40  # instants after each step at which an interception is looked for
_PROBE = 1e-4  # finite difference of the potential [s]
_NEAREST = 1e-3  # the push grows no more below this distance [forearms]


class SpatialField(NamedTuple):
    """The repulsive potential; the attractive force is 1."""

    influence: float  # distance within which obstacles push [forearms]
    gain: float


@njit(_nrt=False)
def push(study, field, q, t):
    """Khatib's repulsive potential of the nearest obstacle at joints q (dof,) and time t [s]."""
    unit = study.scene.limb.length
    away = distance_at(study.scene, q, t, study.desk) - study.scene.limb.thickness
    d = max(away / unit, _NEAREST)
    if d >= field.influence:
        return 0.0
    return 0.5 * field.gain * (1.0 / d - 1.0 / field.influence) ** 2


@njit(_nrt=False)
def aim(study, q, t):
    """Write the posture of the soonest interception from joints q at t [s] to ``study.goal``.

    Returns
    -------
    bool
        Whether there is one before the horizon.
    """
    scene, end = study.scene, study.scene.limits.horizon
    for k in range(1, _AHEAD + 1):
        when = t + (end - t) * (k / _AHEAD) ** 2  # near ones are separated more finely
        for b in range(scene.bodies.rows.shape[0]):
            if scene.bodies.rows[b, PART] == HAND and met_from(study, q, t, b, q, when) > 0:
                return True
    return False


@njit
def descend_in_space(study, field, points):
    """Follow the field from the start to the first target within reach.

    Parameters
    ----------
    points : (m, dof) ndarray
        Filled with the joints after every step of horizon / (m - 1), the start included.

    Returns
    -------
    count : int
        Number of points when a target is met, -1 if none ever is.
    """
    scene, steps = study.scene, points.shape[0] - 1
    limb, rate, fast = scene.limb, scene.limits.joint_speed, fastest_hand(scene)
    dt, q, goal = scene.limits.horizon / steps, limb.start.copy(), study.goal
    force = np.zeros(dof(limb))
    for k in range(steps + 1):
        t = k * dt
        points[k] = q
        if met_at(scene, q, t, study.catch, study.desk.poses) >= 0:
            return k + 1
        if k == steps or not aim(study, q, t):
            return -1
        most = 0.0
        for j in range(dof(limb)):
            most = max(most, abs(goal[j] - q[j]) / rate[j])
        strongest = 1.0
        for j in range(dof(limb)):
            here, probe = q[j], _PROBE * rate[j]
            q[j] = here + probe
            up = push(study, field, q, t + dt)
            q[j] = here - probe
            down = push(study, field, q, t + dt)
            q[j] = here
            away = (up - down) / (2.0 * _PROBE) * limb.length / fast
            force[j] = (goal[j] - here) / rate[j] / max(most, dt) - away
            strongest = max(strongest, abs(force[j]))
        for j in range(dof(limb)):
            there = q[j] + dt * rate[j] * force[j] / strongest
            goal[j] = min(max(there, limb.low[j]), limb.high[j])
        took = time_of(study, q, goal)[0]
        share = min(1.0, dt / took) if took > 0.0 else 1.0
        for j in range(dof(limb)):
            q[j] += share * (goal[j] - q[j])
    return -1


def potential_plan(problem: JointProblem, influence: float, gain: float) -> Plan:
    """Follow the potential field in the known world and verify the resulting movement."""
    study = problem.study
    points = np.empty((STEPS + 1, study.goal.size))
    count = descend_in_space(study, SpatialField(influence, gain), points)
    if count < 0:
        return problem.answer(Failure.NO_FIELD_LINE)
    time = problem.situation.horizon * np.arange(count) / STEPS
    body = met_at(problem.scene, points[count - 1], time[-1], study.catch, study.desk.poses)
    plan, reason = checked(problem, attempt_along(problem, study, time, points[:count], body))
    return problem.answer(reason or Failure.NO_FIELD_LINE) if plan is None else plan
