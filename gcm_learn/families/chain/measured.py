"""Obstacles as a camera or a drawing has them: clouds of points, and meshes."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from gcm_learn.families.chain.stage import Stage, Way
from gcm_learn.families.ranges import Range, Ranges, number, pick, span
from gcm_learn.situation import Body, Box, Capsule, Cloud, Cylinder, Mesh, SolidShape, Sphere

SIDES = 16  # of the polygon that stands for a circle
MOST = 20_000  # points of a cloud


@dataclass(frozen=True)
class Measured(Ranges):
    """Shares of obstacles given as surfaces, clouds or meshes; the floor never is."""

    clouds: float = number(0.0)
    """Share of obstacles that are points on their surfaces, with balls about them."""
    meshes: float = number(0.0)
    """Share of obstacles that are meshes."""
    spacing: Range = span(0.012, 0.02, 1e-3)
    """Mean distance of neighbouring points, which is the radius of the balls, too [reaches]."""

    def of(
        self, rng: np.random.Generator, stage: Stage, way: Way, bodies: Sequence[Body]
    ) -> list[Body]:
        """Return bodies of which some are surfaces, where these leave the ends of the way free."""
        made = list(bodies)
        for k, body in enumerate(bodies):
            if body.role == "target" or self.clouds + self.meshes == 0.0:
                continue
            share = rng.random()
            if share < self.clouds + self.meshes and isinstance(body.shape, SolidShape):
                shape: Any = mesh_of(body.shape)
                if share < self.clouds:
                    spacing = pick(rng, self.spacing) * stage.arm.reach
                    count = int(np.clip(areas_of(shape).sum() / spacing**2, 8, MOST))
                    shape = cloud_of(rng, shape, count, spacing)
                other = replace(body, shape=shape)
                made[k] = other if stage.fits(way, (other,)) else body
        return made


def areas_of(mesh: Mesh) -> np.ndarray:
    """Return the areas (t,) of the triangles of a mesh."""
    sides = mesh.corners[:, 1:] - mesh.corners[:, :1]
    return np.asarray(0.5 * np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1))


def cloud_of(rng: np.random.Generator, mesh: Mesh, count: int, radius: float) -> Cloud:
    """Draw `count` points evenly over a mesh's area, as a cloud of balls of a radius."""
    areas = areas_of(mesh)
    which = rng.choice(len(areas), count, p=areas / areas.sum())
    share = np.sort(rng.random((count, 2)), axis=1)
    share = np.column_stack([share[:, 0], share[:, 1] - share[:, 0], 1.0 - share[:, 1]])
    return Cloud(np.einsum("kc,kcd->kd", share, mesh.corners[which]), radius)


def mesh_of(shape: SolidShape) -> Mesh:
    """Return a triangle mesh of a solid, with all corners on the solid's surface."""
    if isinstance(shape, Box):
        ends = np.array(list(itertools.product((-1.0, 1.0), repeat=3))) * shape.half_extents
        quads = ((0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5))
        return _mesh(ends, [(a, b, c) for a, *rest in quads for b, c in itertools.pairwise(rest)])
    profile = _profile(shape)
    angle = np.arange(SIDES) * (2.0 * np.pi / SIDES)
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    rings = [np.c_[r * circle, np.full(SIDES, z)] for r, z in profile]
    triangles = []
    for low in range(0, SIDES * (len(rings) - 1), SIDES):
        for k in range(SIDES):
            a, b = low + k, low + (k + 1) % SIDES
            triangles += [(a, b, a + SIDES), (b, b + SIDES, a + SIDES)]
    return _mesh(np.concatenate(rings), triangles)


def _mesh(corners: np.ndarray, triangles: list[tuple[int, int, int]]) -> Mesh:
    return Mesh(corners, np.array(triangles))


def _profile(shape: Sphere | Capsule | Cylinder) -> list[tuple[float, float]]:
    """Return distances from the z axis and heights, from the lowest point to the highest."""
    r = shape.radius
    if isinstance(shape, Cylinder):
        h = shape.half_length
        return [(0.0, -h), (r, -h), (r, h), (0.0, h)]
    half = shape.half_length if isinstance(shape, Capsule) else 0.0
    turns = np.linspace(-0.5 * np.pi, 0.5 * np.pi, SIDES // 2 + 1)
    arc = np.stack([r * np.cos(turns), r * np.sin(turns)], axis=1)
    middle = len(arc) // 2
    points = np.concatenate([arc[: middle + 1] - (0.0, half), arc[middle:] + (0.0, half)])
    return [(float(x), float(z)) for x, z in points]
