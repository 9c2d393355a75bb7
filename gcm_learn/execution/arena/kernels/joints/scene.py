"""Situations of a world for arms that move in their joints, and buffers for kernels."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from gcm_learn.arms.limbs import dof, reach_of
from gcm_learn.collision.postures import Desk, desk_of
from gcm_learn.compiled import njit
from gcm_learn.execution.arena.kernels.joints.limbs import beside, blank, limb_in, limits_in, spare
from gcm_learn.execution.arena.kernels.world import bodies_in, rules_in
from gcm_learn.motion.rules import Rules
from gcm_learn.scene import Scene

HORIZON = -1  # column of a world's limits, the fields of `JointLimits` one after the other


class Brakes(NamedTuple):
    """Buffers for the steps in which an arm brakes."""

    posture: np.ndarray  # (1, 2 dof)
    rows: np.ndarray  # (4, dof)
    curve: np.ndarray  # (dof, 4)


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
    ahead: Any  # two limbs, which can be placed where the limb will be
    brakes: Brakes


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
    ahead, gaps = (spare(limb), spare(limb)), np.empty(most)
    brakes = Brakes(np.zeros((1, 2 * n)), np.zeros((4, n)), np.zeros((n, 4)))
    return View(scene, rules, 1.0, 1.0, desk, joints, rates, jacobian, gaps, ahead, brakes)


@njit
def view_in(world, s, room):
    """Return situation s, with the buffers of another view."""
    old, limb = room.desk, limb_in(room.scene.limb, world, s)
    scene = Scene(bodies_in(world, s), limb, limits_in(limb, world, s))
    which = world.obstacles[world.begin[s] : world.begin[s + 1]]
    desk = Desk(old.poses, old.curve, old.joints, old.spans, old.waiting, which, old.budget)
    ahead = (beside(limb, room.ahead[0]), beside(limb, room.ahead[1]))
    return View(
        scene, rules_in(world, s), reach_of(limb), world.pace[s], desk, room.joints, room.rates,
        room.jacobian, room.gaps, ahead, room.brakes,
    )  # fmt: skip
