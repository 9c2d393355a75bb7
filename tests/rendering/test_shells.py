"""Balls of clouds, and margins about shapes: by the referee's distances."""

from __future__ import annotations

import numpy as np
import pytest

from gcm_learn import rendering
from gcm_learn.plots.figures.surfaces import surface_about
from gcm_learn.rendering import shells, solids
from gcm_learn.rendering.shells import COARSE, FEWEST, shell
from gcm_learn.situation import Cloud, Mesh
from tests.geometry import signed_distance
from tests.rendering.test_rendering import SOLIDS, VIEW, WINDOW

CUBE = Mesh(
    [(x, y, z) for x in (-0.2, 0.2) for y in (-0.3, 0.3) for z in (-0.1, 0.1)],
    [
        (0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1),
        (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3),
    ],
)  # fmt: skip
POINTS = np.random.default_rng(5).uniform(-0.4, 0.4, (30, 3))
SURFACES = [Cloud(POINTS, 0.02), CUBE]
SIZED = ("radius", "half_length", "half_extents", "points", "vertices", "triangles")
LAW = {"kind": "quadratic", "velocity": (0, 0, 0), "acceleration": (0, 0, 0)}
LAW |= {"position": (0, 0, 0), "orientation": (1, 0, 0, 0)}


def apart(shape, points):
    """Distances of points (..., 3) to a shape, as the referee measures them."""
    given = {k: np.asarray(getattr(shape, k)).tolist() for k in SIZED if hasattr(shape, k)}
    body = {"shape": {"kind": shape.kind} | given, "motion": LAW}
    return signed_distance(body, 0.0, points.reshape(-1, 3))


def at(about, distance):
    return about.start + distance * about.outward


@pytest.mark.parametrize("distance", [0.01, 0.15])
@pytest.mark.parametrize("shape", SOLIDS + SURFACES, ids=lambda shape: shape.kind)
def test_a_margin_reaches_to_its_distance_and_no_farther(shape, distance):
    corners = at(shell(shape), distance)
    away = apart(shape, corners)  # of convex ones every corner is on the surface
    assert away.max() <= distance + 1e-9 and (shape in SURFACES or away.min() >= distance - 1e-9)
    ways = np.random.default_rng(1).normal(size=(20, 3))
    farthest = (corners.reshape(-1, 3) @ ways.T).max(axis=0)
    start = (solids.faces(shape).reshape(-1, 3) @ ways.T).max(axis=0)
    grown = (farthest - start) / np.linalg.norm(ways, axis=1)
    assert (grown > 0.85 * distance).all() and (
        grown < distance + 0.1 * shape.bounding_radius
    ).all()


@pytest.mark.parametrize("shape", SURFACES, ids=lambda shape: shape.kind)
def test_one_surface_about_a_cloud_or_mesh_is_at_its_distance_and_closed(shape):
    about = surface_about(shape, 0.1)
    away = apart(shape, at(about, 0.1))
    assert (away <= 0.1 + 1e-9).all() and (away > 0.085).all()  # of a mesh to points upon it
    if shape.kind == "cloud":  # but in creases
        assert (np.abs(away - 0.1) < 1e-9).mean() > 0.99
    quads = at(about, 0.1).round(9)
    sides = np.concatenate([np.stack([quads[:, k], quads[:, (k + 1) % 4]], 1) for k in range(4)])
    there = np.unique(sides.reshape(-1, 6), axis=0, return_counts=True)
    back = np.unique(sides[:, ::-1].reshape(-1, 6), axis=0, return_counts=True)
    assert all((a == b).all() for a, b in zip(there, back, strict=True))


def test_of_a_large_cloud_evenly_chosen_points_are_drawn():
    points = np.random.default_rng(2).uniform(0.0, 1.0, (20_000, 3))
    points[2_000:] *= 0.03  # most are in one corner
    cloud, most = Cloud(points, 0.004), 8_000
    drawn = shells.thinned(cloud, most // FEWEST)
    assert most // FEWEST / 2 < len(drawn) <= most // FEWEST
    assert (np.linalg.norm(drawn, axis=1) > 0.1).mean() > 0.9
    faces = solids.faces(cloud, most)
    assert len(faces) == FEWEST * len(drawn)
    np.testing.assert_allclose(faces.reshape(len(drawn), -1, 3).mean(axis=1), drawn, atol=1e-9)
    assert len(solids.faces(Cloud(points[:10], 0.1), most)) > 50 * 10  # few are round


def test_points_in_one_place_and_tiny_meshes_are_drawn():
    assert len(shells.thinned(Cloud([(0.1, 0.2, 0.3)] * 500, 0.01), 3)) == 1
    point = Mesh([(0.0, 0.0, 0.0)], [(0, 0, 0)] * 40)
    assert np.isfinite(shell(point, COARSE).start).all()
    assert surface_about(point, 0.0) is None


def test_a_mesh_of_many_triangles_has_a_margin_of_few_faces():
    u, v = np.meshgrid(np.linspace(0, np.pi, 40), np.linspace(0, 2 * np.pi, 80), indexing="ij")
    ball = np.stack([np.sin(u) * np.cos(v), np.sin(u) * np.sin(v), np.cos(u)], -1).reshape(-1, 3)
    k = (np.arange(39)[:, None] * 80 + np.arange(79)).ravel()
    mesh = Mesh(ball, np.concatenate([np.c_[k, k + 80, k + 1], np.c_[k + 1, k + 80, k + 81]]))
    about = shell(mesh, 20_000)
    assert len(about.start) <= 20_000 < COARSE * len(mesh.triangles)
    assert np.linalg.norm(at(about, 0.1), axis=2).max() == pytest.approx(1.1, abs=0.02)


def test_a_triangle_is_seen_from_both_sides():
    right, up = 0.5 * VIEW.right, 0.5 * VIEW.up
    for corners in ((right, up, -right), (-right, up, right)):
        mesh = Mesh([VIEW.centre + corner for corner in corners], [(0, 1, 2)])
        thing = solids.placed(mesh, np.zeros(3), np.eye(3), np.array([1.0, 0.0, 0.0]))
        image = rendering.render(VIEW, WINDOW, [thing], 40)
        assert (image < 0.9).any(axis=-1).mean() == pytest.approx(0.25 / 4, rel=0.2)
