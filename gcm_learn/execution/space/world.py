"""Many situations in space packed side by side, and where arms are in them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from gcm_learn.arms import SpatialLimb
from gcm_learn.collision.postures import Desk, desk_of
from gcm_learn.compiled import njit
from gcm_learn.execution.world import side_by_side
from gcm_learn.motion import fastest_hand
from gcm_learn.motion.rules import Rules
from gcm_learn.scene import LIMB, PART, Scene
from gcm_learn.scene import JointLimits as JointLimits
from gcm_learn.scene.bodies import Bodies

_LIMB = 31  # columns of a world's limbs: the fields of `SpatialLimb`, one after the other
HORIZON = 10  # column of a world's limits, which are the fields of `JointLimits` likewise


class SpatialWorld(NamedTuple):
    """Many situations in the frames of their arms' bases, one after the other."""

    rows: np.ndarray  # these five as in `World`
    vertices: np.ndarray
    angles: np.ndarray
    angle_steps: np.ndarray
    first: np.ndarray
    obstacles: np.ndarray  # (o,) int64: which rows of their situation the limb must not touch
    begin: np.ndarray  # (s + 1,) int64: those of situation k are begin[k]:begin[k + 1]
    limbs: np.ndarray  # (s, 31)
    limits: np.ndarray  # (s, 11)
    rules: np.ndarray  # (s, 4): the fields of `Rules`
    pace: np.ndarray  # (s,): fastest that a hand can be [lengths/s]


class SpatialState(NamedTuple):
    """Where many arms are, each in a situation of the world."""

    place: np.ndarray  # (e,) int64: situation
    posture: np.ndarray  # (e, 8): joints [rad], then their rates [rad/s]
    hand: np.ndarray  # (e, 3), in the frame of the base [lengths]
    time: np.ndarray  # (e,) [s]


class SpatialOptions(NamedTuple):
    """Settings as kernels want them, see `settings`."""

    dt: float
    weights: np.ndarray  # (4,)
    discount: float
    slots: int
    fan: bool


class SpatialView(NamedTuple):
    """A situation in space and the room to work in; all else is told of one arm in it."""

    scene: Scene
    rules: Rules
    reach: float  # of the arm [lengths]
    pace: float  # fastest that its hand can be [lengths/s]
    desk: Desk
    joints: np.ndarray  # (2, 4): the present ones, and room for others
    rates: np.ndarray  # (4, 4): room for rates
    jacobian: np.ndarray  # (3, 4)
    gaps: np.ndarray  # (n,): distances of bodies


@njit
def views_for(world, state, first, last):
    """A view, of the situation of arm `first`, with room for arms first to last - 1."""
    most = 1
    for e in range(first, last):
        s = state.place[e]
        most = max(most, world.first[s + 1] - world.first[s])
    s = state.place[first]
    scene, rules = scene_in_space(world, s), rules_in_space(world, s)
    spare = desk_of(scene)
    desk = Desk(
        np.zeros((most, 12)), spare.curve, spare.joints, spare.spans, spare.waiting,
        spare.obstacles,
    )  # fmt: skip
    joints, rates, jacobian = np.zeros((2, 4)), np.zeros((4, 4)), np.zeros((3, 4))
    return SpatialView(scene, rules, 1.0, 1.0, desk, joints, rates, jacobian, np.empty(most))


@njit
def view_in(world, s, room):
    """Situation s, in the room of another view."""
    scene, old = scene_in_space(world, s), room.desk
    which = world.obstacles[world.begin[s] : world.begin[s + 1]]
    desk = Desk(old.poses, old.curve, old.joints, old.spans, old.waiting, which)
    reach = scene.limb.rho + scene.limb.length
    return SpatialView(
        scene, rules_in_space(world, s), reach, world.pace[s], desk, room.joints, room.rates,
        room.jacobian, room.gaps,
    )  # fmt: skip


@njit
def scene_in_space(world, s):
    """Situation s, as all kernels of situations want it."""
    rows = world.rows[world.first[s] : world.first[s + 1]]
    bodies = Bodies(rows, world.vertices, world.angles, world.angle_steps[s])
    a, b = world.limbs[s], world.limits[s]
    limb = SpatialLimb(
        a[0:3], a[3:6], a[6:10], a[10:14], a[14:17], a[17:20], a[20], a[21], a[22], a[23:27],
        a[27:31],
    )  # fmt: skip
    return Scene(bodies, limb, JointLimits(b[0:4], b[4:8], b[8], b[9], b[10]))


@njit(_nrt=False)
def rules_in_space(world, s):
    """What movements keep in situation s."""
    a = world.rules
    return Rules(a[s, 0], a[s, 1], a[s, 2], a[s, 3])


def spatial_world_of(scenes: Sequence[Scene], rules: Sequence[Rules]) -> SpatialWorld:
    """Pack scenes side by side.

    Parameters
    ----------
    scenes : sequence of Scene
        With spatial arms.
    rules : sequence of Rules
    """
    which = [np.flatnonzero(scene.bodies.rows[:, PART] == LIMB) for scene in scenes]
    limbs = np.array([np.hstack(scene.limb) for scene in scenes])
    assert limbs.shape[1] == _LIMB
    return SpatialWorld(
        **side_by_side([scene.bodies for scene in scenes]),
        obstacles=np.concatenate(which).astype(np.int64),
        begin=np.cumsum([0, *map(len, which)]),
        limbs=limbs,
        limits=np.array([np.hstack(scene.limits) for scene in scenes]),
        rules=np.array(rules, dtype=float),
        pace=np.array([fastest_hand(scene) for scene in scenes]),
    )
