"""A situation as kernels read it: bodies, limb and limits in one tuple of arrays and numbers."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from gcm_learn.scene.bodies import Bodies


class Limb(NamedTuple):
    """A planar arm of two bones with its shoulder at the origin, and where its hand starts.

    Lengths in forearms.
    """

    rho: float  # length of the upper arm
    side: float  # of the elbow: `SIDE` of `scene.limb`
    near: float  # radii of the ring that the hand can reach
    far: float
    thickness: float  # radius of both bones
    x: float  # hand at t = 0
    y: float


class Limits(NamedTuple):
    """What a movement may do, as the situation says it."""

    speed: float  # of the hand [forearms/s]
    shoulder: float  # of the joints [rad/s], infinite where there is no limit
    elbow: float
    grasp: float  # signed distance of hand and target at which it is caught [forearms]
    horizon: float  # last moment at which a catch counts [s]


class SpatialLimits(NamedTuple):
    """What a movement of a spatial arm may do; infinite where the situation says nothing."""

    joint_speed: np.ndarray  # (4,) [rad/s]
    joint_acceleration: np.ndarray  # (4,) [rad/s^2]
    speed: float  # of the hand [lengths/s]
    grasp: float  # signed distance of hand and target at which it is caught [lengths]
    horizon: float  # last moment at which a catch counts [s]


class Scene(NamedTuple):
    """A situation, packed once and handed from kernel to kernel.

    Kernels of the plane take a `Limb` with `Limits`, those of space the other two.
    """

    bodies: Bodies
    limb: Any  # Limb or SpatialLimb
    limits: Any  # Limits or SpatialLimits
