"""Surfaces about shapes at any distance: balls of clouds, and margins, which grow."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache
from itertools import product
from typing import NamedTuple

import numpy as np

from gcm_learn.situation import Body, Box, Cloud, Cylinder, Mesh, SpaceShape

SIDES = 24  # polygon that stands for a circle
FACES = 48_000  # of all clouds in a picture, and of all margins
BALLS = ((SIDES, 15), (12, 6), (8, 4), (6, 4), (4, 2))  # sides and rings of balls, finest first
COARSE = 8 * 4  # fewest faces of a ball about a point with a margin
FEWEST = 4 * 2  # of a ball of a cloud
CUBES, LARGER = 200, 1.2  # along a cloud that is thinned, at first; growth of their edge


class Shell(NamedTuple):
    """Faces about a shape."""

    start: np.ndarray
    """(n, 4, 3) float: corners on the shape itself, in its own frame."""
    outward: np.ndarray
    """(n, 4, 3) float: unit, the ways of the corners with growing distance."""


@lru_cache(maxsize=256)
def shell(shape: SpaceShape, most: int = FACES) -> Shell:
    """Return faces about a solid, with directions in which to offset them to any distance.

    Of a cloud of many points some are left out; of a mesh of many triangles vertices are joined.

    Parameters
    ----------
    shape : SpaceShape
    most : int
        About the largest number of faces.
    """
    return _swept(*_core(shape, most // COARSE), most)


@lru_cache(maxsize=256)
def balls(cloud: Cloud, most: int = FACES) -> Shell:
    """Return the balls about a cloud's points, or about some points if there are too many."""
    return _swept(thinned(cloud, most // FEWEST)[:, None], cloud.radius, most)


@lru_cache(maxsize=256)
def thinned(cloud: Cloud, most: int) -> np.ndarray:
    """Return at most `most` points (n, 3) of a cloud, evenly in space: one point of each cube."""
    points = cloud.points - cloud.points.min(axis=0)
    chosen, edge = np.arange(len(points)), max(float(points.max()), cloud.radius) / CUBES
    while len(chosen) > most:
        chosen = np.unique(np.floor(points / edge), axis=0, return_index=True)[1]
        edge *= LARGER
    return cloud.points[chosen]


def points_drawn(bodies: Iterable[Body], most: int) -> tuple[int, int]:
    """Return how many points of clouds are drawn with so many faces for each, and of how many."""
    clouds = [body.shape for body in bodies if isinstance(body.shape, Cloud)]
    drawn = (len(thinned(cloud, most // FEWEST)) for cloud in clouds)
    return sum(drawn), sum(len(cloud.points) for cloud in clouds)


def turned(profile: np.ndarray, sides: int = SIDES) -> np.ndarray:
    """Turn a profile (k, 2) about the z axis."""
    angle = np.linspace(0.0, 2 * np.pi, sides + 1)
    r, z = profile[:, :1], np.broadcast_to(profile[:, 1:], (len(profile), sides + 1))
    rings = np.stack([r * np.cos(angle), r * np.sin(angle), z], axis=-1)
    a, b = rings[:-1], rings[1:]
    return np.stack([a[:, :-1], a[:, 1:], b[:, 1:], b[:, :-1]], axis=2).reshape(-1, 4, 3)


def _swept(points: np.ndarray, radius: float, most: int) -> Shell:
    """Return faces about the convex hulls of sets of points (k, m, 3), at a radius from them."""
    fitting = [ball for ball in BALLS if len(points) * ball[0] * ball[1] <= most]
    sides, rings = (fitting or BALLS[-1:])[0]
    angle = np.linspace(-np.pi / 2, np.pi / 2, rings + 1)
    ball = turned(np.stack([np.cos(angle), np.sin(angle)], axis=1), sides).reshape(-1, 3)
    ways = np.round(ball, 12)  # equal where a ball closes
    farthest = (points @ ways.T).argmax(axis=1)
    core = np.take_along_axis(points, farthest[..., None], axis=1)
    outward = np.broadcast_to(ways, core.shape).reshape(-1, 4, 3)
    return Shell(core.reshape(-1, 4, 3) + radius * outward, outward)


def _core(shape: SpaceShape, most: int) -> tuple[np.ndarray, float]:
    """Return sets of points (k, m, 3), and at which distance from their hulls a shape ends."""
    if isinstance(shape, Cloud):
        return thinned(shape, most)[:, None], shape.radius
    if isinstance(shape, Mesh):
        return _coarser(shape, most).corners, 0.0
    if isinstance(shape, Box):
        return np.array([list(product(*((-h, h) for h in shape.half_extents)))]), 0.0
    half = getattr(shape, "half_length", 0.0)
    if isinstance(shape, Cylinder):
        rims = turned(np.array([(shape.radius, -half), (shape.radius, half)]))
        return rims.reshape(1, -1, 3), 0.0
    return np.array([[(0.0, 0.0, -half), (0.0, 0.0, half)]]), shape.radius


def _coarser(mesh: Mesh, most: int) -> Mesh:
    """Return a mesh of about so many triangles at most, vertices of which are joined."""
    coarse, edge = mesh, mesh.bounding_radius / 25
    while len(coarse.triangles) > most and edge < mesh.bounding_radius:
        coarse = mesh.simplified(edge)[0]
        edge *= LARGER
    return coarse
