"""The canonical form in space: without the base, and with left arms only."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, strategies as st

from gcm_learn.arms import Base, forward_in_space, quaternion_of, rotation_of
from gcm_learn.scene import pose
from gcm_learn.situation import Pendulum, SpatialFrame, canonical, situation_from_json
from tests import strategies
from tests.situation.scenes import MOVING, NAO
from tests.transforms import carried_motion

MIRROR = np.diag([1.0, -1.0, 1.0])


def moved(situation, matrix, shift):
    """Carry or mirror a whole situation: x -> matrix x + shift, `matrix` orthogonal.

    A mirrored arm is written as the mirror in the xz-plane of its base, whose pose is then proper.
    """
    arm, mirrored = situation.arm, np.linalg.det(matrix) < 0
    base = matrix @ rotation_of(arm.base.rotation)
    if mirrored:
        base = base @ MIRROR
        signs = np.array([1.0, -1.0, -1.0, -1.0])
        ranges = [arm.joint_range[0], *((-high, -low) for low, high in arm.joint_range[1:])]
        arm = replace(
            arm, upper_arm=tuple(MIRROR @ arm.upper_arm), forearm=tuple(MIRROR @ arm.forearm),
            joint_range=tuple(ranges), joints=tuple(signs * arm.joints),
            joint_rates=None if arm.joint_rates is None else tuple(signs * arm.joint_rates),
        )  # fmt: skip
    origin = tuple((matrix @ arm.base.origin + shift).tolist())
    arm = replace(arm, base=Base(origin, quaternion_of(base)))
    bodies = tuple(
        replace(body, motion=carried_motion(body.motion, matrix, shift))
        for body in situation.bodies
    )
    return replace(situation, arm=arm, bodies=bodies)


def assert_same(a, b):
    """The same arm, and bodies of the same shapes that do the same."""
    for name in ("upper_arm", "forearm", "joints", "joint_range", "max_joint_speed"):
        np.testing.assert_allclose(getattr(a.arm, name), getattr(b.arm, name), atol=1e-12)
    np.testing.assert_allclose(a.arm.joint_rates or (), b.arm.joint_rates or (), atol=1e-12)
    assert a.arm.base == b.arm.base == Base()
    for k, (one, other) in enumerate(zip(a.bodies, b.bodies, strict=True)):
        assert one.shape == other.shape
        for t in (0.0, 0.6 * a.horizon, a.horizon):
            (place, turn), (there, turned) = pose(a, k, t), pose(b, k, t)
            np.testing.assert_allclose(place, there, atol=1e-7)
            if one.shape.kind in ("capsule", "cylinder"):  # nobody sees them roll
                turn, turned = turn[:, 2], turned[:, 2]
            np.testing.assert_allclose(turn, turned, atol=1e-6)


shifts = strategies.vectors(3)


@given(strategies.spatial_situations(), strategies.rotations(), shifts, st.booleans())
def test_situations_that_differ_by_how_they_lie_have_one_form(situation, turn, shift, mirror):
    there = moved(situation, turn @ MIRROR if mirror else turn, shift)
    (a, frame), (b, other) = canonical(situation), canonical(there)
    if mirror and frame.mirrored is other.mirrored:  # as where everything is in the xz-plane
        np.testing.assert_allclose(a.arm.joints[1:], 0.0, atol=1e-9)
        return
    assert (frame.mirrored is not other.mirrored) is mirror
    assert_same(a, b)


@given(strategies.spatial_situations(), strategies.vectors(4))
def test_the_arm_in_the_frame_is_the_arm_that_was_there(situation, q):
    """What mirrors do to joints is confirmed by forward kinematics."""
    form, frame = canonical(situation)
    joints = frame.canonical_joints(q)
    here = forward_in_space(situation.arm, q)
    for before, after in zip(here, forward_in_space(form.arm, joints), strict=True):
        np.testing.assert_allclose(frame.canonical(before), after, atol=1e-9)
        np.testing.assert_allclose(frame.original(after), before, atol=1e-9)
    np.testing.assert_array_equal(frame.canonical_joints(situation.arm.joints), form.arm.joints)


@given(strategies.spatial_situations(1), st.floats(0.0, 1.0), strategies.vectors(3))
def test_bodies_are_where_the_frame_says(situation, share, point):
    """Every point of every body, and not only their centres."""
    form, frame = canonical(situation)
    t = share * situation.horizon
    world = replace(situation, arm=replace(situation.arm, base=Base()))  # poses in the world
    (place, turn), (there, turned) = pose(world, 0, t), pose(form, 0, t)
    if situation.bodies[0].shape.kind == "sphere":
        turn = turned = np.eye(3)
    of_body = MIRROR @ point if frame.mirrored else np.array(point)
    reached = there + turned @ of_body
    if situation.bodies[0].shape.kind != "sphere":
        np.testing.assert_allclose(
            frame.canonical(place + turn @ np.array(point)), reached, atol=1e-6
        )
    np.testing.assert_allclose(frame.canonical(place), there, atol=1e-7)


@given(strategies.spatial_situations())
def test_a_canonical_situation_is_its_own_form(situation):
    form, _ = canonical(situation)
    again, frame = canonical(form)
    assert frame == SpatialFrame(Base(), False)
    assert_same(again, form)


def test_left_arms_stay_and_right_arms_are_mirrored():
    left = situation_from_json(MOVING)
    assert not canonical(left)[1].mirrored
    right = moved(left, MIRROR, np.zeros(3))
    assert right.arm.joint_range[1] == (-1.3265, 0.3142)
    form, frame = canonical(right)
    assert frame.mirrored
    assert form.arm == canonical(left)[0].arm
    assert form.arm.joint_rates == left.arm.joint_rates
    assert all(math.copysign(1.0, x) > 0 for x in form.arm.joint_rates if x == 0.0)


@pytest.mark.parametrize("place", ["joints", "body"])
def test_an_arm_without_a_side_gets_one_from_what_happens(place):
    situation = situation_from_json(NAO)
    ranges = ((-2, 2), (-1, 1), (-2, 2), (-1, 1))
    joints = (0.3, -0.2 if place == "joints" else 0, 0, 0)
    arm = replace(
        situation.arm, upper_arm=(0.1, 0, 0), forearm=(0.1, 0, 0.01), joint_range=ranges,
        joints=joints, base=Base(),
    )  # fmt: skip
    there = replace(situation, arm=arm)
    motion = replace(there.bodies[0].motion, position=(0.2, -0.1, 0.4))
    there = replace(there, bodies=(replace(there.bodies[0], motion=motion), *there.bodies[1:]))
    form, frame = canonical(there)
    assert frame.mirrored
    assert form.bodies[0].motion.position[1] == 0.1
    assert form.arm.joints[1] == (0.2 if place == "joints" else 0.0)
    assert isinstance(form.bodies[1].motion, Pendulum)
    other, turned = canonical(moved(there, MIRROR, np.zeros(3)))
    assert not turned.mirrored
    assert_same(form, other)
