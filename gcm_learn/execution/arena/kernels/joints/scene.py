"""Situations of a world for arms that move in their joints, and buffers for kernels."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from gcm_learn.arms.limbs import dof, reach_of
from gcm_learn.collision.postures import Desk, desk_of
from gcm_learn.compiled import njit
from gcm_learn.execution.arena.kernels.joints.limbs import blank, buffers, limb_in, limits_in
from gcm_learn.execution.arena.kernels.world import bodies_in, rules_in
from gcm_learn.motion.rules import Rules
from gcm_learn.scene import Scene

HORIZON = -1  # column of a world's limits, the fields of `JointLimits` one after the other


class View(NamedTuple):
    """A situation, and buffers for one arm in it."""

    scene: Scene
    rules: Rules
    reach: float  # of the arm [lengths]
    pace: float  # fastest that its hand can be [lengths/s]
    desk: Desk
    joints: np.ndarray  # (2, dof): the present ones, and a buffer for others
    rates: np.ndarray  # (4, dof): buffer for rates
    jacobian: np.ndarray  # (3, dof)
    gaps: np.ndarray  # (n,): distances of bodies
    own: Any  # buffers that the type of limb needs, see `limbs.buffers`


@njit
def views_for(world, state, first, last):
    """Return a view of the situation of arm `first`, with buffers for arms first to last - 1."""
    most = 1
    for e in range(first, last):
        s = state.place[e]
        most = max(most, world.first[s + 1] - world.first[s])
    s = state.place[first]
    limb = limb_in(blank(world), world, s)
    scene, rules = Scene(bodies_in(world, s), limb, limits_in(limb, world, s)), rules_in(world, s)
    old = desk_of(scene)
    desk = Desk(
        np.zeros((most, 12)), old.curve, old.joints, old.spans, old.waiting, old.obstacles,
        old.budget,
    )  # fmt: skip
    n = dof(limb)
    joints, rates, jacobian = np.zeros((2, n)), np.zeros((4, n)), np.zeros((3, n))
    gaps, own = np.empty(most), buffers(limb)
    return View(scene, rules, 1.0, 1.0, desk, joints, rates, jacobian, gaps, own)


@njit
def view_in(world, s, room):
    """Return situation s, with the buffers of another view."""
    old, limb = room.desk, limb_in(room.scene.limb, world, s)
    scene = Scene(bodies_in(world, s), limb, limits_in(limb, world, s))
    which = world.obstacles[world.begin[s] : world.begin[s + 1]]
    desk = Desk(old.poses, old.curve, old.joints, old.spans, old.waiting, which, old.budget)
    return View(
        scene, rules_in(world, s), reach_of(limb), world.pace[s], desk, room.joints, room.rates,
        room.jacobian, room.gaps, room.own,
    )  # fmt: skip
