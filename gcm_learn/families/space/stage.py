"""Stage of families in space: an arm, its torso, and postures to aim at."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from gcm_learn.arms import Base, SpatialArm, forward_in_space, rotation_of
from gcm_learn.families.ranges import Range, pick, pick_angle
from gcm_learn.families.solids import gap, placed, solid, triple
from gcm_learn.families.space.arms import Build, arm_of
from gcm_learn.situation import Body, Capsule, Situation

POSTURES = 160  # that a draw chooses its start and its end from
ALONG = np.linspace(0.0, 1.0, 6)  # places on a bone that are asked for their distance
CHECKS = 8  # postures of a line that are asked for their distance
NECK, HIP = 0.1, -1.7  # heights of the ends of a torso, from the shoulder [forearms]
TIGHT = (0.04, 0.12)  # between torso and shoulder, beyond the limb's thickness [forearms]


class SpaceWay(NamedTuple):
    """From a start to a posture that catches, in a straight line of the joints."""

    start: np.ndarray
    """Joints (dof,) [rad]."""
    end: np.ndarray
    takes: float
    """At full speed [s]."""
    meet: np.ndarray
    """The hand (3,) at its end [forearms]."""

    def opens(self, horizon: float, left: float) -> float:
        """Return when a body opens that leaves `left` straight ways before the horizon [s]."""
        return max(horizon - left * self.takes, self.takes)

    def at(self, share: float) -> np.ndarray:
        """Joints (dof,) at a share of the way."""
        return self.start + share * (self.end - self.start)


class SpaceStage(NamedTuple):
    """An arm with its horizon, in forearms about its shoulder."""

    build: Build
    arm: SpatialArm
    """In any posture, its shoulder at the origin."""
    horizon: float
    """[s]"""
    torso: tuple[Body, ...]
    """None or one."""
    joints: np.ndarray
    """Postures (n, dof) within the joints' ranges, free of the torso [rad]."""

    @property
    def thickness(self) -> float:
        """Radius of the limb [forearms]."""
        return self.build.thickness / self.build.unit

    @property
    def grasp(self) -> float:
        """Distance at which a target is caught [forearms]."""
        return self.build.grasp / self.build.unit

    @property
    def reach(self) -> float:
        """Of the hand [forearms]."""
        return 1.0 + float(np.linalg.norm(self.build.upper_arm)) / self.build.unit

    def limb(self, joints: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Elbows and hands (..., 3) of joints (..., dof) [forearms]."""
        elbow, hand = forward_in_space(self.arm, joints)
        return elbow / self.build.unit, hand / self.build.unit

    def points(self, joints: np.ndarray) -> np.ndarray:
        """Places (..., 11, 3) on the limb, from the shoulder to the hand [forearms]."""
        elbow, hand = (place[..., None, :] for place in self.limb(joints))
        share = ALONG[:, None]
        return np.concatenate([share * elbow, elbow + share[1:] * (hand - elbow)], axis=-2)

    def room(self, joints: np.ndarray, bodies: Sequence[Body], t: float = 0.0) -> np.ndarray:
        """Estimate clearances of limbs at joints (..., dof) from bodies at time t [forearms]."""
        points = self.points(joints)
        gaps = [gap(points, body, t).min(axis=-1) for body in bodies if body.role == "obstacle"]
        return np.min([np.full(points.shape[:-2], np.inf), *gaps], axis=0) - self.thickness

    def lines(
        self, first: np.ndarray, last: np.ndarray, bodies: Sequence[Body], t: float
    ) -> np.ndarray:
        """Return which straight lines of joints (m, dof) are free of bodies as at time t (m,)."""
        shares = np.linspace(0.0, 1.0, CHECKS)[:, None, None]
        return np.all(self.room(first + shares * (last - first), bodies, t) > 0.0, axis=0)

    def way(
        self,
        rng: np.random.Generator,
        takes: Range,
        starts: np.ndarray | None = None,
        ends: np.ndarray | None = None,
    ) -> SpaceWay:
        """A way between two of the postures.

        Parameters
        ----------
        rng : numpy.random.Generator
        takes : (float, float)
            Range of its time [horizons]; the nearest there is, if there is none.
        starts, ends : (n,) ndarray of bool, optional
            Which postures may be either; all of them if none may.
        """
        first = self.joints[_one(rng, starts, len(self.joints))]
        turns = np.abs(self.joints - first) / self.build.max_joint_speed
        shares = turns.max(axis=1) / self.horizon
        off = np.maximum(np.maximum(takes[0] - shares, shares - takes[1]), 0.0)
        if ends is not None and ends.any():
            off = np.where(ends, off, np.inf)
        last = _one(rng, off <= off.min(), len(off))
        _, meet = self.limb(self.joints[last])
        return SpaceWay(first, self.joints[last], float(shares[last]) * self.horizon, meet)

    def situation(
        self,
        rng: np.random.Generator,
        name: str,
        start: np.ndarray,
        bodies: Sequence[Body],
        limits: Mapping[str, Any],
    ) -> Situation[SpatialArm]:
        """The situation in the world, the robot turned about the vertical at random."""
        build, angle = self.build, pick_angle(rng)
        rotation = (math.cos(0.5 * angle), 0.0, 0.0, math.sin(0.5 * angle))
        turn = rotation_of(rotation)
        origin = turn @ (0.0, build.aside, build.height)
        base = Base(triple(origin), rotation)
        joints: Any = tuple(start.tolist())
        arm = replace(self.arm, joints=joints, base=base, **limits)
        there = (placed(body, build.unit, turn, origin) for body in (*bodies, *self.torso))
        return Situation(name, self.horizon, arm, tuple(there))


def stage_of(rng: np.random.Generator, build: Build, horizon: float, torso: bool) -> SpaceStage:
    """An arm with random postures, beside a torso or not."""
    low, high = np.array(build.joint_range).T
    joints = low + (high - low) * rng.random((2 * POSTURES, len(low)))
    trunk = (_torso(rng, build),) if torso else ()
    bare = SpaceStage(build, arm_of(build, joints[0]), horizon, trunk, joints)
    free = joints[bare.room(joints, trunk) > 0.0] if torso else joints
    return bare._replace(joints=free[:POSTURES])


def _torso(rng: np.random.Generator, build: Build) -> Body:
    """Draw the torso: an upright capsule on the arm's other side, a little off the shoulder."""
    aside, thickness = build.aside / build.unit, build.thickness / build.unit
    radius = max(aside - thickness - pick(rng, TIGHT), 0.1)
    shape = Capsule(radius, 0.5 * (NECK - HIP))
    return solid("torso", shape, (0.0, -aside, 0.5 * (NECK + HIP)))


def _one(rng: np.random.Generator, allowed: np.ndarray | None, count: int) -> int:
    """Draw an index that is allowed, or any of `count` if none is allowed."""
    if allowed is None or not allowed.any():
        return int(rng.integers(count))
    return int(rng.choice(np.flatnonzero(allowed)))
