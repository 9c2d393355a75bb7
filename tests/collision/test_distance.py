"""Kernels of moving bodies: distances against brute force, bounds against sampled motion."""

import math

import numpy as np
import pytest
from hypothesis import example, given, strategies as st

from gcm_learn.arms import Arm
from gcm_learn.collision import distance
from gcm_learn.families.random_solid import random_rotation
from gcm_learn.scene import bodies as k
from gcm_learn.scene.packing import pack_bodies
from gcm_learn.scene.shapes.polygon import segments_cross
from gcm_learn.situation import (
    Body,
    Box,
    Capsule,
    Cylinder,
    Disc,
    PlanarQuadratic,
    Plane,
    Polygon,
    Situation,
    SolidQuadratic,
    Sphere,
)
from tests import strategies
from tests.planar_geometry import point_distances, segment_distances
from tests.worlds import flight

FLAT = Plane((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
STILL2, STILL3 = (0.0, 0.0), (0.0, 0.0, 0.0)
SOLIDS = [Sphere(0.3), Box((0.1, 0.2, 0.3)), Capsule(0.1, 0.3), Cylinder(0.25, 0.15)]
BENT = Polygon(((-0.3, -0.3), (0.3, -0.3), (0.3, 0.3), (0.2, -0.1), (-0.2, -0.1), (-0.3, 0.3)))
PLANAR = [Disc(0.3), BENT]


def scene(shape, motion=None, role="obstacle"):
    """Return a situation whose body 1 has the shape, at rest in the origin by default."""
    if isinstance(shape, Disc | Polygon):
        rest, plane, ball = PlanarQuadratic(STILL2, STILL2, STILL2), None, Disc(0.1)
    else:
        rest, plane, ball = SolidQuadratic(STILL3, STILL3, STILL3), FLAT, Sphere(0.1)
    bodies = (Body("target", "ball", ball, rest), Body(role, "body", shape, motion or rest))
    return Situation("scene", 1.0, Arm((1.0, 0.5), 1.0), bodies, plane)


def kernel_distance(shape, pose, a, b):
    """Distance of segment a-b to the shape at a pose (centre, rotation), by the kernel."""
    row = np.zeros((2, 12))
    row[1, :3], row[1, 3:] = pose[0], np.ravel(pose[1])
    return distance.segment_distance(pack_bodies(scene(shape)), row, 1, *a, *b)


def sampled_distance(shape, pose, a, b):
    """Return the same by brute force: points on the segment, then ever more of them where nearest.

    The distance to a convex body is convex along the segment, so the nearest is between the
    neighbours of the nearest sample.
    """
    low, high = 0.0, 1.0
    for _ in range(4):
        s = np.linspace(low, high, 401)
        d = point_distances(shape, pose, np.asarray(a) + s[:, None] * np.subtract(b, a))
        best = int(d.argmin())
        low, high = s[max(best - 1, 0)], s[min(best + 1, 400)]
    return d[best]


points = st.tuples(st.floats(-1.2, 1.2), st.floats(-1.2, 1.2))
corners = points | st.sampled_from([(0.0, 0.0), (1.0, 0.0), (0.0, -1.0), (0.1, 0.2)])


@given(
    strategies.solid_shapes | strategies.discs,
    strategies.rotations(),
    st.tuples(*[st.floats(-0.8, 0.8) | st.just(0.0)] * 3),
    corners,
    corners,
)
def test_distance_to_convex_bodies_is_that_of_brute_force(shape, rotation, centre, a, b):
    if isinstance(shape, Disc):
        rotation, centre = np.eye(3), (*centre[:2], 0.0)
    pose = np.array(centre), rotation
    expected = sampled_distance(shape, pose, a, b)
    assert kernel_distance(shape, pose, a, b) == pytest.approx(expected, abs=2e-7)


@given(strategies.polygons(), strategies.angles, points, corners, corners)
@example(BENT, 0.0, (0.0, 0.0), (0.0, 0.0), (0.0, 1.0))  # from the bay of the U
@example(BENT, 0.0, (0.0, 0.0), (0.0, 0.0), (0.0, -1.0))
@example(BENT, 0.0, (0.0, 0.0), (-1.0, -0.2), (1.0, -0.2))  # right through
def test_distance_to_polygons_is_that_of_brute_force(shape, angle, centre, a, b):
    c, s = math.cos(angle), math.sin(angle)
    pose = np.array([*centre, 0.0]), np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    found = kernel_distance(shape, pose, a, b)
    share = np.linspace(0.0, 1.0, 2001)[:, None]
    sampled = point_distances(shape, pose, np.asarray(a) + share * np.subtract(b, a)).min()
    spacing = math.dist(a, b) / 2000
    assert sampled - 0.5 * spacing - 1e-9 <= found <= sampled + 1e-9
    expected = segment_distances(shape, (pose[0], pose[1][None]), np.array([a]), np.array([b]))
    assert found == pytest.approx(expected[0], abs=1e-9)


@pytest.mark.parametrize("shape", SOLIDS + PLANAR, ids=lambda s: s.kind)
def test_a_segment_that_pierces_or_lies_inside_has_distance_zero(shape):
    pose, depth = (np.zeros(3), np.eye(3)), -0.05 if isinstance(shape, Capsule) else -0.15
    assert kernel_distance(shape, pose, (-1.0, depth), (1.0, depth)) == 0.0
    assert kernel_distance(shape, pose, (-0.02, depth), (0.02, depth - 0.01)) == 0.0
    assert kernel_distance(shape, pose, (0.0, depth), (0.0, depth)) == 0.0
    assert kernel_distance(shape, pose, (-1.0, depth - 0.5), (1.0, depth - 0.5)) > 0.2


BY_HAND = [
    (Sphere(0.3), (1.0, 0.5, 0.4), math.hypot(0.5, 0.4) - 0.3),
    (Box((0.1, 0.2, 0.3)), (1.0, 0.5, 0.7), math.hypot(0.3, 0.4)),
    (Box((0.1, 0.2, 0.3)), (2.5, 0.0, 0.0), 0.4),
    (Capsule(0.1, 0.3), (1.0, 0.5, 0.7), math.hypot(0.5, 0.4) - 0.1),
    (Cylinder(0.1, 0.3), (1.0, 0.5, 0.7), math.hypot(0.4, 0.4)),
    (Disc(0.3), (1.0, 0.5, 0.0), 0.2),
    (BENT, (1.0, 0.5, 0.0), 0.2),
]


@pytest.mark.parametrize(("shape", "place", "expected"), BY_HAND)
def test_distance_to_the_x_axis_by_hand(shape, place, expected):
    found = kernel_distance(shape, (np.array(place), np.eye(3)), (0.0, 0.0), (2.0, 0.0))
    assert found == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("shape", SOLIDS + PLANAR, ids=lambda s: s.kind)
def test_a_segment_of_no_length_is_a_point(shape, rng):
    for _ in range(50):
        planar = isinstance(shape, Disc | Polygon)
        rotation = np.eye(3) if planar else random_rotation(rng)
        pose = rng.uniform(-0.5, 0.5, 3) * (1.0, 1.0, 0.0 if planar else 1.0), rotation
        at = rng.uniform(-1.0, 1.0, (1, 2))
        expected = point_distances(shape, pose, at)[0]
        assert kernel_distance(shape, pose, at[0], at[0]) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("shape", SOLIDS + PLANAR, ids=lambda s: s.kind)
def test_an_obstacle_meets_the_limb_and_a_target_the_hand(shape):
    hand, elbow = (1.0, 0.9), (1.0, -0.1)
    motion = PlanarQuadratic((0.5, 1.0), STILL2, STILL2)
    if not isinstance(shape, Disc | Polygon):
        motion = SolidQuadratic((0.5, 1.0, 0.1), STILL3, STILL3)
    rows = np.zeros((2, 12))
    found = {}
    for role in ("obstacle", "target"):
        bodies = pack_bodies(scene(shape, motion, role))
        k.poses_at(bodies, 0.0, rows)
        found[role] = distance.arm_distance(bodies, rows, 1, *hand, *elbow)
    pose = rows[1, :3], rows[1, 3:].reshape(3, 3)
    if isinstance(shape, Disc | Sphere):
        pose = pose[0], np.eye(3)
    forearm = sampled_distance(shape, pose, elbow, hand)
    upper_arm = sampled_distance(shape, pose, (0.0, 0.0), elbow)
    assert found["obstacle"] == pytest.approx(min(forearm, upper_arm), abs=1e-6)
    assert found["target"] == pytest.approx(sampled_distance(shape, pose, hand, hand), abs=1e-6)


def test_segments_cross_only_properly():
    assert segments_cross(0.0, 0.0, 1.0, 1.0, 0.0, 1.0, 1.0, 0.0)
    assert not segments_cross(0.0, 0.0, 1.0, 1.0, 2.0, 3.0, 3.0, 2.0)
    assert not segments_cross(0.0, 0.0, 1.0, 0.0, 0.5, 0.0, 0.5, 1.0)  # one only touches
    assert not segments_cross(0.0, 0.0, 1.0, 0.0, 0.2, 0.0, 2.0, 0.0)  # in one line


def poses_of(bodies, b, times):
    """Centres (n, 3) and rotations (n, 3, 3) of body b."""
    rows = np.zeros((len(times), bodies.rows.shape[0], 12))
    for row, t in zip(rows, times, strict=True):
        row[b, 3:] = np.eye(3).ravel()
        k.pose_at(bodies, b, t, row)
    return rows[:, b, :3], rows[:, b, 3:].reshape(-1, 3, 3)


def farthest_points(situation, b):
    """Points of body b (m, 3), in its frame, that move fastest or far."""
    reach = situation.bodies[b].shape.bounding_radius
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    if not situation.is_solid:
        axes = axes[[0, 1, 3, 4]]
    return reach * np.concatenate([axes, np.zeros((1, 3))])


@given(strategies.situations(), st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_drift_and_top_speed_bound_every_point_of_a_body(situation, start, stop):
    bodies = pack_bodies(situation)
    t0, t1 = (situation.horizon * s for s in sorted((start, stop)))
    times = np.linspace(t0, t1, 33)
    for b in range(len(situation.bodies)):
        centre, rotation = poses_of(bodies, b, times)
        tracks = centre[:, None] + np.einsum("nij,mj->nmi", rotation, farthest_points(situation, b))
        steps = np.linalg.norm(np.diff(tracks, axis=0), axis=2)  # chords: not above the way itself
        way = steps.sum(axis=0).max()
        assert way <= k.drift(bodies, b, t0, t1) * (1.0 + 1e-5) + 1e-12
        spans = np.diff(times)[:, None]
        assert (steps <= bodies.rows[b, k.TOP_SPEED] * spans * (1.0 + 1e-5) + 1e-12).all()


def test_drift_is_not_wasteful():
    """A bound that is always huge would bound as well: here it has to be sharp."""
    bodies = pack_bodies(scene(Sphere(0.1), flight(STILL3, (3.0, 0.0, 0.0))))
    assert k.drift(bodies, 1, 0.2, 0.6) == pytest.approx(1.2)
    assert bodies.rows[1, k.TOP_SPEED] == pytest.approx(3.0)
    bodies = pack_bodies(scene(Sphere(0.1), flight(STILL3, STILL3, (0.0, 0.0, -10.0))))
    assert k.drift(bodies, 1, 0.0, 0.1) == pytest.approx(0.1 * 1.0)
    bodies = pack_bodies(scene(Box((0.3, 0.4, 1.2)), flight(STILL3, spin=(0.0, 0.0, 4.0))))
    assert bodies.rows[1, k.TOP_SPEED] == pytest.approx(4.0 * 1.3)
