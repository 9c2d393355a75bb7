"""Timing under limits of acceleration: dashes to a posture, paths that are tracked."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from gcm_learn.motion import Movement
from gcm_learn.motion.acceleration import braked, dash, tracked
from gcm_learn.scene import pack
from tests.motion.test_joint_verification import ARM, situation

FORCES = (30.0, 20.0, 40.0, 25.0)
LIMITED = replace(ARM, max_joint_acceleration=FORCES)


def scene_of(rates=(0.0,) * 4, speeds=(4.0,) * 4):
    arm = replace(
        ARM, max_joint_acceleration=FORCES, joint_rates=tuple(rates), max_joint_speed=speeds
    )
    return pack(situation(arm))


def farthest(start_rate, force, speed, until):
    """How far a joint gets in a time, at full force and then at full speed."""
    ramp = min((speed - start_rate) / force, until)
    return start_rate * ramp + 0.5 * force * ramp**2 + speed * (until - ramp)


@pytest.mark.parametrize("seed", range(40))
def test_a_dash_ends_where_it_should_within_all_limits(seed):
    rng = np.random.default_rng(seed)
    scene = scene_of(rng.uniform(-2.0, 2.0, 4))
    goal, until = rng.uniform(-1.5, 1.5, 4), rng.uniform(0.2, 1.0)
    joints, rates = np.empty((3, 4)), np.empty((3, 4))
    switch = dash(scene, goal, until, joints, rates)
    if switch < 0.0:
        return
    last = slice(0, 3) if switch < until else slice(0, 2)
    time = np.array([0.0, switch, until])[last]
    curve = CubicHermiteSpline(time, joints[last], rates[last])
    fine = np.linspace(0.0, until, 1001)
    assert np.allclose(curve(until), goal, atol=1e-12)
    assert np.allclose(curve(0.0), scene.limb.start) and np.allclose(
        curve(0.0, 1), scene.limb.rates
    )
    assert (np.abs(curve(fine, 1)) <= 4.0 + 1e-9).all()
    assert (np.abs(curve(fine, 2)) <= np.array(FORCES) * (1.0 + 1e-9)).all()


@pytest.mark.parametrize("until", [0.15, 0.4, 0.9])
def test_a_single_joint_is_dashed_as_far_as_its_limits_let_it(until):
    most = farthest(1.0, FORCES[0], 4.0, until)
    scene, joints, rates = scene_of((1.0, 0.0, 0.0, 0.0)), np.empty((3, 4)), np.empty((3, 4))
    for share, found in ((0.999, True), (1.001, False)):
        goal = scene.limb.start + (share * most, 0.0, 0.0, 0.0)
        assert (dash(scene, goal, until, joints, rates) >= 0.0) == found


def test_many_joints_are_dashed_in_nine_of_ten_cases_that_each_alone_could_reach():
    rng, found, reachable = np.random.default_rng(1), 0, 0
    joints, rates = np.empty((3, 4)), np.empty((3, 4))
    for _ in range(400):
        scene, until = scene_of(), rng.uniform(0.2, 0.8)
        goal = scene.limb.start + rng.uniform(-1.5, 1.5, 4)
        way = np.abs(goal - scene.limb.start)
        if all(way[j] < farthest(0.0, FORCES[j], 4.0, until) for j in range(4)):
            reachable += 1
            found += dash(scene, goal, until, joints, rates) >= 0.0
    assert reachable > 100 and found > 0.9 * reachable


@pytest.fixture(scope="module")
def corner():
    time = np.array([0.0, 0.3, 0.5, 0.8])
    path = np.array([[0, 0, 0, 0], [1, 0.5, 0, -0.2], [1, 0.5, 0, -0.2], [0.2, 1, 0.3, 0.4]], float)
    return time, path


@pytest.mark.parametrize("force", [20.0, 40.0, 100.0, 400.0])
def test_a_tracked_path_keeps_accelerations_and_comes_nearer_the_more_it_may(corner, force):
    time, path = corner
    rates = np.array([0.5, -1.0, 0.0, 2.0])
    at, joints, moving = tracked(time, path, rates, np.full(4, force))
    curve, fine = CubicHermiteSpline(at, joints, moving), np.linspace(0.0, 0.8, 2001)
    assert np.abs(curve(fine, 2)).max() <= force * (1.0 + 1e-6)
    assert np.allclose(joints[0], path[0]) and np.allclose(moving[0], rates)
    assert np.allclose(joints[-1], path[-1], atol=1e-4)
    wanted = np.stack([np.interp(fine, time, path[:, j]) for j in range(4)], axis=-1)
    assert np.abs(curve(fine) - wanted).max() < 8.0 / force + 0.02


@pytest.mark.parametrize(("kept", "rests"), [([0, 1, 2, 3], True), ([0, 1, 3], False)])
def test_a_tracked_path_that_waits_rests(corner, kept, rests):
    time, path = (part[kept] for part in corner)
    curve = tracked(time, path, np.zeros(4), np.full(4, 400.0))
    assert Movement(LIMITED, *curve).rests is rests


def test_what_cannot_be_tracked_falls_short_of_its_end(corner):
    _, joints, _ = tracked(*corner, np.zeros(4), np.full(4, 1.0))
    assert np.abs(joints[-1] - corner[1][-1]).max() > 0.1


@pytest.mark.parametrize("seed", range(20))
def test_a_movement_ends_at_rest_as_soon_as_it_can(seed):
    """Each joint with its limit, all the way; the others go on meanwhile."""
    rng = np.random.default_rng(seed)
    rates = rng.uniform(-3.0, 3.0, 4) * (rng.random(4) < 0.8)
    plan = Movement(LIMITED, np.array([0.7]), np.zeros((1, 4)), rates[None])
    whole = braked(plan, np.array(FORCES))
    assert whole.duration == pytest.approx(0.7 + np.max(np.abs(rates) / FORCES))
    assert np.allclose(whole.rates[-1], 0.0, atol=1e-12)
    fine = np.linspace(0.7, whole.duration, 500, endpoint=False)[1:]
    _, moving, forces = whole.states_at(fine)
    on = np.abs(rates) / FORCES > (fine - 0.7)[:, None] + 1e-9
    assert np.allclose(forces[on], np.broadcast_to(-np.sign(rates) * FORCES, on.shape)[on])
    assert np.allclose(moving[~on], 0.0, atol=1e-9)
    assert np.allclose(whole.joints[-1], 0.5 * rates * np.abs(rates) / FORCES)


def test_a_joint_that_brakes_stays_in_its_range():
    """Its end takes what speed is left, at once where there is no room at all."""
    high = np.array([pair[1] for pair in ARM.joint_range])
    near = high - [0.3, 0.01, 0.0, 0.0]
    plan = Movement(LIMITED, np.zeros(1), near[None], np.full((1, 4), 3.0))
    whole = braked(plan, np.array(FORCES))
    fine = whole.states_at(np.linspace(0.0, whole.duration, 4001))[0]
    assert (fine <= high + 1e-6).all()
    assert np.allclose(whole.joints[-1], [near[0] + 0.15, *high[1:]], atol=1e-6)


def test_joints_that_stop_together_are_one_sample():
    """However rounding has it."""
    rates = np.array([0.3, 0.2 * (1.0 + 1e-15), 0.4, 0.25])
    plan = Movement(LIMITED, np.array([1.1]), np.zeros((1, 4)), rates[None])
    assert braked(plan, np.array(FORCES)).time.size == 2
