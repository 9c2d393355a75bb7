"""Timed hand paths."""

from __future__ import annotations

import numpy as np
import pytest

from gcm_learn.arm import Trajectory, forward, joint_angles

TIME = np.array([0.0, 0.5, 0.5, 1.0])
HAND = np.array([[1.0, 0.0], [1.0, 0.5], [1.0, 0.5], [0.4, 1.3]])


def test_joints_follow_from_the_hand():
    path = Trajectory.of_hand(TIME, HAND, 1.2, "left")
    np.testing.assert_array_equal(path.joints, joint_angles(HAND, 1.2, "left"))
    np.testing.assert_allclose(forward(path.joints, 1.2), HAND, atol=1e-12)


def test_it_is_linear_between_samples_and_held_beyond():
    path = Trajectory.of_hand(TIME, HAND)
    np.testing.assert_allclose(path.hand_at(0.25), (1.0, 0.25))
    np.testing.assert_allclose(path.hand_at([-1.0, 0.75, 9.0]), [HAND[0], (0.7, 0.9), HAND[-1]])
    middle = 0.5 * (path.joints[0] + path.joints[1])
    np.testing.assert_allclose(path.joints_at(0.25), middle)


def test_duration_and_length():
    path = Trajectory.of_hand(TIME, HAND)
    assert path.duration == 1.0
    assert path.length == pytest.approx(0.5 + 1.0)


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
def test_what_does_not_fit_is_refused(time, hand, joints):
    with pytest.raises(ValueError, match="trajectory"):
        Trajectory(time, hand, joints)
