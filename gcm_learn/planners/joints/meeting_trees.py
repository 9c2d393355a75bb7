"""Two trees in joints and time: from the start, and from postures that catch.

A node is a posture with the time at which the limb is there.  The first tree grows forwards by free
moves, the second backwards; a free move from one to the other is a way to a catch.  The idea is
that of RRT-Connect (Kuffner and LaValle 2000) with time, as in ST-RRT* (Grothe et al. 2022).

Under limits of acceleration nodes have rates, too: half of them rest, half move on.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.collision.postures import free_at
from gcm_learn.compiled import njit
from gcm_learn.planners.joints.end_goals import bias_by, draw_by, end_at
from gcm_learn.planners.joints.endings import BRAKES, FIRST, braking
from gcm_learn.planners.joints.moves import turning_time
from gcm_learn.planners.joints.ramps import END_FREE, GIVEN, START_FREE
from gcm_learn.planners.joints.tree_moves import (
    FROM_CATCH,
    FROM_START,
    box_by,
    halve_by,
    keep_by,
    may_by,
    move_by,
    rates_by,
    soon_by,
    time_by,
)
from gcm_learn.planners.joints.trees import add_node, uniform
from gcm_learn.planners.joints.ways import MOST, write, write_rates

TRIES = 3  # nearest nodes of the other tree to which a new node is connected
SOONER, ABOUT = 0.4, 0.1  # how much earlier, and how far away, earlier ends are tried [share]
NEARER = 3  # moves to a drawn state that are tried, each half as long as the one before
NEARER_GOAL = 4  # likewise from one to a posture that catches, which is often in a narrow place
HASTY = 0.25  # share of moves that are as fast as they may be
ROUND = 20  # price of a round, in distances along moves
SCANNED = 64  # nodes that are looked at for the price of one
RARE = 3  # draws that may fail in place of one, while there is no goal


@njit(_nrt=False, forceinline=True)
def ends_free(trees, tree, k):
    """Return whether node k is a catch by a touch, where a movement may end with any rates."""
    return tree == FROM_CATCH and trees.via[tree, k] < 0 and trees.free[tree, k] == END_FREE


@njit(_nrt=False)
def _draw_state(study, trees, horizon, bias):
    """Draw a posture that the start can reach into ``trees.drawn``; return a time for it [s].

    A share `bias` of the draws are nodes of the other tree.
    """
    limb, q = study.scene.limb, trees.drawn
    if bias > 0.0 and trees.size[FROM_CATCH] > 0 and uniform(trees) < bias:
        k = int(uniform(trees) * trees.size[FROM_CATCH])
        for j in range(q.size):
            q[j] = trees.joints[FROM_CATCH, k, j]
        return trees.time[FROM_CATCH, k]
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
    """Find the tree's node with the quickest move to or from q (n,) at t [s]; also its time.

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
            if ends_free(trees, tree, k) or may_by(
                trees.moves, limits, there, trees.rates[tree, k], q, spare, tree
            ):
                best, found = took, k
    return found, best


@njit(_nrt=False)
def join(study, trees, tree, k, q, rates, t, free):
    """Find a free move between node k of a tree and joints q with some rates (n,) at t [s].

    Returns whether there is one. Its begin and end are in ``trees.ends``, and what rates were free
    are written.
    """
    there, when, turning = trees.joints[tree, k], trees.time[tree, k], trees.rates[tree, k]
    if tree == FROM_START:
        begin, end = move_by(trees.moves, study, there, turning, when, q, rates, t, free)
    else:
        if ends_free(trees, tree, k):
            free += END_FREE
        begin, end = move_by(trees.moves, study, q, rates, t, there, turning, when, free)
    trees.ends[0], trees.ends[1] = begin, end
    if begin < 0.0:
        return False
    keep_by(trees.moves, tree, free, rates)
    return True


@njit(_nrt=False)
def grown_to(study, trees, t):
    """Grow the first tree to the drawn posture at t [s]; the new node, -1 if no move is free.

    If the whole move is blocked, half of it is tried, and so on.
    """
    tree, q, rates = FROM_START, trees.drawn, trees.drawn_rates
    free = rates_by(trees.moves, tree, rates, uniform(trees))
    k, _ = _nearest(study, trees, tree, q, t, -1.0)
    if k < 0:
        return -1
    there, when = trees.joints[tree, k], trees.time[tree, k]
    if uniform(trees) < HASTY:
        t = min(t, when + soon_by(trees.moves, study, there, q))
    for _ in range(NEARER):
        if free_at(study.scene, q, t, study.touch, study.desk):
            if join(study, trees, tree, k, q, rates, t, free):
                return add_node(trees, tree, q, rates, trees.ends[1], free, k, 0)
        halve_by(trees.moves, q, there, trees.rates[tree, k], t - when)
        t = 0.5 * (t + when)
    return -1


@njit(_nrt=False)
def _grown_backward(study, trees, bias):
    """Grow the second tree by a move from a drawn posture; the new node, -1 if none is free.

    The move ends at the nearest node, and begins at a time by which the start can be there.
    """
    limits, limb = study.scene.limits, study.scene.limb
    tree, q, rates = FROM_CATCH, trees.drawn, trees.drawn_rates
    m = -1
    if bias > 0.0 and uniform(trees) < bias:
        m = int(uniform(trees) * trees.size[FROM_START])
    for j in range(q.size):
        if m < 0:
            q[j] = limb.low[j] + uniform(trees) * (limb.high[j] - limb.low[j])
        else:
            q[j] = trees.joints[FROM_START, m, j]
    free = rates_by(trees.moves, tree, rates, uniform(trees))
    k, best = -1, 1e300
    for m in range(trees.size[tree]):
        took = turning_time(limits.joint_speed, q, trees.joints[tree, m])
        if took < best:
            k, best = m, took
    there, when, turning = trees.joints[tree, k], trees.time[tree, k], trees.rates[tree, k]
    if ends_free(trees, tree, k):
        free += END_FREE
        for j in range(q.size):
            turning[j] = 0.0
    share = max(uniform(trees) - HASTY, 0.0) / (1.0 - HASTY)
    for _ in range(NEARER_GOAL):
        took = time_by(trees.moves, limits, q, there)
        spare = when - took - time_by(trees.moves, limits, limb.start, q)
        took += share * max(spare, 0.0)
        if spare > 0.0 and free_at(study.scene, q, when - took, study.touch, study.desk):
            if join(study, trees, tree, k, q, rates, when - took, free & START_FREE):
                time = trees.ends[0]
                return add_node(trees, tree, q, rates, time, free, k, trees.body[k])
        halve_by(trees.moves, q, there, turning, -took)
    return -1


@njit(_nrt=False)
def connected(study, trees, tree, k):
    """Find a node of the other tree to which node k has a free move; return its number, or -1.

    The ends of that move are in ``trees.ends``.
    """
    other, worse = 1 - tree, -1.0
    q, t, rates = trees.joints[tree, k], trees.time[tree, k], trees.rates[tree, k]
    free = END_FREE if ends_free(trees, tree, k) else GIVEN
    for _ in range(TRIES):
        m, took = _nearest(study, trees, other, q, t, worse)
        if m < 0:
            return -1
        if join(study, trees, other, m, q, rates, t, free):
            return m
        worse = took
    return -1


@njit
def search_trees(ends, study, trees, rounds, horizon, way):
    """Grow both trees until they meet.

    Parameters
    ----------
    ends : Endings or Lines
        Room for ends of movements, where a touch will not do.
    rounds : int
        Goals that are drawn; each is followed by growing both trees.  While there is none, `RARE`
        times as many draws may fail.
    horizon : float
        Catches after this do not count [s].
    way : Way
        Written if they meet.

    Returns
    -------
    bool
    """
    bias = bias_by(ends)
    vain = RARE * rounds if trees.size[FROM_CATCH] == 0 else 0
    while rounds > 0 and study.desk.budget[0] >= 0:
        study.desk.budget[0] -= ROUND + (trees.size[0] + trees.size[1]) // SCANNED
        root = draw_by(ends, study, trees, horizon)
        if root < 0 and trees.size[FROM_CATCH] == 0 and vain > 0:
            vain -= 1
            continue
        rounds -= 1
        if root >= 0:
            m = connected(study, trees, FROM_CATCH, root)
            if m >= 0:
                return trace(trees, m, root, way)
        elif trees.size[FROM_CATCH] == 0:
            return False
        for tree in range(2):
            if tree == FROM_START:
                k = grown_to(study, trees, _draw_state(study, trees, horizon, bias))
            else:
                k = _grown_backward(study, trees, bias)
            if k < 0:
                continue
            m = connected(study, trees, tree, k)
            if m >= 0:
                first, second = (k, m) if tree == FROM_START else (m, k)
                return trace(trees, first, second, way)
        if max(trees.size[0], trees.size[1]) + 2 > trees.time.shape[1]:
            return False
    return False


@njit
def plant_stop(study, trees):
    """Add the posture in which a limb that moves at first can come to rest to the first tree."""
    q, rates, limits = trees.drawn, trees.drawn_rates, study.scene.limits
    v, since = trees.rates[FROM_START, 0], trees.time[FROM_START, 0]
    for stretch in BRAKES:
        span = braking(limits, v, stretch)
        for j in range(q.size):
            q[j], rates[j] = trees.joints[FROM_START, 0, j] + 0.5 * span * v[j], 0.0
        if span > 0.0 and join(study, trees, FROM_START, 0, q, rates, since + span, GIVEN):
            add_node(trees, FROM_START, q, rates, trees.ends[1], GIVEN, 0, 0)
            return


@njit
def hastened(ends, study, trees, tries, way):
    """Try earlier ends near that of a way; the way becomes the earliest that the trees reach.

    Parameters
    ----------
    tries : int
        Ends that are drawn.
    way : Way
    """
    q, limb = trees.drawn, study.scene.limb
    for _ in range(tries):
        e = way.body[0]
        t, earliest = ends.span[e, 0], trees.time[FROM_START, 0]
        t -= (t - earliest) * SOONER * uniform(trees) ** 2
        box_by(trees.moves, study, t)
        for j in range(q.size):
            off = ABOUT * (limb.high[j] - limb.low[j]) * (2.0 * uniform(trees) - 1.0)
            q[j] = min(max(ends.joints[e, FIRST, j] + off, study.low[j]), study.high[j])
        root = end_at(ends, study, trees, ends.body[e], t)
        if root >= 0:
            m = connected(study, trees, FROM_CATCH, root)
            if m >= 0:
                trace(trees, m, root, way)


@njit
def trace(trees, first, second, way):
    """Write the way through node `first` of the first tree and node `second` of the second.

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
    root = ends_free(trees, FROM_CATCH, second)
    for i in range(length):
        k, last = order[i], i + 1 == length
        left = trees.ends[0] if last else trees.begin[FROM_START, order[i + 1]]
        reached = trees.end[FROM_START, k] if i > 0 else trees.time[FROM_START, k]
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
