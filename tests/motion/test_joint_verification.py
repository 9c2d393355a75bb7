"""What "caught" promises of a spatial arm: kept, and broken in one way at a time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gcm_learn.arms import SpatialArm, forward_in_space
from gcm_learn.motion import Failure, Movement, opening, verify
from gcm_learn.scene import pack
from gcm_learn.situation import Body, Situation, SolidQuadratic, Sphere

ARM = SpatialArm(
    upper_arm=(1.0, 0.0, 0.0),
    forearm=(1.0, 0.0, 0.0),
    joints=(0.0, 0.0, 0.0, 0.4),
    joint_range=((-2.0, 2.0),) * 4,
    max_joint_speed=(4.0,) * 4,
    grasp=0.1,
    thickness=0.05,
)
GOAL = (0.5, 0.3, -0.2, 0.9)
SOON = np.array(GOAL) + np.outer((-1e-6, 1e-6), (0.0, 0.7, 0.0, 0.0))


def ball(name, role, place, velocity=(0.0, 0.0, 0.0), radius=0.05):
    return Body(role, name, Sphere(radius), SolidQuadratic(place, velocity, (0.0, 0.0, 0.0)))


def situation(arm=ARM, obstacles=(), horizon=1.0):
    target = ball("target", "target", tuple(forward_in_space(arm, GOAL)[1]))
    return Situation("reach", horizon, arm, (target, *obstacles))


def verdict(of, time, joints, rates=None):
    scene = pack(of)
    moves = Movement(of.arm, np.array(time), np.array(joints, dtype=float), rates)
    return verify(scene, opening(scene).rules, moves, 0)


def test_a_plain_reach_is_good_and_its_clearance_is_that_of_the_post():
    post = ball("post", "obstacle", (0.0, -0.5, 0.0), radius=0.2)
    found = verdict(situation(obstacles=(post,)), [0.0, 0.5], [ARM.joints, GOAL])
    assert found.good and found.clearance == pytest.approx(0.5 - 0.2 - 0.05, abs=3e-4)


def halfway(of_arm=ARM):
    middle = (np.array(ARM.joints) + GOAL) / 2.0
    return tuple(forward_in_space(of_arm, middle)[1])


BROKEN = {
    "elsewhere": (situation(), [0.0, 0.5], [GOAL, GOAL], Failure.WRONG_START),
    "late": (situation(horizon=0.4), [0.0, 0.5], [ARM.joints, GOAL], Failure.LATE),
    "range": (
        situation(replace(ARM, joint_range=((-2.0, 2.0),) * 3 + ((0.0, 0.8),))),
        [0.0, 0.5],
        [ARM.joints, GOAL],
        Failure.JOINT_RANGE,
    ),
    "joint": (situation(), [0.0, 0.12], [ARM.joints, GOAL], Failure.JOINT_SPEED),
    "hand": (
        situation(replace(ARM, max_hand_speed=1.0)),
        [0.0, 0.5],
        [ARM.joints, GOAL],
        Failure.HAND_SPEED,
    ),
    "missed": (
        situation(),
        [0.0, 0.5],
        [ARM.joints, np.array(GOAL) + (0.0, 0.2, 0.0, 0.0)],
        Failure.MISSED,
    ),
    "touched": (
        situation(obstacles=(ball("post", "obstacle", halfway(), radius=0.02),)),
        [0.0, 0.5],
        [ARM.joints, GOAL],
        Failure.COLLISION,
    ),
    "touched in between only": (
        situation(
            obstacles=(
                ball(
                    "bullet",
                    "obstacle",
                    tuple(np.array(halfway()) - (0.0, 0.0, 12.5)),
                    (0.0, 0.0, 50.0),
                    0.01,
                ),
            )
        ),
        [0.0, 0.5],
        [ARM.joints, GOAL],
        Failure.COLLISION,
    ),
    "no rates": (
        situation(replace(ARM, max_joint_acceleration=(50.0,) * 4)),
        [0.0, 0.5],
        [ARM.joints, GOAL],
        Failure.JOINT_ACCELERATION,
    ),
}


@pytest.mark.parametrize("name", BROKEN)
def test_each_broken_promise_is_named(name):
    of, time, joints, failure = BROKEN[name]
    found = verdict(of, time, joints)
    assert not found.good and found.reason.failure is failure
    assert (found.collision_time is not None) == (failure is Failure.COLLISION)


def test_the_time_of_a_touch_is_told():
    bullet = BROKEN["touched in between only"]
    assert verdict(*bullet[:3]).collision_time == pytest.approx(0.25, abs=0.01)


def smooth(limit):
    """Two samples at rest, half a second apart: each joint needs 6 |way| / span^2."""
    arm = replace(ARM, max_joint_acceleration=(limit,) * 4)
    return verdict(situation(arm), [0.0, 0.5], [ARM.joints, GOAL], np.zeros((2, 4)))


def test_accelerations_of_the_hermite_curve_are_judged_at_its_ends():
    needed = 6.0 * np.abs(np.subtract(GOAL, ARM.joints)).max() / 0.25
    assert smooth(1.001 * needed).good
    assert smooth(0.999 * needed).reason.failure is Failure.JOINT_ACCELERATION


def test_rates_of_the_hermite_curve_are_judged_where_they_are_largest():
    needed = 1.5 * np.abs(np.subtract(GOAL, ARM.joints)).max() / 0.5
    for share, good in ((1.001, True), (0.999, False)):
        speeds = (share * needed,) * 4
        arm = replace(ARM, max_joint_acceleration=(99.0,) * 4, max_joint_speed=speeds)
        found = verdict(situation(arm), [0.0, 0.5], [ARM.joints, GOAL], np.zeros((2, 4)))
        assert found.good == good
        assert good or found.reason.failure is Failure.JOINT_SPEED


def test_a_hermite_curve_that_swings_out_of_its_range_is_refused():
    ranges = ((-0.001, 2.0),) + ((-2.0, 2.0),) * 3
    arm = replace(
        ARM,
        joint_range=ranges,
        max_joint_acceleration=(200.0,) * 4,
        joint_rates=(-3.0, 0.0, 0.0, 0.0),
    )
    rates = np.array([arm.joint_rates, (0.0,) * 4])
    found = verdict(situation(arm), [0.0, 0.5], [ARM.joints, GOAL], rates)
    assert found.reason.failure is Failure.JOINT_RANGE


@pytest.mark.parametrize("seed", range(8))
def test_the_hands_speed_is_judged_at_its_fastest_instant(seed):
    rng = np.random.default_rng(seed)
    start, end = rng.uniform(-1.5, 1.5, (2, 4))
    arm = replace(ARM, joints=tuple(start), max_joint_speed=(50.0,) * 4)
    share = np.linspace(0.0, 1.0, 20001)[:, None]
    hands = forward_in_space(arm, start + share * (end - start))[1]
    fastest = np.linalg.norm(np.diff(hands, axis=0), axis=1).max() * 20000 / 0.5
    for factor, good in ((1.0001, True), (0.9999, False)):
        limited = replace(arm, max_hand_speed=factor * fastest)
        target = ball("target", "target", tuple(hands[-1]))
        found = verdict(Situation("reach", 1.0, limited, (target,)), [0.0, 0.5], [start, end])
        assert found.good == good
        assert good or found.reason.failure is Failure.HAND_SPEED


def test_a_catch_at_once_has_one_sample():
    arm = replace(ARM, joints=GOAL)
    assert verdict(situation(arm), [0.0], [GOAL]).good
    post = ball("post", "obstacle", tuple(forward_in_space(arm, GOAL)[0]), radius=0.02)
    touched = verdict(situation(arm, obstacles=(post,)), [0.0], [GOAL])
    assert touched.reason.failure is Failure.COLLISION


def test_a_hand_that_is_too_fast_at_once_keeps_no_promise():
    turning = replace(
        ARM, joints=GOAL, max_joint_acceleration=(9.0,) * 4, joint_rates=(0.0, 0.7, 0.0, 0.0)
    )
    speed = np.linalg.norm(np.diff(forward_in_space(ARM, SOON)[1], axis=0)[0]) / 2e-6
    for factor, good in ((1.0001, True), (0.9999, False)):
        arm = replace(turning, max_hand_speed=factor * speed)
        found = verdict(situation(arm), [0.0], [GOAL], np.array([turning.joint_rates]))
        assert found.good == good
        assert good or found.reason.failure is Failure.HAND_SPEED


def test_bodies_are_judged_in_the_world_wherever_the_base_is():
    from gcm_learn.arms import Base

    turn = np.array([0.5, 0.5, -0.5, 0.5])
    arm = replace(ARM, base=Base((0.3, -2.0, 1.0), tuple(turn)))
    place = tuple((forward_in_space(arm, ARM.joints)[0] + forward_in_space(arm, GOAL)[0]) / 2)
    post = ball("post", "obstacle", place, radius=0.1)
    assert verdict(situation(arm), [0.0, 0.5], [ARM.joints, GOAL]).good
    found = verdict(situation(arm, obstacles=(post,)), [0.0, 0.5], [ARM.joints, GOAL])
    assert found.reason.failure is Failure.COLLISION


def test_rates_without_limits_of_acceleration_are_refused():
    time, joints, rates = np.array([0.0, 0.5]), np.array([ARM.joints, GOAL]), np.zeros((2, 4))
    with pytest.raises(ValueError, match="no max_joint_acceleration"):
        Movement(ARM, time, joints, rates)
