"""What a movement keeps so that its verification surely succeeds: limits less a hair."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.collision.sweep import least_distance
from gcm_learn.scene.bodies import HAND, PART, TOP_SPEED
from gcm_learn.scene.scene import Scene

SAFETY = 1e-4  # clearance that a plan keeps beyond "does not touch" [forearm lengths]
CATCH_SAFETY = 1e-6  # how much nearer than `grasp` the hand must come [forearm lengths]
SPEED_SAFETY = 2e-9  # share of the speed limit that is not used, against rounding
_INSTANT = 5e-4  # resolution of interceptions: the way of hand and target in it [forearm lengths]
_MOST_INSTANTS = 20_000  # in a horizon, against absurdly long ones


class Rules(NamedTuple):
    """What planners keep of a scene's limits."""

    touch: float  # distance at which an obstacle counts as touching the limb
    catch: float  # signed distance to a target at which the hand surely catches
    speed: float  # of the hand
    instant: float  # resolution in time of interceptions [s]


def rules_of(scene: Scene, at_start: float | None = None) -> Rules:
    """The rules of a scene.

    Parameters
    ----------
    scene : Scene
    at_start : float, optional
        `start_clearance`, if the caller has it at hand [forearm lengths].
    """
    at_start = start_clearance(scene) if at_start is None else at_start
    targets = scene.bodies.rows[scene.bodies.rows[:, PART] == HAND, TOP_SPEED]
    fastest = scene.limits.speed + targets.max()
    return Rules(
        touch=scene.limb.thickness + safety_of(at_start),
        catch=scene.limits.grasp - CATCH_SAFETY,
        speed=scene.limits.speed * (1.0 - SPEED_SAFETY),
        instant=float(max(_INSTANT / fastest, scene.limits.horizon / _MOST_INSTANTS)),
    )


def start_clearance(scene: Scene) -> float:
    """Distance of the limb at t = 0 to the obstacles, less the thickness [forearm lengths]."""
    hand = np.array([[scene.limb.x, scene.limb.y]])
    distance, _ = least_distance(scene, np.zeros(1), hand, -1.0, 1.0)
    return float(distance) - scene.limb.thickness


def safety_of(at_start: float) -> float:
    """Clearance that a path must keep [forearm lengths], given that at t = 0.

    Half of it where the limb begins nearer to an obstacle than SAFETY asks for.
    """
    return min(SAFETY, 0.5 * at_start)
