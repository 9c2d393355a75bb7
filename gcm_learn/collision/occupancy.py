"""Tests, without a raster, whether the limb in a cell touches a body now or in a span of time."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.collision import distance
from gcm_learn.compiled import njit
from gcm_learn.scene.bodies import (
    ACCELERATION,
    BALL,
    HAND,
    PART,
    REACH,
    SIZE,
    SWING,
    TOP_SPEED,
    Bodies,
    glide,
)

FINEST = 2e-3  # way of a body that is not resolved when a limb is asked about [forearm lengths]
MOST_LOOKS = 256  # at one span of time, against absurdly fast bodies


class Postures(NamedTuple):
    """Resting limbs, one for every cell, and the bodies that may touch them."""

    bodies: Bodies
    limb: np.ndarray  # (m, 4): hand x, y and elbow x, y
    gap: np.ndarray  # (m,): distance at which an obstacle counts as touching
    poses: np.ndarray  # (n, 12): of the bodies, at the moment that is being checked
    scratch: np.ndarray  # (n, 12): buffer for poses at other instants


def postures_of(bodies: Bodies, limb: np.ndarray, gap: np.ndarray) -> Postures:
    """Postures with arrays for the bodies' poses."""
    poses = np.zeros((len(bodies.rows), 12))
    return Postures(bodies, limb, gap, poses, np.zeros_like(poses))


@njit(_nrt=False)
def passes_by(bodies, b, hx, hy, ex, ey, gap, t0, t1, scratch):
    """Tell whether body b surely stays more than `gap` from a limb at rest during [t0, t1].

    Its ball stays near the chord of its centre's way: a quadratic motion departs from that by at
    most |a| (t1 - t0)^2 / 8.  Nothing is known of a pendulum, so False is not certain.
    """
    rows = bodies.rows
    if rows[b, SWING] >= 0.0:
        return False
    ax, ay, _ = glide(bodies, b, t0, scratch)
    bx, by, _ = glide(bodies, b, t1, scratch)
    bulge = np.sqrt(rows[b, ACCELERATION] ** 2 + rows[b, ACCELERATION + 1] ** 2) / 8.0
    far = gap + rows[b, REACH] + bulge * (t1 - t0) ** 2 + 1e-12
    if rows[b, PART] == HAND:
        return distance.segment_point2(hx, hy, ax, ay, bx, by) > far * far
    return distance.limb_segment2(hx, hy, ex, ey, ax, ay, bx, by) > far * far


@njit
def first_touch(bodies, b, hx, hy, ex, ey, gap, t0, t1, shortest, scratch):
    """First instant in [t0, t1] at which body b is within `gap` of a limb at rest, or -1.

    Conservative advancement: from a distance d above the gap, nothing can happen before the
    body has travelled d - gap.  It stops refining below `shortest` [s], or what a faster body
    needs for FINEST, within MOST_LOOKS.  Now and then it asks whether the body passes by.
    """
    t, looks, check = t0, 0, 2
    speed = bodies.rows[b, TOP_SPEED]
    if speed > 0.0:
        shortest = min(shortest, max(FINEST / speed, (t1 - t0) / MOST_LOOKS))
    while True:
        room = distance.room_at(bodies, b, t, hx, hy, ex, ey, gap, scratch)
        if room <= 0.0:
            return t
        if t >= t1 or speed == 0.0:
            return -1.0
        looks += 1
        if looks == check:
            if passes_by(bodies, b, hx, hy, ex, ey, gap, t, t1, scratch):
                return -1.0
            check *= 2
        t = min(t + max(room / speed, shortest), t1)


@njit
def blocked_cells(postures, cells, since, count, now, shortest, blocked):
    """Mark the cells whose limb an obstacle touches at any instant of a span of time.

    Parameters
    ----------
    postures : Postures
        With the bodies' poses at time `now`: one evaluation serves all cells that a front reaches
        together.
    cells, since : (count,) ndarray
        Cells to check and the time [s] since when each must have been free.
    now, shortest : float
        End of the span; resolution at which it is searched [s].
    blocked : (count,) bool ndarray
        Filled.
    """
    bodies, limb, gap, poses, scratch = postures
    blocked[:count] = False
    if count == 0:
        return
    for b in range(bodies.rows.shape[0]):
        if bodies.rows[b, PART] == HAND:
            continue
        speed, ball = bodies.rows[b, TOP_SPEED], bodies.rows[b, BALL] > 0.0
        radius, reach = bodies.rows[b, SIZE], bodies.rows[b, REACH]
        x, y, z = poses[b, 0], poses[b, 1], poses[b, 2]
        for i in range(count):
            m = cells[i]
            if blocked[i]:
                continue
            hx, hy, ex, ey = limb[m, 0], limb[m, 1], limb[m, 2], limb[m, 3]
            travel = speed * (now - since[i])
            if ball:  # the common case, decided without a root or a call
                d2 = distance.limb_point2(x, y, hx, hy, ex, ey) + z * z
                near, far = radius + gap[m], radius + gap[m] + travel
                if d2 > far * far:
                    continue
                if d2 <= near * near:
                    blocked[i] = True
                    continue
            else:
                d2 = distance.limb_point2(x, y, hx, hy, ex, ey) + z * z
                far = reach + gap[m] + travel
                if d2 > far * far:  # the ball that holds the body spares most of its corners
                    continue
                room = distance.arm_distance(bodies, poses, b, hx, hy, ex, ey) - gap[m]
                if room > travel:
                    continue
                if room <= 0.0:
                    blocked[i] = True
                    continue
            t = first_touch(bodies, b, hx, hy, ex, ey, gap[m], since[i], now, shortest, scratch)
            blocked[i] = t >= 0.0


@njit
def met_targets(postures, gap, cells, since, count, now, shortest, body, when):
    """Find for every cell the first target that comes within `gap` of a hand resting there.

    Parameters
    ----------
    gap : float
        Distance at which a target counts as met.
    body : (count,) int64 ndarray
        Filled with the target's index, -1 if none.
    when : (count,) ndarray
        Filled with the time [s] where there is one.

    The others are those of `blocked_cells`.
    """
    bodies, limb, _, poses, scratch = postures
    body[:count] = -1
    for b in range(bodies.rows.shape[0]):
        if bodies.rows[b, PART] != HAND:
            continue
        speed, radius = bodies.rows[b, TOP_SPEED], bodies.rows[b, REACH] + gap
        ball = bodies.rows[b, BALL] > 0.0
        x, y, z = poses[b, 0], poses[b, 1], poses[b, 2]
        for i in range(count):
            hx, hy = limb[cells[i], 0], limb[cells[i], 1]
            far = speed * (now - since[i])
            if (hx - x) ** 2 + (hy - y) ** 2 + z * z > (radius + far) ** 2:
                continue
            if not ball and distance.arm_distance(bodies, poses, b, hx, hy, hx, hy) > gap + far:
                continue
            t = first_touch(bodies, b, hx, hy, hx, hy, gap, since[i], now, shortest, scratch)
            if t >= 0.0 and (body[i] < 0 or t < when[i]):
                body[i], when[i] = b, t
