"""The arm in space: forward against matrices, and inverse, Jacobian and bounds against forward."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, strategies as st

from gcm_learn.arms import (
    CHAIN,
    SPATIAL,
    Base,
    ByKind,
    Chain,
    SpatialArm,
    check_kind,
    forward_in_space,
    hands_along,
    inverse_in_space,
    links_along,
    rotation_of,
    spatial_limb_of,
    swivel_in_space,
)
from gcm_learn.arms.limbs import hand_of, jacobian, place
from gcm_learn.arms.swivels import (
    POLE,
    ZERO,
    elbow_at,
    joints_of_limb,
    limb_at,
    swivel_axes,
    swivel_of,
)
from gcm_learn.errors import ArmKindError
from tests import strategies

SPEEDS = (8.268, 7.194, 8.268, 7.194)
NAO = SpatialArm(
    upper_arm=(0.105, 0.015, 0),
    forearm=(0.1137, 0, -0.01231),
    joints=(1.4, 0.2, -1.2, -0.6),
    joint_range=((-2.0857, 2.0857), (-0.3142, 1.3265), (-2.0857, 2.0857), (-1.5446, -0.0349)),
    max_joint_speed=SPEEDS,
    grasp=0.015,
    base=Base((0, 0.098, 0.43)),
)
HUMAN = SpatialArm(
    upper_arm=(1, 0, 0),
    forearm=(1, 0, 0),
    joints=(0, 0, 0, -1),
    joint_range=((-2.8, 2.0), (-0.6, 2.2), (-2.4, 2.4), (-2.6, 0.0)),
    max_joint_speed=(5, 5, 7, 7),
    grasp=0.1,
)
FREE = ((-math.pi, math.pi),) * 4
CROOKED = SpatialArm(
    upper_arm=(0.5, -0.2, 0.3), forearm=(0.7, 0.1, -0.25), joints=(0.1, 0.2, 0.3, 0.4),
    joint_range=FREE, max_joint_speed=SPEEDS, grasp=0.1,
    base=Base((1, 2, 3), (0.5, -0.5, 0.5, 0.5)),
)  # fmt: skip
FIXED = pytest.mark.parametrize("arm", [NAO, HUMAN, CROOKED], ids=["nao", "human", "crooked"])
fractions = strategies.vectors(4, st.floats(0.0, 1.0))


def about(axis, angle):
    """Rotation matrix about x (0), y (1) or z (2)."""
    i, j = (axis + 1) % 3, (axis + 2) % 3
    turn = np.eye(3)
    turn[i, i] = turn[j, j] = math.cos(angle)
    turn[j, i] = math.sin(angle)
    turn[i, j] = -turn[j, i]
    return turn


def reference(arm, q):
    """Elbow and hand as the contract of the format writes them."""
    base, origin = rotation_of(arm.base.rotation), np.array(arm.base.origin)
    shoulder = base @ about(1, q[0]) @ about(2, q[1])
    elbow = origin + shoulder @ arm.upper_arm
    return elbow, elbow + shoulder @ about(0, q[2]) @ about(2, q[3]) @ arm.forearm


def within(arm, shares):
    """Joints at shares (4,) of the way through their ranges."""
    low, high = np.array(arm.joint_range).T
    return np.clip(low + np.array(shares) * (high - low), low, high)


def drawn(arm, rng, count):
    low, high = np.array(arm.joint_range).T
    return rng.uniform(low, high, (count, 4))


@pytest.mark.parametrize(
    ("q", "elbow", "hand"),
    [
        ((0, 0, 0, -0.0349), (0.06364, 0.182853, 0.43), (0.146794, 0.260397, 0.41769)),
        ((1.4, 0.2, -1.2, -0.6), (-0.013136, 0.135155, 0.331527), (0.048224, 0.174735, 0.243507)),
    ],
)
def test_numbers_of_the_format(q, elbow, hand):
    arm = replace(NAO, base=Base((0, 0.098, 0.43), (0.9238795, 0, 0, 0.3826834)))
    there, reached = forward_in_space(arm, q)
    np.testing.assert_allclose(there, elbow, atol=6e-7)
    np.testing.assert_allclose(reached, hand, atol=6e-7)


@given(strategies.spatial_arms(), strategies.vectors(4))
def test_forward_is_what_the_format_says(arm, q):
    for found, wanted in zip(forward_in_space(arm, q), reference(arm, q), strict=True):
        np.testing.assert_allclose(found, wanted, atol=1e-12)


def test_many_joints_at_once_are_as_one_by_one(rng):
    joints = rng.uniform(-3, 3, (3, 2, 4))
    elbows, hands = forward_in_space(CROOKED, joints)
    assert elbows.shape == hands.shape == (3, 2, 3)
    for index in np.ndindex(3, 2):
        elbow, hand = forward_in_space(CROOKED, joints[index])
        np.testing.assert_array_equal(elbows[index], elbow)
        np.testing.assert_array_equal(hands[index], hand)


@given(strategies.spatial_arms(), strategies.vectors(4))
def test_jacobian_is_the_derivative(arm, q):
    limb, found, step = spatial_limb_of(arm), np.empty((3, 4)), 1e-5
    np.testing.assert_allclose(
        hand_of(limb, place(limb, np.array(q))), limb_at(limb, q)[3:], atol=1e-12
    )
    jacobian(limb, np.array(q), found)
    for k, shift in enumerate(step * np.eye(4)):
        ahead, behind = limb_at(limb, q + shift), limb_at(limb, q - shift)
        wanted = (np.array(ahead[3:]) - np.array(behind[3:])) / (2 * step)
        np.testing.assert_allclose(found[:, k], wanted, atol=1e-8)


@given(strategies.spatial_arms(), strategies.vectors(4))
def test_it_stands_where_the_plain_chain_of_its_model_does(arm, q):
    plain = arm.with_model(arm.model)
    assert isinstance(arm, Chain) and type(plain) is Chain
    for traced in (links_along, hands_along):
        for found, wanted in zip(traced(arm, [q]), traced(plain, [q]), strict=True):
            np.testing.assert_allclose(found, wanted, atol=1e-12)


@FIXED
def test_it_is_thicker_and_slower_as_its_chain_is(arm):
    plain = arm.with_model(arm.model)
    for change in (lambda one: one.thicker(0.01), lambda one: one.slower(0.5)):
        mine, its = change(arm), change(plain)
        assert type(mine) is SpatialArm and mine.upper_arm == arm.upper_arm
        assert mine.max_joint_speed == its.max_joint_speed
        assert mine.max_hand_speed == its.max_hand_speed
        assert [link.radius for link in mine.model.links] == [
            link.radius for link in its.model.links
        ]


def test_tables_fall_back_on_the_entry_of_chains():
    table = ByKind({CHAIN: "chain"}, who="a table")
    assert table.of(NAO) == "chain" and table.takes(NAO)
    table.register(SPATIAL, "own")
    assert table.of(NAO) == "own" and table.of(NAO.with_model(NAO.model)) == "chain"
    with pytest.raises(ArmKindError, match="a table does not take chains"):
        ByKind({SPATIAL: "own"}, who="a table").of(NAO.with_model(NAO.model))
    with pytest.raises(ArmKindError, match="an arena of chains does not take spatial arms"):
        check_kind(NAO, CHAIN, "an arena of chains")


# --- inverse -----------------------------------------------------------------------------------


@given(strategies.spatial_arms(), fractions, st.booleans())
def test_what_inverse_finds_is_right(arm, shares, is_reached):
    """In ranges, with the hand where it should be, whatever the hand and the arm."""
    q = within(arm, shares)
    elbow, hand = forward_in_space(arm, q)
    swivel = swivel_in_space(arm, q)
    if not is_reached:
        hand, swivel = hand + [0.1, 0.2, -0.1], 1.0
    found = inverse_in_space(arm, hand, swivel, near=q)
    low, high = np.array(arm.joint_range).T
    assert len(found) <= 4
    assert ((low <= found) & (found <= high)).all()
    elbows, hands = forward_in_space(arm, found)
    np.testing.assert_allclose(hands, np.broadcast_to(hand, hands.shape), atol=1e-8)
    if is_reached:
        np.testing.assert_allclose(elbows, np.broadcast_to(elbow, elbows.shape), atol=1e-5)


@given(strategies.spatial_arms(held=False), strategies.vectors(4, st.floats(0.02, 0.98)))
def test_inverse_undoes_forward(arm, shares):
    q = within(arm, shares)
    found = inverse_in_space(arm, forward_in_space(arm, q)[1], swivel_in_space(arm, q), near=q)
    assert len(found) >= 1
    hand = forward_in_space(arm, q)[1]
    hands = forward_in_space(arm, found)[1]
    np.testing.assert_allclose(hands, np.broadcast_to(hand, hands.shape), atol=1e-9)


def test_a_stretched_arm_at_the_end_of_its_ranges(rng):
    """Where the elbow is a root of rounding errors, and half of what is near is out of range."""
    for q in drawn(HUMAN, rng, 300):
        q[3] = 0.0
        found = inverse_in_space(
            HUMAN, forward_in_space(HUMAN, q)[1], swivel_in_space(HUMAN, q), near=q
        )
        assert np.abs(found - q).max(axis=1).min() < 1e-6


@FIXED
def test_the_joints_that_were_there_are_among_the_solutions(arm, rng):
    for q in drawn(arm, rng, 300):
        elbow, hand = forward_in_space(arm, q)
        found = inverse_in_space(arm, hand, swivel_in_space(arm, q))
        assert np.abs(found - q).max(axis=1).min() < 1e-6  # near the rims a root of rounding
        elbows, hands = forward_in_space(arm, found)
        np.testing.assert_allclose(hands, np.broadcast_to(hand, hands.shape), atol=1e-9)
        np.testing.assert_allclose(elbows, np.broadcast_to(elbow, elbows.shape), atol=1e-9)


@FIXED
def test_there_are_four_ways_where_joints_are_free(arm, rng):
    """Two where offsets keep the forearm from where the upper arm's other turn wants it."""
    free = replace(arm, joint_range=FREE)
    limb, out, counts = spatial_limb_of(free), np.empty((4, 4)), []
    for q in rng.uniform(-2.5, 2.5, (50, 4)):
        counts.append(joints_of_limb(limb, *limb_at(limb, q), np.zeros(4), out))
        found = out[: counts[-1]]
        differ = [np.abs(a - b).max() for k, a in enumerate(found) for b in found[:k]]
        assert min(differ) > 1e-6
    assert set(counts) <= {2, 4} and np.mean(counts) > 3
    assert arm is not HUMAN or set(counts) == {4}


def test_ranges_choose_among_the_ways(rng):
    """What is found in a part of the ranges is what lies there of all that is found."""
    free = replace(NAO, joint_range=FREE)
    for q in drawn(NAO, rng, 100):
        hand = forward_in_space(NAO, q)[1]
        swivel = swivel_of_pole(spatial_limb_of(NAO), free, q)
        every = inverse_in_space(free, hand, swivel)
        low, high = np.array(NAO.joint_range).T
        wanted = [p for p in every if ((low <= p) & (p <= high)).all()]
        found = inverse_in_space(NAO, hand, swivel_in_space(NAO, q))
        np.testing.assert_allclose(sorted(map(tuple, found)), sorted(map(tuple, wanted)), atol=1e-7)


def swivel_of_pole(limb, other, q):
    """The swivel at q of an arm with other ranges, and so another pole."""
    theirs = spatial_limb_of(other)
    return swivel_of(theirs, *limb_at(limb, q))


def test_angles_some_turns_away_are_taken_if_they_are_nearer():
    wide = replace(CROOKED, joint_range=((-10.0, 10.0),) * 4)
    q = np.array([0.1, 0.2, 0.3, 0.4])
    hand, swivel = forward_in_space(wide, q)[1], swivel_in_space(wide, q)
    for turns in ((0, 0, 0, 0), (1, 0, -1, 0), (-1, 1, 1, -1)):
        there = q + 2 * math.pi * np.array(turns)
        found = inverse_in_space(wide, hand, swivel, near=there)
        assert np.abs(found - there).max(axis=1).min() < 1e-9
    tight = replace(wide, joint_range=((5.0, 10.0),) + wide.joint_range[1:], joints=(6, 0, 0, 0))
    limb, out = spatial_limb_of(tight), np.empty((4, 4))
    count = joints_of_limb(limb, *limb_at(limb, q), q, out)
    assert np.abs(out[:count] - (q + [2 * math.pi, 0, 0, 0])).max(axis=1).min() < 1e-9


def test_hands_out_of_reach_have_no_joints():
    for radius in (2.001, 5.0):
        assert len(inverse_in_space(HUMAN, (radius, 0, 0), 0.3)) == 0
    short = replace(HUMAN, upper_arm=(0.4, 0, 0), joint_range=FREE)
    for radius in (0.599, 0.3, 0.0):
        assert len(inverse_in_space(short, (radius, 0, 0), 0.3)) == 0
    assert len(inverse_in_space(short, (0.601, 0, 0), 0.3)) == 4


def test_axes_in_line_leave_a_joint_as_it_is():
    """Elbow on the y axis: q1 and q3 do the same; forearm in line: q3 does nothing."""
    arm, out = replace(HUMAN, joint_range=FREE), np.empty((4, 4))
    for q in ((0.7, math.pi / 2, 0.4, -1.0), (0.7, 0.3, 0.4, 0.0), (0.7, math.pi / 2, 0.4, 0.0)):
        limb = spatial_limb_of(arm)
        count = joints_of_limb(limb, *limb_at(limb, np.array(q)), np.array(q), out)
        assert np.abs(out[:count] - q).max(axis=1).min() < 1e-6


def test_an_upper_arm_along_its_second_axis(rng):
    """q2 does not move the elbow then, which is on a circle about y."""
    arm = replace(CROOKED, upper_arm=(0, 0, 0.6))
    for q in drawn(arm, rng, 30):
        limb, out = spatial_limb_of(arm), np.empty((4, 4))
        place = limb_at(limb, q)
        count = joints_of_limb(limb, *place, q, out)
        assert count >= 1
        for row in out[:count]:
            np.testing.assert_allclose(limb_at(limb, row), place, atol=1e-6)


# --- swivel ------------------------------------------------------------------------------------


@FIXED
def test_turning_the_elbow_about_the_hand_turns_the_swivel(arm, rng):
    limb = spatial_limb_of(arm)
    for q in drawn(arm, rng, 50):
        place = np.array(limb_at(limb, q))
        elbow, hand = place[:3], place[3:]
        axis, turn = hand / np.linalg.norm(hand), rng.uniform(-3, 3)
        c, s = math.cos(turn), math.sin(turn)
        turned = c * elbow + s * np.cross(axis, elbow) + (1 - c) * axis * (axis @ elbow)
        more = swivel_of(limb, *turned, *hand) - swivel_of(limb, *place)
        assert math.cos(more - turn) == pytest.approx(1.0, abs=1e-9)
        np.testing.assert_allclose(
            elbow_at(limb, *hand, swivel_of(limb, *turned, *hand)), turned, atol=1e-7
        )


@FIXED
def test_swivels_are_smooth_but_at_the_pole(arm, rng):
    """The reference turns slowly as the hand moves, opposite to the pole as well."""
    limb = spatial_limb_of(arm)
    assert np.linalg.norm(limb.solved[POLE:ZERO]) == pytest.approx(1.0)
    assert limb.solved[POLE:ZERO] @ limb.solved[ZERO : ZERO + 3] == pytest.approx(0.0, abs=1e-12)
    hands = rng.normal(size=(200, 3))
    hands[0], hands[1] = -limb.solved[POLE:ZERO], limb.solved[ZERO : ZERO + 3]
    for hand in hands / np.linalg.norm(hands, axis=1)[:, None]:
        away = math.acos(np.clip(hand @ limb.solved[POLE:ZERO], -1, 1))
        step = 1e-4 * rng.normal(size=3)
        a, b = (np.array(swivel_axes(limb, *place)) for place in (hand, hand + step))
        np.testing.assert_allclose(a[4:7] @ a[1:4], 0.0, atol=1e-9)
        np.testing.assert_allclose(np.cross(a[1:4], a[4:7]), a[7:10], atol=1e-9)
        assert np.linalg.norm(b[4:7] - a[4:7]) < 5.0 * np.linalg.norm(step) / away


def angles_to_pole(arm, rng, count=100_000):
    """Angles between the pole and directions to hands in the joints' ranges."""
    limb = spatial_limb_of(arm)
    hands = forward_in_space(replace(arm, base=Base()), drawn(arm, rng, count))[1]
    return np.arccos(np.clip(hands @ limb.solved[POLE:ZERO] / np.linalg.norm(hands, axis=1), -1, 1))


def test_hands_of_a_robot_do_not_come_near_the_pole(rng):
    assert angles_to_pole(NAO, rng).min() > 0.4


def test_hands_of_a_human_are_rarely_near_the_pole(rng):
    """They can be in every direction: no half-line is out of reach.  An even spread has 1/400."""
    angles = angles_to_pole(HUMAN, rng)
    assert (angles < 0.1).mean() < 1 / 1000
    ranges = HUMAN.joint_range[:3] + ((-0.9, 0.0),)
    stretched = replace(HUMAN, joint_range=ranges, joints=(0, 0, 0, -0.5))
    assert angles_to_pole(stretched, rng).min() > 0.4


@given(strategies.spatial_arms())
def test_poles_are_where_hands_are_rare(arm):
    angles = angles_to_pole(arm, np.random.default_rng(0), 2000)
    assert (angles < 0.1).mean() <= 1 / 200
