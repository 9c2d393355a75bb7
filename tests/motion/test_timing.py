"""From ways to timed movements: limits, samples, interceptions."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, strategies as st

from gcm_learn import seeding
from gcm_learn.arms import Arm, forward, joint_angles
from gcm_learn.families.random_planar import random_planar
from gcm_learn.families.random_solid import random_solid
from gcm_learn.motion import Movement, timing
from gcm_learn.motion.interception import first_catch, first_interception, may_be_reached
from gcm_learn.motion.rules import Rules
from gcm_learn.scene.bodies import poses_at
from gcm_learn.scene.packing import pack, pack_bodies
from gcm_learn.scene.shapes.choice import gap_in_plane
from gcm_learn.scene.shapes.region import EMPTY_DISTANCE
from tests.planar_geometry import depths, place, point_distances, rates

FAMILIES = {"planar": random_planar, "solid": random_solid}
pairs = st.tuples(st.floats(-1.2, 1.2), st.floats(-1.2, 1.2))


def wandering(seed, n=20):
    """Hand path (n, 2) well inside the ring of rho = 1."""
    rng = seeding.rng(91, seed)
    angle = np.cumsum(rng.uniform(-0.2, 0.2, n))
    radius = rng.uniform(0.5, 1.6) + np.cumsum(rng.uniform(-0.01, 0.01, n))
    return radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)


@given(st.integers(0, 10**6), st.lists(st.floats(0.0, 3.0), min_size=20, max_size=20))
def test_times_are_the_wanted_ones_unless_the_hand_is_too_slow(seed, wanted):
    hand, wanted = wandering(seed), np.array(wanted)
    arm = Arm(tuple(hand[0]), 2.0)
    time, least = timing.keep_limits(arm, hand, wanted), timing.segment_times(arm, hand)
    assert time[0] == 0.0
    spans = np.diff(time)
    assert (spans >= least * (1.0 - 1e-9) - 1e-12).all()
    assert (time[1:] >= wanted[1:] - 1e-12).all()
    # Each time is the wanted one or as soon after the one before as can be.
    tight = np.abs(spans - least) < 1e-9
    assert (tight | (np.abs(time[1:] - wanted[1:]) < 1e-9)).all()


@given(st.integers(0, 10**6))
def test_segments_take_as_long_as_their_slowest_joint(seed):
    hand = wandering(seed)
    steps = np.linalg.norm(np.diff(hand, axis=0), axis=1)
    np.testing.assert_allclose(
        timing.segment_times(Arm(tuple(hand[0]), 2.0), hand), steps / 2.0, rtol=1e-6
    )
    arm = Arm(tuple(hand[0]), 1e6, max_joint_speed=(1.0, 2.0))
    path = Movement.of_hand(arm, np.arange(20.0), hand)  # a second for every segment
    slowest = (rates(arm, path) / arm.max_joint_speed).max(axis=1)
    least = timing.segment_times(arm, hand)
    assert (least >= slowest * (1.0 - 1e-9)).all()
    assert (least <= 1.1 * slowest + 1e-5).all()


@given(pairs, pairs)
def test_a_straight_way_is_straight_and_dense(start, end):
    way = timing.straight_path(np.array(start), np.array(end))
    assert tuple(way[0]) == start
    np.testing.assert_allclose(way[-1], end, atol=1e-12)
    steps = np.diff(way, axis=0)
    assert np.linalg.norm(steps, axis=1).max() <= 0.02 + 1e-12
    np.testing.assert_allclose(steps, np.tile(steps[0], (len(steps), 1)), atol=1e-12)


@given(st.integers(0, 10_000))
def test_a_path_spread_is_the_same_movement(seed):
    """Against two interpolations; waits keep both ends, a sample that is there twice goes."""
    r = seeding.rng(seed, 5)
    moves, gaps = r.normal(0.0, 0.03, (12, 2)), r.uniform(0.0, 0.1, 12)
    moves[r.random(12) < 0.3] = 0.0
    gaps[r.random(12) < 0.3] = 0.0
    hand, time = np.cumsum(moves, axis=0), np.cumsum(gaps)
    new_time, new_hand = timing.spread(time, hand, timing.SPACING)
    pieces = np.ceil(np.hypot(*np.diff(hand, axis=0).T) / timing.SPACING)
    pieces = np.maximum(pieces, np.diff(time) > 0.0).astype(int)
    ends = np.concatenate([[0], np.cumsum(pieces)])
    at = np.interp(np.arange(ends[-1] + 1), ends, np.arange(12))
    for new, old in ((new_time, time), (new_hand[:, 0], hand[:, 0]), (new_hand[:, 1], hand[:, 1])):
        np.testing.assert_array_equal(new, np.interp(at, np.arange(12), old))
    assert np.hypot(*np.diff(new_hand, axis=0).T).max(initial=0.0) <= timing.SPACING * (1.0 + 1e-9)


@given(st.integers(0, 10**6), st.sampled_from(["right", "left"]))
def test_refined_samples_keep_linear_joints_on_the_way(seed, elbow):
    hand = wandering(seed)[::4]
    time = np.linspace(0.0, 1.0, len(hand))
    fine_time, fine = timing.refine(Arm(tuple(hand[0]), 1.0, elbow=elbow), time, hand)
    for t, h in zip(time, hand, strict=True):
        assert np.abs(fine - h).sum(axis=1).min() < 1e-12 and np.abs(fine_time - t).min() < 1e-12
    for k in (0, 1):  # nothing but samples has been added
        np.testing.assert_allclose(fine[:, k], np.interp(fine_time, time, hand[:, k]), atol=1e-12)
    joints = joint_angles(fine, 1.0, elbow)
    halfway = forward(0.5 * (joints[1:] + joints[:-1]))
    astray = np.linalg.norm(halfway - 0.5 * (fine[1:] + fine[:-1]), axis=1)
    assert astray.max() < 1.5e-4


# --- interception ----------------------------------------------------------------------------


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("seed", range(10))
def test_the_distance_to_a_target_is_that_to_its_cut(family, seed):
    """Below it, all points of the plane are outside of the body; at it, one is inside."""
    rng = seeding.rng(92, seed)
    situation = FAMILIES[family](rng)
    bodies, poses = pack_bodies(situation), np.zeros((len(situation.bodies), 12))
    t = float(rng.uniform(0.0, situation.horizon))
    poses_at(bodies, t, poses)
    circle = np.linspace(0.0, 2.0 * np.pi, 2000)
    circle = np.stack([np.cos(circle), np.sin(circle)], axis=1)
    for b, body in enumerate(situation.bodies):
        centre, rotation = (part[0] for part in place(situation, body, np.array([t])))
        for _ in range(5):
            hand = centre[:2] + rng.uniform(-0.5, 0.5, 2)
            d = gap_in_plane(bodies, poses, b, *hand)
            if d >= EMPTY_DISTANCE:
                grid = rng.uniform(-1.0, 1.0, (4000, 2)) * body.shape.bounding_radius
                away = point_distances(body.shape, (centre, rotation), centre[:2] + grid)
                assert away.min() > 0.0
                continue
            around = [hand + share * max(d, 0.0) * circle for share in (0.5, 0.9, 0.995)]
            if d > 1e-3:
                inner = point_distances(body.shape, (centre, rotation), np.concatenate(around))
                assert inner.min() > 0.0
                outer = hand + (d + 1e-3) * circle
                assert point_distances(body.shape, (centre, rotation), outer).min() < 2e-3
            elif d < -1e-6:
                assert point_distances(body.shape, (centre, rotation), hand[None])[0] == 0.0


def sampled_room(situation, b, hands, times):
    """Distances (n,) of hands to the target's solid, which bound those to its cut from below."""
    body = situation.bodies[b]
    centres, rotations = place(situation, body, times)
    if situation.plane is None:
        poses = zip(centres, rotations, strict=True)
        return np.array(
            [point_distances(body.shape, p, h[None])[0] for p, h in zip(poses, hands, strict=True)]
        )
    spatial = np.concatenate([hands, np.zeros((len(hands), 1))], axis=1) - centres
    return np.maximum(depths(body.shape, np.einsum("nij,ni->nj", rotations, spatial)), 0.0)


@pytest.mark.parametrize("seed", range(25))
def test_the_first_catch_along_a_path_is_the_first_sampled_one(seed):
    rng = seeding.rng(93, seed)
    situation = random_planar(rng, (1, 2))
    # A path that passes the target at some moment.
    target = situation.bodies[0]
    meeting = rng.uniform(0.2, 1.0)
    met = place(situation, target, np.array([meeting]))[0][0, :2]
    time = np.array([0.0, 0.5 * meeting, meeting, 1.2])
    hand = np.array([[1.0, 0.2], rng.uniform(-1.0, 1.0, 2), met, rng.uniform(-1.0, 1.0, 2)])
    bodies = pack_bodies(situation)
    t, b = first_catch(bodies, time, hand, 0.05, 1e-4)
    times = np.linspace(0.0, 1.2, 6001)
    hands = np.stack([np.interp(times, time, hand[:, k]) for k in (0, 1)], axis=1)
    room = sampled_room(situation, 0, hands, times)
    first = times[np.flatnonzero(room <= 0.05)[0]]
    assert b == 0 and t == pytest.approx(first, abs=4e-4)


def test_no_catch_along_a_path_that_passes_by():
    situation = random_planar(seeding.rng(93, 0), (1, 1))
    far = np.array([[50.0, 0.0], [51.0, 0.0]])
    assert first_catch(pack_bodies(situation), np.array([0.0, 1.0]), far, 0.05, 1e-4) == (-1.0, -1)


@pytest.mark.parametrize("seed", range(25))
def test_the_first_interception_is_the_first_there_is(seed):
    """Discs in free space: the hand can meet the disc as soon as it can cover the gap."""
    rng = seeding.rng(94, seed)
    situation = random_planar(rng, (1, 1))
    scene, arm = pack(situation), situation.arm
    reach, speed = 0.05, arm.max_hand_speed
    rules = Rules(touch=0.0, catch=reach, speed=speed, instant=2e-4)
    t, b, px, py = first_interception(scene, rules, *arm.hand, 0.0, 0.0, 1.2)
    times = np.linspace(0.0, 1.2, 6001)
    centre = place(situation, situation.bodies[0], times)[0][:, :2]
    gap = situation.bodies[0].shape.radius + reach
    away = np.linalg.norm(centre - arm.hand, axis=1)
    radius = np.linalg.norm(centre, axis=1)
    can = away - gap <= speed * times
    # Only where the ring surely does not matter.
    sure = can & (radius < arm.reach) & (radius > arm.inner_reach + gap)
    if b < 0:
        assert not sure.any()
        return
    met = np.interp(t, times, centre[:, 0]), np.interp(t, times, centre[:, 1])
    assert math.dist(met, (px, py)) <= gap + 1e-4
    assert math.dist(arm.hand, (px, py)) <= speed * t + 1e-9
    assert arm.inner_reach - 1e-9 <= math.hypot(px, py) <= arm.reach + 1e-9
    assert t >= times[np.flatnonzero(can)[0]] - 1e-3
    if sure.any():
        assert t <= times[np.flatnonzero(sure)[0]] + 1e-3


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("seed", range(40))
def test_hopeless_is_certain(family, seed):
    situation = FAMILIES[family](seeding.rng(95, seed))
    arm, end = situation.arm, situation.horizon
    hopeful = may_be_reached(pack(situation))
    times = np.linspace(0.0, end, 2000)
    still = np.tile(arm.hand, (2000, 1))
    way = sampled_room(situation, 0, still, times) - arm.grasp - arm.max_hand_speed * times
    ring = sampled_room(situation, 0, np.zeros((2000, 2)), times) - arm.grasp - arm.reach
    possible = ((way <= 0.0) & (ring <= 0.0)).any()
    assert hopeful or not possible
    nearly = ((way <= 0.05) & (ring <= 0.05)).any()
    assert nearly or not hopeful  # and hope is given up when there is none
