"""Canonical form of spatial situations that differ only by the base's pose or by a mirror.

A mirror in the xz-plane of the base makes a left arm of a right one.  It reverses the sense of
rotations about x and z, and keeps that of rotations about y.  So the first joint stays, and the
others change their signs.  Their ranges are turned round, and the bones' y coordinates change their
signs.  Nothing else is symmetry here, because joints have ranges.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from gcm_learn.arms import IDENTITY, Base, Chain, SpatialArm, rotation_of
from gcm_learn.situation.body import Approach, Body
from gcm_learn.situation.laws import carried, sides
from gcm_learn.situation.situation import AnySituation, Plane, Situation
from gcm_learn.situation.surfaces import SURFACES

_IDENTITY = np.eye(3)


def plane_frame(plane: Plane | None) -> tuple[np.ndarray, np.ndarray]:
    """Return the rotation world -> arm plane (rows x, y, normal) and the plane's origin."""
    if plane is None:
        return _IDENTITY, np.zeros(3)
    (a, b, c), (d, e, f) = plane.x, plane.y
    normal = (b * f - c * e, c * d - a * f, a * e - b * d)
    return np.array([plane.x, plane.y, normal]), np.asarray(plane.origin)


def arm_frame(situation: AnySituation) -> tuple[np.ndarray, np.ndarray]:
    """Return the rotation world -> the arm's coordinates, and their origin in the world.

    Returns
    -------
    rotation : (3, 3) ndarray
        Its rows are the arm's axes: x, y and normal of the arm plane, or x, y, z of the base.
    origin : (3,) ndarray
    """
    base = getattr(situation.arm, "base", None)
    if base is None:
        return plane_frame(situation.plane)
    return rotation_of(base.rotation).T, np.asarray(base.origin)


NOTHING = 1e-9
"""Share of the reach, and angle [rad], below which a number has no side."""

_MIRROR = np.array([1.0, -1.0, 1.0])  # of positions
_TURNS = np.array([1.0, -1.0, -1.0, -1.0])  # of joint angles


@dataclass(frozen=True)
class SpatialFrame:
    """Pose of a situation: its canonical form, mirrored in the xz-plane if so, then moved."""

    base: Base = IDENTITY
    """Pose of the shoulder in the world."""
    mirrored: bool = False
    """True for a right arm."""

    def canonical(self, points: ArrayLike) -> np.ndarray:
        """Points (..., 3) of the world in canonical coordinates."""
        there = np.asarray(points, dtype=float) - self.base.origin
        return there @ rotation_of(self.base.rotation) * self._sides

    def original(self, points: ArrayLike) -> np.ndarray:
        """Points (..., 3) in canonical coordinates, in the world."""
        there = np.asarray(points, dtype=float) * self._sides
        return there @ rotation_of(self.base.rotation).T + self.base.origin

    def canonical_joints(self, joints: ArrayLike) -> np.ndarray:
        """Joint angles or rates (..., dof) of the situation in canonical coordinates."""
        values = np.asarray(joints, dtype=float)
        return values * _TURNS + 0.0 if self.mirrored else values.copy()

    @property
    def _sides(self) -> np.ndarray:
        return _MIRROR if self.mirrored else np.ones(3)


def spatial_frame_of(situation: Situation[SpatialArm]) -> SpatialFrame:
    """Return the pose of a situation.

    The first number that has a side decides; a negative one is mirrored.  The order: the middles of
    the ranges of all joints but the first, the bones' y, joints and rates at t = 0, the bodies.
    """
    arm = situation.arm
    small = NOTHING * arm.reach
    for value, least in chain(_sides_of_arm(arm, small), _sides_of_bodies(situation, small)):
        if abs(value) > least:
            return SpatialFrame(arm.base, value < 0.0)
    return SpatialFrame(arm.base, False)


def _sides_of_arm(arm: SpatialArm, small: float) -> Iterator[tuple[float, float]]:
    """Yield each number of the arm that a mirror negates, and the size up to which it is 0."""
    yield from ((low + high, NOTHING) for low, high in arm.joint_range[1:])
    yield from ((bone[1], small) for bone in (arm.upper_arm, arm.forearm))
    for start in (arm.joints, arm.joint_rates, arm.joint_accelerations):
        yield from ((value, NOTHING) for value in (start or ())[1:])


def _sides_of_bodies(
    situation: Situation[SpatialArm], small: float
) -> Iterator[tuple[float, float]]:
    """Yield the same of the bodies, in the frame of the base."""
    for body in _in_base(situation, mirrored=False):
        yield from ((value, small) for value in sides(body.motion))  # type: ignore[arg-type]
        yield from ((one.axis[1], NOTHING) for one in body.approach)
        if body.place is not None:
            yield body.place.position[1], small


def canonical_in_space(
    situation: Situation[SpatialArm],
) -> tuple[Situation[SpatialArm], SpatialFrame]:
    """Return the situation in its canonical form, and its frame; see `canonical`."""
    frame = spatial_frame_of(situation)
    arm = _mirrored(situation.arm) if frame.mirrored else situation.arm
    bodies = tuple(_in_base(situation, mirrored=frame.mirrored))
    return replace(situation, arm=replace(arm, base=IDENTITY), bodies=bodies), frame


def canonical_on_base(situation: Situation[Chain]) -> tuple[Situation[Chain], SpatialFrame]:
    """Return the situation with its chain's base at the origin, and the frame of that base."""
    bodies = tuple(_in_base(situation, mirrored=False))
    arm = replace(situation.arm, base=IDENTITY)
    return replace(situation, arm=arm, bodies=bodies), SpatialFrame(situation.arm.base)


def _in_base(situation: Situation[Chain], *, mirrored: bool) -> Iterator[Body]:
    """Yield the bodies in the frame of the base, mirrored in its xz-plane if `mirrored`."""
    rows, origin = arm_frame(situation)
    turn = rows * _MIRROR[:, None] if mirrored else rows
    for body in situation.bodies:
        place, motion = body.place, carried(body.motion, turn, origin)  # type: ignore[arg-type]
        if place is not None:
            there = turn @ (np.asarray(place.position) - origin)
            place = replace(place, position=tuple(there.tolist()))
        approach, shape = body.approach, body.shape
        if mirrored:
            approach = tuple(map(_mirrored_approach, approach))
            shape = shape.mirrored if isinstance(shape, SURFACES) else shape
        yield replace(body, shape=shape, motion=motion, place=place, approach=approach)


def _mirrored_approach(approach: Approach) -> Approach:
    """Return an approach under a mirror that reflects body and forearm in their xz-planes."""
    hand = None if approach.hand is None else _bone(approach.hand)
    return replace(approach, axis=_bone(approach.axis), hand=hand)


def _bone(v: tuple[float, float, float]) -> tuple[float, float, float]:
    return (v[0], 0.0 - v[1], v[2])


def _mirrored(arm: SpatialArm) -> SpatialArm:
    """Return the arm mirrored in the xz-plane of its base."""

    def turned(q: tuple[float, ...] | None) -> Any:
        return None if q is None else (q[0], 0.0 - q[1], 0.0 - q[2], 0.0 - q[3])

    ranges = ((0.0 - high, 0.0 - low) for low, high in arm.joint_range[1:])
    return replace(
        arm,
        upper_arm=_bone(arm.upper_arm),
        forearm=_bone(arm.forearm),
        joint_range=(arm.joint_range[0], *ranges),
        joints=turned(arm.joints),
        joint_rates=turned(arm.joint_rates),
        joint_accelerations=turned(arm.joint_accelerations),
    )
