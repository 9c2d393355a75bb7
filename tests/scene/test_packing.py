"""Where bodies are: motion laws against closed forms, series and an integrator of our own."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from gcm_learn import seeding, situation as records
from gcm_learn.arms import Arm, rotation_of
from gcm_learn.errors import SituationError
from gcm_learn.families.random_solid import random_rotation, random_solid
from gcm_learn.scene import bodies as k
from gcm_learn.scene.packing import pack_bodies, pose
from tests import strategies
from tests.planar_geometry import place
from tests.transforms import carried

WORLD = records.Plane((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
ARM = Arm((1.0, 0.5), 1.0)
TRIANGLE = records.Polygon(((-0.1, -0.1), (0.3, -0.1), (-0.1, 0.2)))
AXIS, DOWN = (0.0, 1.0, 0.0), (0.0, 0.0, -1.0)


def solid_scene(motion, shape=None, horizon=2.0, plane=WORLD):
    """Return a 3D situation of one body, a target."""
    body = records.Body("target", "body", shape or records.Cylinder(0.1, 0.2), motion)
    return records.Situation("scene", horizon, ARM, (body,), plane)


def swing(**changes):
    """Return a pendulum of one second's length or so; angles grow about the y axis."""
    given = {"length": 1.0, "gravity": 10.0, "angle": 0.0, "rate": 0.0}
    return records.Pendulum((0.0, 0.0, 0.0), AXIS, DOWN, **{**given, **changes})


def angle_at(motion, t, horizon=None):
    """Angle of a pendulum [rad], as packed, without the wrapping of a pose."""
    bodies = pack_bodies(solid_scene(motion, horizon=horizon or max(t, 0.1)))
    return k.swing_angle(bodies, 0, t)


def exponential(spin, t):
    """exp([spin t]) by its series, after scaling so that 30 terms are plenty."""
    x, y, z = np.asarray(spin) * t / 1024.0
    generator = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    total, term = np.eye(3), np.eye(3)
    for order in range(1, 30):
        term = term @ generator / order
        total = total + term
    for _ in range(10):
        total = total @ total
    return total


@given(strategies.planar_motions, st.floats(0.0, 2.0))
def test_planar_bodies_move_and_turn_as_the_contract_says(motion, t):
    body = records.Body("target", "body", TRIANGLE, motion)
    centre, rotation = pose(records.Situation("scene", 2.0, ARM, (body,)), 0, t)
    law = zip(motion.position, motion.velocity, motion.acceleration, strict=True)
    expected = [p + v * t + 0.5 * a * t * t for p, v, a in law]
    np.testing.assert_allclose(centre, [*expected, 0.0], atol=1e-12)
    turn = motion.angle + motion.spin * t
    np.testing.assert_allclose(rotation[:, 0], [math.cos(turn), math.sin(turn), 0.0], atol=1e-12)
    np.testing.assert_allclose(rotation[:, 2], [0.0, 0.0, 1.0], atol=1e-12)


@given(strategies.solid_quadratics, st.floats(0.0, 2.0))
def test_solids_spin_by_the_matrix_exponential(motion, t):
    centre, rotation = pose(solid_scene(motion), 0, t)
    law = zip(motion.position, motion.velocity, motion.acceleration, strict=True)
    expected = [p + v * t + 0.5 * a * t * t for p, v, a in law]
    np.testing.assert_allclose(centre, expected, atol=1e-12)
    turned = exponential(motion.spin, t) @ rotation_of(motion.orientation)
    np.testing.assert_allclose(rotation, turned, atol=1e-10)


@given(strategies.unit_vectors(4), strategies.vectors(3))
def test_a_quaternion_turns_vectors_by_its_sandwich(quaternion, vector):
    def product(p, q):
        real = p[0] * q[0] - p[1:] @ q[1:]
        return np.array([real, *(p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:]))])

    q = np.array(quaternion)
    turned = product(product(q, np.array([0.0, *vector])), q * (1.0, -1.0, -1.0, -1.0))
    np.testing.assert_allclose(rotation_of(quaternion) @ vector, turned[1:], atol=1e-12)


def test_round_bodies_are_not_turned():
    spinning = records.SolidQuadratic((1.0, 0.0, 0.0), (0.0,) * 3, (0.0,) * 3, spin=(1.0, 2.0, 3.0))
    situation = solid_scene(spinning, records.Sphere(0.2))
    np.testing.assert_array_equal(pose(situation, 0, 1.0)[1], np.eye(3))
    assert pack_bodies(situation).rows[0, k.TOP_SPEED] == 0.0
    disc = records.Body(
        "target",
        "disc",
        records.Disc(0.2),
        records.PlanarQuadratic((1, 0), (0, 0), (0, 0), 0.5, 9.0),
    )
    assert pack_bodies(records.Situation("scene", 1.0, ARM, (disc,))).rows[0, k.TOP_SPEED] == 0.0


@settings(max_examples=25)
@given(strategies.pendulums(), st.floats(0.01, 2.0))
def test_pendulums_follow_their_equation(motion, t):
    """Against Taylor steps of third order in the angle, and smaller ones until nothing changes."""
    stiffness = motion.gravity / motion.length

    def integrate(steps):
        h, x, v = t / steps, motion.angle, motion.rate
        for _ in range(steps):
            a = -stiffness * math.sin(x) - motion.damping * v
            jerk = -stiffness * math.cos(x) * v - motion.damping * a
            snap = -stiffness * (math.cos(x) * a - math.sin(x) * v * v) - motion.damping * jerk
            x += h * (v + h / 2 * (a + h / 3 * (jerk + h / 4 * snap)))
            v += h * (a + h / 2 * (jerk + h / 3 * snap))
        return x

    coarse, fine = integrate(1500), integrate(3000)
    extrapolated = fine + (fine - coarse) / 7.0
    assert angle_at(motion, t) == pytest.approx(extrapolated, abs=3e-7)


@pytest.mark.parametrize("damping", [0.0, 0.7])
def test_small_swings_are_harmonic(damping):
    small, omega = 1e-4, math.sqrt(10.0 / 1.6)
    motion = swing(length=1.6, angle=small, damping=damping)
    slow = math.sqrt(omega**2 - 0.25 * damping**2)
    for t in (0.1, 0.7, 1.9):
        swinging = math.cos(slow * t) + 0.5 * damping / slow * math.sin(slow * t)
        expected = small * math.exp(-0.5 * damping * t) * swinging
        assert angle_at(motion, t, 2.0) == pytest.approx(expected, abs=1e-8 * small + 1e-12)


@pytest.mark.parametrize("amplitude", [0.5, 1.5, 2.9])
def test_large_swings_have_the_period_of_the_elliptic_integral(amplitude):
    a, b = 1.0, math.cos(0.5 * amplitude)
    for _ in range(30):  # Gauss: T = 2 pi / omega / agm(1, cos(amplitude / 2))
        a, b = 0.5 * (a + b), math.sqrt(a * b)
    period = 2.0 * math.pi / math.sqrt(10.0) / a
    motion = swing(angle=amplitude)
    assert angle_at(motion, period) == pytest.approx(amplitude, abs=1e-9)
    assert angle_at(motion, 0.5 * period, period) == pytest.approx(-amplitude, abs=1e-9)
    assert angle_at(motion, 0.25 * period, period) == pytest.approx(0.0, abs=1e-8)


@given(st.floats(-3.0, 3.0), st.floats(-8.0, 8.0))
def test_an_undamped_pendulum_keeps_its_energy(angle, rate):
    bodies = pack_bodies(solid_scene(swing(angle=angle, rate=rate), horizon=5.0))
    table = bodies.angles[0]
    energy = 0.5 * table[:, 1] ** 2 - 10.0 * np.cos(table[:, 0])
    assert np.ptp(energy) < 1e-8
    # The table is one of states at its time steps: its rates are the slopes of its angles.
    slopes = (table[2:, 0] - table[:-2, 0]) / (2.0 * bodies.angle_step)
    assert np.abs(slopes - table[1:-1, 1]).max() < 1e-3


def test_a_damped_pendulum_loses_energy():
    table = pack_bodies(solid_scene(swing(angle=2.0, damping=0.5), horizon=5.0)).angles[0]
    energy = 0.5 * table[:, 1] ** 2 - 10.0 * np.cos(table[:, 0])
    assert (np.diff(energy) < 0.0).all() and energy[-1] < energy[0] - 5.0


def test_without_gravity_a_pendulum_turns_freely():
    assert angle_at(swing(gravity=0.0, rate=3.0), 1.7) == pytest.approx(5.1, abs=1e-10)
    braked = swing(gravity=0.0, rate=3.0, damping=2.0)
    assert angle_at(braked, 1.7) == pytest.approx(1.5 * (1.0 - math.exp(-3.4)), abs=1e-9)


def test_a_pendulum_hangs_from_its_pivot_along_its_cord():
    motion = replace(swing(angle=0.3, hang=0.8), pivot=(0.1, 0.2, 2.0))
    centre, rotation = pose(solid_scene(motion), 0, 0.0)
    # A right-handed turn about +y carries "down" (-z) towards -x.
    cord = np.array([-math.sin(0.3), 0.0, -math.cos(0.3)])
    np.testing.assert_allclose(rotation[:, 2], cord, atol=1e-12)
    np.testing.assert_allclose(centre, (0.1, 0.2, 2.0) + 0.8 * cord, atol=1e-12)
    np.testing.assert_allclose(rotation[:, 1], AXIS, atol=1e-12)


@settings(max_examples=40)
@given(strategies.pendulums(), st.floats(0.0, 1.0))
def test_pendulum_frames_are_rotations_with_z_along_the_cord(motion, t):
    centre, rotation = pose(solid_scene(motion, horizon=1.0), 0, t)
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-9)
    assert np.linalg.det(rotation) == pytest.approx(1.0, abs=1e-9)
    cord = centre - np.array(motion.pivot)
    np.testing.assert_allclose(cord, motion.hang_distance * rotation[:, 2], atol=1e-9)
    assert abs(rotation[:, 2] @ np.array(motion.axis)) < 1e-9


def test_a_cord_is_a_capsule_that_hangs_by_half_its_length():
    motion = swing(angle=0.7, hang=0.5)
    centre, rotation = pose(solid_scene(motion, records.Capsule(0.01, 0.5)), 0, 0.3)
    ends = centre + np.outer([-0.5, 0.5], rotation[:, 2])
    np.testing.assert_allclose(ends[0], motion.pivot, atol=1e-12)
    assert np.linalg.norm(ends[1]) == pytest.approx(1.0)


def test_a_pendulum_too_fast_for_its_horizon_is_refused_with_both_numbers():
    with pytest.raises(SituationError, match=r"horizon: 2 s .*1000"):
        pack_bodies(solid_scene(swing(length=1e-6, gravity=1e6), horizon=2.0))


@pytest.mark.parametrize("seed", range(6))
def test_carrying_scene_and_plane_together_changes_no_pose(seed):
    rng = seeding.rng(3, seed)
    situation = random_solid(rng)
    there = carried(situation, random_rotation(rng), rng.uniform(-5.0, 5.0, 3))
    for b in range(len(situation.bodies)):
        for t in (0.0, 0.4, 1.0):
            for here, after in zip(pose(situation, b, t), pose(there, b, t), strict=True):
                np.testing.assert_allclose(after, here, atol=1e-9)


def test_the_plane_gives_the_coordinates():
    plane = records.Plane((1.0, 2.0, 3.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))  # normal is world x
    motion = records.SolidQuadratic(
        (1.5, 2.1, 3.2), (0.0, 0.3, 0.0), (0.0, 0.0, 0.4), spin=(0, 0, 2.0)
    )
    centre, rotation = pose(solid_scene(motion, plane=plane), 0, 1.0)
    np.testing.assert_allclose(centre, (0.4, 0.4, 0.5), atol=1e-12)
    # The body's z axis is the world's, which is the plane's y.
    np.testing.assert_allclose(rotation[:, 2], (0.0, 1.0, 0.0), atol=1e-12)
    assert np.linalg.det(rotation) == pytest.approx(1.0)


@pytest.mark.parametrize("seed", range(8))
def test_poses_are_those_of_the_referee(seed):
    situation = random_solid(seeding.rng(4, seed))
    for b, body in enumerate(situation.bodies):
        for t in (0.0, 0.37, 1.0):
            centre, rotation = pose(situation, b, t)
            expected = place(situation, body, np.array([t]))
            np.testing.assert_allclose(centre, expected[0][0], atol=1e-7)
            if not isinstance(body.shape, records.Sphere):
                np.testing.assert_allclose(rotation, expected[1][0], atol=1e-7)


def test_rows_follow_the_order_of_the_bodies():
    still = records.PlanarQuadratic((1.0, 0.0), (0.0, 0.0), (0.0, 0.0))
    square = records.Polygon(((0, 0), (1, 0), (1, 1), (0, 1)))
    roles, shapes = ("obstacle", "target", "obstacle"), (TRIANGLE, records.Disc(0.2), square)
    bodies = [records.Body(*given, still) for given in zip(roles, "abc", shapes, strict=True)]
    packed = pack_bodies(records.Situation("scene", 1.0, ARM, bodies))
    assert packed.rows[:, k.KIND].tolist() == [k.POLYGON, k.DISC, k.POLYGON]
    assert packed.rows[:, k.PART].tolist() == [k.LIMB, k.HAND, k.LIMB]
    slices = packed.rows[:, [k.FIRST, k.LAST]].astype(int)
    np.testing.assert_array_equal(packed.vertices[slice(*slices[0])], TRIANGLE.vertices)
    np.testing.assert_array_equal(packed.vertices[slice(*slices[2])], square.vertices)
    assert slices[1, 0] == slices[1, 1]
