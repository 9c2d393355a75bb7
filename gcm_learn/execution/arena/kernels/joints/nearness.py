"""Nearest points of a limb in space and a body, their speed, and rates of joints."""

from __future__ import annotations

import numpy as np

from gcm_learn.arms.curves import hermite, line
from gcm_learn.arms.limbs import dof
from gcm_learn.collision.distance import to_body
from gcm_learn.compiled import njit
from gcm_learn.scene.bodies import (
    ACCELERATION,
    BALL,
    SWING,
    VELOCITY,
    centre_at,
)
from gcm_learn.scene.shapes.choice import from_nearest, part_near

_NEARLY = 1e-6  # share of a bone to which its nearest point is found
_MOMENT = 1e-3  # over which what swings is differentiated [s]


@njit(_nrt=False)
def _slope(bodies, b, part, p, d, s):
    """Half the derivative by s of the squared distance of p + s d to a part of solid b."""
    x, y, z = from_nearest(bodies, b, part, p[0] + s * d[0], p[1] + s * d[1], p[2] + s * d[2])
    return x * d[0] + y * d[1] + z * d[2]


@njit(_nrt=False)
def _share_of(bodies, b, part, p, d):
    """Return s in [0, 1] at which p + s d is nearest to a part of solid b: the root of the slope.

    By the Illinois rule, and bisection every third step, as for cylinders.
    """
    if bodies.rows[b, BALL] > 0.0:
        along = p[0] * d[0] + p[1] * d[1] + p[2] * d[2]
        length2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2]
        return min(max(-along / max(length2, 1e-300), 0.0), 1.0)
    below, above = _slope(bodies, b, part, p, d, 0.0), _slope(bodies, b, part, p, d, 1.0)
    if below >= 0.0 or above <= 0.0:
        return 0.0 if below >= 0.0 else 1.0
    low, high, turn = 0.0, 1.0, 0
    while high - low > _NEARLY:
        turn += 1
        s = 0.5 * (low + high)
        if turn % 3:
            s = low - below * (high - low) / (above - below)
        slope = _slope(bodies, b, part, p, d, s)
        if slope == 0.0 or s <= low or s >= high:
            return s
        if slope < 0.0:
            low, below, above = s, slope, 0.5 * above
        else:
            high, above, below = s, slope, 0.5 * below
    return 0.5 * (low + high)


@njit(_nrt=False)
def nearest_on_bone(bodies, b, poses, p, q):
    """Return the point of bone pq nearest to body b at its pose, and the vector to the body.

    The squared distance to a convex part is convex along the bone.

    Returns
    -------
    share : float
        Of the bone, from p.
    x, y, z : float
        From that point to the nearest point of the body; 0 where they meet.
    """
    rows = bodies.rows
    p = to_body(bodies, poses, b, p[0], p[1], p[2])
    q = to_body(bodies, poses, b, q[0], q[1], q[2])
    d = (q[0] - p[0], q[1] - p[1], q[2] - p[2])
    part = part_near(bodies, b, p, q)
    s = _share_of(bodies, b, part, p, d)
    x, y, z = from_nearest(bodies, b, part, p[0] + s * d[0], p[1] + s * d[1], p[2] + s * d[2])
    if rows[b, BALL] > 0.0:
        return s, -x, -y, -z
    return (
        s,
        -(poses[b, 3] * x + poses[b, 4] * y + poses[b, 5] * z),
        -(poses[b, 6] * x + poses[b, 7] * y + poses[b, 8] * z),
        -(poses[b, 9] * x + poses[b, 10] * y + poses[b, 11] * z),
    )


@njit(_nrt=False)
def centre_motion(bodies, b, t, poses):
    """Return velocity (3) and acceleration (3) of body b's centre at t [s]; overwrites its pose."""
    rows = bodies.rows
    if rows[b, SWING] < 0.0:
        ax, ay, az = rows[b, ACCELERATION], rows[b, ACCELERATION + 1], rows[b, ACCELERATION + 2]
        return (
            rows[b, VELOCITY] + ax * t, rows[b, VELOCITY + 1] + ay * t,
            rows[b, VELOCITY + 2] + az * t, ax, ay, az,
        )  # fmt: skip
    h = _MOMENT
    centre_at(bodies, b, t, poses)
    x0, y0, z0 = poses[b, 0], poses[b, 1], poses[b, 2]
    centre_at(bodies, b, t + h, poses)
    x1, y1, z1 = poses[b, 0], poses[b, 1], poses[b, 2]
    centre_at(bodies, b, t + 2.0 * h, poses)
    x2, y2, z2 = poses[b, 0], poses[b, 1], poses[b, 2]
    return (
        (x1 - x0) / h, (y1 - y0) / h, (z1 - z0) / h,
        (x2 - 2.0 * x1 + x0) / h**2, (y2 - 2.0 * y1 + y0) / h**2, (z2 - 2.0 * z1 + z0) / h**2,
    )  # fmt: skip


_HAIR = 2e-9  # share of the joints' speeds that is not used, against rounding
SOFTER = 1e-6  # the same of accelerations, which short pieces tell with few digits


@njit(_nrt=False, forceinline=True)
def _fastest_towards(room, most):
    """Greatest rate after a step of which the joint can rest `room` steps' rate farther on.

    `room` has what the rate before the step takes of it off; the inverse of half a rate and of the
    way in steps' time until the joint rests, braking by at most `most` in each.
    """
    if room <= 0.0:
        return room
    whole = int(0.5 * (np.sqrt(1.0 + 8.0 * room / most) - 1.0))
    return whole * most + (room - 0.5 * most * whole * (whole + 1.0)) / (whole + 1.0)


@njit(_nrt=False)
def wish(scene, posture, e, command, span, out):
    """Write into `out` (dof,) the rates nearest to a command (dof,) that keep the joints' limits.

    Under limits of acceleration these are the rates after the step, and leave the joint the way to
    stop before its range ends. Otherwise rates hold during the step and end at the range.
    """
    limb, limits, n = scene.limb, scene.limits, dof(scene.limb)
    for j in range(n):
        q, v = posture[e, j], posture[e, n + j]
        top = limits.joint_speed[j] * (1.0 - _HAIR)
        rate = min(max(command[e, j], -1.0), 1.0) * top
        most = limits.joint_acceleration[j] * span * (1.0 - SOFTER)
        if most < np.inf:
            rate = min(rate, _fastest_towards((limb.high[j] - q) / span - 0.5 * v, most))
            rate = max(rate, -_fastest_towards((q - limb.low[j]) / span + 0.5 * v, most))
            out[j] = min(max(rate, v - most), v + most)
        else:
            out[j] = (min(max(q + rate * span, limb.low[j]), limb.high[j]) - q) / span


@njit(_nrt=False)
def lay(scene, posture, e, rates, span, end, curve):
    """Write the end (dof,) and the curve (dof, 4) of a step that ends with `rates` (dof,)."""
    limb, n = scene.limb, dof(scene.limb)
    q, v = posture[e, :n], posture[e, n:]
    free = scene.limits.joint_acceleration[0] == np.inf
    for j in range(n):
        mean = rates[j] if free else 0.5 * (v[j] + rates[j])
        end[j] = min(max(q[j] + mean * span, limb.low[j]), limb.high[j])
    if free:
        line(q, end, curve)
    else:
        hermite(q, v, end, rates, span, curve)
