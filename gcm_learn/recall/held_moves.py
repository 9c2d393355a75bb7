"""Kernels of remembered held catches: trees grow by remembered postures, not by random ones.

The posture in which a memory caught is pulled to the target, at its time and at times nearby. A
whole end is made of it: run-up, hold, stop (`planners.joints.endings`). Then the knots of its
approach join the tree of the start, until the trees meet.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.arms.limbs import dof
from gcm_learn.compiled import njit
from gcm_learn.planners.joints.end_goals import end_at
from gcm_learn.planners.joints.endings import Endings
from gcm_learn.planners.joints.meeting_trees import connected, grown_to, join, trace
from gcm_learn.planners.joints.moves import Study, turning_time
from gcm_learn.planners.joints.tree_moves import FROM_CATCH, FROM_START, box_by, rates_by
from gcm_learn.planners.joints.trees import Trees, add_node, uniform
from gcm_learn.recall.joint_moves import EARLIEST, KNOTS, TIME
from gcm_learn.recall.trials import learn, most_promising
from gcm_learn.scene.bodies import HAND, PART

STRETCHES = np.array([1.0, 1.08, 0.92, 1.2, 0.8])  # of a memory's times, in the order of trial


class HeldQuery(NamedTuple):
    """Situation in the form that adaptations of held catches take."""

    study: Study
    ends: Endings
    trees: Trees
    turns: np.ndarray  # (dof,): signs that make joints of a left arm those of this one
    shift: np.ndarray  # (dof,): added to them, see `recall.headings`


@njit(_nrt=False)
def caught_at(knots, m):
    """Return the knot of memory m at which the target is caught."""
    c = KNOTS - 1
    while c > 0 and knots[m, c, EARLIEST] < 0.0:
        c -= 1
    return c


@njit(_nrt=False)
def _draw(query, knots, m, k, share):
    """Set the drawn posture to knot k, moved by a share of the offset between the starts."""
    limb, q, turns, shift = query.study.scene.limb, query.trees.drawn, query.turns, query.shift
    for j in range(dof(limb)):
        first = turns[j] * np.float64(knots[m, 0, j]) + shift[j]
        at = turns[j] * np.float64(knots[m, k, j]) + shift[j] + share * (limb.start[j] - first)
        q[j] = min(max(at, limb.low[j]), limb.high[j])


@njit(_nrt=False)
def _rooted(query, knots, m, c, until):
    """Add an end of memory m at `until` [s] for each target, until the start's tree reaches one.

    Returns
    -------
    node : int
        The node of the start's tree that reaches the end, -1 if none does.
    root : int
        The last end that was added, -1 without one.
    """
    study, ends, trees, last = query.study, query.ends, query.trees, -1
    for b in range(study.scene.bodies.rows.shape[0]):
        if study.scene.bodies.rows[b, PART] != HAND:
            continue
        _draw(query, knots, m, c, 0.0)
        box_by(trees.moves, study, until)
        root = end_at(ends, study, trees, b, until)
        if root >= 0:
            last, node = root, connected(study, trees, FROM_CATCH, root)
            if node >= 0:
                return node, root
    return -1, last


@njit
def _way_of(query, knots, m, stretch, way):
    """Grow the start's tree along the approach of memory m; return whether it meets an end."""
    study, trees, first, c = query.study, query.trees, knots[m, 0], caught_at(knots, m)
    length = max(_length(query, first, knots[m, c]), 1e-9)
    for k in range(1, c):
        share = max(1.0 - _length(query, first, knots[m, k]) / length, 0.0)
        _draw(query, knots, m, k, share)
        t = stretch * np.float64(knots[m, k, TIME])
        node = _straight_to(study, trees, t)
        if node < 0:
            node = grown_to(study, trees, t)
        if node >= 0:
            root = connected(study, trees, FROM_START, node)
            if root >= 0:
                return trace(trees, node, root, way)
    return False


@njit(_nrt=False)
def _straight_to(study, trees, t):
    """Go straight from the start to the drawn posture at t [s]; the new node, -1 if none is."""
    q, rates = trees.drawn, trees.drawn_rates
    free = rates_by(trees.moves, FROM_START, rates, uniform(trees))
    if t <= trees.time[FROM_START, 0] or not join(study, trees, FROM_START, 0, q, rates, t, free):
        return -1
    return add_node(trees, FROM_START, q, rates, trees.ends[1], free, 0, 0)


@njit(_nrt=False)
def _length(query, one, other):
    """Time of a straight move by the joints' speeds [s]."""
    return turning_time(query.study.scene.limits.joint_speed, one, other)


@njit
def _met(query, knots, m, way):
    """Add ends of memory m at its stretched times, until the start's tree reaches an end.

    Returns
    -------
    met : bool
        True if an end is reached; then the way is written.
    stretch : float
        The first of the times at which there is an end, 0 without one.
    """
    trees, horizon, found = query.trees, query.study.scene.limits.horizon, 0.0
    c, room = caught_at(knots, m), trees.time.shape[1]
    for stretch in STRETCHES:
        until = stretch * np.float64(knots[m, c, TIME])
        if until > horizon or max(trees.size[0], trees.size[1]) + 2 * KNOTS > room:
            continue
        node, root = _rooted(query, knots, m, c, until)
        if node >= 0:
            return trace(trees, node, root, way), stretch
        if root >= 0 and found == 0.0:
            found = stretch
    return False, found


@njit
def in_turn(query, paths, offer, budget, alone, times, way):
    """Try memories: the ends of all of them, then their approaches; the most promising first.

    Parameters
    ----------
    query : HeldQuery
    paths : ((n, KNOTS, dof + 2), (n, 6)) ndarrays of float32
        Knots and goals of all memories.
    offer : Offer
        The memories; scores and what is left of them are changed.
    budget : TrialLimits
    alone : bool
        Try each in trees of its own, and all of them; else they share trees, until these meet.
    times : (m,) ndarray
        When memories catch [s], negative for those that do not, by their places in the offer.
    way : JointWay
        Written if trees meet.

    Returns
    -------
    place : int
        Position of the last memory by which trees met in the offer, -1 if they never do.
    count : int
        Memories that were tried.
    """
    knots, trees, first, place, count = paths[0], query.trees, query.trees.size[FROM_START], -1, 0
    order, stretches = np.empty(budget.tries, np.int64), np.zeros(budget.tries)
    state = trees.state[0]
    while count < budget.tries and (alone or place < 0):
        i = most_promising(offer)
        if i < 0:
            break
        if alone:
            trees.size[FROM_START], trees.size[FROM_CATCH], query.ends.made[0] = first, 0, 0
            trees.state[0] = state
        offer.left[i], order[count] = False, i
        met, stretches[count] = _met(query, knots, offer.chosen[i], way)
        if alone and not met and stretches[count] > 0.0:
            met = _way_of(query, knots, offer.chosen[i], stretches[count], way)
        if met:
            place, times[i] = i, query.ends.span[way.body[0], 0]
        elif budget.penalty > 0.0:
            learn(offer, i, budget.penalty)
        count += 1
    for n in range(0 if alone or place >= 0 else count):
        i = order[n]
        if stretches[n] > 0.0 and _way_of(query, knots, offer.chosen[i], stretches[n], way):
            return i, count
    return place, count
