"""Rotations and frames as matrices."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from gcm_learn.situation.situation import Plane

_IDENTITY = np.eye(3)


def rotation_of(quaternion: Sequence[float]) -> np.ndarray:
    """Rotation matrix (3, 3) of a unit quaternion (w, x, y, z)."""
    length = math.hypot(*quaternion)
    w, x, y, z = (part / length for part in quaternion)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def plane_frame(plane: Plane | None) -> tuple[np.ndarray, np.ndarray]:
    """Rotation world -> arm plane (rows x, y, normal) and the plane's origin."""
    if plane is None:
        return _IDENTITY, np.zeros(3)
    (a, b, c), (d, e, f) = plane.x, plane.y
    normal = (b * f - c * e, c * d - a * f, a * e - b * d)
    return np.array([plane.x, plane.y, normal]), np.asarray(plane.origin)
