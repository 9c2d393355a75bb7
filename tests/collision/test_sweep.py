"""The continuous clearance against brute force, closed forms and bodies in a hurry."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, example, given, settings, strategies as st

from gcm_learn import seeding
from gcm_learn.arms import Arm
from gcm_learn.collision.sweep import Sweep, least_in_segment, limb_sweep
from gcm_learn.families.random_planar import random_planar
from gcm_learn.families.random_solid import random_shape, random_solid
from gcm_learn.motion import Movement
from gcm_learn.motion.verification import RESOLUTION, clearance
from gcm_learn.scene.packing import pack
from gcm_learn.situation import (
    Body,
    Box,
    Capsule,
    Cylinder,
    Disc,
    PlanarQuadratic,
    Plane,
    Polygon,
    Sphere,
)
from tests import strategies
from tests.planar_geometry import by_hand, elbow_of, limb_distances, nearest
from tests.worlds import among, disc, flight, solid_ball

FLAT = Plane((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
STRETCHED = Arm((2.0, 0.0), 3.0)
BALL = disc("ball", (9.0, 9.0), role="target", radius=0.1)


AWAY = solid_ball("away", (9.0, 9.0, 9.0), role="target", radius=0.1)


def random_path(rng, arm, horizon, samples):
    """Return a wandering path in the ring, not always moving."""
    low, high = abs(arm.upper_arm - 1.0) + 0.1, arm.upper_arm + 0.95
    radius = rng.uniform(low, high, samples)
    angle = rng.uniform(-math.pi, math.pi) + np.cumsum(rng.uniform(-0.5, 0.5, samples))
    hand = radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    rest = rng.random(samples) < 0.2
    rest[0] = False
    for k in np.flatnonzero(rest):
        hand[k] = hand[k - 1]
    time = np.concatenate([[0.0], np.sort(rng.uniform(0.0, horizon, samples - 1))])
    return Movement.of_hand(arm, time, hand)


def brute(situation, path, instants=3000):
    """Smallest distance of the limb to obstacles, less the thickness, by sampling."""
    t = np.unique(np.concatenate([np.linspace(0.0, path.duration, instants), path.time]))
    return (
        nearest(situation, lambda t: by_hand(situation.arm, path, t), t) - situation.arm.thickness
    )


@pytest.mark.parametrize("family", [random_planar, random_solid])
@pytest.mark.parametrize("seed", range(12))
def test_it_is_that_of_brute_force_on_random_paths(family, seed):
    rng = seeding.rng(31, seed)
    situation = family(rng, (2, 4))
    path = random_path(rng, situation.arm, situation.horizon, 12)
    found, when = clearance(situation, path)
    expected = brute(situation, path)
    if expected > 1e-3:
        assert expected - 1e-6 <= found + RESOLUTION and found <= expected + RESOLUTION + 1e-6
        t = np.array([when])
        limb = by_hand(situation.arm, path, t)
        at_when = min(limb_distances(situation, b, limb, t)[0] for b in situation.obstacles)
        assert at_when - situation.arm.thickness == pytest.approx(found, abs=1e-6)
    elif expected <= 0.0:
        assert found <= 0.0
    else:
        assert found <= expected + RESOLUTION


@pytest.mark.parametrize("seed", range(6))
def test_it_is_exact_for_every_kind_of_solid(seed):
    """Solids beside the limb, above and below its plane, spinning: no touch, a true distance."""
    rng = seeding.rng(32, seed)
    arm = Arm((1.2, 0.4), 3.0, thickness=0.01)
    path = random_path(rng, arm, 1.0, 8)
    for shape in (Sphere(0.2), Box((0.1, 0.2, 0.15)), Capsule(0.1, 0.2), Cylinder(0.15, 0.1)):
        height = shape.bounding_radius + rng.uniform(0.05, 0.3)
        place = (*rng.uniform(-1.0, 1.0, 2), height * rng.choice([-1.0, 1.0]))
        velocity, spin = (*rng.uniform(-1.0, 1.0, 2), 0.0), tuple(rng.uniform(-5.0, 5.0, 3))
        obstacle = Body("obstacle", "o", shape, flight(place, velocity, spin=spin))
        situation = among(arm, AWAY, obstacle, plane=FLAT)
        found, _ = clearance(situation, path)
        expected = brute(situation, path)
        assert expected > 0.0
        assert expected - 1e-6 <= found <= expected + RESOLUTION + 1e-6


def scene(*obstacles, arm=STRETCHED):
    """Return a planar situation with these obstacles: pairs of shape and motion."""
    bodies = [Body("obstacle", str(k), *given) for k, given in enumerate(obstacles)]
    return among(arm, BALL, *bodies, horizon=10.0)


def resting(duration=1.0, hand=(2.0, 0.0), samples=2):
    """Return a path that stays; by default with the arm stretched out along x."""
    return Movement.of_hand(
        STRETCHED, np.linspace(0.0, duration, samples), np.tile(hand, (samples, 1))
    )


def still(x, y):
    return PlanarQuadratic((x, y), (0.0, 0.0), (0.0, 0.0))


@pytest.mark.parametrize("seed", range(12))
def test_it_is_that_of_brute_force_for_bodies_at_rest_beside_the_shoulder(seed):
    """The nearest part is the shoulder, or a place on the upper arm, for much of the way."""
    rng = seeding.rng(33, seed)
    arm = Arm((1.2, 0.4), 3.0, upper_arm=rng.uniform(0.8, 1.2))
    path = random_path(rng, arm, 1.0, 10)
    radius, angle = rng.uniform(0.25, 0.6), rng.uniform(-math.pi, math.pi)
    shape = Disc(0.2) if seed % 2 else Polygon(((-0.2, -0.1), (0.2, -0.1), (0.0, 0.0), (0.0, 0.2)))
    there = still(radius * math.cos(angle), radius * math.sin(angle))
    situation = scene((shape, there), arm=arm)
    found, expected = clearance(situation, path)[0], brute(situation, path, 20_000)
    assert expected - 1e-6 <= found + RESOLUTION and found <= max(expected, 0.0) + RESOLUTION + 1e-6


def test_a_limb_that_stays_equally_far_is_not_looked_at_for_ever():
    """The shoulder is nearest all the way, so no look finds less, and bounds have to show it."""
    situation = scene((Disc(0.2), still(-0.5, 0.1)))
    packed, limit = pack(situation), np.hypot(0.5, 0.1) - 0.2
    time, hand = np.array([0.0, 1.0]), np.array([[1.2, -0.8], [1.2, 0.8]])
    poses, stack = np.zeros((2, 12)), np.empty((50, 3))
    work = Sweep(time, hand, 0.0, RESOLUTION, poses, stack)
    least, _, looks = least_in_segment(packed, work, 1, 0, limit, limit, limit, 0.0, 0)
    assert least == limit and 0 < looks < 100  # 4095 by bounds for the whole limb


def test_without_obstacles_it_is_infinite():
    target = disc("t", (1.0, 0.0), role="target", radius=0.3)
    for situation in (scene(), among(STRETCHED, target)):
        assert clearance(situation, resting())[0] == math.inf


def test_at_rest_it_is_the_distance():
    square = Polygon(((-0.1, -0.1), (0.1, -0.1), (0.1, 0.1), (-0.1, 0.1)))
    beside = scene((Disc(0.2), still(0.7, 0.9)))
    assert clearance(beside, resting())[0] == pytest.approx(0.7)
    assert clearance(scene((square, still(1.5, -0.6))), resting())[0] == pytest.approx(0.5)
    thick = replace(beside, arm=replace(STRETCHED, thickness=0.15))
    assert clearance(thick, resting())[0] == pytest.approx(0.55)


def test_a_single_sample_is_judged_where_it_is():
    path = Movement.of_hand(STRETCHED, np.zeros(1), np.array([[2.0, 0.0]]))
    falling = PlanarQuadratic((0.7, 0.9), (0.0, -5.0), (0.0, 0.0))
    assert clearance(scene((Disc(0.2), falling)), path)[0] == pytest.approx(0.7)


def test_a_body_that_turns_back_is_met_at_its_turning_point():
    """Thrown up from below: highest, and nearest, at v / g."""
    motion = PlanarQuadratic((1.3, -2.0), (0.0, 6.0), (0.0, -10.0))
    found, when = clearance(scene((Disc(0.1), motion)), resting(1.2))
    assert found == pytest.approx(2.0 - 36.0 / 20.0 - 0.1, abs=RESOLUTION)
    assert when == pytest.approx(0.6, abs=0.01)


def test_a_spinning_bar_comes_nearest_when_upright():
    bar = Polygon(((-0.5, -0.02), (0.5, -0.02), (0.5, 0.02), (-0.5, 0.02)))
    motion = PlanarQuadratic((1.0, 0.8), (0.0, 0.0), (0.0, 0.0), spin=2.0)
    found, when = clearance(scene((bar, motion)), resting(1.5))
    lowest = math.hypot(0.5, 0.02)  # a corner comes a little lower than the end
    assert found == pytest.approx(0.8 - lowest, abs=RESOLUTION)
    assert 2.0 * when == pytest.approx(math.pi / 2, abs=0.06)


def test_a_hand_that_reaches_over_a_body_is_judged_on_the_way():
    """The elbow swings out: the ends are clear, the middle is not."""
    time, hand = np.array([0.0, 1.0]), np.array([[1.0, 1.0], [1.0, -1.0]])
    path = Movement.of_hand(STRETCHED, time, hand)
    elbow = elbow_of(Arm((1.0, 0.0), 1.0), np.array([[1.0, 0.0]]))[0]
    obstacle = (Disc(0.05), still(*(1.02 * elbow)))
    assert min(clearance(scene(obstacle), resting(hand=h))[0] for h in hand) > 0.05
    assert clearance(scene(obstacle), path)[0] <= 0.0


@given(
    st.floats(0.001, 0.999),
    st.floats(1.0, 1e4),
    st.floats(0.05, 1.95),
    st.floats(-1.2, 1.2),
    st.booleans(),
)
@example(0.5, 1e4, 1.0, 0.0, True)
def test_a_bullet_between_two_samples_is_never_missed(moment, speed, along, slant, below):
    """It crosses the limb at `moment`, and is far off at both samples."""
    direction = np.array([math.sin(slant), -math.cos(slant) if below else math.cos(slant)])
    velocity = speed * direction
    start = np.array([along, 0.0]) - moment * velocity
    motion = PlanarQuadratic(tuple(start), tuple(velocity), (0.0, 0.0))
    found, when = clearance(scene((Disc(1e-4), motion)), resting())
    assert found <= 0.0
    assert abs(when - moment) * speed <= 0.1
    short = Movement.of_hand(STRETCHED, np.array([0.0, 0.9 * moment]), np.tile((2.0, 0.0), (2, 1)))
    if speed * moment * math.cos(slant) > 0.01:
        assert clearance(scene((Disc(1e-4), motion)), short)[0] > 0.0


@settings(max_examples=40)
@given(st.integers(0, 10**6), st.floats(20.0, 500.0))
def test_a_bullet_at_a_moving_limb_is_never_missed(seed, speed):
    rng = seeding.rng(33, seed)
    arm = Arm((1.2, 0.4), 3.0, upper_arm=float(rng.uniform(0.7, 1.4)))
    path = random_path(rng, arm, 1.0, 5)
    moment = rng.uniform(0.0, path.duration)
    hand, elbow = (part[0] for part in by_hand(arm, path, np.array([moment])))
    share = rng.random()
    met = share * elbow if rng.random() < 0.5 else elbow + share * (hand - elbow)
    heading = rng.uniform(-math.pi, math.pi)
    velocity = speed * np.array([math.cos(heading), math.sin(heading)])
    motion = PlanarQuadratic(tuple(met - moment * velocity), tuple(velocity), (0.0, 0.0))
    assert clearance(scene((Disc(1e-4), motion), arm=arm), path)[0] <= 0.0


@settings(max_examples=40)
@given(st.integers(0, 10**6))
def test_a_solid_bullet_through_the_plane_is_never_missed(seed):
    rng = seeding.rng(34, seed)
    arm = Arm((1.2, 0.4), 3.0)
    path = random_path(rng, arm, 1.0, 4)
    moment = rng.uniform(0.0, path.duration)
    hand, elbow = (part[0] for part in by_hand(arm, path, np.array([moment])))
    met = np.array([*(elbow + rng.random() * (hand - elbow)), 0.0])
    velocity = rng.normal(size=3) * 60.0
    motion = flight(met - moment * velocity, velocity, spin=tuple(rng.normal(size=3)))
    bullet = Body("obstacle", "bullet", random_shape(rng, (1e-3, 1e-2)), motion)
    assert clearance(among(arm, AWAY, bullet, plane=FLAT), path)[0] <= 0.0


@pytest.mark.parametrize(("speed", "moment"), [(3.0, 1e-3), (10.0, 3e-4), (30.0, 1e-3)])
def test_a_bullet_at_a_limb_that_starts_from_the_shoulder_is_never_missed(speed, moment):
    """With the hand on the shoulder, any direction of the upper arm is as good as another."""
    path = Movement.of_hand(STRETCHED, np.array([0.0, 0.01]), np.array([[0.0, 0.0], [-0.033, 0.0]]))
    motion = PlanarQuadratic((speed * moment, 0.5), (-speed, 0.0), (0.0, 0.0))
    situation = scene((Disc(1e-4), motion), arm=Arm((0.0, 0.0), 3.3))
    assert brute(situation, path) <= 0.0
    assert clearance(situation, path)[0] <= 0.0


@pytest.mark.parametrize("seed", range(10))
def test_samples_that_add_nothing_change_nothing(seed):
    rng = seeding.rng(35, seed)
    situation = random_planar(rng, (3, 5)) if seed % 2 else random_solid(rng)
    path = random_path(rng, situation.arm, situation.horizon, 9)
    time = np.unique(np.concatenate([path.time, rng.uniform(0.0, path.duration, 100)]))
    finer = Movement.of_hand(situation.arm, time, path.hand_at(time))
    found, _ = clearance(situation, path)
    again, _ = clearance(situation, finer)
    assert (found <= 0.0) == (again <= 0.0)
    if found > 0.0:
        assert again == pytest.approx(found, abs=RESOLUTION + 1e-9)


@given(
    st.floats(0.3, 2.5),
    st.sampled_from(["right", "left"]),
    *[strategies.angles] * 2,
    *[st.floats(0.0, 1.0)] * 2,
)
def test_the_sweep_bounds_the_way_of_every_point_of_the_limb(rho, side, a0, a1, s0, s1):
    inner = abs(rho - 1.0)
    radii = [max(inner + s * (rho + 1.0 - inner), 1e-3) for s in (s0, s1)]
    ends = np.array(
        [(r * math.cos(a), r * math.sin(a)) for r, a in zip(radii, (a0, a1), strict=True)]
    )
    hand = ends[0] + np.linspace(0.0, 1.0, 400)[:, None] * (ends[1] - ends[0])
    assume(np.linalg.norm(hand, axis=1).min() >= inner)
    elbow = elbow_of(Arm((rho, 1.0), 1.0, rho, side), hand)
    bound = limb_sweep(*ends[0], *ends[1], rho)
    for share in (0.25, 0.75, 1.0):
        for points in (share * elbow, elbow + share * (hand - elbow)):
            way = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
            assert way <= bound * (1.0 + 1e-6) + 1e-6


def test_the_sweep_is_sharp_for_a_turn_and_a_stretch():
    """Round the shoulder by a small angle; outwards by a small way."""
    a = 0.01
    turn = limb_sweep(1.5, 0.0, 1.5 * math.cos(a), 1.5 * math.sin(a), 1.0)
    assert 1.5 * a * 0.99 < turn < 1.5 * a * 1.1
    outwards = limb_sweep(1.0, 0.0, 1.01, 0.0, 1.0)
    bend = math.acos(0.5) - math.acos(0.505)
    assert outwards == pytest.approx(max(0.01, bend))
    assert limb_sweep(1.0, 0.2, 1.0, 0.2, 1.0) == 0.0
