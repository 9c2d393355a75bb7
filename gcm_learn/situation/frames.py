"""Rotations and frames as matrices, and motion laws seen in other frames."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from gcm_learn.arms import SpatialArm, quaternion_of, rotation_of
from gcm_learn.situation.motion import Pendulum, SolidMotion, SolidQuadratic
from gcm_learn.situation.situation import AnySituation, Plane

_IDENTITY = np.eye(3)
_ITS_MIRROR = np.diag([1.0, -1.0, 1.0])  # a body reflected in its own xz-plane


def plane_frame(plane: Plane | None) -> tuple[np.ndarray, np.ndarray]:
    """Rotation world -> arm plane (rows x, y, normal) and the plane's origin."""
    if plane is None:
        return _IDENTITY, np.zeros(3)
    (a, b, c), (d, e, f) = plane.x, plane.y
    normal = (b * f - c * e, c * d - a * f, a * e - b * d)
    return np.array([plane.x, plane.y, normal]), np.asarray(plane.origin)


def arm_frame(situation: AnySituation) -> tuple[np.ndarray, np.ndarray]:
    """Rotation world -> the arm's coordinates, and their origin in the world: the shoulder.

    Returns
    -------
    rotation : (3, 3) ndarray
        Its rows are the arm's axes: x, y and normal of the arm plane, or x, y, z of the base.
    origin : (3,) ndarray
    """
    if isinstance(situation.arm, SpatialArm):
        base = situation.arm.base
        return rotation_of(base.rotation).T, np.asarray(base.origin)
    return plane_frame(situation.plane)


def carried(motion: SolidMotion, turn: np.ndarray, origin: np.ndarray) -> SolidMotion:
    """A motion law seen in other coordinates: what was at p is at ``turn @ (p - origin)``.

    Parameters
    ----------
    motion : SolidMotion
    turn : (3, 3) ndarray
        Orthogonal.  Where it is a reflection, the body is one that its own xz-plane mirrors, as
        all our solids are: it comes out reflected in that plane as well, so it is turned only.
    origin : (3,) ndarray
    """
    reflected = bool(np.linalg.det(turn) < 0.0)

    def move(v: ArrayLike) -> tuple[float, float, float]:
        x, y, z = (turn @ np.asarray(v, dtype=float)).tolist()
        return (x, y, z)

    def place(v: ArrayLike) -> tuple[float, float, float]:
        return move(np.asarray(v, dtype=float) - origin)

    def axial(v: ArrayLike) -> tuple[float, float, float]:
        """Axes of rotation, which reflections turn round as well."""
        return move(-np.asarray(v, dtype=float) if reflected else v)

    if isinstance(motion, Pendulum):
        axis, down = axial(motion.axis), move(motion.down)
        return replace(motion, pivot=place(motion.pivot), axis=axis, down=down)
    rotation = turn @ rotation_of(motion.orientation)
    return SolidQuadratic(
        place(motion.position),
        move(motion.velocity),
        move(motion.acceleration),
        quaternion_of(rotation @ _ITS_MIRROR if reflected else rotation),
        axial(motion.spin),
    )
