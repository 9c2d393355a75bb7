"""Trees in joints and time that grow in steps, as in RRT-Connect, towards states that are in time.

Among obstacles that move a catch has its instant, and most ways of trees without time come too late
for it.  Therefore states are drawn that the start reaches, and from which a posture that catches is
reached.  ST-RRT* (Grothe et al. 2022) draws so, too.  A node that is late is never near to them.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.arms.limbs import link_count
from gcm_learn.collision.postures import free_at
from gcm_learn.compiled import njit
from gcm_learn.planners.joints.meeting_trees import join, trace
from gcm_learn.planners.joints.moves import time_of, timed_move_is_free, turning_time
from gcm_learn.planners.joints.ramps import GIVEN
from gcm_learn.planners.joints.still_trees import GOAL, GOALS, RANGE, ROUND, draw_tree
from gcm_learn.planners.joints.tree_goals import draw_goal
from gcm_learn.planners.joints.tree_moves import FROM_CATCH, FROM_START
from gcm_learn.planners.joints.trees import add_node, uniform

HASTY = 0.4  # share of steps that are as fast as they may be
ROOM = 64  # nodes that a round adds at most
SCANNED = 64  # nodes that are looked at for the price of one distance to a limb of few links
MORE = 4  # of them for each link, since a distance is dearer then


@njit(_nrt=False)
def _draw_in_time(study, trees):
    """Draw joints into ``study.goal`` that are in time for a root, and when: a time [s]."""
    limb, rate, q = study.scene.limb, study.scene.limits.joint_speed, study.goal
    k = int(uniform(trees) * trees.size[FROM_CATCH])
    while trees.via[FROM_CATCH, k] >= 0:
        k = trees.via[FROM_CATCH, k]
    end = trees.time[FROM_CATCH, k]
    t = uniform(trees) * end
    for j in range(q.size):
        first, last = limb.start[j], trees.joints[FROM_CATCH, k, j]
        low = max(limb.low[j], first - rate[j] * t, last - rate[j] * (end - t))
        high = min(limb.high[j], first + rate[j] * t, last + rate[j] * (end - t))
        q[j] = low + uniform(trees) * (high - low)
    return t


@njit(_nrt=False)
def _nearest(study, trees, tree, q, t):
    """Node of a tree next to joints q (n,) that is in time for t [s], and how many steps away."""
    limb, rate, best, found = study.scene.limb, study.scene.limits.joint_speed, 1e300, -1
    scale = trees.drawn
    for j in range(q.size):
        scale[j] = 1.0 / max(limb.high[j] - limb.low[j], 1e-12)
    for k in range(trees.size[tree]):
        spare = t - trees.time[tree, k] if tree == FROM_START else trees.time[tree, k] - t
        if spare <= 0.0:
            continue
        there, away = trees.joints[tree, k], 0.0
        for j in range(q.size):
            share = (q[j] - there[j]) * scale[j]
            away += share * share
        if away < best and turning_time(rate, there, q) <= spare:
            best, found = away, k
    return found, max(int(np.ceil(np.sqrt(best) / RANGE)), 1)


@njit(_nrt=False)
def _step(study, trees, tree, k, t, share, hasty):
    """Step from node k a share of the way to the joints of ``study.goal`` at t [s].

    Returns the new node, -1 if the step is blocked or comes too late.
    """
    q, there, when = trees.drawn, trees.joints[tree, k], trees.time[tree, k]
    for j in range(q.size):
        q[j] = there[j] + share * (study.goal[j] - there[j])
    least, pieces = time_of(study, q, there) if tree else time_of(study, there, q)
    span = least if hasty else max(share * abs(t - when), least)
    if span > abs(t - when):
        return -1
    new = when - span if tree else when + span
    if not free_at(study.scene, q, new, study.touch, study.desk):
        return -1
    if tree == FROM_START:
        free = timed_move_is_free(study, there, when, q, new, pieces)
    else:
        free = timed_move_is_free(study, q, new, there, when, pieces)
    trees.ends[0], trees.ends[1] = min(when, new), max(when, new)
    body = trees.body[k] if tree else 0
    return add_node(trees, tree, q, trees.drawn_rates, new, GIVEN, k, body) if free else -1


@njit(_nrt=False)
def _met(study, trees, tree, node):
    """Step a tree towards `node` of the other; return the tree's node with a move to it, or -1."""
    q, t = study.goal, trees.time[1 - tree, node]
    for j in range(q.size):
        q[j] = trees.joints[1 - tree, node, j]
    k, steps = _nearest(study, trees, tree, q, t)
    hasty = uniform(trees) < HASTY
    while k >= 0 and steps > 1:
        k, steps = _step(study, trees, tree, k, t, 1.0 / steps, hasty), steps - 1
    if k >= 0 and join(study, trees, tree, k, q, trees.drawn_rates, t, GIVEN):
        return k
    return -1


@njit
def search_timely(study, trees, rounds, horizon, way):
    """Grow both trees by steps until they meet; see `search_trees`."""
    looks = SCANNED + MORE * link_count(study.scene.limb)
    while rounds > 0 and study.desk.budget[0] >= 0:
        rounds -= 1
        none = trees.size[FROM_CATCH] == 0
        study.desk.budget[0] -= ROUND + (trees.size[0] + trees.size[1]) // looks
        tree, node = FROM_CATCH, -1
        if none or uniform(trees) < GOALS:
            study.desk.budget[0] -= GOAL
            node = draw_goal(study, trees, horizon)
            if node < 0 and none:
                continue
        if node < 0:
            tree = draw_tree(trees)
            t = _draw_in_time(study, trees)
            node, steps = _nearest(study, trees, tree, study.goal, t)
            if node >= 0:
                hasty = uniform(trees) < HASTY
                node = _step(study, trees, tree, node, t, 1.0 / steps, hasty)
        m = _met(study, trees, 1 - tree, node) if node >= 0 else -1
        if m >= 0:
            first, second = (node, m) if tree == FROM_START else (m, node)
            return trace(trees, first, second, way)
        if max(trees.size[0], trees.size[1]) + ROOM > trees.time.shape[1]:
            return False
    return False
