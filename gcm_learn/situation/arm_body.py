"""Physical properties of arms in joints: records and files of the format ``gcm-learn/body@1``."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import numpy as np

from gcm_learn.arms import JOINTS, Chain, SpatialArm
from gcm_learn.checks import non_negative, positive, put, quote, sequence, show, text, vector
from gcm_learn.errors import SituationError
from gcm_learn.situation import json_records

BONES = 2
FITS = 0.01
"""Tolerance of the lengths of bones, as a share of them."""


@dataclass(frozen=True)
class BoneMass:
    """Mass of a bone, with all parts that move with it.

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
        """Return a sentence why this body does not fit an arm; empty if it fits."""
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


Row = tuple[float, float, float]
ROUGH = 1e-6
"""Tolerance of symmetry and of principal moments, as a share of the largest number."""


@dataclass(frozen=True)
class FrameMass:
    """Mass that a frame of a chain carries.

    Parameters
    ----------
    mass : float
        Not negative [kg].
    centre : (3,) tuple of float
        Of mass, in the frame [m].
    inertia : (3, 3) tuple of float
        About the centre, along the axes of the frame; symmetric [kg m^2]. No principal moment is
        negative or exceeds the sum of the others.
    """

    mass: float
    centre: Row
    inertia: tuple[Row, Row, Row]

    def __post_init__(self) -> None:
        """Check the documented ranges."""
        put(self, "mass", non_negative(self.mass, "mass"))
        put(self, "centre", vector(self.centre, "centre", 3))
        rows = sequence(self.inertia, "inertia", "3 rows")
        if len(rows) != 3:
            raise SituationError("inertia", f"must be a list of 3 rows (got {len(rows)})")
        put(self, "inertia", tuple(vector(r, f"inertia[{k}]", 3) for k, r in enumerate(rows)))
        self._check_inertia()

    def _check_inertia(self) -> None:
        given = np.array(self.inertia)
        rough = ROUGH * float(np.abs(given).max())
        for i, j in ((0, 1), (0, 2), (1, 2)):
            if abs(given[i, j] - given[j, i]) > rough:
                both = f"{given[i, j]:g} and {given[j, i]:g}"
                raise SituationError(f"inertia[{i}][{j}]", f"must equal [{j}][{i}] ({both})")
        low, middle, high = np.linalg.eigvalsh(given).tolist()
        if low < -rough:
            raise SituationError("inertia", f"has the negative principal moment {low:g}")
        if high > low + middle + rough:
            raise SituationError("inertia", f"{high:g} is more than the sum of the other two")


@dataclass(frozen=True)
class ChainBody:
    """Masses and motors of a chain.

    Parameters
    ----------
    metres : float
        Length of the unit in which the arm is given [m].
    gravity : (3,) tuple of float
        In the world frame [m/s^2].
    frames : (m + 1,) tuple of FrameMass
        Of the base and of every joint, in the order of the arm's frames. Beyond every joint there
        is something that it moves: a mass, an inertia, or its own armature.
    joints : (m,) tuple of Motor
        In the order of the arm's joints; those of followers have no torque.
    name : str
    """

    metres: float
    gravity: Row
    frames: tuple[FrameMass, ...]
    joints: tuple[Motor, ...]
    name: str = ""

    format: ClassVar[str] = "gcm-learn/body@2"
    """Format of its files."""

    def __post_init__(self) -> None:
        """Check the documented shapes."""
        check_world(self)
        if not self.joints:
            raise SituationError("joints", "must not be empty")
        for field, record, count in (
            ("joints", Motor, len(self.joints)), ("frames", FrameMass, len(self.joints) + 1),
        ):  # fmt: skip
            put(self, field, records(getattr(self, field), field, record, count))
        heavy = False
        for k in range(len(self.joints), 0, -1):
            heavy = heavy or self.frames[k].mass > 0.0 or bool(np.any(self.frames[k].inertia))
            if not heavy and self.joints[k - 1].armature == 0.0:
                reason = f"is 0, and so is the joint's armature: nothing resists joint {k}"
                raise SituationError(f"frames[{k}].mass", reason)

    def misfit(self, arm: Chain) -> str:
        """Return a sentence why this body does not fit an arm; empty if it fits."""
        if len(arm.model.joints) != len(self.joints):
            return f"joints: the arm has {len(arm.model.joints)}, the body has {len(self.joints)}"
        for k, (line, motor) in enumerate(zip(arm.model.lines, self.joints, strict=True)):
            if not line.leads and motor.torque != 0.0:
                return f"joints[{k}].torque: must be 0, as the joint follows another"
        return ""


AnyArmBody = ArmBody | ChainBody
"""Body of an arm of any kind that has one."""


class _Layout(NamedTuple):
    """Record type of a format, and the record types in its lists."""

    record: type[Any]
    parts: dict[str, type[Any]]


_LAYOUTS = {
    layout.record.format: layout
    for layout in (
        _Layout(ArmBody, {"bones": BoneMass, "joints": Motor}),
        _Layout(ChainBody, {"frames": FrameMass, "joints": Motor}),
    )
}
"""By the name of the format."""


def read_arm_body(path: str | Path) -> AnyArmBody:
    """Read the body of an arm from a file.

    Raises
    ------
    FileFormatError
        One line: ``nao.json:7: joints[2].torque: must be positive (got 0)``.
    """
    return json_records.read_value(Path(path), str(path), arm_body_from_json)


def arm_body_from_json(obj: object) -> AnyArmBody:
    """Return the body that a parsed JSON value describes.

    Raises
    ------
    SituationError
        With the path of the offending field, e.g. ``"bones[1].mass"``.
    """
    members = json_records.object_from(obj, "")
    given = members.get("format")
    layout = _LAYOUTS.get(given) if isinstance(given, str) else None
    if layout is None:
        known = " or ".join(quote(name) for name in _LAYOUTS)
        raise SituationError("format", f"must be {known} (got {show(given)})")
    json_records.check_names(members, "", layout.record, extra=("format",))
    values: dict[str, Any] = {k: v for k, v in members.items() if k != "format"}
    for field, record in layout.parts.items():
        values[field] = json_records.records_from(record, values[field], field)
    made: AnyArmBody = json_records.made_from(layout.record, values, "")
    return made


def arm_body_to_json(body: AnyArmBody) -> dict[str, Any]:
    """Return a body as a JSON object; `arm_body_from_json` restores an equal body."""
    return {"format": body.format, **json_records.members_of(body)}
