"""Many memories tried on one situation, in compiled code: adapted, checked, repaired.

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
from gcm_learn.recall.kernels import (
    HUB,
    KNOTS,
    POLAR,
    Style,
    adapt_to_targets,
    keep,
    meet,
    workspace_for,
)
from gcm_learn.scene.bodies import DISC, HAND, KIND, PART, REACH
from gcm_learn.scene.limb import elbow_of

PUSHES = np.array([0.06, 0.12, 0.2, 0.3, 0.42])  # heights of bumps [forearm lengths]
TURNS = 8  # directions of bumps
CLEARANCE = 0.012  # by which a pushed limb is free where it touched [forearm lengths]
INSTANTS = 8  # at most at which a push is tried
_RINGS = (0.03, 0.985)  # shares of the ring between which a push may end


class Offer(NamedTuple):
    """Memories that may be valid."""

    chosen: np.ndarray  # (m,) int64: which of all
    scores: np.ndarray  # (m,) float64: how promising each is
    places: np.ndarray  # (m, d) float32: their embeddings
    left: np.ndarray  # (m,) bool: not tried yet


class Budget(NamedTuple):
    """How much is tried."""

    repairs: int  # how often a path that touches is pushed aside
    tries: int  # paths that are checked at most
    novelty: float  # a path this near to one that failed is not checked [forearm lengths]
    penalty: float  # what a memory loses by the failure of one in the same direction


@njit
def is_valid(query, work, count):
    """Whether the limb keeps free and out of the hole on the best path's first samples."""
    time, hand, floor = work.best_time[:count], work.best_hand[:count], query.rules.touch
    if count > 1 and nearest_to_shoulder(hand) < max(query.scene.limb.near, 0.5 * HUB):
        return False
    return least_distance(query.scene, time, hand, floor, np.inf)[0] > floor


@njit
def catch_times(knots, goals, chosen, query, styles, repairs):
    """When memories, adapted to a situation, catch in it.

    Parameters
    ----------
    knots, goals : (n, KNOTS, 4), (n, 2) ndarray of float32
        All memories.
    chosen : (m,) ndarray of int64
        Which of them to try.
    query : Query
    styles : (s, 2) ndarray of int64
        In which each is tried, in order: columns of `Style`.
    repairs : int
        How often a path that touches is pushed aside.

    Returns
    -------
    (m,) ndarray
        Catch times [s], negative where no adapted path is valid.
    """
    work, out = workspace_for(query), np.full(chosen.size, -1.0)
    for i in range(chosen.size):
        for s in range(styles.shape[0]):
            style = Style(styles[s, 0], styles[s, 1])
            samples, body = adapt_to_targets(knots, goals, chosen[i], query, style, work)
            for k in range(repairs + 1):
                if samples > 0 and is_valid(query, work, samples):
                    out[i] = work.best_time[samples - 1]
                    break
                if samples > 0 and k < repairs:
                    samples = repair(query, style, work, samples, body)
            if out[i] >= 0.0:
                break
    return out


@njit
def first_valid(knots, goals, offer, query, styles, budget):
    """Try memories, the most promising first, until one is valid.

    Each failure says something about the situation: memories in the same direction are put back, so
    that the next one tried is another kind of path.

    Parameters
    ----------
    knots, goals, query, styles :
        As of `catch_times`.
    offer : Offer
        The memories; scores and what is left of them are changed.
    budget : Budget

    Returns
    -------
    place : int
        Position in the offer, -1 if none is valid.
    body : int
        The target that is caught.
    checked : int
        Paths that were checked.
    time, hand : (m,), (m, 2) ndarray
        The valid path.
    """
    work = workspace_for(query)
    time, hand = work.best_time, work.best_hand
    failed = np.empty((budget.tries, KNOTS + 1, 3))
    checked, kept = 0, 0
    while True:
        i = most_promising(offer)
        if i < 0:
            return -1, -1, checked, time[:0], hand[:0]
        offer.left[i] = False
        for s in range(styles.shape[0]):
            style = Style(styles[s, 0], styles[s, 1])
            samples, body = adapt_to_targets(knots, goals, offer.chosen[i], query, style, work)
            if samples == 0 and budget.novelty <= 0.0:
                checked += 1
            for k in range(budget.repairs + 1):
                if checked >= budget.tries:
                    return -1, -1, checked, time[:0], hand[:0]
                if samples == 0:
                    break
                if budget.novelty > 0.0 and _known(failed[:kept], query, work, samples, budget):
                    break
                checked += 1
                if is_valid(query, work, samples):
                    return i, body, checked, time[:samples], hand[:samples]
                _note(failed[kept], query, work, samples)
                kept += 1
                if k < budget.repairs:
                    samples = repair(query, style, work, samples, body)
        if budget.penalty > 0.0:
            learn(offer, i, budget.penalty)


@njit(_nrt=False)
def most_promising(offer):
    """Position of the largest score that is left, the first of equal ones; -1 if none is."""
    best = -1
    for i in range(offer.scores.size):
        if offer.left[i] and (best < 0 or offer.scores[i] > offer.scores[best]):
            best = i
    return best


@njit(_nrt=False)
def learn(offer, failed, penalty):
    """Take from all scores what the failure of one says: more, the nearer their direction is."""
    own = _length(offer.places, failed)
    for i in range(offer.scores.size):
        if offer.left[i]:
            total = 0.0
            for j in range(offer.places.shape[1]):
                total += offer.places[i, j] * offer.places[failed, j]
            cosine = max(total / max(own * _length(offer.places, i), 1e-30), 0.0)
            offer.scores[i] -= penalty * cosine**4


@njit(_nrt=False)
def _length(places, i):
    total = 0.0
    for j in range(places.shape[1]):
        total += places[i, j] ** 2
    return np.sqrt(total)


@njit(_nrt=False)
def _note(row, query, work, count):
    """Note the best path; samples that it does not have are its last one."""
    for k in range(KNOTS + 1):
        j = min(k, count - 1)
        row[k, 0], row[k, 1] = work.best_hand[j, 0], work.best_hand[j, 1]
        row[k, 2] = query.rules.speed * work.best_time[j]


@njit(_nrt=False)
def _known(failed, query, work, count, budget):
    """Whether a noted path is everywhere as near as `novelty` to the best one, time included."""
    limit, speed = budget.novelty * budget.novelty, query.rules.speed
    time, hand = work.best_time, work.best_hand
    for row in range(failed.shape[0]):
        apart = 0.0
        for k in range(KNOTS + 1):
            j = min(k, count - 1)
            d2 = (failed[row, k, 0] - hand[j, 0]) ** 2 + (failed[row, k, 1] - hand[j, 1]) ** 2
            apart = max(apart, d2 + (failed[row, k, 2] - speed * time[j]) ** 2)
            if apart > limit:
                break
        if apart <= limit:
            return True
    return False


@njit
def repair(query, style, work, count, body):
    """Push the path that is the best in the workspace aside where it first touches.

    Returns
    -------
    count : int
        Samples of the new path in the workspace, 0 if no push is found.
    """
    if style.space != POLAR:
        return 0
    first, last = _touching(query, work, count)
    if first < 0:
        return 0
    turn, rise, top = _push(query, work, count, first, last)
    if top < 0.0:
        return 0
    for k in range(1, KNOTS - 1):
        height = _bump(work.share[k], top)
        work.base[k, 0] += height * turn
        work.base[k, 1] += height * rise
    t = meet(query, body, style, work)
    if t < 0.0:
        return 0
    keep(work, t)
    return KNOTS + 1


@njit
def _bump(share, top):
    """Height of a bump at a share of the path: 0 at the ends, 1 at its top."""
    s = share / top if share < top else (1.0 - share) / (1.0 - top)
    return np.sin(0.5 * np.pi * min(max(s, 0.0), 1.0)) ** 2


@njit(_nrt=False)
def _clearance(query, g, x, y, enough):
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
def _at(query, work, count, g):
    """Where the best path is at instant g of the table: segment, position in it, and hand."""
    time, hand = work.best_time, work.best_hand
    t, k = g * (query.scene.limits.horizon / (query.table.shape[0] - 1)), 0
    while k < count - 2 and time[k + 1] < t:
        k += 1
    span = time[k + 1] - time[k] if count > 1 else 0.0
    s = min(max((t - time[k]) / span, 0.0), 1.0) if span > 0.0 else 0.0
    x = hand[k, 0] + s * (hand[k + 1, 0] - hand[k, 0])
    return k, s, x, hand[k, 1] + s * (hand[k + 1, 1] - hand[k, 1])


@njit(_nrt=False)
def _touching(query, work, count):
    """First and last instant of the table of the first time that the limb touches; -1 if none."""
    first = -1
    if count < 2:
        return -1, -1
    step = query.scene.limits.horizon / (query.table.shape[0] - 1)
    end = int(work.best_time[count - 1] / step)
    for g in range(1, end + 1):
        _, _, x, y = _at(query, work, count, g)
        touches = _clearance(query, g, x, y, query.rules.touch) <= query.rules.touch
        if touches and first < 0:
            first = g
        if not touches and first >= 0:
            return first, g - 1
    return first, end


@njit
def _push(query, work, count, first, last):
    """The lowest bump that frees the limb from instant `first` to `last`.

    Returns
    -------
    turn, rise : float
        By which its top moves the hand [rad, shares of the ring].
    top : float
        Share of the path at which it is, -1 if none frees the limb.
    """
    limb, share = query.scene.limb, work.share
    width, n = limb.far - limb.near, min(last - first + 1, INSTANTS)
    radius, angle = np.empty(n), np.empty(n)
    place, instant = np.empty(n), np.empty(n, dtype=np.int64)
    for i in range(n):
        g = first + (last - first) * i // max(n - 1, 1)
        k, s, x, y = _at(query, work, count, g)
        before, after = min(k, KNOTS - 1), min(k + 1, KNOTS - 1)
        place[i] = share[before] + s * (share[after] - share[before])
        radius[i], angle[i], instant[i] = np.sqrt(x * x + y * y), np.arctan2(y, x), g
    top = min(max(0.5 * (place[0] + place[n - 1]), 0.04), 0.96)
    middle = radius[n // 2]
    for push in PUSHES:
        best, turn, rise = query.rules.touch + CLEARANCE, 0.0, 0.0
        for d in range(TURNS):
            a = push * np.sin(2.0 * np.pi * d / TURNS) / max(middle, 0.2)
            u = push * np.cos(2.0 * np.pi * d / TURNS) / width
            least = 1e300
            for i in range(n):
                height = _bump(place[i], top)
                ring = (radius[i] - limb.near) / width + height * u
                r = limb.near + min(max(ring, _RINGS[0]), _RINGS[1]) * width
                turned = angle[i] + limb.side * height * a
                x, y = r * np.cos(turned), r * np.sin(turned)
                least = min(least, _clearance(query, instant[i], x, y, best))
                if least <= best:
                    break
            if least > best:
                best, turn, rise = least, a, u
        if turn != 0.0 or rise != 0.0:
            return turn, rise, top
    return 0.0, 0.0, -1.0
