"""Frames of arms and planes as matrices."""

from __future__ import annotations

import numpy as np

from gcm_learn.arms import PLANAR, ByKind, rotation_of
from gcm_learn.situation.situation import AnySituation, Plane

_IDENTITY = np.eye(3)


def plane_frame(plane: Plane | None) -> tuple[np.ndarray, np.ndarray]:
    """Return the rotation world -> arm plane (rows x, y, normal) and the plane's origin."""
    if plane is None:
        return _IDENTITY, np.zeros(3)
    (a, b, c), (d, e, f) = plane.x, plane.y
    normal = (b * f - c * e, c * d - a * f, a * e - b * d)
    return np.array([plane.x, plane.y, normal]), np.asarray(plane.origin)


def arm_frame(situation: AnySituation) -> tuple[np.ndarray, np.ndarray]:
    """Return the rotation world -> the arm's coordinates, and their origin in the world.

    Returns
    -------
    rotation : (3, 3) ndarray
        Its rows are the arm's axes: x, y and normal of the arm plane, or x, y, z of the base.
    origin : (3,) ndarray
    """
    return _FRAME.of(situation)(situation)


def _base_frame(situation: AnySituation) -> tuple[np.ndarray, np.ndarray]:
    """Return rotation and origin of an arm that stands on a base."""
    base = situation.arm.base  # type: ignore[union-attr]
    return rotation_of(base.rotation).T, np.asarray(base.origin)


def _arm_plane(situation: AnySituation) -> tuple[np.ndarray, np.ndarray]:
    return plane_frame(situation.plane)


_FRAME = ByKind({PLANAR: _arm_plane}, default=_base_frame)
