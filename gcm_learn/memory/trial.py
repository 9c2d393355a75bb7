"""Many memories tried on one situation, in compiled code."""

from __future__ import annotations

import numpy as np
from numba import njit

from gcm_learn.memory.holding import holds
from gcm_learn.memory.kernels import adapt, desk_for


@njit(cache=True)
def transfer(traces, goals, chosen, query, style, tempo):
    """When memories, bent to a situation, catch in it.

    Parameters
    ----------
    traces, goals : (n, KNOTS, 4), (n, 2) ndarray of float32
        All memories.
    chosen : (m,) ndarray of int64
        Which of them to try.
    query : Query
    style, tempo : int

    Returns
    -------
    (m,) ndarray
        Catch times [s], negative where the bent path does not hold.
    """
    desk = desk_for(query)
    time, hand = desk.best_time, desk.best_hand
    out = np.full(chosen.size, -1.0)
    for i in range(chosen.size):
        samples, _ = adapt(traces, goals, chosen[i], query, style, tempo, desk)
        if samples > 0 and holds(query, time, hand, samples):
            out[i] = time[samples - 1]
    return out


@njit(cache=True)
def first_that_holds(traces, goals, chosen, query, styles, tries, novelty):
    """Try memories in order until one holds.

    Parameters
    ----------
    traces, goals, chosen, query :
        As of `transfer`, the most promising first.
    styles : (s, 2) ndarray of int64
        Styles and tempos that each is tried in.
    tries : int
        Paths that are checked at most.
    novelty : float
        A path that stays this near to one that has failed is not checked [forearm lengths].

    Returns
    -------
    place : int
        Position in `chosen`, -1 if none holds.
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
    for i in range(chosen.size):
        for s in range(styles.shape[0]):
            if checked >= tries:
                return -1, -1, checked, time[:0], hand[:0]
            samples, body = adapt(traces, goals, chosen[i], query, styles[s, 0], styles[s, 1], desk)
            if samples == 0:
                if novelty <= 0.0:
                    checked += 1
                continue
            if novelty > 0.0 and _known(failed, kept, query, time, hand, samples, novelty):
                continue
            checked += 1
            if holds(query, time, hand, samples):
                return i, body, checked, time[:samples], hand[:samples]
            _keep(failed, kept, query, time, hand, samples)
            kept += 1
    return -1, -1, checked, time[:0], hand[:0]


@njit(cache=True)
def _keep(failed, row, query, time, hand, count):
    """Note a path; samples that it does not have are its last one."""
    for k in range(failed.shape[1]):
        j = min(k, count - 1)
        failed[row, k, 0], failed[row, k, 1] = hand[j, 0], hand[j, 1]
        failed[row, k, 2] = query.speed * time[j]


@njit(cache=True)
def _known(failed, rows, query, time, hand, count, novelty):
    """Whether one of the noted paths is everywhere as near as `novelty`, time included."""
    limit = novelty * novelty
    for row in range(rows):
        apart = 0.0
        for k in range(failed.shape[1]):
            j = min(k, count - 1)
            d2 = (failed[row, k, 0] - hand[j, 0]) ** 2 + (failed[row, k, 1] - hand[j, 1]) ** 2
            apart = max(apart, d2 + (failed[row, k, 2] - query.speed * time[j]) ** 2)
            if apart > limit:
                break
        if apart <= limit:
            return True
    return False
