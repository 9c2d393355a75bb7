"""Families of situations that depend on a few parameters, each linearly."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from gcm_learn.arms import Arm, SpatialArm
from gcm_learn.errors import FamilyError, UnknownNameError
from gcm_learn.situation import (
    AnySituation,
    Body,
    Box,
    Capsule,
    Disc,
    PlanarQuadratic,
    Situation,
    SolidQuadratic,
    Sphere,
    situation_to_json,
)
from gcm_learn.storage import content_hash

SAME = 1e-9
"""Largest difference between a situation and its copy in a family."""
_LAW = ("position", "velocity", "acceleration")


@dataclass(frozen=True)
class Parameter:
    """A number that situations of a family differ in."""

    name: str
    low: float
    high: float
    unit: str
    moves: tuple[tuple[str, str, tuple[float, ...]], ...]
    """Bodies by name, `position` or `velocity`, and its change for a unit of the parameter."""


@dataclass(frozen=True)
class ParametricFamily:
    """Situations that differ in a few numbers, on which motions of bodies depend linearly.

    Shapes, orientations, the arm and the horizon are those of `middle`.
    """

    name: str
    summary: str
    middle: AnySituation
    """The situation in which every parameter is in the middle of its range."""
    parameters: tuple[Parameter, ...]
    """Free parameters."""

    @cached_property
    def low(self) -> np.ndarray:
        """(K,) float: lowest values of the parameters."""
        return np.array([parameter.low for parameter in self.parameters])

    @cached_property
    def high(self) -> np.ndarray:
        """(K,) float: highest values of the parameters."""
        return np.array([parameter.high for parameter in self.parameters])

    @cached_property
    def centre(self) -> np.ndarray:
        """(K,) float: middle of the box."""
        return 0.5 * (self.low + self.high)

    @cached_property
    def numbers(self) -> np.ndarray:
        """(bodies, 3, dim) float: position, velocity and acceleration in the middle."""
        return law_numbers(self.middle)

    @cached_property
    def slopes(self) -> np.ndarray:
        """(K, bodies, 3, dim) float: derivatives of these numbers by the parameters."""
        names = [body.name for body in self.middle.bodies]
        out = np.zeros((len(self.parameters), *self.numbers.shape))
        for k, parameter in enumerate(self.parameters):
            for body, law, change in parameter.moves:
                out[k, names.index(body), _LAW.index(law)] += change
        return out

    @cached_property
    def digest(self) -> str:
        """Hash of all that the family's situations follow from."""
        about = [self.name, situation_to_json(self.middle)]
        boxes = [self.low.tolist(), self.high.tolist(), self.slopes.tolist()]
        return content_hash(json.dumps([about, boxes]))

    def free(self, count: int) -> ParametricFamily:
        """Return the family in which only the first parameters are free.

        Raises
        ------
        FamilyError
            If it has not as many parameters.
        """
        most = len(self.parameters)
        if not 1 <= count <= most:
            raise FamilyError("free", f"{self.name!r} has 1 to {most} parameters (got {count})")
        return replace(self, parameters=self.parameters[:count])

    def situation(self, theta: np.ndarray, name: str = "") -> Any:
        """Return the situation of parameters theta (K,)."""
        numbers = self.numbers + np.tensordot(theta - self.centre, self.slopes, 1)
        bodies = (
            replace(body, motion=replace(body.motion, **_law_of(rows)))
            for body, rows in zip(self.middle.bodies, numbers.tolist(), strict=True)
        )
        return replace(self.middle, name=name or self.name, bodies=tuple(bodies))

    def drifts(self, time: np.ndarray) -> np.ndarray:
        """Derivatives (n, K, bodies, dim) of all bodies' places by the parameters at times (n,)."""
        t = time[:, None, None, None]
        return self.slopes[None, :, :, 0] + t * self.slopes[None, :, :, 1]

    def parameters_of(self, situation: AnySituation) -> np.ndarray | None:
        """Return the parameters (K,) of a situation; None if the family has no such situation."""
        middle, bodies = self.middle, situation.bodies
        if situation.arm != middle.arm or abs(situation.horizon - middle.horizon) > SAME:
            return None
        if situation.catch != middle.catch or situation.plane != middle.plane:
            return None
        if len(bodies) != len(middle.bodies) or not all(map(_alike, bodies, middle.bodies)):
            return None
        given = (law_numbers(situation) - self.numbers).reshape(-1)
        change = self._inverse @ given
        if np.abs(given - change @ self._flat).max() > SAME:
            return None
        theta: np.ndarray = self.centre + change
        return theta

    @cached_property
    def _flat(self) -> np.ndarray:
        return self.slopes.reshape(len(self.parameters), -1)

    @cached_property
    def _inverse(self) -> np.ndarray:
        return np.linalg.pinv(self._flat.T)


def law_numbers(situation: AnySituation) -> np.ndarray:
    """Position, velocity and acceleration (bodies, 3, dim) of a situation's bodies."""
    rows: list[Any] = [
        (body.motion.position, body.motion.velocity, body.motion.acceleration)  # type: ignore[union-attr]
        for body in situation.bodies
    ]
    return np.array(rows)


def _law_of(rows: list[list[float]]) -> dict[str, Any]:
    """Return fields of a motion from the rows (3, dim) of its numbers."""
    return {name: tuple(row) for name, row in zip(_LAW, rows, strict=True)}


def _alike(body: Body, other: Body) -> bool:
    """Return whether two bodies differ at most in what parameters change."""
    if body.role != other.role or body.shape != other.shape or body.approach != other.approach:
        return False
    mine, its = body.motion, other.motion
    if type(mine) is not type(its):
        return False
    if isinstance(mine, PlanarQuadratic) and isinstance(its, PlanarQuadratic):
        return mine.angle == its.angle and mine.spin == its.spin
    if isinstance(mine, SolidQuadratic) and isinstance(its, SolidQuadratic):
        return mine.orientation == its.orientation and mine.spin == its.spin
    return False


def _in_plane(x: float, y: float, vx: float = 0.0) -> PlanarQuadratic:
    return PlanarQuadratic((x, y), (vx, 0.0), (0.0, 0.0))


def belt() -> ParametricFamily:
    """A part on a belt in the plane, behind posts and a carrier that comes the other way."""
    goods = ("part", "good 1", "good 2")
    bodies = (
        Body("target", "part", Disc(0.06), _in_plane(-0.7, 1.2, 0.6)),
        Body("obstacle", "good 1", Disc(0.1), _in_plane(-1.35, 1.2, 0.6)),
        Body("obstacle", "good 2", Disc(0.1), _in_plane(-0.05, 1.2, 0.6)),
        Body("obstacle", "carrier", Disc(0.1), _in_plane(0.9, 0.85, -0.6)),
        Body("obstacle", "post 1", Disc(0.06), _in_plane(-0.75, 0.75)),
        Body("obstacle", "post 2", Disc(0.06), _in_plane(1.3, 0.8)),
    )
    arm = Arm((1.1, 0.1), 3.0, thickness=0.05, grasp=0.05)
    return ParametricFamily(
        "belt",
        "a part on a belt in the plane, behind posts and a moving carrier",
        Situation("belt", 1.6, arm, bodies),
        (
            Parameter("along", -0.4, 0.4, "forearms", (("part", "position", (1.0, 0.0)),)),
            Parameter("across", -0.15, 0.15, "forearms", (("part", "position", (0.0, 1.0)),)),
            Parameter(
                "pace",
                -0.3,
                0.3,
                "forearms/s",
                tuple((name, "velocity", (1.0, 0.0)) for name in goods),
            ),
            Parameter("phase", -0.3, 0.3, "forearms", (("carrier", "position", (1.0, 0.0)),)),
            Parameter("speed", -0.3, 0.3, "forearms/s", (("carrier", "velocity", (1.0, 0.0)),)),
        ),
    )


def _in_space(x: float, y: float, z: float, vy: float = 0.0) -> SolidQuadratic:
    return SolidQuadratic((x, y, z), (0.0, vy, 0.0), (0.0, 0.0, 0.0))


def belt_in_space() -> ParametricFamily:
    """A part on a belt before a spatial arm, behind posts and a carrier over the belt."""
    goods = ("part", "good 1", "good 2")
    bodies = (
        Body("target", "part", Sphere(0.08), _in_space(1.2, -0.9, -0.4, 0.6)),
        Body("obstacle", "belt", Box((0.25, 2.0, 0.03)), _in_space(1.2, 0.0, -0.62)),
        Body("obstacle", "good 1", Box((0.1, 0.1, 0.1)), _in_space(1.2, -1.55, -0.45, 0.6)),
        Body("obstacle", "good 2", Box((0.1, 0.1, 0.1)), _in_space(1.2, -0.25, -0.45, 0.6)),
        Body("obstacle", "carrier", Sphere(0.15), _in_space(1.0, 0.5, -0.05, -0.6)),
        Body("obstacle", "post 1", Capsule(0.05, 0.3), _in_space(0.75, -0.75, -0.5)),
        Body("obstacle", "post 2", Capsule(0.05, 0.3), _in_space(0.75, 0.75, -0.5)),
    )
    arm = SpatialArm(
        upper_arm=(1.0, 0.0, 0.0),
        forearm=(1.0, 0.0, 0.0),
        joints=(-0.3, 1.0, 0.0, -1.4),
        joint_range=((-2.8, 2.8), (-2.2, 2.2), (-2.4, 2.4), (-2.6, 0.0)),
        max_joint_speed=(1.5, 1.5, 2.0, 2.0),
        grasp=0.1,
        thickness=0.08,
    )
    return ParametricFamily(
        "belt-space",
        "a part on a belt before a spatial arm, behind posts and a moving carrier",
        Situation("belt-space", 1.6, arm, bodies),
        (
            Parameter("along", -0.4, 0.4, "lengths", (("part", "position", (0.0, 1.0, 0.0)),)),
            Parameter("across", -0.15, 0.15, "lengths", (("part", "position", (1.0, 0.0, 0.0)),)),
            Parameter(
                "pace",
                -0.3,
                0.3,
                "lengths/s",
                tuple((name, "velocity", (0.0, 1.0, 0.0)) for name in goods),
            ),
            Parameter("phase", -0.3, 0.3, "lengths", (("carrier", "position", (0.0, 1.0, 0.0)),)),
            Parameter("speed", -0.3, 0.3, "lengths/s", (("carrier", "velocity", (0.0, 1.0, 0.0)),)),
        ),
    )


FAMILIES: dict[str, Callable[[], ParametricFamily]] = {"belt": belt, "belt-space": belt_in_space}


def parametric_family(name: str) -> ParametricFamily:
    """Return a family by name.

    Raises
    ------
    UnknownNameError
    """
    if name not in FAMILIES:
        raise UnknownNameError.among("family", name, FAMILIES)
    return FAMILIES[name]()
