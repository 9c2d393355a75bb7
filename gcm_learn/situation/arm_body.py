"""Physical properties of a spatial arm: the records of the format ``gcm-learn/body@1``."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

from gcm_learn.arms import JOINTS, SpatialArm
from gcm_learn.checks import non_negative, positive, put, text, vector
from gcm_learn.errors import SituationError

BONES = 2
FITS = 0.01
"""Tolerance of the lengths of bones, as a share of them."""


@dataclass(frozen=True)
class BoneMass:
    """Mass of a bone, with all that moves with it.

    Parameters
    ----------
    mass : float
        Above zero [kg].
    centre : (3,) tuple of float
        Of mass, in the bone's frame: from the shoulder or the elbow [m].
    inertia : (3,) tuple of float
        About the principal axes, which are those of the bone's frame, at the centre [kg m^2].
        None exceeds the sum of the others.
    length : float, optional
        From joint to joint [m]; an arm that the body fits has bones of this length.
    """

    mass: float
    centre: tuple[float, float, float]
    inertia: tuple[float, float, float]
    length: float | None = None

    def __post_init__(self) -> None:
        """Check the documented ranges."""
        put(self, "mass", positive(self.mass, "mass"))
        put(self, "centre", vector(self.centre, "centre", 3))
        put(self, "inertia", vector(self.inertia, "inertia", 3))
        for k, value in enumerate(self.inertia):
            positive(value, f"inertia[{k}]")
        most = max(self.inertia)
        if most > (sum(self.inertia) - most) * (1.0 + 1e-9):
            raise SituationError("inertia", f"{most:g} is more than the sum of the other two")
        if self.length is not None:
            put(self, "length", positive(self.length, "length"))


@dataclass(frozen=True)
class Motor:
    """Motor of a joint.

    Parameters
    ----------
    torque : float
        The largest, either way; not negative [N m; N of a prismatic joint].
    armature : float
        Inertia of the rotor, as the joint feels it; not negative [kg m^2; kg].
    damping : float
        Torque against the motion for each rad/s; not negative [N m s; N s/m].
    """

    torque: float
    armature: float = 0.0
    damping: float = 0.0

    def __post_init__(self) -> None:
        """Check the documented ranges."""
        put(self, "torque", non_negative(self.torque, "torque"))
        put(self, "armature", non_negative(self.armature, "armature"))
        put(self, "damping", non_negative(self.damping, "damping"))


@dataclass(frozen=True)
class ArmBody:
    """Masses and motors of a spatial arm.

    Parameters
    ----------
    metres : float
        Length of the unit in which the arm is given [m].
    gravity : (3,) tuple of float
        In the world frame [m/s^2].
    bones : (2,) tuple of BoneMass
        Upper arm and forearm.
    joints : (4,) tuple of Motor
        In the order of the arm's joints.
    name : str
    """

    metres: float
    gravity: tuple[float, float, float]
    bones: tuple[BoneMass, ...]
    joints: tuple[Motor, ...]
    name: str = ""

    format: ClassVar[str] = "gcm-learn/body@1"
    """Format of its files."""

    def __post_init__(self) -> None:
        """Check the documented shapes."""
        check_world(self)
        for field, kind, count in (("bones", BoneMass, BONES), ("joints", Motor, JOINTS)):
            put(self, field, records(getattr(self, field), field, kind, count))
        for k, motor in enumerate(self.joints):
            positive(motor.torque, f"joints[{k}].torque")

    def misfit(self, arm: SpatialArm) -> str:
        """Say in a sentence why this is not the body of an arm; empty if it is."""
        for label, vector_, bone in zip(
            ("upper_arm", "forearm"), (arm.upper_arm, arm.forearm), self.bones, strict=True
        ):
            length = math.hypot(*vector_) * self.metres
            if bone.length is not None and abs(length - bone.length) > FITS * bone.length:
                return f"{label}: is {length:.4g} m long, the body's is {bone.length:.4g} m"
        return ""


def check_world(body: Any) -> None:
    """Check the name of a body, its unit of lengths and its gravity."""
    put(body, "metres", positive(body.metres, "metres"))
    put(body, "gravity", vector(body.gravity, "gravity", 3))
    put(body, "name", text(body.name, "name"))


def records(given: Any, field: str, record: type[Any], count: int) -> tuple[Any, ...]:
    """Return so many records of a type, in a tuple."""
    if len(given) != count or not all(isinstance(item, record) for item in given):
        raise SituationError(field, f"must be {count} of {record.__name__} (got {len(given)})")
    return tuple(given)
