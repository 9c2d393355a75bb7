"""Situations of a world for arms that move in their joints, and buffers for kernels."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from gcm_learn.arms.limbs import dof, reach_of
from gcm_learn.collision.postures import Desk, desk_of
from gcm_learn.compiled import njit
from gcm_learn.execution.arena.kernels.joints.chains import blank, buffers, limb_in
from gcm_learn.execution.arena.kernels.world import GONE, MOST, ROW_COLUMNS, bodies_in, rules_in
from gcm_learn.motion.rules import Rules
from gcm_learn.scene import JointLimits, Scene
from gcm_learn.scene.bodies import HAND, PART, Bodies

HORIZON = -1  # column of a world's limits, the fields of `JointLimits` one after the other


class ArmView(NamedTuple):
    """A situation, with buffers for one arm."""

    scene: Scene
    rules: Rules
    reach: float  # of the arm [lengths]
    pace: float  # fastest that its hand can be [lengths/s]
    desk: Desk
    joints: np.ndarray  # (2, dof): the present ones, and a buffer for others
    rates: np.ndarray  # (4, dof): buffer for rates
    jacobian: np.ndarray  # (3, dof)
    gaps: np.ndarray  # (n,): distances of bodies
    rows: np.ndarray  # (n, ROW_COLUMNS): buffer for bodies of which some were caught
    own: Any  # buffers that the type of limb needs, see `limbs.buffers`


@njit(forceinline=True)
def _limits_in(world, s, n):
    """Limits of situation s, for n joints."""
    row = world.limits[s]
    return JointLimits(row[0:n], row[n : 2 * n], row[2 * n], row[2 * n + 1], row[2 * n + 2])


@njit
def views_for(world, state, first, last):
    """Return a view of the situation of arm `first`, with buffers for arms first to last - 1."""
    most = 1
    for e in range(first, last):
        s = state.place[e]
        most = max(most, world.first[s + 1] - world.first[s])
    s = state.place[first]
    limb = limb_in(blank(world), world, s)
    scene = Scene(bodies_in(world, s), limb, _limits_in(world, s, dof(limb)))
    old = desk_of(scene)
    desk = Desk(
        np.zeros((most, 12)), old.curve, old.joints, old.spans, old.waiting, old.obstacles,
        old.budget,
    )  # fmt: skip
    n = dof(limb)
    joints, rates, jacobian = np.zeros((2, n)), np.zeros((4, n)), np.zeros((3, n))
    gaps, rows, own = np.empty(most), np.zeros((most, ROW_COLUMNS)), buffers(limb)
    rules = rules_in(world, s)
    return ArmView(scene, rules, 1.0, 1.0, desk, joints, rates, jacobian, gaps, rows, own)


@njit
def _left_in(world, state, e, rows):
    """Return the bodies of arm e's situation, with caught targets marked as gone.

    One target always stays: if all were caught, the last one.
    """
    bodies = bodies_in(world, state.place[e])
    if world.wanted[state.place[e], MOST] == 1:
        return bodies
    n, last, left = bodies.rows.shape[0], -1, 0
    rows[:n] = bodies.rows
    for b in range(n):
        if rows[b, PART] == HAND:
            if state.caught[e, b] < 0.0:
                left += 1
            elif last < 0 or state.caught[e, b] > state.caught[e, last]:
                last = b
    for b in range(n):
        if rows[b, PART] == HAND and state.caught[e, b] >= 0.0 and (left > 0 or b != last):
            rows[b, PART] = GONE
    return Bodies(rows[:n], bodies.vertices, bodies.angles, bodies.angle_step)


@njit
def view_in(world, state, e, room):
    """Return a view of arm e's situation without caught targets, in the buffers of view `room`."""
    s = state.place[e]
    old, limb = room.desk, limb_in(room.scene.limb, world, s)
    scene = Scene(_left_in(world, state, e, room.rows), limb, _limits_in(world, s, dof(limb)))
    which = world.obstacles[world.begin[s] : world.begin[s + 1]]
    desk = Desk(old.poses, old.curve, old.joints, old.spans, old.waiting, which, old.budget)
    return ArmView(
        scene, rules_in(world, s), reach_of(limb), world.pace[s], desk, room.joints, room.rates,
        room.jacobian, room.gaps, room.rows, room.own,
    )  # fmt: skip
