"""Paths that touch, pushed aside where they do.

A path that was bent to a new situation and touches an obstacle there is moved once more: by a bump
whose top is where the limb first touches, which is zero at both ends, and no higher than needed for
the limb to be free there. What comes out is timed and checked like any other path, and counts as
one.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.collision.distance import arm_distance, limb_point2
from gcm_learn.compiled import njit
from gcm_learn.recall.kernels import POLAR, keep, meet
from gcm_learn.scene.bodies import DISC, HAND, KIND, PART, REACH
from gcm_learn.scene.limb import elbow_of

PUSHES = np.array([0.06, 0.12, 0.2, 0.3, 0.42])  # heights of bumps [forearm lengths]
TURNS = 8  # directions of bumps
ROOM = 0.012  # by which a pushed limb is free where it touched [forearm lengths]
LOOKS = 8  # at most at which a push is tried
_RINGS = (0.03, 0.985)  # shares of the ring between which a push may end


@njit
def mend(traces, goals, m, query, style, tempo, desk, count, body):
    """Push the path that `adapt` has just left on the desk aside where it first touches.

    Returns
    -------
    count : int
        Samples of the new path on the desk, 0 if no push is found.
    """
    if style != POLAR:
        return 0
    first, last = _touching(query, desk.best_time, desk.best_hand, count)
    if first < 0:
        return 0
    turn, rise, top = _push(query, desk, count, first, last)
    if top < 0.0:
        return 0
    n = desk.base.shape[0]
    for k in range(1, n - 1):
        height = _bump(desk.share[k], top)
        desk.base[k, 0] += height * turn
        desk.base[k, 1] += height * rise
    t = meet(traces, goals, m, query, body, style, tempo, desk)
    if t < 0.0:
        return 0
    keep(desk, t)
    return n + 1


@njit
def _bump(share, top):
    """Height of a bump at a share of the way: 0 at the ends, 1 at its top."""
    s = share / top if share < top else (1.0 - share) / (1.0 - top)
    return np.sin(0.5 * np.pi * min(max(s, 0.0), 1.0)) ** 2


@njit(_nrt=False)
def _room(query, g, x, y, enough):
    """Least distance of the limb to any obstacle at instant g of the table, or more than enough."""
    bodies, poses = query.scene.bodies, query.table[g]
    ex, ey = elbow_of(x, y, query.scene.limb.rho, query.scene.limb.side)
    least = 1e300
    for b in range(bodies.rows.shape[0]):
        if bodies.rows[b, PART] == HAND:
            continue
        px, py, pz = poses[b, 0], poses[b, 1], poses[b, 2]
        d2 = limb_point2(px, py, x, y, ex, ey)
        d = np.sqrt(d2 + pz * pz) - bodies.rows[b, REACH]
        if d <= enough and bodies.rows[b, KIND] != DISC:
            d = arm_distance(bodies, poses, b, x, y, ex, ey)
        least = min(least, d)
    return least


@njit(_nrt=False)
def _at(time, hand, count, t):
    """Segment and position in it of a path at time t."""
    k = 0
    while k < count - 2 and time[k + 1] < t:
        k += 1
    span = time[k + 1] - time[k] if count > 1 else 0.0
    s = min(max((t - time[k]) / span, 0.0), 1.0) if span > 0.0 else 0.0
    return k, s


@njit(_nrt=False)
def _touching(query, time, hand, count):
    """First and last instant of the table of the first time that the limb touches; -1 if none."""
    step = query.scene.limits.horizon / (query.table.shape[0] - 1)
    first = -1
    if count < 2:
        return -1, -1
    end = int(time[count - 1] / step)
    for g in range(1, end + 1):
        k, s = _at(time, hand, count, g * step)
        x = hand[k, 0] + s * (hand[k + 1, 0] - hand[k, 0])
        y = hand[k, 1] + s * (hand[k + 1, 1] - hand[k, 1])
        touches = _room(query, g, x, y, query.rules.touch) <= query.rules.touch
        if touches and first < 0:
            first = g
        if not touches and first >= 0:
            return first, g - 1
    return first, end


@njit
def _push(query, desk, count, first, last):
    """The lowest bump that frees the limb from instant `first` to `last`.

    Returns
    -------
    turn, rise : float
        By which its top moves the hand [rad, shares of the ring].
    top : float
        Share of the way at which it is, -1 if none frees the limb.
    """
    time, hand, share = desk.best_time, desk.best_hand, desk.share
    step = query.scene.limits.horizon / (query.table.shape[0] - 1)
    width = query.scene.limb.far - query.scene.limb.near
    looks = min(last - first + 1, LOOKS)
    n = share.size
    radius, angle = np.empty(looks), np.empty(looks)
    place, instant = np.empty(looks), np.empty(looks, dtype=np.int64)
    for i in range(looks):
        g = first + (last - first) * i // max(looks - 1, 1)
        k, s = _at(time, hand, count, g * step)
        x = hand[k, 0] + s * (hand[k + 1, 0] - hand[k, 0])
        y = hand[k, 1] + s * (hand[k + 1, 1] - hand[k, 1])
        after = min(k + 1, n - 1)
        place[i] = share[min(k, n - 1)] + s * (share[after] - share[min(k, n - 1)])
        radius[i], angle[i], instant[i] = np.sqrt(x * x + y * y), np.arctan2(y, x), g
    top = min(max(0.5 * (place[0] + place[looks - 1]), 0.04), 0.96)
    middle = radius[looks // 2]
    for push in PUSHES:
        best, turn, rise = query.rules.touch + ROOM, 0.0, 0.0
        for d in range(TURNS):
            a = push * np.sin(2.0 * np.pi * d / TURNS) / max(middle, 0.2)
            u = push * np.cos(2.0 * np.pi * d / TURNS) / width
            least = 1e300
            for i in range(looks):
                height = _bump(place[i], top)
                ring = (radius[i] - query.scene.limb.near) / width + height * u
                r = query.scene.limb.near + min(max(ring, _RINGS[0]), _RINGS[1]) * width
                way = angle[i] + query.scene.limb.side * height * a
                x, y = r * np.cos(way), r * np.sin(way)
                least = min(least, _room(query, instant[i], x, y, best))
                if least <= best:
                    break
            if least > best:
                best, turn, rise = least, a, u
        if turn != 0.0 or rise != 0.0:
            return turn, rise, top
    return 0.0, 0.0, -1.0
