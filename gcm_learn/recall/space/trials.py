"""Many memories tried on one situation of a spatial arm: adapted, checked, bent where they touch.

As `recall.trials` does in the plane.  A memory counts as one check, in whatever form it ends.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.compiled import njit
from gcm_learn.planners.space.ways import samples_of
from gcm_learn.recall.space.bending import bend, hasten
from gcm_learn.recall.space.kernels import KNOTS, adapt_to_targets, first_touch
from gcm_learn.recall.trials import learn, most_promising


@njit
def catch_times(knots, chosen, query, tempo, bends, work):
    """When memories, adapted to a situation, catch in it (m,) [s]; negative where they do not.

    Parameters
    ----------
    knots : (n, KNOTS, COLUMNS) ndarray of float32
        All memories.
    chosen : (m,) ndarray of int64
        Which of them to try.
    query : Query
    tempo : int
    bends : int
        Changes at most of a movement that touches.
    work : Work
    """
    out = np.full(chosen.size, -1.0)
    for i in range(chosen.size):
        if _met(knots, chosen[i], query, tempo, work, bends):
            free, time, _, _ = _freed(query, tempo, work, bends)
            if free:
                out[i] = time[-1]
    return out


@njit
def _freed(query, tempo, work, bends):
    """Bend the best movement if it touches: whether it is free then, its samples, its target."""
    time, joints, body = samples_of(query.study, work.way)
    free = first_touch(query.study, time, joints) < 0
    if not free and bends > 0 and bend(query, tempo, work, bends):
        time, joints, body = samples_of(query.study, work.way)
        free = first_touch(query.study, time, joints) < 0
    return free, time, joints, body


@njit
def _met(knots, m, query, tempo, work, bends):
    """Adapt memory m, and hasten it where it comes too late; whether a target can be met."""
    met = adapt_to_targets(knots, m, query, tempo, work)
    return met or (bends > 0 and hasten(query, tempo, work))


@njit
def first_valid(knots, offer, query, tempo, budget, work):
    """Try memories, the most promising first, until one is valid; as `recall.trials.first_valid`.

    Returns
    -------
    place : int
        Position in the offer, -1 if none is valid.
    body : int
        The target that is caught.
    checked : int
        Movements that were checked.
    time, joints : (m,), (m, 4) ndarray
        The valid movement.
    """
    none, nothing = np.empty(0), np.empty((0, 4))
    failed = np.empty((budget.tries, KNOTS, 5))
    checked = 0
    while True:
        i = most_promising(offer)
        if i < 0 or checked >= budget.tries:
            return -1, -1, checked, none, nothing
        offer.left[i] = False
        if not _met(knots, offer.chosen[i], query, tempo, work, budget.changes):
            checked += 1 if budget.novelty <= 0.0 else 0
        elif budget.novelty <= 0.0 or not _known(failed[:checked], work, budget.novelty):
            _note(failed[checked], work)
            checked += 1
            free, time, joints, body = _freed(query, tempo, work, budget.changes)
            if free:
                return i, body, checked, time, joints
        if budget.penalty > 0.0:
            learn(offer, i, budget.penalty)


@njit(_nrt=False)
def _note(row, work):
    """Note the best movement."""
    for k in range(KNOTS):
        for j in range(4):
            row[k, j] = work.way.joints[k, j]
        row[k, 4] = work.way.reached[k]


@njit(_nrt=False)
def _known(failed, work, novelty):
    """Whether a noted movement is everywhere within `novelty` [rad] of the best one.

    A second counts as much as ten radians.
    """
    way = work.way
    for row in range(failed.shape[0]):
        apart = 0.0
        for k in range(KNOTS):
            apart = max(apart, 10.0 * abs(failed[row, k, 4] - way.reached[k]))
            for j in range(4):
                apart = max(apart, abs(failed[row, k, j] - way.joints[k, j]))
            if apart > novelty:
                break
        if apart <= novelty:
            return True
    return False
