"""Plane cuts of solids against the solids themselves: membership, areas, volumes, symmetry."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings, strategies as st

from gcm_learn.scene.outlines import cut_outline, solid_cut
from gcm_learn.scene.shapes import region
from gcm_learn.scene.shapes.region import EMPTY_DISTANCE
from gcm_learn.situation import Box, Capsule, Cylinder, Disc, Sphere
from tests import strategies
from tests.refusals import refusal

ARC_ERROR = 2e-4  # radii
UPRIGHT = np.eye(3)
LYING = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])  # body z along plane x
ORIGIN = np.zeros(3)


def about_z(angle):
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def leaning(angle):
    """Body z turned by `angle` from the plane's normal towards plane x."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def cut_of(shape, centre=ORIGIN, rotation=UPRIGHT):
    return solid_cut(shape, centre, rotation)


def region_distance(x, y, discs, polygon):
    made = region.Cut(discs, polygon, polygon)
    return region.region_distance(x, y, made, len(discs), len(polygon))


def polygon_distance(x, y, vertices):
    return region.polygon_distance(x, y, vertices, 0, len(vertices))


def depth_outside(shape, points):
    """Signed number that is at most 0 exactly inside the solid; points (n, 3) in its frame."""
    x, y, z = np.abs(points).T
    if isinstance(shape, Sphere):
        return np.hypot(np.hypot(x, y), z) - shape.radius
    if isinstance(shape, Box):
        return (np.abs(points) - shape.half_extents).max(axis=1)
    if isinstance(shape, Cylinder):
        return np.maximum(np.hypot(x, y) - shape.radius, z - shape.half_length)
    return np.hypot(np.hypot(x, y), np.maximum(z - shape.half_length, 0.0)) - shape.radius


def area(polygon):
    if len(polygon) == 0:
        return 0.0
    x, y = (polygon - polygon[0]).T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def volume(shape):
    if isinstance(shape, Box):
        return 8 * math.prod(shape.half_extents)
    ball = 4 / 3 * math.pi * shape.radius**3
    if isinstance(shape, Sphere):
        return ball
    tube = 2 * math.pi * shape.radius**2 * shape.half_length
    return tube if isinstance(shape, Cylinder) else tube + ball


@st.composite
def poses(draw, shape):
    """Centre and rotation with which the plane often, but not always, meets the solid."""
    height = draw(st.sampled_from([0.0, 0.5]) | st.floats(-1.1, 1.1)) * shape.bounding_radius
    centre = np.array([*draw(strategies.vectors(2)), height])
    quarter = st.sampled_from([UPRIGHT, LYING, LYING.T, -np.diag([1.0, 1.0, -1.0])])
    grazing = st.floats(-14, 0).map(lambda k: leaning(10**k))
    flat = st.floats(-14, 0).map(lambda k: leaning(math.pi / 2 - 10**k))
    return centre, draw(strategies.rotations() | quarter | grazing | flat)


@st.composite
def placed_solids(draw):
    shape = draw(strategies.solid_shapes)
    return shape, *draw(poses(shape))


@settings(max_examples=300)
@given(placed_solids(), st.integers(0, 9))
def test_a_point_is_in_the_cut_exactly_when_it_is_in_the_solid(placed, seed):
    shape, centre, rotation = placed
    discs, polygon = cut_of(*placed)
    reach = 1.1 * shape.bounding_radius
    points = centre[:2] + np.random.default_rng(seed).uniform(-reach, reach, (100, 2))
    in_space = np.column_stack((points, np.zeros(100)))
    outside = depth_outside(shape, (in_space - centre) @ rotation)
    distances = np.array([region_distance(x, y, discs, polygon) for x, y in points])
    assert not np.any((outside > 1e-9) & (distances < 0.0))
    assert not np.any((outside < -ARC_ERROR * shape.bounding_radius) & (distances > 0.0))


@given(placed_solids())
def test_outline_bounds_the_cut(placed):
    shape, centre, rotation = placed
    discs, polygon = cut_of(*placed)
    outline = cut_outline(*placed, n=64)
    inner = depth_outside(
        shape, (np.column_stack((outline, 0.0 * outline[:, 0])) - centre) @ rotation
    )
    # on the solid's surface; a disc may bulge out of a capsule's sampled arc
    assert np.all(inner < 1e-9)
    assert np.all(inner > -ARC_ERROR * shape.bounding_radius)
    pieces = [area(polygon), *(math.pi * discs[:, 2] ** 2)]
    # circles of 64 points miss 0.2 % of their area
    assert area(outline) >= 0.997 * max(pieces) - 1e-12
    for x, y in np.concatenate((polygon, discs[:, :2])):
        assert len(outline) == 0 or polygon_distance(x, y, outline) < 1e-9


@given(placed_solids())
def test_polygons_are_convex_counter_clockwise_and_small(placed):
    _, polygon = cut_of(*placed)
    assert len(polygon) <= 256
    if len(polygon) > 2:
        edges = np.roll(polygon, -1, axis=0) - polygon
        following = np.roll(edges, -1, axis=0)
        turns = edges[:, 0] * following[:, 1] - edges[:, 1] * following[:, 0]
        assert np.all(turns >= -1e-15)
        assert area(polygon) >= -1e-15


@given(placed_solids())
def test_vertices_are_on_the_surface(placed):
    shape, centre, rotation = placed
    assume(not isinstance(shape, Capsule))
    _, polygon = cut_of(*placed)
    points = np.column_stack((polygon, np.zeros(len(polygon)))) - centre
    assert np.all(np.abs(depth_outside(shape, points @ rotation)) < 1e-12)


@settings(max_examples=20)
@given(strategies.solid_shapes, strategies.rotations())
def test_areas_of_slices_add_up_to_the_volume(shape, rotation):
    slices = 200
    step = 2 * shape.bounding_radius / slices
    heights = (np.arange(slices) + 0.5) * step - shape.bounding_radius
    areas = [area(cut_outline(shape, (0.0, 0.0, z), rotation)) for z in heights]
    # The area of a convex solid's slices rises, then falls, so that their sum is off by at most
    # the largest slice; a circle of 96 points lacks 0.07 % of its area.
    slack = step * max(areas) + 1e-3 * volume(shape)
    assert sum(areas) * step == pytest.approx(volume(shape), abs=slack)


def grid_around(centre, shape):
    steps = np.linspace(-1.3, 1.3, 5) * shape.bounding_radius
    return [(centre[0] + dx, centre[1] + dy) for dx in steps for dy in steps]


@settings(max_examples=60)
@given(placed_solids(), strategies.angles)
def test_turning_the_scene_about_the_normal_turns_the_cut(placed, angle):
    shape, centre, rotation = placed
    turn = about_z(angle)
    discs, polygon = cut_of(*placed)
    turned_discs, turned_polygon = cut_of(shape, turn @ centre, turn @ rotation)
    for x, y in grid_around(centre, shape):
        there = turn[:2, :2] @ (x, y)
        expected = region_distance(x, y, discs, polygon)
        assume(expected < EMPTY_DISTANCE)
        found = region_distance(*there, turned_discs, turned_polygon)
        assert found == pytest.approx(expected, abs=1e-6 + ARC_ERROR * shape.bounding_radius)


DISCS = [
    *((Sphere(0.5), z, math.sqrt(0.25 - z**2)) for z in (0.0, 0.3, -0.3, 0.5)),
    *((made(0.5, 2.0), z, 0.5) for made in (Cylinder, Capsule) for z in (0.0, 1.9, 2.0, -2.0)),
    (Capsule(0.5, 2.0), 2.3, 0.4),  # one end dips into the plane
]


@pytest.mark.parametrize(("shape", "height", "radius"), DISCS)
def test_upright_round_solids_are_cut_in_a_disc(shape, height, radius):
    discs, polygon = cut_of(shape, (1.0, 2.0, height))
    assert discs[0] == pytest.approx([1.0, 2.0, radius])
    assert (discs[:, :2] == (1.0, 2.0)).all() and discs[:, 2].max() == discs[0, 2]
    assert polygon.shape == (0, 2)


@pytest.mark.parametrize("height", [-0.2, 0.0, 0.3])
def test_box_on_its_base_is_cut_in_a_rectangle(height):
    discs, polygon = cut_of(Box((1.0, 2.0, 0.3)), (5.0, 6.0, height))
    assert discs.shape == (0, 3)
    corners = {(4.0, 4.0), (6.0, 4.0), (6.0, 8.0), (4.0, 8.0)}
    assert len(polygon) == 4
    assert {tuple(v) for v in polygon.round(12).tolist()} == corners
    assert area(polygon) == pytest.approx(8.0)


def test_cube_across_its_diagonal_is_cut_in_a_regular_hexagon():
    normal = np.full(3, 1 / math.sqrt(3))
    x = np.array([1.0, -1.0, 0.0]) / math.sqrt(2)
    rotation = np.array([x, np.cross(normal, x), normal])
    _, polygon = cut_of(Box((1.0, 1.0, 1.0)), ORIGIN, rotation)
    assert len(polygon) == 6
    assert np.hypot(*polygon.T) == pytest.approx(np.full(6, math.sqrt(2)))
    assert area(polygon) == pytest.approx(3 * math.sqrt(3))


@pytest.mark.parametrize("angle", [0.001, 0.3, 1.0, 1.4])
def test_long_cylinder_is_cut_in_an_ellipse(angle):
    shape = Cylinder(0.5, 40.0)
    _, polygon = cut_of(shape, (1.0, -1.0, 0.2), leaning(angle))
    half_axis = 0.5 / math.cos(angle)
    # the axis meets the plane where the centre's height puts it
    middle = np.array([1.0 - 0.2 * math.tan(angle), -1.0])
    u, w = ((polygon - middle) / (half_axis, 0.5)).T
    assert np.hypot(u, w) == pytest.approx(np.ones(len(polygon)), abs=1e-12)
    exact = math.pi * 0.5 * half_axis
    assert (1 - 1.5e-3) * exact < area(polygon) < exact
    arc = np.linspace(0, 2 * math.pi, 3001)
    ellipse = middle + np.column_stack((half_axis * np.cos(arc), 0.5 * np.sin(arc)))
    missed = max(polygon_distance(x, y, polygon) for x, y in ellipse)
    assert missed < ARC_ERROR * 0.5


@pytest.mark.parametrize("height", [0.0, 0.3, -0.4, 0.5])
def test_lying_cylinder_is_cut_in_a_rectangle(height):
    width = math.sqrt(0.25 - height**2)
    _, polygon = cut_of(Cylinder(0.5, 2.0), (0.0, 0.0, height), LYING)
    assert np.abs(polygon[:, 0]) == pytest.approx(np.full(len(polygon), 2.0))
    assert np.abs(polygon[:, 1]) == pytest.approx(np.full(len(polygon), width))
    assert area(polygon) == pytest.approx(8.0 * width)


def test_cut_through_an_end_face_has_the_true_corners():
    # axis at 45 degrees, centre in the plane: the end faces cut the ellipse at u = +- 0.2 sqrt 2
    _, polygon = cut_of(Cylinder(0.5, 0.2), ORIGIN, leaning(math.pi / 4))
    u = 0.2 * math.sqrt(2)
    w = math.sqrt(0.25 - 0.04)
    for corner in [(u, w), (u, -w), (-u, w), (-u, -w)]:
        assert np.min(np.hypot(*(polygon - corner).T)) < 1e-15
    assert np.max(np.abs(polygon[:, 0])) == pytest.approx(u, abs=1e-15)


@pytest.mark.parametrize("height", [0.0, 0.3])
def test_lying_capsule_is_a_stadium(height):
    shape = Capsule(0.5, 2.0)
    width = math.sqrt(0.25 - height**2)
    discs, polygon = cut_of(shape, (0.0, 0.0, height), LYING)
    assert sorted(discs[:, 0]) == pytest.approx([-2.0, 2.0])
    assert discs[:, 2] == pytest.approx([width, width])
    assert area(polygon) == pytest.approx(8.0 * width)
    outline = cut_outline(shape, (0.0, 0.0, height), LYING, n=400)
    assert area(outline) == pytest.approx(8.0 * width + math.pi * width**2, rel=1e-3)


@pytest.mark.parametrize("shape", [Sphere(0.5), Box((0.1, 0.2, 0.3)), Cylinder(0.1, 0.3)])
@pytest.mark.parametrize("height", [0.6, -0.6, 1e50])
def test_solids_off_the_plane_have_no_cut(shape, height):
    discs, polygon = cut_of(shape, (0.0, 0.0, height))
    assert (len(discs), len(polygon)) == (0, 0)
    assert region_distance(0.0, 0.0, discs, polygon) == EMPTY_DISTANCE
    assert cut_outline(shape, (0.0, 0.0, height), UPRIGHT).shape == (0, 2)


TOUCHING = [
    (Sphere(0.5), 0.5, UPRIGHT),
    (Capsule(0.5, 1.0), 1.5, UPRIGHT),
    (Capsule(0.5, 1.0), 0.5, LYING),
    (Cylinder(0.5, 1.0), -0.5, LYING),
    (Box((0.3, 0.4, 0.5)), 0.5, leaning(math.pi / 2) @ LYING.T),
]


@pytest.mark.parametrize(("shape", "height", "rotation"), TOUCHING)
def test_touching_solids_have_a_cut_around_the_point_of_contact(shape, height, rotation):
    discs, polygon = cut_of(shape, (1.0, 1.0, height), rotation)
    assert region_distance(1.0, 1.0, discs, polygon) == pytest.approx(0.0, abs=1e-7)
    for k in (1.0 - 1e-9, 1.0 + 1e-9):  # a hair inside or outside gives no surprises
        for part in cut_of(shape, (1.0, 1.0, k * height), rotation):
            assert np.all(np.isfinite(part))


sizes = st.floats(-50, 50).map(lambda k: 10.0**k)
extreme_solids = st.one_of(
    st.builds(Sphere, sizes),
    st.builds(Box, st.tuples(sizes, sizes, sizes)),
    st.builds(Capsule, sizes, sizes),
    st.builds(Cylinder, sizes, sizes),
)


@settings(max_examples=300, deadline=5000)
@given(extreme_solids, st.tuples(*[sizes | st.just(0.0)] * 3), strategies.rotations())
def test_extreme_sizes_give_finite_cuts(shape, centre, rotation):
    discs, polygon = cut_of(shape, centre, rotation)
    assert np.all(np.isfinite(discs))
    assert np.all(np.isfinite(polygon))
    assert len(polygon) <= 256
    assert not math.isnan(region_distance(0.1, 0.2, discs, polygon))


def test_planar_shapes_are_not_cut():
    said = refusal(TypeError, cut_outline, Disc(1.0), ORIGIN, UPRIGHT)
    assert said == "only solids are cut (got Disc)"


U_SHAPE = np.array([[0, 0], [3, 0], [3, 3], [2, 3], [2, 1], [1, 1], [1, 3], [0, 3]], dtype=float)


def test_distance_to_a_polygon_that_is_not_convex():
    for point, expected in {
        (0.5, 0.5): -0.5,
        (0.5, 2.0): -0.5,
        (1.5, 2.0): 0.5,  # between the arms of the U
        (1.5, 0.5): -0.5,
        (-3.0, -4.0): 5.0,
        (1.5, 5.0): math.hypot(0.5, 2.0),
        (2.0, 1.0): 0.0,
        (3.0, 1.5): 0.0,
        (1.5, 1.0): 0.0,
    }.items():
        assert polygon_distance(*point, U_SHAPE) == pytest.approx(expected)
        assert polygon_distance(*point, U_SHAPE[::-1].copy()) == pytest.approx(expected)


def test_sign_survives_a_corner_that_is_level_with_the_point_up_to_rounding():
    # 1.5e-17 - 0.5 rounds to -0.5, which made one of two edges miss the ray
    kite = np.array([[0.5, 0.0], [3e-17, 0.5], [-0.125, 1.5e-17], [-9e-17, -0.5]])
    assert polygon_distance(-0.5, 0.0, kite) == 0.375


def winding(point, vertices):
    """Angle that a polygon subtends at a point, in turns."""
    x, y = (vertices - point).T
    angle = np.arctan2(y, x)
    steps = np.roll(angle, -1) - angle
    return round(float(np.sum((steps + math.pi) % (2 * math.pi) - math.pi)) / (2 * math.pi))


@given(strategies.polygons(), strategies.vectors(2, st.floats(-0.6, 0.6)))
def test_sign_is_the_winding_number_and_size_the_nearest_point(polygon, point):
    vertices = np.array(polygon.vertices)
    found = polygon_distance(*point, vertices)
    share = np.linspace(0.0, 1.0, 201)[:, None, None]
    boundary = (1 - share) * vertices + share * np.roll(vertices, -1, axis=0)
    nearest = np.hypot(*(boundary.reshape(-1, 2) - point).T).min()
    assert abs(found) <= nearest + 1e-12
    assert abs(found) == pytest.approx(nearest, abs=3e-3)
    assume(nearest > 1e-6)
    assert (found < 0) == (winding(point, vertices) != 0)


def test_distance_to_what_has_no_area():
    assert polygon_distance(0.0, 0.0, np.empty((0, 2))) == EMPTY_DISTANCE
    assert polygon_distance(3.0, 4.0, np.zeros((1, 2))) == 5.0
    assert polygon_distance(0.5, 2.0, np.array([[0.0, 0.0], [1.0, 0.0]])) == 2.0


def test_distance_to_a_union_is_the_smaller_one():
    discs = np.array([[0.0, 0.0, 1.0], [10.0, 0.0, 2.0]])
    square = np.array([[4.0, -1.0], [6.0, -1.0], [6.0, 1.0], [4.0, 1.0]])
    expected = {0.0: -1.0, 1.5: 0.5, 3.0: 1.0, 5.0: -1.0, 7.5: 0.5, 9.0: -1.0}
    for x, distance in expected.items():
        assert region_distance(x, 0.0, discs, square) == pytest.approx(distance)
