"""The arm in space: a chain of two bones, a shoulder of two joints and an elbow of two more."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any, ClassVar

from gcm_learn.arms.chain import Chain, Start, started
from gcm_learn.arms.chain_model import ChainJoint, ChainModel, Hand, Link
from gcm_learn.arms.rotations import IDENTITY, Base
from gcm_learn.checks import (
    in_ranges,
    non_negative,
    positive,
    positive_vector,
    put,
    sequence,
    show,
    vector,
)
from gcm_learn.errors import SituationError

JOINTS = 4
OTHER_ARMS = "an arm with any other joints is a chain (gcm-learn/arm@1)"
"""End of messages to arms that fit no other kind."""
RATES = Start("joint_rates", "max_joint_acceleration", "fast")
ACCELERATIONS = Start("joint_accelerations", "max_joint_jerk", "large")
AXES = ((0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
"""Axes of the joints, each in the frame of the joint before."""
_NAMES = ("shoulder_pitch", "shoulder_roll", "elbow_yaw", "elbow_roll")


class Bone(Link):
    """A link that may have no thickness."""

    def _radius(self) -> float:
        return non_negative(self.radius, "radius")


@dataclass(frozen=True, kw_only=True)
class SpatialArm(Chain):
    """A chain of two bones and four joints in space, whose inverse has a closed form.

    R_x, R_y and R_z are the rotations about an axis. In the frame of the base
    ``elbow = R_y(q1) R_z(q2) upper_arm`` and
    ``hand = elbow + R_y(q1) R_z(q2) R_x(q3) R_z(q4) forearm``.
    Lengths are in any one unit.

    Parameters
    ----------
    upper_arm, forearm : (3,) tuple of float
        Shoulder to elbow and elbow to hand, each in its own bone's frame, not of length 0.
    joints : (4,) tuple of float
        Joint angles q at t = 0, within `joint_range` [rad].
    joint_range : (4, 2) tuple of float
        Lowest and highest angle of each joint, both allowed; angles are not taken modulo 2 pi.
    max_joint_speed : (4,) tuple of float
        Above zero [rad/s].
    grasp : float
        Signed distance of hand and target at which it is caught, not negative.
    base : Base
        Where the shoulder is.
    joint_rates : (4,) tuple of float, optional
        Rates of the joints at t = 0, within `max_joint_speed` [rad/s]. Only with
        `max_joint_acceleration`, and zero there when absent.
    max_hand_speed : float, optional
        Above zero [lengths/s]; no limit when absent.
    max_joint_acceleration : (4,) tuple of float, optional
        Above zero [rad/s^2]; no limits when absent.
    thickness : float
        Radius of both bones, not negative.
    max_joint_jerk : (4,) tuple of float, optional
        Above zero, and only with limits of acceleration [rad/s^3]; no limits when absent.
    joint_accelerations : (4,) tuple of float, optional
        Accelerations at t = 0; only with limits of jerk, and zero there when absent [rad/s^2].
    """

    upper_arm: tuple[float, float, float]
    forearm: tuple[float, float, float]
    joints: tuple[float, float, float, float]
    joint_range: tuple[tuple[float, float], ...] = field()  # type: ignore[assignment]
    max_joint_speed: tuple[float, float, float, float] = field()  # type: ignore[assignment]
    grasp: float
    base: Base = IDENTITY
    joint_rates: tuple[float, float, float, float] | None = None
    max_hand_speed: float | None = None
    max_joint_acceleration: tuple[float, float, float, float] | None = None
    thickness: float = 0.0  # type: ignore[misc]
    max_joint_jerk: tuple[float, float, float, float] | None = None
    joint_accelerations: tuple[float, float, float, float] | None = None
    model: ChainModel = field(init=False, repr=False)
    ignore: tuple[tuple[int | str, str], ...] = field(init=False, repr=False, default=())

    kind: ClassVar[str] = "spatial"

    def __post_init__(self) -> None:
        """Check the documented ranges, then how the arm stands and moves at t = 0."""
        if not isinstance(self.base, Base):
            raise SituationError("base", f"must be a base (got {show(self.base)})")
        for name in ("joint_range", "joints", "max_joint_speed"):
            _check_count(getattr(self, name), name)
        for name in ("upper_arm", "forearm"):
            put(self, name, _bone(getattr(self, name), name))
        put(self, "joint_range", _ranges(self.joint_range))
        put(self, "joints", vector(self.joints, "joints", JOINTS))
        for name in ("max_joint_speed", "max_joint_acceleration", "max_joint_jerk"):
            if name == "max_joint_speed" or getattr(self, name) is not None:
                put(self, name, positive_vector(getattr(self, name), name, JOINTS))
        if self.max_hand_speed is not None:
            put(self, "max_hand_speed", positive(self.max_hand_speed, "max_hand_speed"))
        for name in ("thickness", "grasp"):
            put(self, name, non_negative(getattr(self, name), name))
        put(self, "joints", in_ranges(self.joints, self.joint_range, "joints"))
        most, jerks = self.max_joint_acceleration, self.max_joint_jerk
        if jerks is not None and most is None:
            raise SituationError("max_joint_jerk", "is given without max_joint_acceleration")
        put(self, "joint_rates", started(self.joint_rates, RATES, self.max_joint_speed, most))
        now = self.joint_accelerations
        put(self, "joint_accelerations", started(now, ACCELERATIONS, most, jerks))
        bones = self.upper_arm, self.forearm, self.thickness
        put(self, "model", _model(*bones, self.joint_range, self.max_joint_speed))

    def thicker(self, width: float) -> SpatialArm:
        """Return the arm with bones that are thicker by a width."""
        return replace(self, thickness=self.thickness + width)

    def slower(self, share: float) -> SpatialArm:
        """Return the arm with the speed limits of hand and joints multiplied by `share`."""
        speed = None if self.max_hand_speed is None else share * self.max_hand_speed
        joints: Any = tuple(share * top for top in self.max_joint_speed)
        return replace(self, max_hand_speed=speed, max_joint_speed=joints)

    def without_pairs(self) -> SpatialArm:
        """Return the arm itself: it has no pairs of links to keep apart."""
        return self


@lru_cache(maxsize=64)
def _model(
    upper: tuple[float, float, float],
    fore: tuple[float, float, float],
    radius: float,
    ranges: tuple[tuple[float, float], ...],
    speeds: tuple[float, ...],
) -> ChainModel:
    """Return the chain: joints turn about y and z, then beyond the elbow about x and z."""
    none = (0.0, 0.0, 0.0)
    joints = tuple(
        ChainJoint(AXES[k], pair, speed, origin=upper if k == 2 else none, name=_NAMES[k])
        for k, (pair, speed) in enumerate(zip(ranges, speeds, strict=True))
    )
    length = math.hypot(*fore)
    hand = Hand(JOINTS, fore, (fore[0] / length, fore[1] / length, fore[2] / length))
    links = Bone(2, none, upper, radius, "upper arm"), Bone(4, none, fore, radius, "forearm")
    return ChainModel("", joints, links, hand)


def _check_count(value: object, name: str) -> None:
    """Refuse lists for other numbers of joints, and name the kind of arm that has them."""
    if isinstance(value, list | tuple) and len(value) != JOINTS:
        reason = f"must be a list of {JOINTS} (got {len(value)}): a spatial arm has 4 joints"
        raise SituationError(name, f"{reason}; {OTHER_ARMS}")


def _bone(value: object, name: str) -> tuple[float, ...]:
    """Return a bone's vector (3,), which has a length."""
    result = vector(value, name, 3)
    if math.hypot(*result) == 0.0:
        raise SituationError(name, "must not have length 0")
    return result


def _ranges(value: object) -> tuple[tuple[float, float], ...]:
    """Return the four pairs of lowest and highest angle."""
    pairs = sequence(value, "joint_range", f"{JOINTS} pairs")
    result = []
    for k, pair in enumerate(pairs):
        low, high = vector(pair, f"joint_range[{k}]", 2)
        if low > high:
            raise SituationError(f"joint_range[{k}]", f"low {low} is above high {high}")
        result.append((low, high))
    return tuple(result)
