"""Meetings of a hand with targets, and the rates of the joints that lead straight there.

Approximate: the hand is as fast as the joints can move it now in the target's direction. Balls
stand for bodies.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.arms.limbs import dof, hand_of, jacobian, place
from gcm_learn.compiled import njit
from gcm_learn.scene.bodies import HAND, PART, REACH, TOP_SPEED, centre_at

_INSTANTS = 16  # at which an interception is looked for
_BISECTIONS = 6
_DAMPING = 0.1  # share of the fastest hand, near singular postures [1]
_AT_END = 1e-3  # of a joint's range: it does not go on there [rad]
_SLOWEST = 0.1  # share of the fastest hand that is expected at least
AIM_ROW = 3  # row of a view's rates in which the aim is left


class JointMeeting(NamedTuple):
    """About when and where the hand first meets a target."""

    body: int
    found: bool
    time: float  # the horizon if there is none [s]
    x: float  # the target's centre then
    y: float
    z: float


@njit(_nrt=False)
def _solve(limb, matrix, damping, x, y, z):
    """(M M^T + damping^2)^-1 (x, y, z) of a matrix M (3, dof), by Cramer's rule."""
    a = b = c = d = e = f = 0.0
    for j in range(dof(limb)):
        p, q, r = matrix[0, j], matrix[1, j], matrix[2, j]
        a, b, c = a + p * p, b + p * q, c + p * r
        d, e, f = d + q * q, e + q * r, f + r * r
    a, d, f = a + damping * damping, d + damping * damping, f + damping * damping
    u, v, w = d * f - e * e, c * e - b * f, b * e - c * d
    whole = a * u + b * v + c * w
    p, q, r = a * f - c * c, b * c - a * e, a * d - b * b
    return (
        (u * x + v * y + w * z) / whole,
        (v * x + p * y + q * z) / whole,
        (w * x + q * y + r * z) / whole,
    )


@njit(_nrt=False)
def aim_along(view, posture, e, x, y, z):
    """Work out how the joints take the hand in a unit direction (x, y, z), at their fastest.

    Damped least squares in shares of the joints' speeds; joints at an end of their range are left
    where they are. The aim is left in the view, as a command.

    Returns
    -------
    float
        Speed of the hand in that direction [lengths/s].
    """
    scene, matrix, aim = view.scene, view.jacobian, view.rates[AIM_ROW]
    limb, limits = scene.limb, scene.limits
    for j in range(dof(limb)):
        view.rates[0, j] = posture[e, j]
    jacobian(limb, view.rates[0], matrix)
    for j in range(dof(limb)):
        for i in range(3):
            matrix[i, j] *= limits.joint_speed[j]
    for _ in range(dof(limb)):
        u, v, w = _solve(limb, matrix, _DAMPING * view.pace, x, y, z)
        stuck = False
        for j in range(dof(limb)):
            aim[j] = matrix[0, j] * u + matrix[1, j] * v + matrix[2, j] * w
            up = posture[e, j] >= limb.high[j] - _AT_END and aim[j] > 0.0
            down = posture[e, j] <= limb.low[j] + _AT_END and aim[j] < 0.0
            if up or down:
                stuck, aim[j] = True, 0.0
                for i in range(3):
                    matrix[i, j] = 0.0
        if not stuck:
            break
    top = abs(aim[0])
    for j in range(1, dof(limb)):
        top = max(top, abs(aim[j]))
    hx = hy = hz = 0.0
    for j in range(dof(limb)):
        aim[j] /= max(top, 1e-12)
        hx, hy, hz = (
            hx + matrix[0, j] * aim[j], hy + matrix[1, j] * aim[j], hz + matrix[2, j] * aim[j]
        )  # fmt: skip
    speed = np.sqrt(hx * hx + hy * hy + hz * hz)
    if speed > limits.speed:
        for j in range(dof(limb)):
            aim[j] *= limits.speed / speed
        return limits.speed
    return max(hx * x + hy * y + hz * z, 0.0)


@njit(_nrt=False)
def _missing(view, b, hand, t, wait, pace):
    """Return the distance that a hand lacks to body b after `wait` [s], at time t.

    At most 0 if it gets there. The body's centre is left in the poses.
    """
    poses = view.desk.poses
    centre_at(view.scene.bodies, b, t, poses)
    x, y, z = poses[b, 0], poses[b, 1], poses[b, 2]
    near = view.scene.bodies.rows[b, REACH] + view.rules.catch
    way = np.sqrt((x - hand[0]) ** 2 + (y - hand[1]) ** 2 + (z - hand[2]) ** 2)
    return max(way - near - pace * wait, np.sqrt(x * x + y * y + z * z) - view.reach - near)


@njit(_nrt=False)
def _meeting_with(view, since, posture, e, b):
    """Return the meeting with target b."""
    end, poses = view.scene.limits.horizon, view.desk.poses
    for j in range(dof(view.scene.limb)):
        view.rates[0, j] = posture[e, j]
    hx, hy, hz = hand_of(view.scene.limb, place(view.scene.limb, view.rates[0]))
    hand = (hx, hy, hz)
    centre_at(view.scene.bodies, b, since, poses)
    dx, dy, dz = poses[b, 0] - hx, poses[b, 1] - hy, poses[b, 2] - hz
    away = max(np.sqrt(dx * dx + dy * dy + dz * dz), 1e-12)
    pace = aim_along(view, posture, e, dx / away, dy / away, dz / away)
    pace = max(pace, _SLOWEST * view.pace)
    step = (end - since) / _INSTANTS
    stride = max((pace + view.scene.bodies.rows[b, TOP_SPEED]) * step, 1e-12)
    k, before = 0, since
    while k <= _INSTANTS:
        t = since + step * k
        missing = _missing(view, b, hand, t, t - since, pace)
        if missing <= 0.0:
            low, high = before, t
            for _ in range(_BISECTIONS if k > 0 else 0):
                t = 0.5 * (low + high)
                if _missing(view, b, hand, t, t - since, pace) <= 0.0:
                    high = t
                else:
                    low = t
            centre_at(view.scene.bodies, b, high, poses)
            return JointMeeting(b, True, high, poses[b, 0], poses[b, 1], poses[b, 2])
        before = t
        k += max(int(missing / stride), 1)
    centre_at(view.scene.bodies, b, end, poses)
    return JointMeeting(b, False, end, poses[b, 0], poses[b, 1], poses[b, 2])


@njit(_nrt=False)
def first_meeting_in_view(view, since, posture, e):
    """Return the target that can be met first, and the meeting."""
    first = JointMeeting(-1, False, 1e300, 0.0, 0.0, 0.0)
    for b in range(view.scene.bodies.rows.shape[0]):
        if view.scene.bodies.rows[b, PART] != HAND:
            continue
        new = _meeting_with(view, since, posture, e, b)
        sooner = new.found == first.found and new.time < first.time
        if first.body < 0 or (new.found and not first.found) or sooner:
            first = new
    return first


@njit(_nrt=False)
def way_to_go(view, since, posture, e):
    """Return the guide's potential: the hand's way to the first meeting over the arm's span."""
    first = first_meeting_in_view(view, since, posture, e)
    for j in range(dof(view.scene.limb)):
        view.rates[0, j] = posture[e, j]
    x, y, z = hand_of(view.scene.limb, place(view.scene.limb, view.rates[0]))
    way = np.sqrt((first.x - x) ** 2 + (first.y - y) ** 2 + (first.z - z) ** 2)
    return min(0.5 * way / view.reach, 1.0)
