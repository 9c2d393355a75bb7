"""The two-joint arm: forward against inverse, sides, symmetries, rims."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, strategies as st

from gcm_learn.arms import elbow_position, forward, joint_angles

SIDES = ("right", "left")
uppers = st.sampled_from([1.0, 0.3, 2.0]) | st.floats(0.05, 20.0)
sides = st.sampled_from(SIDES)
angles = st.floats(-math.pi, math.pi)


@st.composite
def hands(draw, low=0.0, high=1.0):
    """Upper arm and a hand at a share `low` to `high` of the way across the ring."""
    rho = draw(uppers)
    radius = abs(rho - 1.0) + draw(st.floats(low, high)) * (rho + 1.0 - abs(rho - 1.0))
    angle = draw(angles)
    return rho, np.array([radius * math.cos(angle), radius * math.sin(angle)])


def cross(a, b):
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


@given(hands(), sides)
def test_forward_undoes_inverse(arm, side):
    rho, hand = arm
    found = forward(joint_angles(hand, rho, side), rho)
    # At the rims the elbow is the root of a rounding error.
    np.testing.assert_allclose(found, [hand], atol=1e-7 * (1.0 + rho))


@given(hands(low=0.01, high=0.99), sides)
def test_forward_undoes_inverse_to_rounding_off_the_rims(arm, side):
    rho, hand = arm
    np.testing.assert_allclose(
        forward(joint_angles(hand, rho, side), rho)[0], hand, atol=1e-12 * (1.0 + rho)
    )


@given(hands(low=0.001, high=0.999), sides)
def test_both_segments_have_their_length(arm, side):
    rho, hand = arm
    elbow = elbow_position(hand, rho, side)
    assert np.hypot(*elbow) == pytest.approx(rho, rel=1e-12)
    assert np.hypot(*(hand - elbow)) == pytest.approx(1.0, rel=1e-9)


@given(hands(low=0.001, high=0.999))
def test_the_elbow_lies_on_its_side(arm):
    """Right is clockwise when looking from the shoulder to the hand."""
    rho, hand = arm
    assert cross(hand, elbow_position(hand, rho, "right")) < 0.0
    assert cross(hand, elbow_position(hand, rho, "left")) > 0.0
    assert 0.0 < joint_angles(hand, rho, "right")[0, 1] < math.pi
    assert -math.pi < joint_angles(hand, rho, "left")[0, 1] < 0.0


def test_a_pose_that_can_be_drawn():
    """Upper arm along -y, forearm along +x: the hand is at (1, -1), the elbow to its right."""
    np.testing.assert_allclose(elbow_position((1.0, -1.0)), (0.0, -1.0), atol=1e-12)
    np.testing.assert_allclose(elbow_position((1.0, -1.0), elbow="left"), (1.0, 0.0), atol=1e-12)
    joints = joint_angles((1.0, -1.0))
    np.testing.assert_allclose(joints, [[-math.pi / 2, math.pi / 2]], atol=1e-12)


@given(hands(low=0.001, high=0.999), sides)
def test_mirror_symmetry(arm, side):
    rho, hand = arm
    other = SIDES[SIDES.index(side) - 1]
    mirror = np.array([1.0, -1.0])
    np.testing.assert_allclose(
        elbow_position(hand * mirror, rho, other),
        elbow_position(hand, rho, side) * mirror,
        atol=1e-12 * (1.0 + rho),
    )
    joints = joint_angles(hand, rho, side)
    turn = joint_angles(hand * mirror, rho, other) + joints
    np.testing.assert_allclose(np.cos(turn), 1.0, atol=1e-9)


@given(hands(low=0.01, high=0.99), sides, angles)
def test_rotation_symmetry(arm, side, turn):
    rho, hand = arm
    c, s = math.cos(turn), math.sin(turn)
    rotation = np.array([[c, -s], [s, c]])
    np.testing.assert_allclose(
        elbow_position(rotation @ hand, rho, side),
        rotation @ elbow_position(hand, rho, side),
        atol=1e-11 * (1.0 + rho),
    )
    before, after = joint_angles(hand, rho, side)[0], joint_angles(rotation @ hand, rho, side)[0]
    assert after[1] == pytest.approx(before[1], abs=1e-9)
    assert math.cos(after[0] - before[0] - turn) == pytest.approx(1.0, abs=1e-12)


@given(uppers, sides, angles, st.sampled_from(["inner", "outer", "beyond", "shoulder", "within"]))
def test_rims_and_shoulder_give_numbers(rho, side, angle, where):
    radius = {
        "inner": abs(rho - 1.0),
        "outer": rho + 1.0,
        "beyond": (rho + 1.0) * (1.0 + 1e-9),
        "shoulder": 0.0,
        "within": abs(rho - 1.0) * (1.0 - 1e-9),
    }[where]
    hand = (radius * math.cos(angle), radius * math.sin(angle))
    elbow, joints = elbow_position(hand, rho, side), joint_angles(hand, rho, side)
    assert np.isfinite(elbow).all() and np.isfinite(joints).all()
    assert np.hypot(*elbow) == pytest.approx(rho, rel=1e-9)
    if where != "shoulder" or rho == 1.0:
        np.testing.assert_allclose(forward(joints, rho)[0], hand, atol=1e-6 * (1.0 + rho))


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("rho", [0.7, 1.0, 1.4])
def test_joints_are_continuous_and_unwrapped(rho, side):
    """Three times round the shoulder and in and out."""
    s = np.linspace(0.0, 1.0, 2000)
    middle, swing = 0.5 * (abs(rho - 1.0) + rho + 1.0), 0.3
    radius, angle = middle + swing * np.sin(9.0 * s), 6.0 * np.pi * s
    path = radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    joints = joint_angles(path, rho, side)
    assert np.abs(np.diff(joints, axis=0)).max() < 0.1
    turned = joints[-1, 0] - joints[0, 0]
    first, last = path[0] / radius[0], path[-1] / radius[-1]
    np.testing.assert_allclose(first, last, atol=1e-9)
    assert turned == pytest.approx(6.0 * np.pi, abs=1.0)
    np.testing.assert_allclose(forward(joints, rho), path, atol=1e-10)


def test_many_hands_at_once_are_as_one_by_one(rng):
    hands = rng.uniform(-1.2, 1.2, (3, 4, 2))
    elbows = elbow_position(hands, 1.0, "left")
    assert elbows.shape == hands.shape
    for index in np.ndindex(3, 4):
        np.testing.assert_array_equal(elbows[index], elbow_position(hands[index], 1.0, "left"))
    joints = rng.uniform(-3.0, 3.0, (3, 4, 2))
    assert forward(joints, 1.3).shape == (3, 4, 2)
