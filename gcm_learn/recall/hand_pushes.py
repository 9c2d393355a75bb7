"""Kernels that find the contacts of a hand path, and push the path aside or hold it back."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.arms.planar_limb import elbow_of
from gcm_learn.collision.distance import arm_distance, limb_point2
from gcm_learn.compiled import njit
from gcm_learn.recall.hand_paths import KNOTS
from gcm_learn.recall.styles import PUSHED, Habits, QuickCheck, bump
from gcm_learn.scene.bodies import DISC, HAND, KIND, PART, REACH, TOP_SPEED, poses_at

PUSHES = np.array([0.06, 0.12, 0.2, 0.3, 0.42])  # heights of bumps [forearm lengths]
TURNS = 8  # directions of bumps
CLEARANCE = 0.012  # clearance of a pushed limb where it touched [forearm lengths]
MARGIN = 0.005  # clearance of a changed path at quick checks [forearm lengths]
INSTANTS = 8  # at most at which a push is tried
HOLDS = np.array([0.02, 0.05, 0.1, 0.2, 0.35])  # delays [horizons]
ALTERNATIVES = 5  # memories that are compared before each check after the first
_RINGS = (0.03, 0.985)  # shares of the ring between which a push may end


class HandTouch(NamedTuple):
    """Places and times at which a path touches."""

    places: np.ndarray  # (n, 3): share of the path, radius and direction of the hand
    instants: np.ndarray  # (n,) int64: of the table
    knots: np.ndarray  # (2,) int64: the last one before it touches, and the one after the start
    times: np.ndarray  # (2,): of these [s]


@njit(_nrt=False)
def _clearance(query, g, x, y, enough):
    """Return the limb's least distance to obstacles at instant g, or more than `enough`."""
    bodies, poses = query.scene.bodies, query.table[g]
    if np.isnan(poses[0, 0]):
        poses_at(bodies, query.scene.limits.horizon * g / (query.table.shape[0] - 1), poses)
    ex, ey = elbow_of(x, y, query.scene.limb.rho, query.scene.limb.side)
    least = 1e300
    for b in range(bodies.rows.shape[0]):
        if bodies.rows[b, PART] == HAND:
            continue
        px, py, pz = poses[b, 0], poses[b, 1], poses[b, 2]
        d2 = limb_point2(px, py, x, y, ex, ey)
        d = np.sqrt(d2 + pz * pz) - bodies.rows[b, REACH]
        if d <= enough and bodies.rows[b, KIND] != DISC:  # only discs count by their depth
            d = arm_distance(bodies, poses, b, x, y, ex, ey)
        least = min(least, d)
    return least


@njit(_nrt=False)
def _at(query, work, count, g):
    """Return segment, share of the segment and hand of the best path at instant g of the table."""
    time, hand = work.best_time, work.best_hand
    t, k = g * (query.scene.limits.horizon / (query.table.shape[0] - 1)), 0
    while k < count - 2 and time[k + 1] < t:
        k += 1
    span = time[k + 1] - time[k] if count > 1 else 0.0
    s = min(max((t - time[k]) / span, 0.0), 1.0) if span > 0.0 else 0.0
    x = hand[k, 0] + s * (hand[k + 1, 0] - hand[k, 0])
    return k, s, x, hand[k, 1] + s * (hand[k + 1, 1] - hand[k, 1])


@njit(_nrt=False)
def habits(_query):
    """Return the numbers by which hand paths are changed."""
    changes = PUSHED + 1 + 2 * HOLDS.size
    return Habits(changes, MARGIN, np.inf, True, False, ALTERNATIVES)


@njit(_nrt=False)
def sweep(query, work, count):
    """Return the numbers of a quick check of the best path."""
    step, nearer = query.scene.limits.horizon / (query.table.shape[0] - 1), 0.0
    for b in range(query.scene.bodies.rows.shape[0]):
        nearer = max(nearer, step * (query.rules.speed + query.scene.bodies.rows[b, TOP_SPEED]))
    end = 1.0 * int(work.best_time[count - 1] / step) if count > 1 else 0.0
    touch = query.rules.touch
    return QuickCheck(touch, 1.0, touch + CLEARANCE, end, nearer, end)


@njit(_nrt=False)
def room(query, work, count, g, enough):
    """Return the limb's clearance at instant g, or a number above `enough`."""
    _, _, x, y = _at(query, work, count, g)
    return _clearance(query, g, x, y, enough)


@njit(_nrt=False)
def caught_at(_query, work):
    """Return when the best path catches [s]."""
    return work.best_time[KNOTS]


@njit
def touch_of(query, work, count, first, last):
    """Return where the best path touches, from instant `first` to `last`."""
    n, share = min(last - first + 1, INSTANTS), work.share
    touch = HandTouch(
        np.empty((n, 3)), np.empty(n, dtype=np.int64), np.empty(2, dtype=np.int64), np.empty(2)
    )
    for i in range(n):
        g = first + (last - first) * i // max(n - 1, 1)
        k, s, x, y = _at(query, work, count, g)
        before, after = min(k, KNOTS - 1), min(k + 1, KNOTS - 1)
        touch.places[i, 0] = share[before] + s * (share[after] - share[before])
        touch.places[i, 1], touch.places[i, 2] = np.sqrt(x * x + y * y), np.arctan2(y, x)
        touch.instants[i] = g
        if i == 0:
            touch.knots[0], touch.knots[1] = max(before, 1), 1
    for i in range(2):
        touch.times[i] = work.best_time[touch.knots[i]]
    return touch


@njit(_nrt=False)
def horizon(query):
    """Return the horizon [s]."""
    return query.scene.limits.horizon


@njit(_nrt=False)
def hold(_query, i):
    """Return delay i [horizons]."""
    return HOLDS[i]


@njit(_nrt=False)
def pushed(query, work, touch, wide, side):
    """Push the path aside by a low bump that frees the limb where it touched.

    Parameters
    ----------
    wide : float
        Width of the bump [shares of the path].
    side : (2,) ndarray
        Previous push, which the new push must not continue; overwritten by the new push.

    Returns
    -------
    bool
        True if a bump frees the limb.
    """
    turn, rise, top = _push(query, touch, wide, side[0], side[1])
    if top < 0.0:
        return False
    side[0], side[1] = turn, rise
    for k in range(1, KNOTS - 1):
        height = bump(work.share[k], top, wide)
        work.base[k, 0] += height * turn
        work.base[k, 1] += height * rise
    return True


@njit(_nrt=False)
def _push(query, touch, wide, turn_before, rise_before):
    """Find the lowest bump that frees the limb by CLEARANCE, or else by most.

    Returns
    -------
    turn, rise : float
        Move of the hand at the bump's top [rad, shares of the ring].
    top : float
        Share of the path at the top, -1 if no bump frees the limb.
    """
    limb, places, n = query.scene.limb, touch.places, touch.instants.size
    width, middle = limb.far - limb.near, max(places[n // 2, 1], 0.2)
    top = min(max(0.5 * (places[0, 0] + places[n - 1, 0]), 0.04), 0.96)
    most, turn, rise = query.rules.touch, 0.0, 0.0
    for push in PUSHES:
        for d in range(TURNS):
            a = push * np.sin(2.0 * np.pi * d / TURNS) / middle
            u = push * np.cos(2.0 * np.pi * d / TURNS) / width
            if a * turn_before * middle * middle + u * rise_before * width * width > 0.0:
                continue
            least = _least_on(query, touch, a, u, top, wide, most)
            if least > most:
                most, turn, rise = least, a, u
        if most > query.rules.touch + CLEARANCE:
            break
    return turn, rise, top if turn != 0.0 or rise != 0.0 else -1.0


@njit(_nrt=False)
def _least_on(query, touch, a, u, top, wide, enough):
    """Return the least clearance of a bump where the path touched; stop below `enough`."""
    limb, least = query.scene.limb, 1e300
    width = limb.far - limb.near
    for i in range(touch.instants.size):
        height = bump(touch.places[i, 0], top, wide)
        ring = (touch.places[i, 1] - limb.near) / width + height * u
        r = limb.near + min(max(ring, _RINGS[0]), _RINGS[1]) * width
        turned = touch.places[i, 2] + limb.side * height * a
        x, y = r * np.cos(turned), r * np.sin(turned)
        least = min(least, _clearance(query, touch.instants[i], x, y, enough))
        if least <= enough:
            break
    return least
