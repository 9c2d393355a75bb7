"""Shapes of bodies: the answers of every shape, held against dense samples of it.

A new shape gets a line in EXAMPLES and its signed distance in `gcm_learn/referee/shapes.py`. The
tests then name what its file or the table of a layer lacks.
"""

from __future__ import annotations

import inspect
from typing import get_args

import numpy as np
import pytest

from gcm_learn.collision.distance import bone_distance, point_distance
from gcm_learn.execution.body.model import GEOMS
from gcm_learn.families.random_solid import random_rotation
from gcm_learn.referee.segments import segments_apart
from gcm_learn.referee.shapes import segment_gaps
from gcm_learn.rendering.solids import MESHES
from gcm_learn.scene import Bodies, bodies as k, no_bodies
from gcm_learn.scene.shapes import ball, box, capsule, choice, cloud, cylinder, mesh, polygon
from gcm_learn.scene.shapes.choice import ENTRIES
from gcm_learn.scene.shapes.region import EMPTY_DISTANCE
from gcm_learn.situation import (
    PLANAR,
    SOLID,
    SPACE,
    Box,
    Capsule,
    Cloud,
    Cylinder,
    Disc,
    Mesh,
    Polygon,
    Sphere,
)  # fmt: skip
from gcm_learn.situation.schema import LISTS, NUMBERS
from gcm_learn.situation.shapes import Shape
from tests.planar_geometry import depths, members, segment_distances

_DRAWN = np.random.default_rng(3)
POINTS = Cloud(_DRAWN.uniform(-0.4, 0.4, (137, 3)), 0.05)
"""Balls of which some overlap, in a tree that is not full."""
FOLDS = Mesh(_DRAWN.uniform(-0.4, 0.4, (40, 3)), _DRAWN.integers(0, 39, (61, 3)))
"""Triangles that cross each other; some have no area, and a vertex is not used."""
BENT = Polygon(((-0.3, -0.3), (0.3, -0.3), (0.3, 0.3), (0.2, -0.1), (-0.2, -0.1), (-0.3, 0.3)))
EXAMPLES = {
    Disc: (Disc(0.3), ball), Polygon: (BENT, polygon), Sphere: (Sphere(0.3), ball),
    Box: (Box((0.1, 0.2, 0.3)), box), Capsule: (Capsule(0.1, 0.3), capsule),
    Cylinder: (Cylinder(0.25, 0.15), cylinder), Cloud: (POINTS, cloud), Mesh: (FOLDS, mesh),
}  # fmt: skip
"""A shape of each class, and the file of its kernels."""
of_all = pytest.mark.parametrize("shape", [s for s, _ in EXAMPLES.values()], ids=lambda s: s.kind)
SOLIDS_TOO = {made: ("inner_radius", "cut") if made in SOLID else () for made in SPACE}
of_space = pytest.mark.parametrize("shape", [EXAMPLES[s][0] for s in SPACE], ids=lambda s: s.kind)
of_solids = pytest.mark.parametrize("shape", [EXAMPLES[s][0] for s in SOLID], ids=lambda s: s.kind)


def bodies_of(shape) -> Bodies:
    """Return a shape as the only body."""
    entry, row = ENTRIES[type(shape)], np.zeros((1, k.COLUMNS))
    corners = np.array(entry.vertices(shape), dtype=float).reshape(-1, 2)
    row[0, k.KIND], row[0, k.BALL], row[0, k.LAST] = entry.number, entry.is_ball, len(corners)
    row[0, k.SIZE : k.SIZE + 3], row[0, k.REACH] = entry.sizes(shape), shape.bounding_radius
    return no_bodies()._replace(rows=row, vertices=corners)


def points_near(shape, rng, n):
    """Return points (n, 3) in and around a shape; those of planar shapes lie in the plane."""
    flat = isinstance(shape, PLANAR)
    return rng.uniform(-0.7, 0.7, (n, 3)) * (1.0, 1.0, 0.0 if flat else 1.0)


def true_depths(shape, points):
    """Distances (n,) of points by the referee; signed for solids, else 0 inside."""
    if isinstance(shape, PLANAR):
        pose = np.zeros((len(points), 3)), np.broadcast_to(np.eye(3), (len(points), 3, 3))
        return segment_distances(shape, pose, points[:, :2], points[:, :2])
    return depths(shape, points)


@pytest.mark.parametrize("made", get_args(Shape), ids=lambda s: s.kind)
def test_every_layer_knows_every_shape(made):
    shape, file = EXAMPLES[made]
    entry = ENTRIES[made]
    assert (made in PLANAR) != (made in SPACE)
    assert made in NUMBERS or made in LISTS or made is Mesh
    assert len(entry.sizes(shape)) == 3
    assert [e.number for e in ENTRIES.values()].count(entry.number) == 1
    questions = {"gap", "gap_of_bone", "long_axis"}
    if made in SPACE:
        questions |= {"from_nearest"}
        assert made in MESHES
    if made in SOLID:
        questions |= {"inner_radius", "cut"}
        assert made.kind in GEOMS
    assert questions <= set(dir(file))


def test_the_choice_names_every_shape_in_every_question():
    """A branch that is missing would answer for another shape."""
    for made in SPACE:
        file = EXAMPLES[made][1].__name__.rpartition(".")[2]
        for question in ("gap", "gap_of_bone", "long_axis", "from_nearest", *SOLIDS_TOO[made]):
            source = inspect.getsource(getattr(choice, question).py_func)
            assert f"{file}.{question}(" in source


@of_all
def test_the_gap_is_that_of_the_referee(shape, rng):
    bodies, points = bodies_of(shape), points_near(shape, rng, 400)
    found = np.array([choice.gap(bodies, 0, *p) for p in points])
    true = true_depths(shape, points)
    if isinstance(shape, PLANAR):
        assert np.array_equal(found <= 0.0, true == 0.0)
        found = np.maximum(found, 0.0)
    np.testing.assert_allclose(found, true, atol=1e-9)


@of_all
def test_the_gap_of_a_bone_is_that_of_its_nearest_point(shape, rng):
    bodies, share = bodies_of(shape), np.linspace(0.0, 1.0, 2001)[:, None]
    for p, q in points_near(shape, rng, 120).reshape(-1, 2, 3):
        sampled = max(true_depths(shape, p + share * (q - p)).min(), 0.0)
        found = choice.gap_of_bone(bodies, 0, tuple(p), tuple(q), 1e300, 1e300)
        spacing = np.linalg.norm(q - p) / 2000
        assert sampled - 0.5 * spacing - 1e-9 <= found <= sampled + 1e-9


@of_all
def test_poses_turn_the_question_not_the_answer(shape, rng):
    bodies = bodies_of(shape)
    p, q = points_near(shape, rng, 2)
    if isinstance(shape, PLANAR):
        turn, centre = np.eye(3), np.array([0.4, -0.2, 0.0])
    else:
        turn, centre = random_rotation(rng), rng.normal(size=3)
    poses = np.hstack([centre, np.zeros(9) if ENTRIES[type(shape)].is_ball else turn.ravel()])[None]
    a, b = tuple(centre + turn @ p), tuple(centre + turn @ q)
    gap, bone = (
        choice.gap(bodies, 0, *p),
        choice.gap_of_bone(bodies, 0, tuple(p), tuple(q), 1e300, 1e300),
    )
    assert point_distance(bodies, poses, 0, *a) == pytest.approx(gap, abs=1e-9)
    assert bone_distance(bodies, poses, 0, a, b, 1e300, 1e300) == pytest.approx(bone, abs=1e-9)


@of_space
def test_the_vector_from_the_nearest_point_ends_there(shape, rng):
    bodies = bodies_of(shape)
    for p in points_near(shape, rng, 200):
        part = choice.part_near(bodies, 0, tuple(p), tuple(p))
        away = np.array(choice.from_nearest(bodies, 0, part, *p))
        gap = choice.gap(bodies, 0, *p)
        assert np.linalg.norm(away) == pytest.approx(max(gap, 0.0), abs=1e-12)
        assert gap <= 0.0 or choice.gap(bodies, 0, *(p - away)) == pytest.approx(0.0, abs=1e-9)


def test_triangles_of_rounding_errors_are_where_they_are(rng):
    """Slivers and tiny triangles have a plane of any direction."""
    corners = rng.uniform(-0.4, 0.4, (300, 1, 3)) + 1e-17 * rng.normal(size=(300, 3, 3))
    corners[::2, 2] = corners[::2, 0] + rng.uniform(-0.3, 0.3, (150, 3))
    corners[::2, 1] = 0.5 * (corners[::2, 0] + corners[::2, 2])
    mesh = Mesh(corners.reshape(-1, 3), np.arange(900).reshape(-1, 3))
    bodies, shape = bodies_of(mesh), members(mesh)
    p, q = rng.uniform(-0.7, 0.7, (2, 200, 3))
    true = np.min([segments_apart(p, q, *np.broadcast_to(c[[0, 2]][:, None], (2, 200, 3)))
                   for c in corners], axis=0)  # fmt: skip
    found = [choice.gap_of_bone(bodies, 0, tuple(a), tuple(b), 1e300, 1e300)
             for a, b in zip(p, q, strict=True)]  # fmt: skip
    np.testing.assert_allclose(found, true, atol=1e-12)
    np.testing.assert_allclose(segment_gaps(shape, p, q), true, atol=1e-12)


@pytest.mark.parametrize("shape", [POINTS, FOLDS], ids=lambda s: s.kind)
def test_what_is_beyond_what_was_asked_for_is_said_to_be_far(shape, rng):
    bodies = bodies_of(shape)
    for p, q in points_near(shape, rng, 200).reshape(-1, 2, 3):
        true = choice.gap_of_bone(bodies, 0, tuple(p), tuple(q), 1e300, 1e300)
        found = choice.gap_of_bone(bodies, 0, tuple(p), tuple(q), 0.05, 0.1)
        assert found == true if true <= 0.05 else found >= true
        assert (found <= 0.1) == (true <= 0.1)


@of_solids
def test_the_inner_ball_is_the_largest_inside(shape):
    bodies = bodies_of(shape)
    assert choice.inner_radius(bodies, 0) == pytest.approx(-choice.gap(bodies, 0, 0.0, 0.0, 0.0))


@of_all
def test_the_ball_holds_the_shape(shape, rng):
    bodies, points = bodies_of(shape), points_near(shape, rng, 400)
    inside = np.array([choice.gap(bodies, 0, *p) <= 0.0 for p in points])
    assert (np.linalg.norm(points[inside], axis=1) <= shape.bounding_radius).all()
    if ENTRIES[type(shape)].is_ball:
        assert (np.linalg.norm(points[~inside], axis=1) >= shape.bounding_radius).all()


@of_all
def test_the_long_axis_is_that_of_most_spread(shape, rng):
    bodies, points = bodies_of(shape), points_near(shape, rng, 4000)
    x = np.array(choice.long_axis(bodies, 0))
    if not x.any():
        return
    if isinstance(shape, Polygon):  # of the corners
        points = np.pad(np.array(shape.vertices), ((0, 0), (0, 1)))
        points -= points.mean(axis=0)
    elif shape == EXAMPLES[Cylinder][0]:  # told for what is round, however short
        return
    else:
        points = points[[choice.gap(bodies, 0, *p) <= 0.0 for p in points]]
    most = np.linalg.svd(points, full_matrices=False)[2][0]
    assert abs(most @ x) == pytest.approx(np.linalg.norm(x), rel=0.03)


@pytest.mark.parametrize("shape", [EXAMPLES[s][0] for s in PLANAR + SOLID], ids=lambda s: s.kind)
def test_the_gap_in_the_plane_is_that_of_the_cut(shape, rng):
    bodies = bodies_of(shape)
    for height in (0.0,) if isinstance(shape, PLANAR) else (0.0, 0.1, 0.9):
        turn = np.eye(3) if isinstance(shape, PLANAR) else random_rotation(rng)
        poses = np.hstack([0.0, 0.0, height, turn.ravel()])[None]
        for p in points_near(shape, rng, 60) * (1.0, 1.0, 0.0):
            found = choice.gap_in_plane(bodies, poses, 0, p[0], p[1])
            solid = choice.gap(bodies, 0, *((p - poses[0, :3]) @ turn))
            if height > shape.bounding_radius:
                assert found == EMPTY_DISTANCE
            elif abs(solid) > 1e-3:
                assert (found < 0.0) == (solid < 0.0)
            if solid > 0.0:
                assert found >= solid - 1e-9
