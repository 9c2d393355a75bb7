"""Rotations as matrices and as unit quaternions (w, x, y, z); poses of bases."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gcm_learn.checks import UNIT_TOLERANCE, put, unit_vector, vector

ROUNDING = 1e-15
"""A quaternion this near to length 1 stays as it is, so that normalising twice changes nothing."""


def rotation_of(quaternion: Sequence[float]) -> np.ndarray:
    """Rotation matrix (3, 3) of a unit quaternion (w, x, y, z)."""
    length = math.hypot(*quaternion)
    return _matrix(*(part / length for part in quaternion))


def rotations_of(quaternions: np.ndarray) -> np.ndarray:
    """Rotation matrices (n, 3, 3) of unit quaternions (n, 4)."""
    lengths = np.linalg.norm(quaternions, axis=1, keepdims=True)
    return np.moveaxis(_matrix(*(quaternions / lengths).T), -1, 0)


def _matrix(w: Any, x: Any, y: Any, z: Any) -> np.ndarray:
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def turned_by(turns: np.ndarray) -> np.ndarray:
    """Rotations (n, 3, 3) by vectors (n, 3) [rad]: Rodrigues' formula."""
    angle = np.linalg.norm(turns, axis=1)
    x, y, z = (turns / np.where(angle > 0.0, angle, 1.0)[:, None]).T
    zero = np.zeros_like(x)
    cross = np.moveaxis(np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]]), -1, 0)
    sine, rest = np.sin(angle)[:, None, None], (1.0 - np.cos(angle))[:, None, None]
    return np.eye(3) + sine * cross + rest * (cross @ cross)


def quaternion_of(rotation: np.ndarray) -> tuple[float, float, float, float]:
    """Unit quaternion (w, x, y, z) of a rotation matrix (3, 3), the inverse of `rotation_of`.

    The largest of the four numbers is positive; it is taken from the diagonal and the others by
    division (S. W. Shepperd, J. Guidance and Control 1, 1978), so none is a difference of nearly
    equal numbers.
    """
    r = rotation.tolist()
    trace = r[0][0] + r[1][1] + r[2][2]
    squares = (trace, r[0][0], r[1][1], r[2][2])
    k = max(range(4), key=squares.__getitem__)
    if k == 0:
        q = [1.0 + trace, r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]]
    else:
        a, b, c = k - 1, k % 3, (k + 1) % 3
        q = [r[c][b] - r[b][c], 0.0, 0.0, 0.0]
        q[1 + a] = 1.0 + r[a][a] - r[b][b] - r[c][c]
        q[1 + b] = r[b][a] + r[a][b]
        q[1 + c] = r[c][a] + r[a][c]
    length = math.sqrt(math.fsum(x * x for x in q))
    w, x, y, z = (value / length for value in q)
    return (w, x, y, z)


def unit_quaternion(
    value: object, field: str, tolerance: float = UNIT_TOLERANCE
) -> tuple[float, float, float, float]:
    """Return a quaternion of length 1 up to a tolerance, normalised.

    Raises
    ------
    SituationError
        If it is no list of four numbers, or its length is off.
    """
    rotation = unit_vector(value, field, 4, tolerance=tolerance)
    length = math.hypot(*rotation)
    if abs(length - 1.0) > ROUNDING:
        rotation = tuple(part / length for part in rotation)
    w, x, y, z = rotation
    return (w, x, y, z)


def frame_along(axis: np.ndarray) -> np.ndarray:
    """Return a rotation (3, 3) with the unit vector `axis` (3,) as its third column."""
    if axis[0] == axis[1] == 0.0 < axis[2]:
        return np.eye(3)
    first = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(axis, first), axis], axis=1)


@dataclass(frozen=True)
class Base:
    """Pose of an arm's base in the world.

    Parameters
    ----------
    origin : (3,) tuple of float
        Position of the base, which is the shoulder of a spatial arm.
    rotation : (4,) tuple of float
        Unit quaternion (w, x, y, z), base to world; normalised.
    """

    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rotation: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        """Check the documented shapes and normalise the rotation."""
        put(self, "origin", vector(self.origin, "origin", 3))
        put(self, "rotation", unit_quaternion(self.rotation, "rotation"))


IDENTITY = Base()
