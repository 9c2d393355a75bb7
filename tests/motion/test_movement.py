"""Movements of planar arms; those in the joints are in test_joint_verification."""

from __future__ import annotations

import numpy as np
import pytest

from gcm_learn import Arm
from gcm_learn.arms import forward, joint_angles
from gcm_learn.motion import Movement

ARM = Arm((1.0, 0.0), 9.0)
TIME = np.array([0.0, 0.5, 0.5, 1.0])
HAND = np.array([[1.0, 0.0], [1.0, 0.5], [1.0, 0.5], [0.4, 1.3]])


def test_joints_follow_from_the_hand():
    path = Movement.of_hand(Arm((1.0, 0.0), 9.0, 1.2, "left"), TIME, HAND)
    np.testing.assert_array_equal(path.joints, joint_angles(HAND, 1.2, "left"))
    np.testing.assert_allclose(forward(path.joints, 1.2), HAND, atol=1e-12)


def test_it_is_linear_between_samples_and_held_beyond():
    path = Movement.of_hand(ARM, TIME, HAND)
    np.testing.assert_allclose(path.hand_at(0.25), (1.0, 0.25))
    np.testing.assert_allclose(path.hand_at([-1.0, 0.75, 9.0]), [HAND[0], (0.7, 0.9), HAND[-1]])
    middle = 0.5 * (path.joints[0] + path.joints[1])
    np.testing.assert_allclose(path.joints_at(0.25), middle)


def test_duration_and_length():
    path = Movement.of_hand(ARM, TIME, HAND)
    assert path.duration == 1.0
    assert path.length == pytest.approx(0.5 + 1.0)


def halting() -> Movement:
    """Right for 0.5 s, rest for 0.3 s, up for 0.5 s, rest for 0.1 s."""
    corner, top = [1.5, 0.0], [1.5, 0.5]
    return Movement.of_hand(
        ARM, np.array([0.0, 0.5, 0.8, 1.3, 1.4]), np.array([[1.0, 0.0], corner, corner, top, top])
    )


def test_waits_are_where_and_while_the_hand_rests():
    first, last = halting().waits()
    assert first == pytest.approx((1.5, 0.0, 0.5, 0.8)) and first.duration == pytest.approx(0.3)
    assert last == pytest.approx((1.5, 0.5, 1.3, 1.4))
    assert halting().waits(shortest=0.2) == [first]


def test_waits_do_not_depend_on_the_samples():
    way = halting()
    rng = np.random.default_rng(0)
    time = np.sort(np.concatenate([np.repeat(way.time, 2), rng.uniform(0.0, way.duration, 200)]))
    finer = Movement.of_hand(ARM, time, way.hand_at(time))
    np.testing.assert_allclose(finer.waits(), way.waits(), atol=1e-9)


def test_a_slow_hand_does_not_wait_and_one_that_never_moves_always_does():
    slow = Movement.of_hand(
        ARM, np.array([0.0, 1.0, 9.0]), np.array([[1.0, 0], [1.5, 0], [1.6, 0]])
    )
    assert slow.waits() == []
    still = Movement.of_hand(ARM, np.array([0.0, 0.4, 0.9]), np.full((3, 2), 0.7))
    assert still.waits() == [(0.7, 0.7, 0.0, 0.9)]
    assert Movement.of_hand(ARM, np.zeros(1), np.ones((1, 2))).waits() == []


@pytest.mark.parametrize(
    ("time", "hand", "joints"),
    [
        (np.zeros(3), np.zeros((2, 2)), np.zeros((3, 2))),
        (np.zeros(3), np.zeros((3, 2)), np.zeros((3, 3))),
        (np.zeros((3, 1)), np.zeros((3, 2)), np.zeros((3, 2))),
        (np.zeros(0), np.zeros((0, 2)), np.zeros((0, 2))),
        (np.array([0.0, 1.0, 0.9]), np.zeros((3, 2)), np.zeros((3, 2))),
    ],
)
def test_arrays_that_do_not_fit_are_refused(time, hand, joints):
    with pytest.raises(ValueError, match="movement"):
        Movement(ARM, time, joints, path=hand)
