"""Rotations in space as matrices."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[Any]


def rotations(quaternion: ArrayLike) -> Array:
    """Return rotations (..., 3, 3) of quaternions (..., 4) w, x, y, z, which are normalised."""
    q = np.asarray(quaternion, dtype=float)
    w, x, y, z = np.moveaxis(q / np.linalg.norm(q, axis=-1, keepdims=True), -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def unit(vector: ArrayLike) -> Array:
    """Return a vector (3,) of length 1."""
    v = np.asarray(vector, dtype=float)
    v = v / np.abs(v).max()  # squares of tiny numbers are 0
    return v / np.linalg.norm(v)


def angle_of(first: Array, second: Array) -> float:
    """Return the angle between two vectors (3,) [rad]."""
    across = np.linalg.norm(np.cross(first, second))
    return float(np.arctan2(across, first @ second))


def crossing(axis: ArrayLike) -> Array:
    """Return the matrix (3, 3) of the cross product with an axis on the left."""
    x, y, z = np.asarray(axis, dtype=float)
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def turns(axis: ArrayLike, angle: ArrayLike) -> Array:
    """Return rotations (..., 3, 3) about an axis (3,) by angles (...) [rad]."""
    cross = crossing(unit(axis))
    a = np.asarray(angle, dtype=float)[..., None, None]
    return np.eye(3) + np.sin(a) * cross + (1.0 - np.cos(a)) * (cross @ cross)
