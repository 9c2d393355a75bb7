"""Physical properties of an arm: the exchange format ``gcm-learn/body@1``."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gcm_learn.arms import JOINTS, SpatialArm
from gcm_learn.checks import non_negative, positive, put, quote, show, text, vector
from gcm_learn.errors import FileFormatError, SituationError
from gcm_learn.situation.json_records import check_names, made_from, object_from, record_from
from gcm_learn.situation.json_text import JsonTextError, line_of, parse

BODY_FORMAT = "gcm-learn/body@1"
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
        The largest, either way; above zero [N m].
    armature : float
        Inertia of the rotor, as the joint feels it; not negative [kg m^2].
    damping : float
        Torque against the motion for each rad/s; not negative [N m s].
    """

    torque: float
    armature: float = 0.0
    damping: float = 0.0

    def __post_init__(self) -> None:
        """Check the documented ranges."""
        put(self, "torque", positive(self.torque, "torque"))
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

    def __post_init__(self) -> None:
        """Check the documented shapes."""
        put(self, "metres", positive(self.metres, "metres"))
        put(self, "gravity", vector(self.gravity, "gravity", 3))
        put(self, "name", text(self.name, "name"))
        for field, kind, count in (("bones", BoneMass, BONES), ("joints", Motor, JOINTS)):
            given = getattr(self, field)
            if len(given) != count or not all(isinstance(item, kind) for item in given):
                raise SituationError(field, f"must be {count} of {kind.__name__}")
            put(self, field, tuple(given))

    def misfit(self, arm: SpatialArm) -> str:
        """Say in a sentence why this is not the body of an arm; empty if it is."""
        for label, vector_, bone in zip(
            ("upper_arm", "forearm"), (arm.upper_arm, arm.forearm), self.bones, strict=True
        ):
            length = math.hypot(*vector_) * self.metres
            if bone.length is not None and abs(length - bone.length) > FITS * bone.length:
                return f"{label}: is {length:.4g} m long, the body's is {bone.length:.4g} m"
        return ""


def read_arm_body(path: str | Path) -> ArmBody:
    """Read a file of one body.

    Raises
    ------
    FileFormatError
        One line: ``nao.json:7: joints[2].torque: must be positive (got 0)``.
    """
    try:
        content = Path(path).read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise FileFormatError(f"{path}:1: is not UTF-8 text ({error.reason})") from None
    except (OSError, ValueError) as error:  # ValueError: a path with a null byte
        reason = getattr(error, "strerror", None) or error
        raise FileFormatError(f"{path}: cannot be read ({reason})") from None
    try:
        return arm_body_from_json(parse(content))
    except JsonTextError as error:
        raise FileFormatError(f"{path}:{error.line}: not valid JSON: {error.reason}") from None
    except SituationError as error:
        raise FileFormatError(f"{path}:{line_of(content, error.field)}: {error}") from None


def arm_body_from_json(obj: object) -> ArmBody:
    """The body that a parsed JSON value describes.

    Raises
    ------
    SituationError
        With the path of the offending field, e.g. ``"bones[1].mass"``.
    """
    members = object_from(obj, "")
    given = members.get("format")
    if given != BODY_FORMAT:
        raise SituationError("format", f"must be {quote(BODY_FORMAT)} (got {show(given)})")
    check_names(members, "", ArmBody, extra=("format",))
    values: dict[str, Any] = {k: v for k, v in members.items() if k != "format"}
    for field, kind in (("bones", BoneMass), ("joints", Motor)):
        if not isinstance(values[field], list):
            raise SituationError(field, f"must be a list of objects (got {show(values[field])})")
        values[field] = tuple(
            record_from(kind, item, f"{field}[{k}]") for k, item in enumerate(values[field])
        )
    return made_from(ArmBody, values, "")
