"""Spatial situations of a world, and buffers for kernels."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.arms import SpatialLimb
from gcm_learn.arms.limbs import dof
from gcm_learn.collision.postures import Desk, desk_of
from gcm_learn.compiled import njit
from gcm_learn.execution.arena.kernels.world import bodies_in, rules_in
from gcm_learn.motion.rules import Rules
from gcm_learn.scene import JointLimits as JointLimits
from gcm_learn.scene import Scene

# Columns of a world's limbs, the fields of `SpatialLimb` one after the other, and of its limits.
START = slice(23, 31)  # joints and rates at t = 0
HORIZON = 10


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


@njit
def views_for(world, state, first, last):
    """Return a view of the situation of arm `first`, with buffers for arms first to last - 1."""
    most = 1
    for e in range(first, last):
        s = state.place[e]
        most = max(most, world.first[s + 1] - world.first[s])
    s = state.place[first]
    scene, rules = scene_of(world, s), rules_in(world, s)
    spare = desk_of(scene)
    desk = Desk(
        np.zeros((most, 12)), spare.curve, spare.joints, spare.spans, spare.waiting,
        spare.obstacles, spare.budget,
    )  # fmt: skip
    n = dof(scene.limb)
    joints, rates, jacobian = np.zeros((2, n)), np.zeros((4, n)), np.zeros((3, n))
    return View(scene, rules, 1.0, 1.0, desk, joints, rates, jacobian, np.empty(most))


@njit
def view_in(world, s, room):
    """Return situation s, with the buffers of another view."""
    scene, old = scene_of(world, s), room.desk
    which = world.obstacles[world.begin[s] : world.begin[s + 1]]
    desk = Desk(old.poses, old.curve, old.joints, old.spans, old.waiting, which, old.budget)
    reach = scene.limb.rho + scene.limb.length
    return View(
        scene, rules_in(world, s), reach, world.pace[s], desk, room.joints, room.rates,
        room.jacobian, room.gaps,
    )  # fmt: skip


@njit
def scene_of(world, s):
    """Return situation s in the form of all kernels."""
    a, b = world.limbs[s], world.limits[s]
    limb = SpatialLimb(
        a[0:3], a[3:6], a[6:10], a[10:14], a[14:17], a[17:20], a[20], a[21], a[22], a[23:27],
        a[27:31],
    )  # fmt: skip
    limits = JointLimits(b[0:4], b[4:8], b[8], b[9], b[10])
    return Scene(bodies_in(world, s), limb, limits)
