"""Many memories tried on one situation, in compiled code: adapted, repaired, checked.

A path that was adapted to a situation and touches an obstacle there is moved once more: by a bump
whose top is where the limb first touches, which is zero at both ends, and no higher than needed for
the limb to be free there. What comes out is timed and checked like any other path, and counts as
one.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.collision.distance import arm_distance, limb_point2
from gcm_learn.collision.sweep import least_distance
from gcm_learn.compiled import njit
from gcm_learn.motion.verification import nearest_to_shoulder
from gcm_learn.recall.kernels import HUB, POLAR, adapt, desk_for, keep, meet
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


class Offer(NamedTuple):
    """Memories that may hold."""

    chosen: np.ndarray  # (m,) int64: which of all
    scores: np.ndarray  # (m,) float64: how promising each is
    places: np.ndarray  # (m, d) float32: their embeddings
    left: np.ndarray  # (m,) bool: not tried yet


@njit
def holds(query, time, hand, count):
    """Whether the limb keeps free and out of the hole on a path, its first `count` samples."""
    time, hand, floor = time[:count], hand[:count], query.rules.touch
    if count > 1 and nearest_to_shoulder(hand) < max(query.scene.limb.near, 0.5 * HUB):
        return False
    return least_distance(query.scene, time, hand, floor, np.inf)[0] > floor


@njit
def transfer(traces, goals, chosen, query, style, tempo, mends):
    """When memories, bent to a situation, catch in it.

    Parameters
    ----------
    traces, goals : (n, KNOTS, 4), (n, 2) ndarray of float32
        All memories.
    chosen : (m,) ndarray of int64
        Which of them to try.
    query : Query
    style, tempo : int
    mends : int
        How often a path that touches is pushed aside.

    Returns
    -------
    (m,) ndarray
        Catch times [s], negative where the bent path does not hold.
    """
    desk = desk_for(query)
    time, hand = desk.best_time, desk.best_hand
    out = np.full(chosen.size, -1.0)
    for i in range(chosen.size):
        samples, body = adapt(traces, goals, chosen[i], query, style, tempo, desk)
        for k in range(mends + 1):
            if samples == 0:
                break
            if holds(query, time, hand, samples):
                out[i] = time[samples - 1]
                break
            if k < mends:
                samples = mend(traces, goals, chosen[i], query, style, tempo, desk, samples, body)
    return out


@njit
def first_that_holds(traces, goals, offer, query, styles, mends, tries, novelty, regret):
    """Try memories, the most promising first, until one holds.

    Each failure says something about the situation: memories in the same direction are put back, so
    that the next one tried is another kind of way.

    Parameters
    ----------
    traces, goals, query :
        As of `transfer`.
    offer : Offer
        The memories; scores and what is left of them are changed.
    styles : (s, 2) ndarray of int64
        Styles and tempos that each is tried in.
    mends : int
        How often a path that touches is pushed aside.
    tries : int
        Paths that are checked at most.
    novelty : float
        A path that stays this near to one that has failed is not checked [forearm lengths].
    regret : float
        What a memory loses by the failure of one in the same direction.

    Returns
    -------
    place : int
        Position in the offer, -1 if none holds.
    body : int
        The target that is caught.
    checked : int
        Paths that were checked.
    time, hand : (m,), (m, 2) ndarray
        The path that holds.
    """
    n, desk = traces.shape[1], desk_for(query)
    time, hand = desk.best_time, desk.best_hand
    failed = np.empty((tries, n + 1, 3))
    checked, kept = 0, 0
    while True:
        i = _most_promising(offer)
        if i < 0:
            return -1, -1, checked, time[:0], hand[:0]
        offer.left[i] = False
        m = offer.chosen[i]
        for s in range(styles.shape[0]):
            style, tempo = styles[s, 0], styles[s, 1]
            samples, body = adapt(traces, goals, m, query, style, tempo, desk)
            if samples == 0 and novelty <= 0.0:
                checked += 1
            for k in range(mends + 1):
                if checked >= tries:
                    return -1, -1, checked, time[:0], hand[:0]
                if samples == 0:
                    break
                if novelty > 0.0 and _known(failed, kept, query, time, hand, samples, novelty):
                    break
                checked += 1
                if holds(query, time, hand, samples):
                    return i, body, checked, time[:samples], hand[:samples]
                _keep(failed, kept, query, time, hand, samples)
                kept += 1
                if k < mends:
                    samples = mend(traces, goals, m, query, style, tempo, desk, samples, body)
        if regret > 0.0:
            _learn(offer, i, regret)


@njit(_nrt=False)
def _most_promising(offer):
    """Position of the largest score that is left, the first of equal ones; -1 if none is."""
    best = -1
    for i in range(offer.scores.size):
        if offer.left[i] and (best < 0 or offer.scores[i] > offer.scores[best]):
            best = i
    return best


@njit(_nrt=False)
def _learn(offer, failed, regret):
    """Take from all scores what the failure of one says: more, the nearer their direction is."""
    own = _length(offer.places, failed)
    for i in range(offer.scores.size):
        if offer.left[i]:
            total = 0.0
            for j in range(offer.places.shape[1]):
                total += offer.places[i, j] * offer.places[failed, j]
            cosine = max(total / max(own * _length(offer.places, i), 1e-30), 0.0)
            offer.scores[i] -= regret * cosine**4


@njit(_nrt=False)
def _length(places, i):
    total = 0.0
    for j in range(places.shape[1]):
        total += places[i, j] ** 2
    return np.sqrt(total)


@njit(_nrt=False)
def _keep(failed, row, query, time, hand, count):
    """Note a path; samples that it does not have are its last one."""
    for k in range(failed.shape[1]):
        j = min(k, count - 1)
        failed[row, k, 0], failed[row, k, 1] = hand[j, 0], hand[j, 1]
        failed[row, k, 2] = query.rules.speed * time[j]


@njit(_nrt=False)
def _known(failed, rows, query, time, hand, count, novelty):
    """Whether one of the noted paths is everywhere as near as `novelty`, time included."""
    limit = novelty * novelty
    for row in range(rows):
        apart = 0.0
        for k in range(failed.shape[1]):
            j = min(k, count - 1)
            d2 = (failed[row, k, 0] - hand[j, 0]) ** 2 + (failed[row, k, 1] - hand[j, 1]) ** 2
            apart = max(apart, d2 + (failed[row, k, 2] - query.rules.speed * time[j]) ** 2)
            if apart > limit:
                break
        if apart <= limit:
            return True
    return False
