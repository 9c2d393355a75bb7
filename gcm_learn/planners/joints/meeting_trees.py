"""Trees in joints and time, one from the start and one from postures that catch.

A node is a posture with the time at which the limb is there.  The first tree grows forwards by free
moves, the second backwards; a free move from one to the other is a way to a catch.  The idea is
that of RRT-Connect (Kuffner and LaValle 2000) with time, as in ST-RRT* (Grothe et al. 2022).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.collision.postures import gap_at
from gcm_learn.compiled import njit
from gcm_learn.planners.joints.goals import reach
from gcm_learn.planners.joints.moves import Study, turning_time
from gcm_learn.planners.joints.pull import box, pulled
from gcm_learn.planners.joints.ways import MOST, write
from gcm_learn.scene.bodies import HAND, PART

FROM_START, FROM_CATCH = 0, 1
TRIES = 3  # nearest nodes of the other tree to which a new node is connected
NEAR_START = 0.5  # share of goals that are drawn near to what the start is pulled to


class Trees(NamedTuple):
    """Both trees of a search, and its random numbers."""

    joints: np.ndarray  # (2, size, n)
    time: np.ndarray  # (2, size): when the limb is there [s]
    begin: np.ndarray  # (2, size): of the move that joins a node to `via` [s]
    end: np.ndarray  # (2, size) [s]
    via: np.ndarray  # (2, size): the node nearer to the root; -1 of a root
    body: np.ndarray  # (size,): caught at a root of the second tree, which all its nodes inherit
    size: np.ndarray  # (2,): nodes of each
    drawn: np.ndarray  # (n,): a posture
    state: np.ndarray  # (1,) uint64: of the random numbers


def new_trees(study: Study, size: int, seed: int) -> Trees:
    """Return trees with the start alone."""
    n = study.goal.size
    trees = Trees(
        np.zeros((2, size, n)),
        np.zeros((2, size)),
        np.zeros((2, size)),
        np.zeros((2, size)),
        np.full((2, size), -1, np.int64),
        np.zeros(size, np.int64),
        np.zeros(2, np.int64),
        np.zeros(n),
        np.array([seed], np.uint64),
    )
    trees.joints[FROM_START, 0] = study.scene.limb.start
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
def _add(trees, tree, q, time, begin, end, via, body):
    """Add a node to a tree: its number, -1 if the tree is full."""
    k = trees.size[tree]
    if k == trees.time.shape[1]:
        return -1
    for j in range(q.size):
        trees.joints[tree, k, j] = q[j]
    trees.time[tree, k], trees.begin[tree, k], trees.end[tree, k] = time, begin, end
    trees.via[tree, k] = via
    if tree == FROM_CATCH:
        trees.body[k] = body
    trees.size[tree] = k + 1
    return k


@njit(_nrt=False)
def draw_goal(study, trees, horizon):
    """Draw a posture that catches a target at some time, and is free then, as a root.

    Returns
    -------
    int
        Number of the root, -1 if the draw failed.
    """
    scene, q = study.scene, trees.drawn
    rows, limb = scene.bodies.rows, scene.limb
    targets = 0
    for b in range(rows.shape[0]):
        targets += rows[b, PART] == HAND
    left, b = int(uniform(trees) * targets), -1
    while left >= 0:
        b += 1
        left -= rows[b, PART] == HAND
    t = horizon * (1.0 - uniform(trees))
    box(study, limb.start, t)
    near = 1.0 if uniform(trees) >= NEAR_START else uniform(trees)
    for j in range(q.size):
        share = study.low[j] + uniform(trees) * (study.high[j] - study.low[j])
        q[j] = limb.start[j] + near * (share - limb.start[j])
    if not pulled(study, b, t, q) or gap_at(scene, q, t, study.desk) <= study.touch:
        return -1
    return _add(trees, FROM_CATCH, q, t, t, t, -1, b)


@njit(_nrt=False)
def _draw_state(study, trees, horizon):
    """Draw a posture that the start can reach, into ``trees.drawn``, and a time for it [s]."""
    limb, q = study.scene.limb, trees.drawn
    for j in range(q.size):
        q[j] = limb.low[j] + uniform(trees) * (limb.high[j] - limb.low[j])
    least = turning_time(study.scene.limits.joint_speed, limb.start, q)
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
    rate, best, found = study.scene.limits.joint_speed, 1e300, -1
    for k in range(trees.size[tree]):
        spare = t - trees.time[tree, k] if tree == FROM_START else trees.time[tree, k] - t
        if spare <= 0.0:
            continue
        took = turning_time(rate, trees.joints[tree, k], q)
        if worse < took < best and took <= spare:
            best, found = took, k
    return found, best


@njit(_nrt=False)
def _join(study, trees, tree, k, q, t):
    """Free move between node k of a tree and joints q (n,) at t [s]: its begin and end, or -1."""
    there, when = trees.joints[tree, k], trees.time[tree, k]
    if tree == FROM_START:
        return reach(study, there, when, t, q, t)
    return reach(study, q, t, when, there, when)


@njit(_nrt=False)
def _grown(study, trees, tree, q, t):
    """Grow a tree by a move to or from q (n,) at t [s]; the new node, -1 if no move is free.

    If the whole move is blocked, half of it and then a quarter are tried.
    """
    k, _ = _nearest(study, trees, tree, q, t, -1.0)
    if k < 0:
        return -1
    there, when = trees.joints[tree, k], trees.time[tree, k]
    for _ in range(3):
        begin, end = _join(study, trees, tree, k, q, t)
        if begin >= 0.0:
            time = end if tree == FROM_START else begin
            return _add(trees, tree, q, time, begin, end, k, trees.body[k])
        for j in range(q.size):
            q[j] = 0.5 * (q[j] + there[j])
        t = 0.5 * (t + when)
    return -1


@njit(_nrt=False)
def _connected(study, trees, tree, k, ends):
    """Node of the other tree to which node k has a free move, whose ends (2,) [s] are written."""
    other, worse = 1 - tree, -1.0
    q, t = trees.joints[tree, k], trees.time[tree, k]
    for _ in range(TRIES):
        m, took = _nearest(study, trees, other, q, t, worse)
        if m < 0:
            return -1
        ends[0], ends[1] = _join(study, trees, other, m, q, t)
        if ends[0] >= 0.0:
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
    ends = np.zeros(2)
    for _ in range(rounds):
        root = draw_goal(study, trees, horizon)
        if root >= 0:
            m = _connected(study, trees, FROM_CATCH, root, ends)
            if m >= 0:
                return _trace(trees, m, root, ends, way)
        elif trees.size[FROM_CATCH] == 0:
            continue
        for tree in range(2):
            t = _draw_state(study, trees, horizon)
            k = _grown(study, trees, tree, trees.drawn, t)
            if k < 0:
                continue
            m = _connected(study, trees, tree, k, ends)
            if m >= 0:
                first, second = (k, m) if tree == FROM_START else (m, k)
                return _trace(trees, first, second, ends, way)
        if max(trees.size[0], trees.size[1]) + 2 > trees.time.shape[1]:
            return False
    return False


@njit
def _trace(trees, first, second, ends, way):
    """Write the way through node `first` of the one tree and `second` of the other."""
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
    for i in range(length):
        k = order[i]
        left = trees.begin[FROM_START, order[i + 1]] if i + 1 < length else ends[0]
        reached = trees.end[FROM_START, k] if i > 0 else 0.0
        write(way, i, trees.joints[FROM_START, k], reached, left)
    k, reached, i = second, ends[1], length
    while k >= 0:
        root = trees.via[FROM_CATCH, k] < 0
        left = trees.time[FROM_CATCH, k] if root else trees.begin[FROM_CATCH, k]
        write(way, i, trees.joints[FROM_CATCH, k], reached, left)
        reached, i, k = trees.end[FROM_CATCH, k], i + 1, trees.via[FROM_CATCH, k]
    return True
