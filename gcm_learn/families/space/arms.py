"""Spatial arms of families, and the paper's scenes for them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from gcm_learn.arms import SpatialArm
from gcm_learn.errors import UnknownNameError
from gcm_learn.families import paper
from gcm_learn.families.paper import EARTH, PAPER_SCENES
from gcm_learn.families.ranges import Range, Ranges, number, pick, span
from gcm_learn.situation import AnySituation, Body, Box, Capsule, Situation, SolidQuadratic, Sphere

Matrix = tuple[tuple[float, float], ...]


class Build(NamedTuple):
    """Measures of a left arm in a unit of its own: x ahead, y to the arm's side, z up."""

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
        """Draw an arm between human and NAO, in a unit of about its forearm, each number varied."""
        share, mixed = pick(rng, self.between), {}
        for name, human in HUMAN._asdict().items():
            unit = {"metres": 1.0 / NAO.unit, **_RADIANS}.get(name, NAO.unit)
            value = (1.0 - share) * np.array(human) + share * np.array(getattr(NAO, name)) / unit
            mixed[name] = value * (1.0 + self.around * rng.uniform(-1.0, 1.0, value.shape))
        return Build(**{name: _plain(value) for name, value in mixed.items()})


def arm_of(build: Build, joints: np.ndarray) -> SpatialArm:
    """Return the arm of a build at joint angles, with its shoulder at the origin."""
    names = set(SpatialArm.__dataclass_fields__) & set(Build._fields)
    shape = {name: getattr(build, name) for name in names}
    return SpatialArm(joints=_plain(joints), **shape)


def _plain(value: np.ndarray) -> Any:
    """An array as a number, or as tuples of them."""
    return tuple(map(_plain, value)) if value.ndim else float(value)


RAISED = (-0.32, 0.59, -1.01, -1.8)  # [rad] chosen: the hand is where it is in the plane
HANGING = (1.5, 0.1, -1.2, -0.05)  # [rad] chosen: the arm hangs down behind the box


def fig5_space() -> Situation[SpatialArm]:
    """A ball falls past a fixed bar (Fig. 5), before the human-like arm.

    Bar, ball, gravity and the limit of the hand's speed are as in the plane. The bar ends to
    either side, so that there is a way round its ends as well.
    """
    arm = replace(arm_of(HUMAN, np.array(RAISED)), max_hand_speed=paper.HAND_SPEED)
    planar = paper.fig5()
    return Situation("fig5-space", planar.horizon, arm, planar.bodies)


def fig8_space() -> Situation[SpatialArm]:
    """The pendulum experiment (Figs. 7 and 8) with NAO's left arm, in metres about its shoulder.

    The arm hangs down behind the box; the ball swings past over it. The hand has to be led up along
    the box, and round its edge.
    """
    swing = paper.pendulum_of(1.0, NAO.height)
    depth, width, height = paper.BOX_SIZE
    middle = (paper.BOX_DISTANCE + depth / 2, 0.0, height / 2 - NAO.height)
    radius, pivot = paper.BALL_DIAMETER / 2, swing(0.0)
    cord = pivot.length - radius
    box = SolidQuadratic(middle, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    bodies = (
        Body("target", "ball", Sphere(radius), swing(pivot.length)),
        Body("obstacle", "cord", Capsule(paper.CORD_RADIUS, cord / 2), swing(cord / 2)),
        Body("obstacle", "box", Box((depth / 2, width / 2, height / 2)), box),
    )
    return Situation("fig8-space", 1.2, arm_of(NAO, np.array(HANGING)), bodies)


SPATIAL_SCENES: dict[str, Callable[[], Situation[SpatialArm]]] = {
    "fig5-space": fig5_space,
    "fig8-space": fig8_space,
}


def paper_scene(name: str) -> AnySituation:
    """Return the scene of a paper's figure, e.g. ``paper_scene("fig4")`` or ``"fig8-space"``."""
    scene = SPATIAL_SCENES.get(name) or PAPER_SCENES.get(name)
    if scene is None:
        raise UnknownNameError.among("scene", name, [*PAPER_SCENES, *SPATIAL_SCENES])
    return scene()
