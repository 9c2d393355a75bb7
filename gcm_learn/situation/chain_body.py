"""Physical properties of a chain: the records of the format ``gcm-learn/body@2``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from gcm_learn.arms import Chain
from gcm_learn.checks import non_negative, put, sequence, vector
from gcm_learn.errors import SituationError
from gcm_learn.situation.arm_body import Motor, check_world, records

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
        """Say in a sentence why this is not the body of an arm; empty if it is."""
        if len(arm.model.joints) != len(self.joints):
            return f"joints: the arm has {len(arm.model.joints)}, the body has {len(self.joints)}"
        for k, (line, motor) in enumerate(zip(arm.model.lines, self.joints, strict=True)):
            if not line.leads and motor.torque != 0.0:
                return f"joints[{k}].torque: must be 0, as the joint follows another"
        return ""
