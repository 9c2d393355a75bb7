"""Outlines of bodies in the arm plane."""

from __future__ import annotations

import math

import numpy as np

from gcm_learn.scene.bodies import COLUMNS, KIND, SIZE, no_bodies
from gcm_learn.scene.packing import pose
from gcm_learn.scene.shapes.choice import cut, entry_of
from gcm_learn.scene.shapes.region import new_cut
from gcm_learn.situation import PLANAR, SOLID, PlanarShape, Situation, SolidShape

CIRCLE = np.linspace(0.0, 2 * np.pi, 65)[:-1]


def outline(situation: Situation, index: int, t: float) -> np.ndarray | None:
    """Return the outline of a body, or of its cut with the arm plane.

    Parameters
    ----------
    situation : Situation
    index : int
        Position of the body in ``situation.bodies``.
    t : float
        Time [s].

    Returns
    -------
    (n, 2) ndarray or None
        Corners in order, in arm-plane coordinates; None when the plane misses the body.
    """
    shape = situation.bodies[index].shape
    centre, rotation = pose(situation, index, t)
    if isinstance(shape, PLANAR):
        return centre[:2] + _planar(shape) @ rotation[:2, :2].T
    assert isinstance(shape, SOLID)
    corners = cut_outline(shape, centre, rotation)
    return corners if len(corners) else None


def _planar(shape: PlanarShape) -> np.ndarray:
    """Return the outline of a planar body in its own frame."""
    if entry_of(shape).is_ball:
        return shape.bounding_radius * np.stack([np.cos(CIRCLE), np.sin(CIRCLE)], axis=1)
    return np.asarray(entry_of(shape).vertices(shape))


def cut_outline(
    shape: SolidShape, centre: np.ndarray, rotation: np.ndarray, n: int = 96
) -> np.ndarray:
    """Return the boundary of a solid's cut with z = 0, for figures.

    Parameters
    ----------
    shape : Sphere, Box, Capsule or Cylinder
    centre : (3,) array_like
        In arm-plane coordinates.
    rotation : (3, 3) array_like
        Body frame to arm-plane frame.
    n : int
        Points on every full circle.

    Returns
    -------
    (m, 2) ndarray
        Counter-clockwise, the first point not repeated; (0, 2) when the cut has no area.
    """
    if isinstance(shape, PLANAR):
        raise TypeError(f"only solids are cut (got {type(shape).__name__})")
    discs, polygon = solid_cut(shape, centre, rotation)
    angles = np.arange(n) * (2.0 * math.pi / n)
    circle = np.column_stack((np.cos(angles), np.sin(angles)))
    pieces = [polygon, *(disc[:2] + disc[2] * circle for disc in discs)]
    return _convex_hull(np.concatenate(pieces))


def solid_cut(
    shape: SolidShape, centre: np.ndarray, rotation: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return discs (k, 3) and corners (m, 2) of a solid's cut with z = 0; see `region`."""
    kind, sizes, *_ = entry_of(shape)
    bodies = no_bodies()._replace(rows=np.zeros((1, COLUMNS)))
    bodies.rows[0, KIND], bodies.rows[0, SIZE : SIZE + 3] = kind, sizes(shape)
    poses = np.concatenate([np.ravel(centre), np.ravel(rotation)])[None].astype(float)
    made = new_cut()
    discs, corners = cut(bodies, poses, 0, made)
    return made.discs[:discs], made.corners[:corners]


def _convex_hull(points: np.ndarray) -> np.ndarray:
    """Return the corners of the convex hull, counter-clockwise (Andrew's monotone chain)."""
    ordered = [(x, y) for x, y in np.unique(points, axis=0).tolist()]
    hull: list[tuple[float, float]] = []
    for side in (ordered, ordered[::-1]):
        chain: list[tuple[float, float]] = []
        for x, y in side:
            while len(chain) > 1 and _turn(chain[-2], chain[-1], (x, y)) <= 0.0:
                chain.pop()
            chain.append((x, y))
        hull += chain[:-1]
    return np.array(hull if len(hull) > 2 else []).reshape(-1, 2)


def _turn(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> float:
    """Twice the area of the triangle a, b, c; positive if the corners run counter-clockwise."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
