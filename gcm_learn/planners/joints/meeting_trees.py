"""Trees in joints and time, one from the start and one from postures that catch.

A node is a posture with the time at which the limb is there.  The first tree grows forwards by free
moves, the second backwards; a free move from one to the other is a way to a catch.  The idea is
that of RRT-Connect (Kuffner and LaValle 2000) with time, as in ST-RRT* (Grothe et al. 2022).

Under limits of acceleration nodes have rates, too: half of them rest, half move on.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.collision.postures import free_at
from gcm_learn.compiled import njit
from gcm_learn.planners.joints.moves import Study, turning_time
from gcm_learn.planners.joints.pull import pulled
from gcm_learn.planners.joints.ramps import END_FREE, GIVEN, START_FREE, Ramp, new_ramp
from gcm_learn.planners.joints.tree_moves import (
    FROM_CATCH,
    FROM_START,
    LINES,
    Lines,
    box_by,
    halve_by,
    keep_by,
    may_by,
    move_by,
    rates_by,
    time_by,
)
from gcm_learn.planners.joints.ways import MOST, write, write_rates
from gcm_learn.scene.bodies import HAND, PART

TRIES = 3  # nearest nodes of the other tree to which a new node is connected
NEAR_START = 0.5  # share of goals that are drawn near to what the start is pulled to
NEAR_GOAL = 0.3  # share of goals that are drawn near to one that is there
NEARBY = 0.3  # how near: share of a joint's range, and of the horizon
NEARER = 3  # moves to a drawn state that are tried, each half as long as the one before
NEARER_GOAL = 4  # likewise from one to a posture that catches, which is often in a narrow place


class Trees(NamedTuple):
    """Both trees of a search, and its random numbers."""

    moves: Lines | Ramp  # their kind, and room for one
    joints: np.ndarray  # (2, size, n)
    rates: np.ndarray  # (2, size, n): when a node is left, or reached in the second tree [rad/s]
    time: np.ndarray  # (2, size): when the limb is there [s]
    begin: np.ndarray  # (2, size): of the move that joins a node to `via` [s]
    end: np.ndarray  # (2, size) [s]
    free: np.ndarray  # (2, size): which rates of that move were free; see `ramp`
    via: np.ndarray  # (2, size): the node nearer to the root; -1 of a root
    body: np.ndarray  # (size,): caught at a root of the second tree, which all its nodes inherit
    size: np.ndarray  # (2,): nodes of each
    drawn: np.ndarray  # (n,): a posture
    drawn_rates: np.ndarray  # (n,)
    ends: np.ndarray  # (2,): when a move begins and ends [s]
    state: np.ndarray  # (1,) uint64: of the random numbers


def new_trees(study: Study, size: int, seed: int, accelerates: bool) -> Trees:
    """Return trees with the start alone."""
    n = study.goal.size
    trees = Trees(
        new_ramp(n) if accelerates else LINES,
        np.zeros((2, size, n)),
        np.zeros((2, size, n)),
        np.zeros((2, size)),
        np.zeros((2, size)),
        np.zeros((2, size)),
        np.zeros((2, size), np.int64),
        np.full((2, size), -1, np.int64),
        np.zeros(size, np.int64),
        np.zeros(2, np.int64),
        np.zeros(n),
        np.zeros(n),
        np.zeros(2),
        np.array([seed], np.uint64),
    )
    trees.joints[FROM_START, 0] = study.scene.limb.start
    trees.rates[FROM_START, 0] = study.scene.limb.rates
    trees.size[FROM_START] = 1
    return trees


@njit(_nrt=False)
def uniform(trees):
    """Draw a number in [0, 1): splitmix64 (Steele, Lea and Flood 2014)."""
    trees.state[0] += np.uint64(0x9E3779B97F4A7C15)
    z = trees.state[0]
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    z = z ^ (z >> np.uint64(31))
    return float(z >> np.uint64(11)) * (1.0 / 9007199254740992.0)


@njit(_nrt=False)
def _add(trees, tree, q, rates, time, free, via, body):
    """Add a node to a tree, by the move of ``trees.ends``: its number, -1 if the tree is full."""
    k = trees.size[tree]
    if k == trees.time.shape[1]:
        return -1
    for j in range(q.size):
        trees.joints[tree, k, j], trees.rates[tree, k, j] = q[j], rates[j]
    trees.begin[tree, k], trees.end[tree, k] = trees.ends
    trees.time[tree, k] = time
    trees.via[tree, k], trees.free[tree, k] = via, free
    if tree == FROM_CATCH:
        trees.body[k] = body
    trees.size[tree] = k + 1
    return k


@njit(_nrt=False)
def _draw_near_start(study, trees, horizon):
    """Draw a posture between the start and what is within reach: a target and a time [s]."""
    q, rows, start = trees.drawn, study.scene.bodies.rows, study.scene.limb.start
    targets = 0
    for b in range(rows.shape[0]):
        targets += rows[b, PART] == HAND
    left, b = int(uniform(trees) * targets), -1
    while left >= 0:
        b += 1
        left -= rows[b, PART] == HAND
    t = horizon * np.sqrt(1.0 - uniform(trees))
    box_by(trees.moves, study, t)
    near = 1.0 if uniform(trees) >= NEAR_START else uniform(trees)
    for j in range(q.size):
        share = study.low[j] + uniform(trees) * (study.high[j] - study.low[j])
        q[j] = start[j] + near * (share - start[j])
    return b, t


@njit(_nrt=False)
def _draw_near_goal(study, trees, horizon):
    """Draw a posture near one that catches: its target and a time [s]."""
    q, limb = trees.drawn, study.scene.limb
    k = int(uniform(trees) * trees.size[FROM_CATCH])
    while trees.via[FROM_CATCH, k] >= 0:
        k = trees.via[FROM_CATCH, k]
    wide = NEARBY * uniform(trees)
    t = trees.time[FROM_CATCH, k] + wide * horizon * (2.0 * uniform(trees) - 1.0)
    t = min(max(t, 0.01 * horizon), horizon)
    box_by(trees.moves, study, t)
    for j in range(q.size):
        far = wide * (limb.high[j] - limb.low[j]) * (2.0 * uniform(trees) - 1.0)
        q[j] = min(max(trees.joints[FROM_CATCH, k, j] + far, study.low[j]), study.high[j])
    return trees.body[k], t


@njit(_nrt=False)
def draw_goal(study, trees, horizon):
    """Draw a posture that catches a target at some time, and is free then, as a root.

    Returns
    -------
    int
        Number of the root, -1 if the draw failed.
    """
    scene, q = study.scene, trees.drawn
    if trees.size[FROM_CATCH] > 0 and uniform(trees) < NEAR_GOAL:
        b, t = _draw_near_goal(study, trees, horizon)
    else:
        b, t = _draw_near_start(study, trees, horizon)
    if not pulled(study, b, t, q) or not free_at(scene, q, t, study.touch, study.desk):
        return -1
    trees.ends[0] = trees.ends[1] = t
    return _add(trees, FROM_CATCH, q, trees.drawn_rates, t, GIVEN, -1, b)


@njit(_nrt=False)
def _draw_state(study, trees, horizon):
    """Draw a posture that the start can reach, into ``trees.drawn``, and a time for it [s]."""
    limb, q = study.scene.limb, trees.drawn
    for j in range(q.size):
        q[j] = limb.low[j] + uniform(trees) * (limb.high[j] - limb.low[j])
    least = time_by(trees.moves, study.scene.limits, limb.start, q)
    if least >= horizon:  # come nearer, as far as there is time
        share = uniform(trees) * horizon / least
        for j in range(q.size):
            q[j] = limb.start[j] + share * (q[j] - limb.start[j])
        least *= share
    return least + uniform(trees) * (horizon - least)


@njit(_nrt=False)
def _nearest(study, trees, tree, q, t, worse):
    """Node of a tree from or to which a move to q (n,) at t [s] is quickest, and its time.

    Parameters
    ----------
    worse : float
        Only moves that take longer than this count [s].
    """
    limits, best, found = study.scene.limits, 1e300, -1
    for k in range(trees.size[tree]):
        spare = t - trees.time[tree, k] if tree == FROM_START else trees.time[tree, k] - t
        if spare <= 0.0:
            continue
        there = trees.joints[tree, k]
        took = turning_time(limits.joint_speed, there, q)
        if worse < took < best and took <= spare:
            root = tree == FROM_CATCH and trees.via[tree, k] < 0
            if root or may_by(trees.moves, limits, there, trees.rates[tree, k], q, spare, tree):
                best, found = took, k
    return found, best


@njit(_nrt=False)
def _join(study, trees, tree, k, q, rates, t, free):
    """Free move between node k of a tree and joints q with some rates (n,) at t [s].

    Returns whether there is one. Its begin and end are in ``trees.ends``, and what rates were free
    are written.
    """
    there, when, turning = trees.joints[tree, k], trees.time[tree, k], trees.rates[tree, k]
    if tree == FROM_START:
        begin, end = move_by(trees.moves, study, there, turning, when, q, rates, t, free)
    else:
        if trees.via[tree, k] < 0:
            free += END_FREE
        begin, end = move_by(trees.moves, study, q, rates, t, there, turning, when, free)
    trees.ends[0], trees.ends[1] = begin, end
    if begin < 0.0:
        return False
    keep_by(trees.moves, tree, free, rates)
    return True


@njit(_nrt=False)
def _grown(study, trees, horizon):
    """Grow the first tree to a drawn state; the new node, -1 if no move is free.

    If the whole move is blocked, half of it is tried, and so on.
    """
    tree, q, rates = FROM_START, trees.drawn, trees.drawn_rates
    t = _draw_state(study, trees, horizon)
    free = rates_by(trees.moves, tree, rates, uniform(trees))
    k, _ = _nearest(study, trees, tree, q, t, -1.0)
    if k < 0:
        return -1
    there, when = trees.joints[tree, k], trees.time[tree, k]
    for _ in range(NEARER):
        if free_at(study.scene, q, t, study.touch, study.desk):
            if _join(study, trees, tree, k, q, rates, t, free):
                return _add(trees, tree, q, rates, trees.ends[1], free, k, 0)
        halve_by(trees.moves, q, there, trees.rates[tree, k], t - when)
        t = 0.5 * (t + when)
    return -1


@njit(_nrt=False)
def _grown_backward(study, trees):
    """Grow the second tree by a move from a drawn posture; the new node, -1 if none is free.

    The move ends at the nearest node, and begins at a time by which the start can be there.
    """
    limits, limb = study.scene.limits, study.scene.limb
    tree, q, rates = FROM_CATCH, trees.drawn, trees.drawn_rates
    for j in range(q.size):
        q[j] = limb.low[j] + uniform(trees) * (limb.high[j] - limb.low[j])
    free = rates_by(trees.moves, tree, rates, uniform(trees))
    k, best = -1, 1e300
    for m in range(trees.size[tree]):
        took = turning_time(limits.joint_speed, q, trees.joints[tree, m])
        if took < best:
            k, best = m, took
    there, when, turning = trees.joints[tree, k], trees.time[tree, k], trees.rates[tree, k]
    if trees.via[tree, k] < 0:
        free += END_FREE
        for j in range(q.size):
            turning[j] = 0.0
    share = uniform(trees)
    for _ in range(NEARER_GOAL):
        took = time_by(trees.moves, limits, q, there)
        spare = when - took - time_by(trees.moves, limits, limb.start, q)
        took += share * max(spare, 0.0)
        if spare > 0.0 and free_at(study.scene, q, when - took, study.touch, study.desk):
            if _join(study, trees, tree, k, q, rates, when - took, free & START_FREE):
                time = trees.ends[0]
                return _add(trees, tree, q, rates, time, free, k, trees.body[k])
        halve_by(trees.moves, q, there, turning, -took)
    return -1


@njit(_nrt=False)
def _connected(study, trees, tree, k):
    """Node of the other tree to which node k has a free move, whose ends are in ``trees.ends``."""
    other, worse = 1 - tree, -1.0
    q, t, rates = trees.joints[tree, k], trees.time[tree, k], trees.rates[tree, k]
    free = END_FREE if tree == FROM_CATCH and trees.via[tree, k] < 0 else GIVEN
    for _ in range(TRIES):
        m, took = _nearest(study, trees, other, q, t, worse)
        if m < 0:
            return -1
        if _join(study, trees, other, m, q, rates, t, free):
            return m
        worse = took
    return -1


@njit
def search_trees(study, trees, rounds, horizon, way):
    """Grow both trees until they meet.

    Parameters
    ----------
    rounds : int
        Goals that are drawn; each is followed by growing both trees.
    horizon : float
        Catches after this do not count [s].
    way : Way
        Written if they meet.

    Returns
    -------
    bool
    """
    for _ in range(rounds):
        root = draw_goal(study, trees, horizon)
        if root >= 0:
            m = _connected(study, trees, FROM_CATCH, root)
            if m >= 0:
                return _trace(trees, m, root, way)
        elif trees.size[FROM_CATCH] == 0:
            continue
        for tree in range(2):
            if tree == FROM_START:
                k = _grown(study, trees, horizon)
            else:
                k = _grown_backward(study, trees)
            if k < 0:
                continue
            m = _connected(study, trees, tree, k)
            if m >= 0:
                first, second = (k, m) if tree == FROM_START else (m, k)
                return _trace(trees, first, second, way)
        if max(trees.size[0], trees.size[1]) + 2 > trees.time.shape[1]:
            return False
    return False


@njit
def _trace(trees, first, second, way):
    """Write the way through node `first` of the one tree and `second` of the other.

    The move between them is in ``trees.ends``.
    """
    length, k = 1, first
    while trees.via[FROM_START, k] >= 0:
        length, k = length + 1, trees.via[FROM_START, k]
    after, k = 1, second
    while trees.via[FROM_CATCH, k] >= 0:
        after, k = after + 1, trees.via[FROM_CATCH, k]
    if length + after > MOST:
        return False
    way.body[0] = trees.body[second]
    order = np.empty(length, np.int64)
    k = first
    for i in range(length - 1, -1, -1):
        order[i] = k
        k = trees.via[FROM_START, k]
    root = trees.via[FROM_CATCH, second] < 0
    for i in range(length):
        k, last = order[i], i + 1 == length
        left = trees.ends[0] if last else trees.begin[FROM_START, order[i + 1]]
        reached = trees.end[FROM_START, k] if i > 0 else 0.0
        write(way, i, trees.joints[FROM_START, k], reached, left)
        free = (END_FREE if root else GIVEN) if last else trees.free[FROM_START, order[i + 1]]
        write_rates(way, i, trees.rates[FROM_START, k], free)
    k, reached, i = second, trees.ends[1], length
    while k >= 0:
        root = trees.via[FROM_CATCH, k] < 0
        left = trees.time[FROM_CATCH, k] if root else trees.begin[FROM_CATCH, k]
        write(way, i, trees.joints[FROM_CATCH, k], reached, left)
        write_rates(way, i, trees.rates[FROM_CATCH, k], trees.free[FROM_CATCH, k])
        reached, i, k = trees.end[FROM_CATCH, k], i + 1, trees.via[FROM_CATCH, k]
    return True
