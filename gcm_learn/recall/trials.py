"""Many memories tried on one situation, in compiled code: adapted, bent, checked.

Every memory is checked once, in the form that its adaptation gave it: a path that looks as if it
touched is bent first (`bending`), and one that still does so counts as a check that failed. After
the first failure more are looked at than are checked: what touches less is more easily freed.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.collision.sweep import least_distance
from gcm_learn.compiled import njit
from gcm_learn.motion.verification import nearest_to_shoulder
from gcm_learn.recall.bending import bend, hasten, look
from gcm_learn.recall.kernels import HUB, KNOTS, Style, adapt_to_targets, workspace_for

LOOKS = 5  # memories that are looked at for each check after the first
TOUCH = 32.0  # what a memory loses by touching, before it is bent [log-odds by cost of a look]


class Offer(NamedTuple):
    """Memories that may be valid."""

    chosen: np.ndarray  # (m,) int64: which of all
    scores: np.ndarray  # (m,) float64: how promising each is
    places: np.ndarray  # (m, d) float32: their embeddings
    left: np.ndarray  # (m,) bool: not tried yet


class Budget(NamedTuple):
    """How much is tried."""

    changes: int  # at most of a path that touches
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
def _met(knots, goals, m, query, style, work, bends):
    """Adapt memory m, and hasten it where it comes too late; as `adapt_to_targets`."""
    count, body = adapt_to_targets(knots, goals, m, query, style, work)
    if count == 0 and bends > 0:
        return hasten(query, style, work)
    return count, body


@njit
def adapted(knots, goals, m, query, style, work, bends):
    """Adapt memory m, and bend it where it looks as if it touched.

    Returns
    -------
    count : int
        Samples of the path in the workspace, 0 if no target can be met in time.
    free : bool
        Whether the path may be free.
    body : int
    """
    count, body = _met(knots, goals, m, query, style, work, bends)
    if count == 0:
        return count, False, body
    count, free = bend(query, style, work, count, body, bends)
    return count, free, body


@njit
def catch_times(knots, goals, chosen, query, styles, bends):
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
    bends : int
        Changes at most of a path that touches.

    Returns
    -------
    (m,) ndarray
        Catch times [s], negative where no adapted path is valid.
    """
    work, out = workspace_for(query), np.full(chosen.size, -1.0)
    for i in range(chosen.size):
        for s in range(styles.shape[0]):
            style = Style(styles[s, 0], styles[s, 1])
            samples, free = adapted(knots, goals, chosen[i], query, style, work, bends)[:2]
            if free and is_valid(query, work, samples):
                out[i] = work.best_time[samples - 1]
            if out[i] >= 0.0:
                break
    return out


@njit
def first_valid(knots, goals, offer, query, styles, budget):
    """Try memories, the most promising first, until one is valid.

    Each failure says something about the situation: memories in the same direction are put back, so
    that the next one tried is another kind of path. After the first failure some are looked at for
    each that is checked, as they are adapted and not yet bent, and those that touch are put back.
    Where near ones are not passed over the order is that of the offer.

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
    costs = np.full(offer.scores.size, np.nan)
    checked, kept = 0, 0
    while True:
        if checked == 0 or budget.novelty <= 0.0:
            i = most_promising(offer)
        else:
            style = Style(styles[0, 0], styles[0, 1])
            _look_on(knots, goals, offer, costs, query, style, work, failed[:kept], budget)
            i = _least_touching(offer, costs)
        if i < 0:
            return -1, -1, checked, time[:0], hand[:0]
        offer.left[i] = False
        for s in range(styles.shape[0]):
            style = Style(styles[s, 0], styles[s, 1])
            m, bends = offer.chosen[i], budget.changes
            samples, body = _met(knots, goals, m, query, style, work, bends)
            if samples == 0:
                checked += 1 if budget.novelty <= 0.0 else 0
            elif budget.novelty <= 0.0 or not _known(failed[:kept], query, work, samples, budget):
                checked += 1
                _note(failed[kept], query, work, samples)
                kept += 1
                samples, free = bend(query, style, work, samples, body, bends)
                if free and is_valid(query, work, samples):
                    return i, body, checked, time[:samples], hand[:samples]
            if checked >= budget.tries:
                return -1, -1, checked, time[:0], hand[:0]
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


@njit
def _look_on(knots, goals, offer, costs, query, style, work, failed, budget):
    """Look at some more memories, the most promising first, and note how much they touch.

    Those that meet no target, or are near to one that failed, are left no more.
    """
    looked = 0
    while looked < LOOKS:
        i = -1
        for j in range(costs.size):
            if offer.left[j] and np.isnan(costs[j]):
                if i < 0 or offer.scores[j] > offer.scores[i]:
                    i = j
        if i < 0:
            break
        count, _ = _met(knots, goals, offer.chosen[i], query, style, work, budget.changes)
        if count == 0 or _known(failed, query, work, count, budget):
            offer.left[i] = False
            continue
        costs[i], _, _ = look(query, work, count, 0.0)
        looked += 1


@njit(_nrt=False)
def _least_touching(offer, costs):
    """Position of the most promising memory that was looked at, less what it touches; or -1."""
    best, most = -1, -np.inf
    for i in range(costs.size):
        if offer.left[i] and not np.isnan(costs[i]):
            score = offer.scores[i] - TOUCH * costs[i]
            if best < 0 or score > most:
                best, most = i, score
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
