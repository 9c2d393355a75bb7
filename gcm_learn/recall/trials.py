"""Trials of many memories on one situation, in compiled code: adapt, free, check.

Every memory is checked once, in the form that its adaptation gave it. After the first failure some
memories are compared for each check of a hand path: a path that touches less is easier to free.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

import gcm_learn.recall.hand_paths as hand_paths
import gcm_learn.recall.joint_moves as joint_moves
import gcm_learn.recall.timed_moves as timed_moves
from gcm_learn.compiled import by_type, njit
from gcm_learn.recall.freeing import again, free, habits, quick_check
from gcm_learn.recall.hand_paths import HandQuery
from gcm_learn.recall.joint_moves import JointQuery
from gcm_learn.recall.meeting import adapt_to_targets, hasten
from gcm_learn.recall.styles import POLAR, Style
from gcm_learn.recall.timed_moves import TimedQuery

TOUCH = 32.0  # loss of a memory by contact before it is freed [log-odds by cost of a quick check]

_check = by_type({HandQuery: hand_paths.check, JointQuery: joint_moves.check})
_failures = by_type(
    {
        HandQuery: hand_paths.failures,
        JointQuery: joint_moves.failures,
        TimedQuery: timed_moves.failures,
    }
)
_note = by_type(
    {HandQuery: hand_paths.note, JointQuery: joint_moves.note, TimedQuery: timed_moves.note}
)
_is_near = by_type(
    {
        HandQuery: hand_paths.is_near,
        JointQuery: joint_moves.is_near,
        TimedQuery: timed_moves.is_near,
    }
)


class Offer(NamedTuple):
    """Memories that may be valid."""

    chosen: np.ndarray  # (m,) int64: positions among all
    scores: np.ndarray  # (m,) float64: how promising each is
    places: np.ndarray  # (m, d) float32: their embeddings
    left: np.ndarray  # (m,) bool: not tried yet


class TrialLimits(NamedTuple):
    """Limits of trials."""

    changes: int  # at most of a path that touches
    tries: int  # paths that are checked at most
    novelty: float  # a path this near to one that failed is not checked
    penalty: float  # what a memory loses by the failure of one in the same direction


@njit
def _met_in_time(query, paths, m, style, work, bends):
    """Adapt memory m, and hasten a path that is too late; return as `adapt_to_targets` does."""
    count, body = adapt_to_targets(paths, m, query, style, work)
    if count == 0 and bends > 0:
        return hasten(query, style, work)
    return count, body


@njit
def _freed_path(query, style, work, count, body, bends):
    """Check the best path, and change the path where it touches."""
    if habits(query).checks_first:
        samples, is_free, caught = _check(query, work, count, body)
        if is_free or bends == 0:
            return samples, is_free, caught
    if bends > 0 and style.space == POLAR:
        count, is_free = free(query, style, work, count, body, bends)
        if not is_free:
            return count, False, body
    return _check(query, work, count, body)


@njit
def _freed_in_its_time(query, style, work, count, body, bends):
    """Push the movement aside if it touches at all end times; write a free one as the best."""
    caught = work.track.body[0]
    if caught < 0:
        until, samples = again(query, body, style, work, 0.0)
        if until < 0.0 or not free(query, style, work, samples, body, bends)[1]:
            return count, False, body
        caught = body
    return timed_moves.write_best(work), True, caught


met = by_type({HandQuery: _met_in_time, JointQuery: _met_in_time, TimedQuery: timed_moves.met})
"""Adapt memory m; samples of the path, 0 if no target can be met in time, and the target."""
freed = by_type({HandQuery: _freed_path, JointQuery: _freed_path, TimedQuery: _freed_in_its_time})
"""Free the best path from contacts; its samples, whether it is free, and the target."""


@njit
def adapted(query, paths, m, style, work, bends):
    """Adapt memory m, and change the path where a quick check finds a contact.

    Returns
    -------
    count : int
        Samples of the path in the buffers, 0 if no target can be met in time.
    free : bool
        True if the path may be free.
    body : int
    """
    count, body = met(query, paths, m, style, work, bends)
    if count == 0:
        return count, False, body
    is_free = True
    if bends > 0 and style.space == POLAR:
        count, is_free = free(query, style, work, count, body, bends)
    return count, is_free, body


@njit
def catch_times(query, paths, chosen, styles, bends, work):
    """Return the catch times of memories adapted to a situation.

    Parameters
    ----------
    query : HandQuery, JointQuery or TimedQuery
    paths : (ndarray, ndarray)
        Knots and goals of all memories, float32.
    chosen : (m,) ndarray of int64
        Memories to try.
    styles : (s, 2) ndarray of int64
        Columns of `Style`, in the order in which each is tried.
    bends : int
        Changes at most of a path that touches.
    work : HandWork or JointWork

    Returns
    -------
    (m,) ndarray
        Catch times [s], negative where no adapted path is valid.
    """
    out = np.full(chosen.size, -1.0)
    for i in range(chosen.size):
        for s in range(styles.shape[0]):
            style = Style(styles[s, 0], styles[s, 1])
            count, body = met(query, paths, chosen[i], style, work, bends)
            if count > 0:
                count, is_free, body = freed(query, style, work, count, body, bends)
                if is_free:
                    out[i] = work.best_time[count - 1]
                    break
    return out


@njit
def first_valid(query, paths, offer, styles, budget, work):
    """Try memories, the most promising first, until one is valid.

    Each failure says something about the situation: memories in the same direction lose by it, so
    that the next one tried is another kind of path. Without novelty the order is that of the
    offer.

    Parameters
    ----------
    query, paths, styles, work :
        See `catch_times`.
    offer : Offer
        The memories; scores and what is left of them are changed.
    budget : TrialLimits

    Returns
    -------
    place : int
        Position in the offer, -1 if none is valid.
    body : int
        The target that is caught.
    checked : int
        Paths that were checked.
    count : int
        Samples of the valid path, which is left in the buffers.
    """
    failed, costs = _failures(query, budget.tries), np.full(offer.scores.size, np.nan)
    checked, kept, compares = 0, 0, habits(query).alternatives > 0 and budget.novelty > 0.0
    while True:
        if checked > 0 and compares:
            style = Style(styles[0, 0], styles[0, 1])
            _compare(query, paths, offer, costs, style, work, failed[:kept], budget)
            i = _least_touching(offer, costs)
        else:
            i = most_promising(offer)
        if i < 0:
            return -1, -1, checked, 0
        offer.left[i] = False
        for s in range(styles.shape[0]):
            style = Style(styles[s, 0], styles[s, 1])
            count, body = met(query, paths, offer.chosen[i], style, work, budget.changes)
            if count == 0:
                checked += 1 if budget.novelty <= 0.0 else 0
            elif not _known(query, failed[:kept], work, count, budget.novelty):
                checked += 1
                _note(query, failed[kept], work, count)
                kept += 1
                count, is_free, body = freed(query, style, work, count, body, budget.changes)
                if is_free:
                    return i, body, checked, count
            if checked >= budget.tries:
                return -1, -1, checked, 0
        if budget.penalty > 0.0:
            learn(offer, i, budget.penalty)


@njit(_nrt=False)
def most_promising(offer):
    """Return the position of the largest score left, the first among equals; -1 if none is left."""
    best = -1
    for i in range(offer.scores.size):
        if offer.left[i] and (best < 0 or offer.scores[i] > offer.scores[best]):
            best = i
    return best


@njit
def _compare(query, paths, offer, costs, style, work, failed, budget):
    """Adapt some more memories, the most promising first, and note how much they touch.

    Memories that meet no target, or are near to one that failed, are out.
    """
    compared = 0
    while compared < habits(query).alternatives:
        i = -1
        for j in range(costs.size):
            if offer.left[j] and np.isnan(costs[j]):
                if i < 0 or offer.scores[j] > offer.scores[i]:
                    i = j
        if i < 0:
            break
        count, _ = met(query, paths, offer.chosen[i], style, work, budget.changes)
        if count == 0 or _known(query, failed, work, count, budget.novelty):
            offer.left[i] = False
            continue
        costs[i] = quick_check(query, work, count, 0.0, np.inf)[0]
        compared += 1


@njit
def _known(query, failed, work, count, novelty):
    """Return whether the best path is within `novelty` of a failed path; False at novelty 0."""
    if novelty > 0.0:
        for row in range(failed.shape[0]):
            if _is_near(query, failed[row], work, count, novelty):
                return True
    return False


@njit(_nrt=False)
def _least_touching(offer, costs):
    """Return the position of the compared memory with the best score less contact, or -1."""
    best, most = -1, -np.inf
    for i in range(costs.size):
        if offer.left[i] and not np.isnan(costs[i]):
            score = offer.scores[i] - TOUCH * costs[i]
            if best < 0 or score > most:
                best, most = i, score
    return best


@njit(_nrt=False)
def learn(offer, failed, penalty):
    """Lower the scores after a failure: more, the nearer a memory's direction to the failed one."""
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
