"""The arm in space: two bones, a shoulder that turns about two axes, a forearm about two more."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from gcm_learn.arms.rotations import unit_quaternion
from gcm_learn.arms.starts import Start, started
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


@dataclass(frozen=True)
class Base:
    """Pose of a spatial arm's shoulder in the world.

    Parameters
    ----------
    origin : (3,) tuple of float
        Position of the shoulder.
    rotation : (4,) tuple of float
        Unit quaternion (w, x, y, z), base to world; normalised.
    """

    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rotation: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        """Check the documented shapes and normalise the rotation."""
        put(self, "origin", vector(self.origin, "origin", 3))
        put(self, "rotation", unit_quaternion(self.rotation, "rotation"))


IDENTITY = Base()


@dataclass(frozen=True)
class SpatialArm:
    """An arm of two bones and four joints in space.

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
    joint_range: tuple[tuple[float, float], ...]
    max_joint_speed: tuple[float, float, float, float]
    grasp: float
    base: Base = IDENTITY
    joint_rates: tuple[float, float, float, float] | None = None
    max_hand_speed: float | None = None
    max_joint_acceleration: tuple[float, float, float, float] | None = None
    thickness: float = 0.0
    max_joint_jerk: tuple[float, float, float, float] | None = None
    joint_accelerations: tuple[float, float, float, float] | None = None

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

    @property
    def hand_axis(self) -> tuple[float, ...]:
        """Unit vector (3,) along the forearm, in its own frame."""
        return tuple(part / math.hypot(*self.forearm) for part in self.forearm)

    @property
    def reach(self) -> float:
        """Bound of the distance between shoulder and hand: both bones in line."""
        return math.hypot(*self.upper_arm) + math.hypot(*self.forearm)

    @property
    def inner_reach(self) -> float:
        """Bound of the same distance from below: the forearm folded back."""
        return abs(math.hypot(*self.upper_arm) - math.hypot(*self.forearm))


def _check_count(value: object, field: str) -> None:
    """Refuse lists for other numbers of joints, and name the kind of arm that has them."""
    if isinstance(value, list | tuple) and len(value) != JOINTS:
        reason = f"must be a list of {JOINTS} (got {len(value)}): a spatial arm has 4 joints"
        raise SituationError(field, f"{reason}; {OTHER_ARMS}")


def _bone(value: object, field: str) -> tuple[float, ...]:
    """Return a bone's vector (3,), which has a length."""
    result = vector(value, field, 3)
    if math.hypot(*result) == 0.0:
        raise SituationError(field, "must not have length 0")
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
