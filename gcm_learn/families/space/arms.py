"""Spatial arms to draw: a human-like one, NAO's left arm, and arms between and around them.

Numbers of NAO's arm are from its data sheet (H25); the human-like arm has two bones of 30 cm.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from gcm_learn.arms import SpatialArm
from gcm_learn.families.paper import EARTH
from gcm_learn.families.ranges import Range, Ranges, number, pick, span

Matrix = tuple[tuple[float, float], ...]


class Build(NamedTuple):
    """Measures of an arm, in a unit of its own; a left arm: x ahead, y to its side, z up."""

    metres: float
    """Length of the unit [m]."""
    upper_arm: tuple[float, float, float]
    forearm: tuple[float, float, float]
    joint_range: Matrix
    """[rad]"""
    max_joint_speed: tuple[float, float, float, float]
    """[rad/s]"""
    max_hand_speed: float
    thickness: float
    grasp: float
    aside: float
    """From the middle of the torso to the shoulder."""
    height: float
    """Of the shoulder above the floor."""

    @property
    def unit(self) -> float:
        """Length of the forearm, in which families count."""
        return math.hypot(*self.forearm)

    @property
    def gravity(self) -> float:
        """[forearms/s^2]"""
        return EARTH / (self.metres * self.unit)


HUMAN = Build(
    metres=0.3,
    upper_arm=(1.0, 0.0, 0.0),
    forearm=(1.0, 0.0, 0.0),
    joint_range=((-2.8, 2.0), (-0.6, 2.2), (-2.4, 2.4), (-2.6, 0.0)),
    max_joint_speed=(5.0, 5.0, 7.0, 7.0),
    max_hand_speed=6.0,
    thickness=0.12,
    grasp=0.1,
    aside=0.67,
    height=4.7,
)
NAO = Build(
    metres=1.0,
    upper_arm=(0.105, 0.015, 0.0),
    forearm=(0.1137, 0.0, -0.01231),
    joint_range=((-2.0857, 2.0857), (-0.3142, 1.3265), (-2.0857, 2.0857), (-1.5446, -0.0349)),
    max_joint_speed=(8.268, 7.194, 8.268, 7.194),
    max_hand_speed=2.0,
    thickness=0.025,
    grasp=0.015,
    aside=0.098,
    height=0.43,
)
_RADIANS = {"joint_range": 1.0, "max_joint_speed": 1.0}  # do not count in forearms, as the rest do


@dataclass(frozen=True)
class SpatialArmRanges(Ranges):
    """Ranges of spatial arms, of the duration of situations, and of the limits of movements."""

    human: float = number(0.4)
    """Share of arms that are the human-like one."""
    nao: float = number(0.4)
    """Share of arms that are NAO's, in metres. The others are between and around the two."""
    between: Range = span(0.0, 1.0, -0.5, 1.5)
    """Place between the two arms: 0 is the human-like arm, 1 NAO's in its forearms."""
    around: float = number(0.15, most=0.3)
    """Largest deviation of each number from there, as a share of it."""
    horizon: Range = span(1.0, 2.0, 1e-3)
    """Last moment at which a catch counts [s]."""
    ramp: Range = span(0.0, 0.0)
    """Times in which joints come to their full speed [s]; at 0 nothing limits accelerations."""
    moving: float = number(0.0, most=0.99)
    """Largest rate of a joint at t = 0 where accelerations are limited [of its full speed]."""
    torso: float = number(0.6)
    """Share of arms beside which a torso stands."""

    def build(self, rng: np.random.Generator) -> Build:
        """Draw an arm."""
        place = rng.random() * max(self.human + self.nao, 1.0)
        if place < self.human:
            return HUMAN
        return NAO if place < self.human + self.nao else self._mixed(rng)

    def limits(self, rng: np.random.Generator, build: Build) -> dict[str, Any]:
        """Draw limits of accelerations, and rates at t = 0, as arguments of an arm."""
        ramp = pick(rng, self.ramp)
        if ramp == 0.0:
            return {}
        top = np.array(build.max_joint_speed)
        rates = self.moving * top * rng.uniform(-1.0, 1.0, top.size)
        limits = {"max_joint_acceleration": top / ramp, "joint_rates": rates}
        return {name: _plain(values) for name, values in limits.items()}

    def _mixed(self, rng: np.random.Generator) -> Build:
        """An arm between the two, in a unit of about its forearm, each number moved a little."""
        share, mixed = pick(rng, self.between), {}
        for name, human in HUMAN._asdict().items():
            unit = {"metres": 1.0 / NAO.unit, **_RADIANS}.get(name, NAO.unit)
            value = (1.0 - share) * np.array(human) + share * np.array(getattr(NAO, name)) / unit
            mixed[name] = value * (1.0 + self.around * rng.uniform(-1.0, 1.0, value.shape))
        return Build(**{name: _plain(value) for name, value in mixed.items()})


def arm_of(build: Build, joints: np.ndarray) -> SpatialArm:
    """An arm with its shoulder at the origin."""
    names = set(SpatialArm.__dataclass_fields__) & set(Build._fields)
    shape = {name: getattr(build, name) for name in names}
    return SpatialArm(joints=_plain(joints), **shape)


def _plain(value: np.ndarray) -> Any:
    """An array as a number, or as tuples of them."""
    return tuple(map(_plain, value)) if value.ndim else float(value)
