"""Solids of families in space: made in forearms about the shoulder, put into the world at the end.

Axes are x ahead, y to the arm's own side and z up, as of a base that is not turned.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from gcm_learn.arms import quaternion_of, rotation_of
from gcm_learn.situation import (
    Body,
    Box,
    Capsule,
    Cylinder,
    Pendulum,
    SolidMotion,
    SolidQuadratic,
    SolidShape,
    Sphere,
    carried,
)

UP = np.array([0.0, 0.0, 1.0])
STILL = np.zeros(3)
_LENGTHS = ("radius", "half_length", "half_extents")
_FLOWN = ("position", "velocity", "acceleration")
_SWUNG = ("pivot", "length", "gravity", "hang")


def solid(
    name: str,
    shape: SolidShape,
    place: ArrayLike,
    axes: np.ndarray | None = None,
    *,
    when: float = 0.0,
    velocity: ArrayLike = STILL,
    pull: ArrayLike = STILL,
    spin: ArrayLike = STILL,
) -> Body:
    """Return a solid in free motion; a solid with the name "target" is the target.

    Parameters
    ----------
    name : str
    shape : SolidShape
    place : (3,) array_like
        Of its centre at `when` [forearms].
    axes : (3, 3) ndarray, optional
        Its columns are the body's axes at t = 0; by default those of the base.
    when : float
        [s]
    velocity, pull : (3,) array_like
        At t = 0, and the constant acceleration [forearms/s, forearms/s^2].
    spin : (3,) array_like
        [rad/s]
    """
    v, a = np.asarray(velocity, dtype=float), np.asarray(pull, dtype=float)
    first = np.asarray(place, dtype=float) - v * when - 0.5 * a * when**2
    turn = quaternion_of(np.eye(3) if axes is None else axes)
    role = "target" if name == "target" else "obstacle"
    motion = SolidQuadratic(triple(first), triple(v), triple(a), turn, triple(spin))
    return Body(role, name, shape, motion)


def moved(body: Body, when: float, velocity: ArrayLike, pull: ArrayLike = STILL) -> Body:
    """Return a resting body set in motion, so that it is at its place at time `when`."""
    motion = flight(body)
    axes = rotation_of(motion.orientation)
    shape = body.shape
    assert isinstance(shape, Sphere | Box | Capsule | Cylinder)
    return solid(body.name, shape, motion.position, axes, when=when, velocity=velocity, pull=pull)


def flight(body: Body) -> SolidQuadratic:
    """The free motion of a body that does not swing."""
    assert isinstance(body.motion, SolidQuadratic)
    return body.motion


def unit_vector(v: ArrayLike) -> np.ndarray:
    """Return a vector (3,) scaled to length 1; the x axis for a zero vector."""
    given = np.asarray(v, dtype=float)
    length = float(np.linalg.norm(given))
    return given / length if length > 1e-12 else np.array([1.0, 0.0, 0.0])


def axes_along(z: ArrayLike, x: ArrayLike = UP) -> np.ndarray:
    """Axes (3, 3), as columns: z as given, x as near as can be to a direction."""
    third = unit_vector(z)
    first = np.asarray(x, dtype=float) - third * (third @ np.asarray(x, dtype=float))
    if np.linalg.norm(first) < 1e-6:
        first = np.cross(third, np.eye(3)[int(np.argmin(np.abs(third)))])
    first = unit_vector(first)
    return np.column_stack([first, crossed(third, first), third])


def crossed(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The vector product of two vectors (3,); `np.cross` takes ten times as long for two."""
    (x, y, z), (u, v, w) = a.tolist(), b.tolist()
    return np.array([y * w - z * v, z * u - x * w, x * v - y * u])


def gap(points: np.ndarray, body: Body, t: float) -> np.ndarray:
    """Return signed distances of points (..., 3) to a solid without spin; inf if it swings."""
    motion, shape = body.motion, body.shape
    if not isinstance(motion, SolidQuadratic):
        return np.full(points.shape[:-1], math.inf)
    p, v, a = (np.array(getattr(motion, name)) for name in _FLOWN)
    own = (points - (p + v * t + 0.5 * a * t * t)) @ rotation_of(motion.orientation)
    x, y, z = own[..., 0], own[..., 1], own[..., 2]  # three of them are not worth a reduction
    if isinstance(shape, Sphere):
        return _length(x, y, z) - shape.radius
    if isinstance(shape, Capsule):
        return _length(x, y, z - np.clip(z, -shape.half_length, shape.half_length)) - shape.radius
    if isinstance(shape, Cylinder):
        beside, over = np.hypot(x, y) - shape.radius, np.abs(z) - shape.half_length
        outside = _length(np.maximum(beside, 0.0), np.maximum(over, 0.0))
        return outside + np.minimum(np.maximum(beside, over), 0.0)
    assert isinstance(shape, Box)
    out = [np.abs(c) - half for c, half in zip((x, y, z), shape.half_extents, strict=True)]
    outside = _length(*(np.maximum(side, 0.0) for side in out))
    return outside + np.minimum(np.maximum(np.maximum(*out[:2]), out[2]), 0.0)


def _length(x: np.ndarray, y: np.ndarray, z: np.ndarray | float = 0.0) -> np.ndarray:
    """Length of vectors by their coordinates."""
    return np.sqrt(x * x + y * y + z * z)


def placed(body: Body, unit: float, turn: np.ndarray, origin: np.ndarray) -> Body:
    """A body of another unit, turned (3, 3) and moved to an origin (3,)."""
    assert isinstance(body.motion, SolidQuadratic | Pendulum)
    names = _SWUNG if isinstance(body.motion, Pendulum) else _FLOWN
    motion: SolidMotion = carried(_scaled(body.motion, names, unit), turn, -turn.T @ origin)
    return dataclasses.replace(body, shape=_scaled(body.shape, _LENGTHS, unit), motion=motion)


def _scaled(record: Any, names: tuple[str, ...], unit: float) -> Any:
    """Return a record with the fields in `names` multiplied by `unit`."""
    changes = {}
    for name in names:
        value = getattr(record, name, None)
        if value is not None:
            changes[name] = (
                tuple(unit * v for v in value) if isinstance(value, tuple) else unit * value
            )
    return dataclasses.replace(record, **changes)


def triple(v: ArrayLike) -> tuple[float, float, float]:
    """Return a vector (3,) as a tuple of floats, as records hold it."""
    x, y, z = np.asarray(v, dtype=float).tolist()
    return x, y, z
