"""A situation as kernels read it: bodies, limb and limits in one tuple of arrays and numbers."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from gcm_learn.scene.bodies import Bodies


class Limits(NamedTuple):
    """Limits of a movement, as the situation gives them."""

    speed: float  # of the hand [forearms/s]
    shoulder: float  # of the joints [rad/s], infinite where there is no limit
    elbow: float
    grasp: float  # signed distance of hand and target at which it is caught [forearms]
    horizon: float  # last moment at which a catch counts [s]


class JointLimits(NamedTuple):
    """Limits of a movement in the joints; infinite where the situation gives none."""

    joint_speed: np.ndarray  # (n,) [rad/s; lengths/s of prismatic joints]
    joint_acceleration: np.ndarray  # (n,) [the same per second]
    speed: float  # of the hand [lengths/s]
    grasp: float  # signed distance of hand and target at which it is caught [lengths]
    horizon: float  # last moment at which a catch counts [s]


class AimedLimits(NamedTuple):
    """Limits of a movement in the joints where targets may have an approach.

    It has the fields of `JointLimits`.  Kernels that mind approaches are compiled for this type.
    """

    joint_speed: np.ndarray  # (n,) [rad/s; lengths/s of prismatic joints]
    joint_acceleration: np.ndarray  # (n,) [the same per second]
    speed: float  # of the hand [lengths/s]
    grasp: float  # signed distance of hand and target at which it is caught [lengths]
    horizon: float  # last moment at which a catch counts [s]


class Scene(NamedTuple):
    """A situation, packed once and handed from kernel to kernel.

    A planar arm has a `PlanarLimb` with `Limits`, other arms a limb of their kind with
    `JointLimits`.
    """

    bodies: Bodies
    limb: Any  # of the kind of the arm
    limits: Any  # Limits or JointLimits
