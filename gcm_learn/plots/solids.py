"""Faces of the solid shapes, for 3D views."""

from __future__ import annotations

import itertools

import numpy as np

from gcm_learn.situation import Box, Capsule, Cylinder, SolidShape, Sphere

SIDES = 24  # polygon that stands for a circle
RINGS = 14  # of a sphere, from pole to pole
TILE = 0.4  # [forearms] longest side of a tile of a box


def faces(shape: SolidShape) -> list[np.ndarray]:
    """Return the faces of a solid in its own frame.

    Parameters
    ----------
    shape : Sphere, Box, Capsule or Cylinder

    Returns
    -------
    list of (k, 3) ndarray
        Polygons, counter-clockwise when seen from outside.
    """
    if isinstance(shape, Box):
        return _box(np.asarray(shape.half_extents))
    if isinstance(shape, Sphere):
        return _turned(_arc(shape.radius, 0.0))
    if isinstance(shape, Capsule):
        return _turned(_arc(shape.radius, shape.half_length))
    if isinstance(shape, Cylinder):
        r, h = shape.radius, shape.half_length
        return _turned(np.array([(0.0, -h), (r, -h), *_side(r, h), (r, h), (0.0, h)]))
    raise TypeError(f"not a solid shape: {shape!r}")


def _side(radius: float, half_length: float) -> list[tuple[float, float]]:
    """Points along a long side, so that its faces stay small enough to be sorted by depth."""
    pieces = max(1, int(np.ceil(2 * half_length / max(radius, 0.3))))
    return [(radius, z) for z in np.linspace(-half_length, half_length, pieces + 1)[1:-1]]


def _arc(radius: float, half_length: float) -> np.ndarray:
    """Profile (k, 2) of a sphere or capsule: distance from the axis, height; from low to high."""
    angle = np.linspace(-np.pi / 2, np.pi / 2, RINGS + 1)
    points = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)
    lower, upper = points[: RINGS // 2 + 1], points[RINGS // 2 :]
    low, high = lower - (0.0, half_length), upper + (0.0, half_length)
    if half_length == 0.0:
        return np.concatenate([low, high[1:]])
    return np.concatenate([low, np.array(_side(radius, half_length)).reshape(-1, 2), high])


def _turned(profile: np.ndarray) -> list[np.ndarray]:
    """Turn a profile about the z axis."""
    angle = np.linspace(0.0, 2 * np.pi, SIDES + 1)
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    out = []
    for (r0, z0), (r1, z1) in itertools.pairwise(profile):
        for a, b in itertools.pairwise(ring):
            corners = [(*(r0 * a), z0), (*(r0 * b), z0), (*(r1 * b), z1), (*(r1 * a), z1)]
            out.append(np.array(corners))
    return out


def _box(half: np.ndarray) -> list[np.ndarray]:
    """Faces of a box, tiled so finely that they can be sorted by depth."""
    cuts = [np.linspace(-h, h, int(np.ceil(2 * h / TILE)) + 1) for h in half]
    out = []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for sign in (-1, 1):
            for u0, u1 in itertools.pairwise(cuts[u]):
                for v0, v1 in itertools.pairwise(cuts[v]):
                    corners = np.full((4, 3), sign * half[axis])
                    corners[:, u] = (u0, u1, u1, u0)
                    corners[:, v] = (v0, v0, v1, v1)
                    out.append(corners[::sign])
    return out
