"""Postures that catch a target at some time, drawn as roots of a tree."""

from __future__ import annotations

import numpy as np

from gcm_learn.arms.limbs import inverts, postures_at
from gcm_learn.collision.postures import free_at
from gcm_learn.compiled import njit
from gcm_learn.planners.joints.goals import PLACES, place_on
from gcm_learn.planners.joints.pull import pulled
from gcm_learn.planners.joints.ramps import END_FREE
from gcm_learn.planners.joints.tree_moves import FROM_CATCH, box_by
from gcm_learn.planners.joints.trees import add_node, uniform
from gcm_learn.scene.bodies import HAND, PART

NEAR_START = 0.5  # share of goals that are drawn near to what the start is pulled to
INVERSE = 0.5  # share of the other goals that begin with the hand at the target, by its inverse
SWIVELS = 4096  # from which those are drawn
NEAR_GOAL = 0.3  # share of goals that are drawn near to one that is there
NEARBY = 0.3  # how near: share of a joint's range, and of the horizon


@njit(_nrt=False)
def any_target(study, trees):
    """Draw one of the targets."""
    rows, targets = study.scene.bodies.rows, 0
    for b in range(rows.shape[0]):
        targets += rows[b, PART] == HAND
    left, b = int(uniform(trees) * targets), -1
    while left >= 0:
        b += 1
        left -= rows[b, PART] == HAND
    return b


@njit(_nrt=False)
def draw_near_start(study, trees, b, t):
    """Draw a posture for target b between the start and the joints within reach by t [s]."""
    q, start = trees.drawn, study.scene.limb.start
    box_by(trees.moves, study, t)
    near = 1.0 if uniform(trees) >= NEAR_START else uniform(trees)
    for j in range(q.size):
        share = study.low[j] + uniform(trees) * (study.high[j] - study.low[j])
        q[j] = start[j] + near * (share - start[j])
    if inverts(study.scene.limb) and uniform(trees) < INVERSE:
        _turn_to(study, trees, b, t)


@njit(_nrt=False)
def _turn_to(study, trees, b, t):
    """Turn the drawn posture so that the hand is at a place of body b at t [s], if joints can."""
    q, branches = trees.drawn, study.branches
    x, y, z, _ = place_on(study, b, t, int(uniform(trees) * PLACES))
    k, low, high = int(uniform(trees) * SWIVELS), study.low, study.high
    found = postures_at(study.scene.limb, x, y, z, k, SWIVELS, low, high, branches)
    if found > 0:
        row = int(uniform(trees) * found)
        for j in range(q.size):
            q[j] = min(max(branches[row, j], low[j]), high[j])


@njit(_nrt=False)
def draw_near(study, trees, joints, t, horizon):
    """Draw a posture near `joints` (n,), which catch at t [s]; return the new time [s]."""
    q, limb = trees.drawn, study.scene.limb
    wide = NEARBY * uniform(trees)
    t += wide * horizon * (2.0 * uniform(trees) - 1.0)
    t = min(max(t, 0.01 * horizon), horizon)
    box_by(trees.moves, study, t)
    for j in range(q.size):
        far = wide * (limb.high[j] - limb.low[j]) * (2.0 * uniform(trees) - 1.0)
        q[j] = min(max(joints[j] + far, study.low[j]), study.high[j])
    return t


@njit(_nrt=False)
def draw_goal(study, trees, horizon):
    """Draw a posture that catches a target at some time, and is free then, as a root.

    Returns
    -------
    int
        Number of the root, -1 if the draw failed.
    """
    if trees.size[FROM_CATCH] > 0 and uniform(trees) < NEAR_GOAL:
        k = int(uniform(trees) * trees.size[FROM_CATCH])
        while trees.via[FROM_CATCH, k] >= 0:
            k = trees.via[FROM_CATCH, k]
        t = draw_near(study, trees, trees.joints[FROM_CATCH, k], trees.time[FROM_CATCH, k], horizon)
        b = trees.body[k]
    else:
        b = any_target(study, trees)
        t = horizon * np.sqrt(1.0 - uniform(trees))
        draw_near_start(study, trees, b, t)
    return root_at(study, trees, b, t)


@njit(_nrt=False)
def root_at(study, trees, b, t):
    """Pull the drawn posture to body b at t [s]; add the posture as a root if it is free.

    Returns
    -------
    int
        Number of the root; -1 if the posture does not catch or is not free.
    """
    q = trees.drawn
    if not pulled(study, b, t, q) or not free_at(study.scene, q, t, study.touch, study.desk):
        return -1
    trees.ends[0] = trees.ends[1] = t
    return add_node(trees, FROM_CATCH, q, trees.drawn_rates, t, END_FREE, -1, b)
