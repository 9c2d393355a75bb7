"""Limits for planned movements, tighter by a hair than the limits of verification."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from gcm_learn.arms import PLANAR, ByKind
from gcm_learn.collision.postures import desk_of, gap_at
from gcm_learn.collision.sweep import limb_distance
from gcm_learn.compiled import njit
from gcm_learn.motion.interception import may_be_reached
from gcm_learn.motion.joint_interception import fastest_hand, may_be_met
from gcm_learn.scene import Scene
from gcm_learn.scene.bodies import HAND, PART, TOP_SPEED

SAFETY = 1e-4  # clearance that a plan keeps beyond "does not touch" [forearm lengths]
CATCH_SAFETY = 1e-6  # how much nearer than `grasp` the hand must come [forearm lengths]
SPEED_SAFETY = 2e-9  # share of the speed limit that is not used, against rounding
JOINT_SPEED_SAFETY = 1e-4  # the same where speeds are judged along curves in the joints
_INSTANT = 5e-4  # resolution of interceptions: how far hand and target get in it [forearm lengths]
_MOST_INSTANTS = 20_000  # in a horizon, against absurdly long ones


class Rules(NamedTuple):
    """Limits that planners keep in a scene."""

    touch: float  # distance at which an obstacle counts as touching the limb
    catch: float  # signed distance to a target at which the hand surely catches
    speed: float  # of the hand
    instant: float  # resolution in time of interceptions [s]


def rules_of(scene: Scene) -> Rules:
    """The rules of a scene."""
    return opening(scene).rules


def start_clearance(scene: Scene) -> float:
    """Distance of the limb at t = 0 to the obstacles, less the thickness [forearm lengths]."""
    return opening(scene).clearance


class Opening(NamedTuple):
    """Facts about a scene before planning."""

    clearance: float
    """Distance of the limb at t = 0 to the obstacles, less the thickness [forearm lengths]."""
    hopeful: bool
    """True if a target may come within reach before the horizon; False is certain."""
    rules: Rules


def opening(scene: Scene) -> Opening:
    """Return the facts of a scene before planning: start clearance, hope of a catch, rules.

    Safeties count in forearms, or in the unit of the limb.
    """
    begin, limits = _BEGIN.of(scene), scene.limits
    unit = begin.unit(scene)
    distance, hand, fastest, hopeful = begin.look(scene)
    free = distance - scene.limb.thickness
    rules = Rules(
        touch=scene.limb.thickness + safety_of(free, unit),
        catch=limits.grasp - CATCH_SAFETY * unit,
        speed=limits.speed * (1.0 - begin.speed_safety),
        instant=max(_INSTANT * unit / (hand + fastest), limits.horizon / _MOST_INSTANTS),
    )
    return Opening(free, hopeful, rules)


@njit
def _at_start(scene):
    """Return distance of limb and obstacles, hand and target speeds, if a target may be reached."""
    bodies, limb, distance = scene.bodies, scene.limb, 1e300
    poses = np.zeros((bodies.rows.shape[0], 12))
    for b in range(bodies.rows.shape[0]):
        if bodies.rows[b, PART] != HAND:
            distance = min(distance, limb_distance(scene, b, 0.0, limb.x, limb.y, poses))
    return distance, scene.limits.speed, _fastest_target(scene.bodies.rows), may_be_reached(scene)


@njit
def _at_start_in_joints(scene):
    """Return the results of `_at_start` for a limb that moves in its joints."""
    desk = desk_of(scene)
    distance, hopeful = (gap_at(scene, scene.limb.start, 0.0, desk), may_be_met(scene, desk.poses))
    return distance, fastest_hand(scene), _fastest_target(scene.bodies.rows), hopeful


@njit(_nrt=False)
def _fastest_target(rows):
    fastest = 0.0
    for b in range(rows.shape[0]):
        if rows[b, PART] == HAND:
            fastest = max(fastest, rows[b, TOP_SPEED])
    return fastest


class _Begin(NamedTuple):
    """Functions of a kind of arm that `opening` calls."""

    unit: Callable[[Scene], float]  # length in which safeties count
    look: Callable[[Scene], tuple[float, float, float, bool]]
    speed_safety: float


_BEGIN = ByKind(
    {PLANAR: _Begin(lambda scene: 1.0, _at_start, SPEED_SAFETY)},
    default=_Begin(lambda scene: scene.limb.length, _at_start_in_joints, JOINT_SPEED_SAFETY),
)


def safety_of(at_start: float, unit: float = 1.0) -> float:
    """Clearance that a path must keep, given that at t = 0, in a unit of `unit` lengths.

    Half of it where the limb begins nearer to an obstacle than SAFETY asks for.
    """
    return min(SAFETY * unit, 0.5 * at_start)
