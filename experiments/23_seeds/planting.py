"""Seeds of the trees: postures that catch, their instants, and postures on the way there.

A seed is a row of postures with times; the last one is near a posture that catches.  Its instant is
moved to when the target is nearest to the hand there.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.arms.limbs import hand_of, place
from gcm_learn.collision.postures import free_at
from gcm_learn.compiled import njit
from gcm_learn.motion.joint_interception import target_room
from gcm_learn.planners.joints.meeting_trees import connected, grown_to, join, trace
from gcm_learn.planners.joints.ramps import START_FREE
from gcm_learn.planners.joints.tree_goals import root_at
from gcm_learn.planners.joints.tree_moves import FROM_CATCH, FROM_START, box_by
from gcm_learn.planners.joints.trees import add_node
from gcm_learn.recall.headings import nearest_target

INSTANTS = 24  # of the horizon at which the target is compared with the hand
NOTHING = 1e-9  # least time of a catch [s]


class Seeds(NamedTuple):
    """Seeds in the joints of the arm, the most promising first."""

    joints: np.ndarray  # (k, m, n) [rad]
    time: np.ndarray  # (k, m) [s]


@njit(_nrt=False)
def _aligned(study, q, b, horizon):
    """Return when body b is nearest to the hand at joints q (n,) [s]."""
    x, y, z = hand_of(study.scene.limb, place(study.scene.limb, q))
    best, when = 1e300, horizon
    for k in range(1, INSTANTS + 1):
        t = horizon * k / INSTANTS
        room = target_room(study.scene, b, x, y, z, t, study.desk.poses)
        if room < best:
            best, when = room, t
    return when


@njit(_nrt=False)
def _root(study, trees, q, b, t):
    """Add a root near q (n,) that catches body b at t [s]; -1 if nothing is free there."""
    box_by(trees.moves, study, t)
    for j in range(q.size):
        trees.drawn[j] = min(max(q[j], study.low[j]), study.high[j])
    return root_at(study, trees, b, t)


@njit(_nrt=False)
def _backward(study, trees, k, t):
    """Grow the second tree from the drawn posture at t [s] to its node k; -1 if none is free."""
    if not 0.0 < t < trees.time[FROM_CATCH, k]:
        return -1
    rates = trees.drawn_rates
    if not free_at(study.scene, trees.drawn, t, study.touch, study.desk):
        return -1
    if not join(study, trees, FROM_CATCH, k, trees.drawn, rates, t, START_FREE):
        return -1
    body = trees.body[k]
    return add_node(trees, FROM_CATCH, trees.drawn, rates, trees.ends[0], START_FREE, k, body)


@njit(_nrt=False)
def _draw_gate(trees, joints, time, there, at, g):
    """Draw posture g of a seed, moved with its last one to joints there (n,); its time [s]."""
    last = time.size - 1
    share = (g + 1) / (last + 1)
    for j in range(there.size):
        trees.drawn[j] = joints[g, j] + share * (there[j] - joints[last, j])
    return at * time[g] / max(time[last], NOTHING)


@njit
def _planted(study, trees, joints, time, gates, horizon, way):
    """Add one seed to trees; returns whether they meet."""
    b, last = nearest_target(study.scene, study.desk.poses), time.size - 1
    q, root = joints[last], -1
    at = min(_aligned(study, q, b, horizon), horizon)
    root = _root(study, trees, q, b, at)
    if root < 0:
        at = min(time[last], horizon)
        root = _root(study, trees, q, b, at)
    if root < 0:
        return False
    m = connected(study, trees, FROM_CATCH, root)
    if m >= 0:
        return trace(trees, m, root, way)
    there = trees.joints[FROM_CATCH, root]
    for g in range(last if gates else 0):
        t = _draw_gate(trees, joints, time, there, at, g)
        k = grown_to(study, trees, t) if t > 0.0 else -1
        m = connected(study, trees, FROM_START, k) if k >= 0 else -1
        if m >= 0:
            return trace(trees, k, m, way)
    k, g = root, last if gates else 0
    while g > 0 and k >= 0:
        g -= 1
        t = _draw_gate(trees, joints, time, there, at, g)
        k = _backward(study, trees, k, t)
        m = connected(study, trees, FROM_CATCH, k) if k >= 0 else -1
        if m >= 0:
            return trace(trees, m, k, way)
    return False


@njit
def plant(study, trees, seeds, gates, horizon, way):
    """Add seeds to trees, until they meet.

    Parameters
    ----------
    seeds : Seeds
    gates : bool
        True if postures on the way are added, too.
    horizon : float
        Catches after this do not count [s].
    way : Way
        Written if they meet.

    Returns
    -------
    bool
    """
    for s in range(seeds.time.shape[0]):
        if _planted(study, trees, seeds.joints[s], seeds.time[s], gates, horizon, way):
            return True
    return False


@njit
def meet_alone(study, trees, seeds, gates, horizon, way):
    """Return which seeds (k,) let trees of the start meet, each without the others; see `plant`."""
    out = np.zeros(seeds.time.shape[0], np.bool_)
    for s in range(out.size):
        trees.size[FROM_START], trees.size[FROM_CATCH] = 1, 0
        out[s] = _planted(study, trees, seeds.joints[s], seeds.time[s], gates, horizon, way)
    return out
