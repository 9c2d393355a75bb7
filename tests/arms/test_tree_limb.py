"""Chains with branches and followers against a slow product of matrices and the referee."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy.spatial.transform import Rotation

from gcm_learn import arms
from gcm_learn.errors import SituationError
from tests import strategies

SEEDS = st.integers(0, 2**32 - 1)


def frames_of(arm, q):
    """Poses (4, 4) of frames 0 to m in the world, by the words of the exchange contract."""
    base = np.eye(4)
    base[:3, :3] = Rotation.from_quat(arm.base.rotation, scalar_first=True).as_matrix()
    base[:3, 3] = arm.base.origin
    left, frames, values = iter(q), [base], []
    for k, joint in enumerate(arm.model.joints):
        if joint.follows is None:
            value = next(left)
        else:
            value = joint.follows.factor * values[joint.follows.joint - 1] + joint.follows.offset
        values.append(value)
        before = frames[k if joint.parent is None else joint.parent]
        still, moved = np.eye(4), np.eye(4)
        still[:3, :3] = Rotation.from_quat(joint.rotation, scalar_first=True).as_matrix()
        still[:3, 3] = joint.origin
        if joint.type == "prismatic":
            moved[:3, 3] = value * np.array(joint.axis)
        else:
            moved[:3, :3] = Rotation.from_rotvec(value * np.array(joint.axis)).as_matrix()
        frames.append(before @ still @ moved)
    return frames


@given(strategies.chains(trees=True), SEEDS)
def test_links_and_hands_by_matrices(arm, seed):
    low, high = np.array(arm.joint_range).T
    joints = np.random.default_rng(seed).uniform(low, high, (3, arm.dof))
    (ends, radii), (hands, axes) = arms.links_along(arm, joints), arms.hands_along(arm, joints)
    assert radii == pytest.approx([link.radius for link in arm.model.links])
    for k, q in enumerate(joints):
        frames = frames_of(arm, q)
        for i, link in enumerate(arm.model.links):
            for end, point in enumerate((link.start, link.end)):
                there = frames[link.joint] @ [*point, 1.0]
                assert ends[k, i, end] == pytest.approx(there[:3], abs=1e-9)
        pose, hand = frames[arm.model.hand.joint], arm.model.hand
        assert hands[k] == pytest.approx((pose @ [*hand.point, 1.0])[:3], abs=1e-9)
        assert axes[k] == pytest.approx(pose[:3, :3] @ hand.axis, abs=1e-9)


def joint(**more):
    """A joint about z, half a unit beyond the one before."""
    return arms.ChainJoint(**{"axis": (0, 0, 1), "range": (-2.0, 2.0), "max_speed": 3.0,
                         "origin": (0.5, 0.0, 0.0), **more})  # fmt: skip


def arm_with(*joints, posture=(0.0,), **more):
    """A chain of joints after a first one of range -1 to 1, with the hand on the last frame."""
    every = (joint(range=(-1.0, 1.0)), *joints)
    links = (arms.Link(len(every), (0, 0, 0), (0.3, 0, 0), 0.02),)
    model = arms.ChainModel("made", every, links, arms.Hand(len(every), (0.4, 0, 0)))
    return arms.Chain(model, posture, 0.05, **more)


def test_followers_bind_their_leader():
    follower = joint(follows=arms.Follows(1, -2.0, 0.1), range=(-0.9, 1.1), max_speed=1.0)
    arm = arm_with(follower)
    assert arm.dof == 1 and arms.limb_of_chain(arm).tree is not None
    assert arm.joint_range[0] == pytest.approx((-0.5, 0.5))
    assert arm.max_joint_speed == (0.5,)


def test_limits_of_acceleration_of_followers_hold_beside_a_situations_list():
    first = joint(range=(-1.0, 1.0), max_acceleration=9.0)
    follower = joint(follows=arms.Follows(1, 2.0), max_acceleration=4.0)
    link, hand = arms.Link(1, (0, 0, 0), (0.3, 0, 0), 0.02), arms.Hand(2, (0.4, 0, 0))
    model = arms.ChainModel("made", (first, follower), (link,), hand)
    assert arms.Chain(model, (0.0,), 0.05).max_joint_acceleration == (2.0,)
    most = arms.Chain(model, (0.0,), 0.05, max_joint_acceleration=(7.0,)).max_joint_acceleration
    assert most == (2.0,)
    assert (
        arms.Chain(model, (0.0,), 0.05, max_joint_acceleration=None).max_joint_acceleration is None
    )
    # followers need no limit where coordinates have one
    free = replace(model, joints=(first, replace(follower, max_acceleration=None)))
    assert arms.Chain(free, (0.0,), 0.05).max_joint_acceleration == (9.0,)


def test_a_start_just_outside_a_followers_range_is_in_the_arms():
    follower = joint(follows=arms.Follows(1, 1.0), range=(-0.5, 0.5))
    start = 0.5 + 0.9e-6
    arm = arm_with(follower, posture=(start,))
    assert arm.joint_range == ((-0.5, start),)
    with pytest.raises(
        SituationError, match=r"posture\[0\]: puts its follower joints\[1\] at 0\.5"
    ):
        arm_with(follower, posture=(0.5 + 1.1e-6,))


def test_parents_that_are_the_frame_before_are_left_out():
    assert arm_with(joint(parent=1), posture=(0.0, 0.0)) == arm_with(joint(), posture=(0.0, 0.0))
    assert arm_with(joint(parent=1), posture=(0.0, 0.0)).model.serial


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ([{"parent": 2}], r"joints\[1\]\.parent: must be from 0 to 1, .* \(got 2\)"),
        ([{"parent": -1}], r"joints\[1\]\.parent: must be from 0 to 1"),
        ([{"follows": arms.Follows(2, 1.0)}], r"joints\[1\]\.follows\.joint: must be from 1 to 1"),
        ([{"follows": arms.Follows(0, 1.0)}], r"joints\[1\]\.follows\.joint: must be from 1 to 1"),
        (
            [{"follows": arms.Follows(1, 1.0)}, {"follows": arms.Follows(2, 1.0)}],
            r"joints\[2\]\.follows\.joint: is a joint that follows another itself \(got 2\)",
        ),
    ],
)
def test_trees_that_are_refused(more, message):
    with pytest.raises(SituationError, match=message):
        arm_with(*[joint(**fields) for fields in more])
