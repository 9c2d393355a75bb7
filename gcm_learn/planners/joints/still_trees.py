"""Trees in joints alone, for a world at rest: RRT-Connect (Kuffner and LaValle 2000).

One tree grows from the start, the other from postures that catch.  The tree that did not grow last
then steps towards the new node, up to an obstacle.  Times come when both have met.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.collision.postures import free_at, move_is_free
from gcm_learn.compiled import njit
from gcm_learn.planners.joints.meeting_trees import trace
from gcm_learn.planners.joints.moves import time_of
from gcm_learn.planners.joints.pull import box
from gcm_learn.planners.joints.ramps import GIVEN
from gcm_learn.planners.joints.tree_goals import draw_goal
from gcm_learn.planners.joints.tree_moves import FROM_CATCH, FROM_START
from gcm_learn.planners.joints.trees import add_node, uniform

RANGE = 1.0 / 6.0  # longest step of a tree, in shares of the ways that joints have
GOALS = 0.1  # share of rounds in which a goal is drawn, while there is one
BALANCE = 0.9  # share of the other rounds in which the smaller tree grows
ROUND, GOAL = 6, 20  # prices of a round and of drawing a goal, in distances along moves
SCANNED = 512  # nodes that are looked at for the price of one
PASSES = 6  # of drawing a way straight
SMOOTH = 0.1  # weight of the ways of all joints beside the time of a move


@njit(_nrt=False)
def _nearest(study, trees, tree, q):
    """Node of a tree that is nearest to joints q (n,), and how many steps away."""
    low, high, best, found = study.low, study.high, 1e300, -1
    for k in range(trees.size[tree]):
        there, away = trees.joints[tree, k], 0.0
        for j in range(q.size):
            share = (q[j] - there[j]) / max(high[j] - low[j], 1e-12)
            away += share * share
            if away >= best:
                break
        if away < best:
            best, found = away, k
    return found, max(int(np.ceil(np.sqrt(best) / RANGE)), 1)


@njit(_nrt=False)
def _step(study, trees, tree, k, goal, share):
    """Write joints at a share of the way from node k to a goal (n,); whether the move is free."""
    q, there, touch, desk = trees.drawn, trees.joints[tree, k], study.touch, study.desk
    for j in range(q.size):
        q[j] = there[j] + share * (goal[j] - there[j]) if share < 1.0 else goal[j]
    if not free_at(study.scene, q, 0.0, touch, desk):
        return False
    return move_is_free(study.scene, there, 0.0, q, 0.0, touch, desk)


@njit(_nrt=False)
def _add(trees, tree, k):
    """Add the drawn joints after node k: the new node, -1 if the tree is full."""
    body = trees.body[k] if tree == FROM_CATCH else 0
    return add_node(trees, tree, trees.drawn, trees.drawn_rates, 0.0, GIVEN, k, body)


@njit(_nrt=False)
def _met(study, trees, tree, node):
    """Step a tree towards `node` of the other tree; return the tree's node beside it, or -1."""
    goal = trees.joints[1 - tree, node]
    k, steps = _nearest(study, trees, tree, goal)
    while k >= 0 and _step(study, trees, tree, k, goal, 1.0 / steps):
        if steps == 1:
            return k
        k, steps = _add(trees, tree, k), steps - 1
    return -1


@njit(_nrt=False)
def draw_tree(trees):
    """Draw the tree that grows next, mostly the smaller tree."""
    smaller = FROM_START if trees.size[0] <= trees.size[1] else FROM_CATCH
    return smaller if uniform(trees) < BALANCE else 1 - smaller


@njit(_nrt=False)
def _grown(study, trees, tree):
    """Grow a tree by a step to a drawn posture: the new node, -1 if that is blocked."""
    q = study.goal
    for j in range(q.size):
        q[j] = study.low[j] + uniform(trees) * (study.high[j] - study.low[j])
    k, steps = _nearest(study, trees, tree, q)
    return _add(trees, tree, k) if _step(study, trees, tree, k, q, 1.0 / steps) else -1


@njit
def search_still(study, trees, rounds, horizon, way):
    """Grow both trees until they meet; see `search_trees`.

    The way may end later than the catch, since it has not been shortened.
    """
    while rounds > 0 and study.desk.budget[0] >= 0:
        none = trees.size[FROM_CATCH] == 0
        study.desk.budget[0] -= ROUND + (trees.size[0] + trees.size[1]) // SCANNED
        tree, node = FROM_CATCH, -1
        if none or uniform(trees) < GOALS:
            study.desk.budget[0] -= GOAL
            node = draw_goal(study, trees, horizon)
            if node < 0 and none:
                rounds -= 1
                continue
        box(study, study.scene.limb.start, horizon)
        if node < 0:
            tree = draw_tree(trees)
            node = _grown(study, trees, tree)
        rounds -= 1
        m = _met(study, trees, 1 - tree, node) if node >= 0 else -1
        if m >= 0:
            first, second = (node, m) if tree == FROM_START else (m, node)
            return trace(trees, first, second, way)
        if max(trees.size[0], trees.size[1]) + 2 > trees.time.shape[1]:
            return False
    return False


@njit(_nrt=False)
def timed(study, way):
    """Write the times of a way's moves without waits; return the way's end [s]."""
    t = 0.0
    for k in range(way.size[0]):
        if k > 0:
            t += time_of(study, way.joints[k - 1], way.joints[k])[0]
        way.reached[k] = way.left[k] = t
    return t


@njit(_nrt=False)
def _cost(study, q, p, r):
    """Time of moves from joints q over p to r (n,), and a little for the ways of all joints."""
    rate, first, second = study.scene.limits.joint_speed, 0.0, 0.0
    for j in range(q.size):
        first += ((p[j] - q[j]) / rate[j]) ** 2
        second += ((r[j] - p[j]) / rate[j]) ** 2
    time = time_of(study, q, p)[0] + time_of(study, p, r)[0]
    return time + SMOOTH * (np.sqrt(first) + np.sqrt(second))


@njit(_nrt=False)
def straighten(study, way):
    """Pull inner postures to lines between their neighbours, in all joints or joint by joint."""
    q, scene, touch, desk = study.goal, study.scene, study.touch, study.desk
    for turn in range(PASSES * (way.size[0] - 2)):
        k = 1 + turn % (way.size[0] - 2)
        before, there, after = way.joints[k - 1], way.joints[k], way.joints[k + 1]
        cost = _cost(study, before, there, after)
        for which in range(-1, q.size):
            share = time_of(study, before, there)[0]
            share /= max(share + time_of(study, there, after)[0], 1e-300)
            for j in range(q.size):
                line = before[j] + share * (after[j] - before[j])
                q[j] = 0.5 * (there[j] + line) if which < 0 or which == j else there[j]
            new = _cost(study, before, q, after)
            if new < cost and move_is_free(scene, before, 0.0, q, 0.0, touch, desk):
                if move_is_free(scene, q, 0.0, after, 0.0, touch, desk):
                    cost = new
                    for j in range(q.size):
                        there[j] = q[j]
    timed(study, way)
