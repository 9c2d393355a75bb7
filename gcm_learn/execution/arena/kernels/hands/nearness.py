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
from gcm_learn.scene.bodies import (
    BALL,
    HAND,
    PART,
    REACH,
    SWING,
    TOP_SPEED,
    glide,
    pose_at,
    swing,
)

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
    """`follow`, with distances to bodies themselves where those are near.

    With `least_only` only gaps smaller than earlier ones count, and are exact.
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


@njit
def tell_fan(scene, floor, view, dx, dy, poses, row, at):
    """For every ray how far the hand can go before the limb touches, and how near it comes.

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
    bodies, limb = scene.bodies, scene.limb
    speed, horizon, rho = scene.limits.speed, scene.limits.horizon, limb.rho
    n, reaches = bodies.rows.shape[0], REACHES.size
    table, gaps = np.empty((reaches * n, 12)), np.empty(n)
    for j in range(reaches):  # poses of all bodies, instant by instant
        for b in range(n):
            if bodies.rows[b, PART] != HAND:
                pose_at(bodies, b, min(view.t + REACHES[j] / speed, horizon), poses)
                for i in range(12):
                    table[j * n + b, i] = poses[b, i]
    for ray in range(RAYS):
        reach, least, last = REACHES[reaches - 1], 0.5, 0.0
        ux, uy = dx * RAY_X[ray] - dy * RAY_Y[ray], dy * RAY_X[ray] + dx * RAY_Y[ray]
        for j in range(reaches):
            hx, hy = view.x + REACHES[j] * ux, view.y + REACHES[j] * uy
            r = np.sqrt(hx * hx + hy * hy)
            if r > limb.far or r < limb.near:
                reach = last
                break
            ex, ey = elbow_of(hx, hy, rho, 1.0)
            room = least  # what is farther changes nothing
            for b in range(n):  # balls first: what they leave is checked closely
                gaps[b] = 1e300
                if bodies.rows[b, PART] == HAND:
                    continue
                px, py, pz = table[j * n + b, 0], table[j * n + b, 1], table[j * n + b, 2]
                d2 = limb_point2(px, py, hx, hy, ex, ey)
                gap = np.sqrt(d2 + pz * pz) - bodies.rows[b, REACH] - floor
                if bodies.rows[b, BALL] > 0.0:
                    room = min(room, gap)
                else:
                    gaps[b] = gap
            for b in range(n):
                if gaps[b] < room:
                    for q in range(12):
                        poses[b, q] = table[j * n + b, q]
                    gap = arm_distance(bodies, poses, b, hx, hy, ex, ey)
                    room = min(room, gap - floor)
            if room <= 0.0:
                reach, least = last, 0.0
                break
            least, last = room, REACHES[j]
        row[at + RAY * ray], row[at + RAY * ray + 1] = reach, least
