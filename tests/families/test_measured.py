"""Obstacles that are drawn as clouds and meshes."""

from __future__ import annotations

import numpy as np
import pytest

from gcm_learn.families import draw
from gcm_learn.families.chain.measured import areas_of, cloud_of, mesh_of
from gcm_learn.situation import Box, Capsule, Cloud, Cylinder, Mesh, Sphere
from tests.planar_geometry import depths

SOLIDS = (Sphere(0.2), Box((0.1, 0.2, 0.3)), Capsule(0.1, 0.2), Cylinder(0.2, 0.1))
AREAS = (0.5027, 0.88, 0.377, 0.5027)
of_solids = pytest.mark.parametrize(
    ("solid", "area"), [*zip(SOLIDS, AREAS, strict=True)], ids=[s.kind for s in SOLIDS]
)


@of_solids
def test_meshes_are_the_surfaces_of_solids(solid, area):
    mesh = mesh_of(solid)
    np.testing.assert_allclose(depths(solid, mesh.vertices), 0.0, atol=1e-12)
    assert areas_of(mesh).sum() == pytest.approx(area, rel=0.04)  # chords are shorter than arcs


@of_solids
def test_points_of_clouds_are_spread_over_the_surface(solid, area, rng):
    mesh = mesh_of(solid)
    cloud = cloud_of(rng, mesh, 2000, 0.01)
    np.testing.assert_allclose(depths(mesh, cloud.points), 0.0, atol=1e-12)
    apart = np.linalg.norm(cloud.points[:, None] - mesh.vertices, axis=2).min(axis=0)
    assert apart.max() < 8.0 * np.sqrt(area / 2000)


@pytest.mark.parametrize(
    ("preset", "shape"), [("panda-shelf-mesh", Mesh), ("panda-room-cloud", Cloud)]
)
def test_obstacles_are_measured_but_for_the_floor(preset, shape):
    kinds = [type(body.shape) for k in range(3) for body in draw(preset, 4, k).obstacles]
    assert kinds.count(shape) > 0.7 * len(kinds)
    assert all(type(body.shape) is not shape for body in draw(preset, 4, 0).targets)


def test_persons_have_margins_that_grow():
    drawn = [draw("panda-person", 4, k) for k in range(8)]
    persons = [b for s in drawn for b in s.obstacles if b.name.startswith("person")]
    assert len(persons) >= 4
    assert all(body.margin.rate > 0.0 and any(body.motion.velocity) for body in persons)
    assert all(situation.targets[0].hold is not None for situation in drawn)
