"""Many memories tried on one situation, in compiled code."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.compiled import njit
from gcm_learn.recall.kernels import adapt, desk_for
from gcm_learn.recall.repair import mend
from gcm_learn.recall.validity import holds


class Offer(NamedTuple):
    """Memories that may hold."""

    chosen: np.ndarray  # (m,) int64: which of all
    scores: np.ndarray  # (m,) float64: how promising each is
    places: np.ndarray  # (m, d) float32: their embeddings
    left: np.ndarray  # (m,) bool: not tried yet


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
