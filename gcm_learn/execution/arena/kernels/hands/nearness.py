"""Distances of bodies to the limb, for steps and observations of planar arms.

Most bodies are far most of the time, and their enclosing balls say so. Balls come first, in loops
without calls: a possible call keeps numba from holding numbers in registers. That would cost
several times as much as the distances. Without `stays_free` and `stays_away` steps take 7
to 35 % longer; tests hold both against the functions that verify plans.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.arms.planar_limb import elbow_of
from gcm_learn.collision.distance import arm_distance, limb_point2
from gcm_learn.collision.sweep import limb_sweep
from gcm_learn.compiled import njit
from gcm_learn.scene.bodies import BALL, HAND, PART, REACH, SWING, TOP_SPEED, glide, pose_at, swing

# Columns of a table of moments: the limb then, and a body.
TIME, HAND_X, HAND_Y, ELBOW_X, ELBOW_Y, X, Y, Z, ROOM = range(9)
MOMENT_COLUMNS = 9
_CLOSE = 0.15  # nearer than this, bodies count instead of the balls that hold them
_SLACK = 1e-9  # against rounding where a bound is as good as an answer [forearm lengths]


@njit(_nrt=False, forceinline=True)
def _rooms(bodies, b, count, moments):
    """Write the gaps of limb and ball at the first `count` moments, for centres in the table."""
    reach = bodies.rows[b, REACH]
    for k in range(count):
        ex, ey, x, y = moments[k, ELBOW_X], moments[k, ELBOW_Y], moments[k, X], moments[k, Y]
        d2 = limb_point2(x, y, moments[k, HAND_X], moments[k, HAND_Y], ex, ey)
        moments[k, ROOM] = np.sqrt(d2 + moments[k, Z] * moments[k, Z]) - reach


@njit(_nrt=False, forceinline=True)
def follow(bodies, b, count, moments):
    """Write the centre of body b at the first `count` moments, and the gap between limb and ball.

    Returns
    -------
    bool
        False for bodies that swing, for which nothing is written, and for bodies near the limb
        other than balls. `exactly` serves these.
    """
    if bodies.rows[b, SWING] >= 0.0:
        return False
    for k in range(count):
        t = moments[k, TIME]
        moments[k, X], moments[k, Y], moments[k, Z] = glide(bodies, b, t, moments)
    _rooms(bodies, b, count, moments)
    enough = bodies.rows[b, BALL] > 0.0
    if not enough:
        enough = True
        for k in range(count):
            enough = enough and moments[k, ROOM] > _CLOSE
    return enough


@njit(_nrt=False)
def exactly(bodies, b, count, moments, poses, least_only):
    """Write centres and gaps as `follow`, with exact distances to bodies that are near.

    With `least_only`, only gaps that may be less than all earlier ones are made exact.
    """
    if bodies.rows[b, SWING] >= 0.0:
        for k in range(count):
            moments[k, X], moments[k, Y], moments[k, Z] = swing(bodies, b, moments[k, TIME], poses)
    else:
        for k in range(count):
            t = moments[k, TIME]
            moments[k, X], moments[k, Y], moments[k, Z] = glide(bodies, b, t, poses)
    _rooms(bodies, b, count, moments)
    if bodies.rows[b, BALL] > 0.0:
        return
    least = 1e300
    for k in range(count):
        room = moments[k, ROOM]
        if room <= _CLOSE and (room < least or not least_only):
            moments[k, ROOM] = _exact(bodies, b, k, moments, poses)
        least = min(least, max(moments[k, ROOM], 0.0))


@njit(_nrt=False)
def _exact(bodies, b, k, moments, poses):
    """Distance of the limb to body b itself at moment k."""
    pose_at(bodies, b, moments[k, TIME], poses)
    hx, hy = moments[k, HAND_X], moments[k, HAND_Y]
    return arm_distance(bodies, poses, b, hx, hy, moments[k, ELBOW_X], moments[k, ELBOW_Y])


@njit(_nrt=False, forceinline=True)
def place_limb(moments, k, t, x, y, rho):
    """Write a moment: time, hand and elbow."""
    moments[k, TIME], moments[k, HAND_X], moments[k, HAND_Y] = t, x, y
    moments[k, ELBOW_X], moments[k, ELBOW_Y] = elbow_of(x, y, rho, 1.0)


@njit(_nrt=False)
def stays_free(scene, time, hand, floor, moments, poses):
    """Tell whether no obstacle can come as near as `floor` to the limb on a straight path.

    True is certain, by the first bound of `least_distance`: the mean of the distances at both
    ends, less half of the motion of limb and body. False means to look closer.
    """
    bodies, rho = scene.bodies, scene.limb.rho
    for k in range(2):
        place_limb(moments, k, time[k], hand[k, 0], hand[k, 1], rho)
    sweep = limb_sweep(hand[0, 0], hand[0, 1], hand[1, 0], hand[1, 1], rho) + _SLACK
    span, close = time[1] - time[0], False
    for b in range(bodies.rows.shape[0]):
        if bodies.rows[b, PART] == HAND:
            continue
        moved = bodies.rows[b, TOP_SPEED] * span + sweep
        follow(bodies, b, 2, moments)
        low = 0.5 * (moments[0, ROOM] + moments[1, ROOM] - moved)
        if bodies.rows[b, SWING] >= 0.0 or low <= floor:
            close = True
            break
    return not close or _stays_free_exactly(bodies, span, sweep, floor, moments, poses)


@njit(_nrt=False)
def _stays_free_exactly(bodies, span, sweep, floor, moments, poses):
    """`stays_free`, asking the bodies themselves where their balls are near."""
    for b in range(bodies.rows.shape[0]):
        if bodies.rows[b, PART] == HAND:
            continue
        moved = bodies.rows[b, TOP_SPEED] * span + sweep
        exactly(bodies, b, 2, moments, poses, False)
        if 0.5 * (moments[0, ROOM] + moments[1, ROOM] - moved) <= floor:
            return False
    return True


@njit(_nrt=False)
def stays_away(bodies, time, hand, reach):
    """Tell whether no target can come within `reach` of the hand on a straight path.

    True is certain; of targets that swing it is never said.
    """
    x, y, span = hand[0, 0], hand[0, 1], time[1] - time[0]
    length = np.sqrt((hand[1, 0] - x) ** 2 + (hand[1, 1] - y) ** 2) + _SLACK
    for b in range(bodies.rows.shape[0]):
        if bodies.rows[b, PART] != HAND:
            continue
        px, py, pz = glide(bodies, b, time[0], hand)
        away = np.sqrt((px - x) ** 2 + (py - y) ** 2 + pz * pz) - bodies.rows[b, REACH]
        near = away - max(reach, 0.0) <= bodies.rows[b, TOP_SPEED] * span + length
        if near or bodies.rows[b, SWING] >= 0.0:
            return False
    return True


RAY = 2  # numbers of a ray
RAYS = 25  # directions, the first to the meeting with the target, and last to rest
RAY_X = np.append(np.cos(2.0 * np.pi * np.arange(RAYS - 1) / (RAYS - 1)), 0.0)
RAY_Y = np.append(np.sin(2.0 * np.pi * np.arange(RAYS - 1) / (RAYS - 1)), 0.0)
REACHES = np.array([0.06, 0.12, 0.2, 0.3, 0.45, 0.65, 0.9])  # ways along a ray [forearm lengths]


# Loops over rays call nothing and divide as NumPy does, so they run on several rays at once.


@njit(_nrt=False, error_model="numpy")
def _point(view, dx, dy, reach, hx, hy):
    """Write the hands (RAYS,) that have gone `reach` along the rays."""
    for k in range(RAYS):
        hx[k] = view.x + reach * (dx * RAY_X[k] - dy * RAY_Y[k])
        hy[k] = view.y + reach * (dy * RAY_X[k] + dx * RAY_Y[k])


@njit(_nrt=False, error_model="numpy")
def _bend(rho, hx, hy, ex, ey):
    """Write the elbows (RAYS,) of hands (RAYS,), as `elbow_of` has them."""
    for k in range(RAYS):
        r = np.sqrt(hx[k] * hx[k] + hy[k] * hy[k])
        ux, uy = hx[k] / r, hy[k] / r
        a = (r * r + rho * rho - 1.0) / (2.0 * rho * r)
        a = 1.0 if a > 1.0 else a
        a = -1.0 if a < -1.0 else a
        b = np.sqrt(1.0 - a * a)
        ex[k] = 0.0 if r < 1e-12 else rho * (a * ux + b * uy)
        ey[k] = -rho if r < 1e-12 else rho * (a * uy - b * ux)


@njit(_nrt=False, error_model="numpy")
def _gaps(x, y, z, reach, hx, hy, ex, ey, gaps):
    """Write the gaps (RAYS,) between limbs and a ball of radius `reach` at (x, y, z)."""
    for k in range(RAYS):
        fx, fy, wx, wy = hx[k] - ex[k], hy[k] - ey[k], x - ex[k], y - ey[k]
        s = (wx * fx + wy * fy) / (fx * fx + fy * fy)
        s = 0.0 if s < 0.0 else s
        s = 1.0 if s > 1.0 else s
        wx, wy = wx - s * fx, wy - s * fy
        u = (x * ex[k] + y * ey[k]) / (ex[k] * ex[k] + ey[k] * ey[k])
        u = 0.0 if u < 0.0 else u
        u = 1.0 if u > 1.0 else u
        vx, vy = x - u * ex[k], y - u * ey[k]
        forearm, upper = wx * wx + wy * wy, vx * vx + vy * vy
        d2 = forearm if forearm < upper else upper
        gaps[k] = np.sqrt(d2 + z * z) - reach


@njit(_nrt=False)
def _narrow(scene, floor, t, limbs, room, poses):
    """Lower `room` (RAYS,) to the gaps less `floor` of limbs (5, RAYS) and obstacles at t [s]."""
    bodies, n = scene.bodies, scene.bodies.rows.shape[0]
    hx, hy, ex, ey, gaps = limbs[0], limbs[1], limbs[2], limbs[3], limbs[4]
    for balls in (True, False):  # balls first: what they leave is checked closely
        for b in range(n):
            if bodies.rows[b, PART] == HAND or (bodies.rows[b, BALL] > 0.0) != balls:
                continue
            pose_at(bodies, b, t, poses)
            x, y, z = poses[b, 0], poses[b, 1], poses[b, 2]
            _gaps(x, y, z, bodies.rows[b, REACH], hx, hy, ex, ey, gaps)
            for k in range(RAYS):
                gap = gaps[k] - floor
                if gap < room[k]:
                    if not balls:
                        gap = arm_distance(bodies, poses, b, hx[k], hy[k], ex[k], ey[k]) - floor
                    room[k] = min(room[k], gap)


@njit
def tell_fan(scene, floor, view, dx, dy, poses, row, at):
    """Write for every ray the free way of the hand, and the least gap of the limb on that way.

    The first ray is in direction (dx, dy), the others follow counter-clockwise.

    Parameters
    ----------
    scene : Scene
    floor : float
        Distance at which an obstacle counts as touching the limb.
    view : View
    poses : (n, 12) ndarray
        Overwritten.
    row : (width,) ndarray
        RAY numbers for each ray are written, from `at` on.
    """
    limb, horizon = scene.limb, scene.limits.horizon
    limbs, room = np.empty((5, RAYS)), np.full(RAYS, 0.5)  # what is farther changes nothing
    reach, least = np.zeros(RAYS), np.full(RAYS, 0.5)
    free, last = np.ones(RAYS, np.bool_), 0.0
    for j in range(REACHES.size):
        _point(view, dx, dy, REACHES[j], limbs[0], limbs[1])
        _bend(limb.rho, limbs[0], limbs[1], limbs[2], limbs[3])
        for k in range(RAYS):
            r = np.sqrt(limbs[0, k] * limbs[0, k] + limbs[1, k] * limbs[1, k])
            if r > limb.far or r < limb.near:
                free[k] = False
            room[k] = least[k] if free[k] else -1.0
        t = min(view.t + REACHES[j] / scene.limits.speed, horizon)
        _narrow(scene, floor, t, limbs, room, poses)
        for k in range(RAYS):
            if free[k]:
                free[k], least[k] = room[k] > 0.0, max(room[k], 0.0)
                reach[k] = REACHES[j] if free[k] else last
        last = REACHES[j]
    for k in range(RAYS):
        row[at + RAY * k], row[at + RAY * k + 1] = reach[k], least[k]
