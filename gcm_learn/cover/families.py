"""Families of situations that depend linearly on few parameters; ready-made families on belts."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from gcm_learn import situation
from gcm_learn.arms import Arm, Chain, SpatialArm
from gcm_learn.errors import FamilyError, UnknownNameError
from gcm_learn.situation import (
    AnySituation,
    Approach,
    Body,
    Hold,
    PlanarQuadratic,
    SolidQuadratic,
    situation_to_json,
)
from gcm_learn.storage import content_hash

SAME = 1e-9
"""Largest difference between a situation and its copy in a family."""
_LAW = ("position", "velocity", "acceleration")
_ASKED = "catch", "plane", "end"


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

    Shapes, orientations and the arm are as in `middle`; the horizon is as long or longer.
    """

    name: str
    summary: str
    middle: AnySituation
    """The situation in which every parameter is in the middle of its range."""
    parameters: tuple[Parameter, ...]
    """Free parameters."""

    def __post_init__(self) -> None:
        """Refuse families that the proofs do not cover."""
        if self.middle.catch != "any" and len(self.middle.targets) > 1:
            raise FamilyError("catch", "must be 'any' where there are several targets")
        for parameter in self.parameters:
            if any(law not in _LAW[:2] for _, law, _ in parameter.moves):
                laws = f"of {parameter.name!r} may change {_LAW[0]} and {_LAW[1]} only"
                raise FamilyError("parameters", laws)

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
    def holds(self) -> bool:
        """True if targets are held after the catch; movements do not bend then."""
        return any(body.hold is not None for body in self.middle.bodies)

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
        """Return the parameters (K,) of a situation; None for a situation of another family."""
        middle, bodies = self.middle, situation.bodies
        last = max(middle.horizon, middle.end_by or (np.inf if self.holds else 0.0))
        if situation.horizon < middle.horizon - SAME or situation.arm != middle.arm:
            return None
        if situation.end_by is not None and situation.end_by < last - SAME:
            return None
        if any(getattr(situation, name) != getattr(middle, name) for name in _ASKED):
            return None
        if [_unchanged(body) for body in bodies] != self._kept:
            return None
        if self._ignores and [b.name for b in bodies] != [b.name for b in middle.bodies]:
            return None
        given = (law_numbers(situation) - self.numbers).reshape(-1)
        change = self._inverse @ given
        if np.abs(given - change @ self._flat).max() > SAME:
            return None
        theta: np.ndarray = self.centre + change
        return theta

    @cached_property
    def _ignores(self) -> bool:
        """True if some obstacles are ignored; they are known by their names."""
        some = getattr(self.middle.arm, "ignore", ())
        return bool(some) or any(body.ignore for body in self.middle.bodies)

    @cached_property
    def _kept(self) -> list[Any]:
        return [_unchanged(body) for body in self.middle.bodies]

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
    """Return position, velocity and acceleration, given as rows (3, dim), as fields of a motion."""
    return {name: tuple(row) for name, row in zip(_LAW, rows, strict=True)}


def _unchanged(body: Body) -> tuple[Any, ...]:
    """Return the properties of a body, except its name, that no parameter changes."""
    motion = body.motion
    turns: tuple[Any, ...] = ()
    if isinstance(motion, PlanarQuadratic):
        turns = (motion.angle, motion.spin)
    elif isinstance(motion, SolidQuadratic):
        turns = (motion.orientation, motion.spin)
    asked = body.approach, body.hold, body.place, body.ignore, body.ignore_for, body.margin
    return body.role, body.shape, *asked, type(motion), turns


HORIZON = 1.6  # [s]
PART, CARRIER, POST = "part", "carrier", "post"


def belt() -> ParametricFamily:
    """Return the family of a belt in the plane, behind a row of posts."""
    arm = Arm((1.1, 0.1), 3.0, thickness=0.05, grasp=0.05)
    good, post = situation.Disc(0.1), situation.Disc(0.06)
    bodies = (
        _planar(PART, situation.Disc(0.06), -0.7, 1.2, 0.6),
        _planar("good 1", good, -1.35, 1.2, 0.6),
        _planar("good 2", good, -0.05, 1.2, 0.6),
        _planar(CARRIER, situation.Disc(0.1), 0.9, 0.85, -0.6),
        _planar("post 1", post, -0.75, 0.75),
        _planar("post 2", post, 1.3, 0.8),
    )
    about = "a part on a belt in the plane, behind posts and a moving carrier"
    return _family("belt", about, arm, bodies, ((1.0, 0.0), (0.0, 1.0)), "forearms")


def belt_space() -> ParametricFamily:
    """Return the family of a belt along y before a spatial arm."""
    arm = SpatialArm(
        upper_arm=(1.0, 0.0, 0.0),
        forearm=(1.0, 0.0, 0.0),
        joints=(-0.3, 1.0, 0.0, -1.4),
        joint_range=((-2.8, 2.8), (-2.2, 2.2), (-2.4, 2.4), (-2.6, 0.0)),
        max_joint_speed=(1.5, 1.5, 2.0, 2.0),
        grasp=0.1,
        thickness=0.08,
    )
    good, post = situation.Box((0.1, 0.1, 0.1)), situation.Capsule(0.05, 0.3)
    bodies = (
        _solid(PART, situation.Sphere(0.08), (1.2, -0.9, -0.4), 0.6),
        _solid("belt", situation.Box((0.25, 2.0, 0.03)), (1.2, 0.0, -0.62)),
        _solid("good 1", good, (1.2, -1.55, -0.45), 0.6),
        _solid("good 2", good, (1.2, -0.25, -0.45), 0.6),
        _solid(CARRIER, situation.Sphere(0.15), (1.0, 0.5, -0.05), -0.6),
        _solid("post 1", post, (0.75, -0.75, -0.5)),
        _solid("post 2", post, (0.75, 0.75, -0.5)),
    )
    about = "a part on a belt before a spatial arm, behind posts and a moving carrier"
    return _family("belt-space", about, arm, bodies, ((0.0, 1.0, 0.0), (1.0, 0.0, 0.0)), "lengths")


def belt_chain() -> ParametricFamily:
    """Return the family of a belt along y before a Panda, in metres."""
    arm = Chain(situation.shipped_arm("panda"), (0.0, -0.3, 0.0, -2.0, 0.0, 1.8, 0.7), grasp=0.03)
    good = situation.Box((0.04, 0.04, 0.04))
    bodies = (
        _solid(PART, situation.Sphere(0.03), (0.55, -0.35, 0.15), 0.25),
        _solid("belt", situation.Box((0.1, 0.8, 0.02)), (0.55, 0.0, 0.05)),
        _solid("good 1", good, (0.55, -0.6, 0.12), 0.25),
        _solid("good 2", good, (0.55, -0.1, 0.12), 0.25),
        _solid(CARRIER, situation.Sphere(0.06), (0.45, 0.3, 0.4), -0.25),
        _solid("post 1", situation.Capsule(0.02, 0.12), (0.4, -0.3, 0.1)),
    )
    about = "a part on a belt before a Panda, behind a post and a moving carrier"
    sides = ((0.0, 1.0, 0.0), (1.0, 0.0, 0.0))
    return _family("belt-chain", about, arm, bodies, sides, "m", size=0.25)


def held_belt() -> ParametricFamily:
    """Return the family of a belt from which a Panda picks a box from above, holds it and stops."""
    bare = belt_chain()
    along, across, pace, *carrier = bare.parameters
    with_part = tuple((body, "position", way) for body, _, way in pace.moves)
    parameters = (
        replace(along, low=-0.12, high=0.12, moves=with_part),
        replace(across, low=-0.05, high=0.05),
        replace(pace, low=-0.1, high=0.1),
        *carrier,
    )
    most = (15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0)
    part = replace(
        _solid(PART, situation.Box((0.03, 0.03, 0.03)), (0.55, -0.35, 0.101), 0.25),
        approach=(Approach((0.0, 0.0, -1.0), 0.5),),
        hold=Hold(0.2, 0.1),
    )
    about = "a box on a belt among goods before a Panda, to be held; the arm ends at rest"
    whole: Any = bare.middle
    arm, bodies = replace(whole.arm, max_joint_acceleration=most), (part, *whole.bodies[1:])
    end = {"end": "rest", "end_by": 1.5 * HORIZON, "format": "gcm-learn/situation@4"}
    middle = replace(whole, name="held-belt", arm=arm, bodies=bodies, **end)
    return ParametricFamily("held-belt", about, middle, parameters)


def _planar(
    name: str, shape: situation.Shape, x: float, y: float, pace: float = 0.0
) -> situation.Body:
    """Return a body that moves along x."""
    law = situation.PlanarQuadratic((x, y), (pace, 0.0), (0.0, 0.0))
    return situation.Body("target" if name == PART else "obstacle", name, shape, law)


def _solid(
    name: str, shape: situation.Shape, place: tuple[float, float, float], pace: float = 0.0
) -> situation.Body:
    """Return a solid that moves along y."""
    law = situation.SolidQuadratic(place, (0.0, pace, 0.0), (0.0, 0.0, 0.0))
    return situation.Body("target" if name == PART else "obstacle", name, shape, law)


def _family(
    name: str,
    summary: str,
    arm: Any,
    bodies: tuple[situation.Body, ...],
    sides: tuple[tuple[float, ...], tuple[float, ...]],
    unit: str,
    size: float = 1.0,
) -> ParametricFamily:
    """Return a family with the five parameters of belts.

    Parameters
    ----------
    sides : tuple
        Unit vectors along the belt and across it.
    unit : str
        Of lengths.
    size : float
        Ranges, as shares of those of arms of two unit lengths.
    """
    along, across = sides
    goods = [body.name for body in bodies if body.name in (PART, "good 1", "good 2")]

    def of(
        label: str, most: float, moved: Iterable[str], law: str, way: tuple[float, ...]
    ) -> Parameter:
        said = unit if law == "position" else f"{unit}/s"
        moves = tuple((body, law, way) for body in moved)
        return Parameter(label, -most * size, most * size, said, moves)

    parameters = (
        of("along", 0.4, [PART], "position", along),
        of("across", 0.15, [PART], "position", across),
        of("pace", 0.3, goods, "velocity", along),
        of("phase", 0.3, [CARRIER], "position", along),
        of("speed", 0.3, [CARRIER], "velocity", along),
    )
    middle: Any = situation.Situation(name, HORIZON, arm, bodies)
    return ParametricFamily(name, summary, middle, parameters)


def varied(family: ParametricFamily) -> ParametricFamily:
    """Return the family in which the places of carrier and posts are among the first parameters."""
    along, _, pace, phase, speed = family.parameters
    way, bodies = phase.moves[0][2], family.middle.bodies
    moves = tuple((body.name, "position", way) for body in bodies if body.name.startswith(POST))
    posts = replace(phase, name="posts", moves=moves)
    name = f"{family.name}-varied"
    about = f"{family.summary}, whose places vary"
    middle = replace(family.middle, name=name)
    return ParametricFamily(name, about, middle, (along, phase, posts, speed, pace))


def held_belt_varied() -> ParametricFamily:
    """Return the family of `held_belt` with tall goods near the part, at a gap that varies."""
    bare = held_belt()
    along, across, pace, phase, _ = bare.parameters
    tall, sides = situation.Box((0.04, 0.04, 0.07)), {"good 1": -1.0, "good 2": 1.0}
    bodies = tuple(
        _solid(body.name, tall, (0.55, -0.35 + sides[body.name] * 0.17, 0.141), 0.25)
        if body.name in sides
        else body
        for body in bare.middle.bodies
    )
    ways = tuple((name, "position", (0.0, side, 0.0)) for name, side in sides.items())
    gap = Parameter("gap", -0.05, 0.05, "m", ways)
    name, about = f"{bare.name}-varied", f"{bare.summary}; the goods are tall, and near by a gap"
    middle = replace(bare.middle, name=name, bodies=bodies)
    return ParametricFamily(name, about, middle, (along, gap, pace, across, phase))


FAMILIES: dict[str, Callable[[], ParametricFamily]] = {
    "belt": belt,
    "belt-space": belt_space,
    "belt-chain": belt_chain,
    "held-belt": held_belt,
    "belt-varied": lambda: varied(belt()),
    "belt-space-varied": lambda: varied(belt_space()),
    "held-belt-varied": held_belt_varied,
}


def parametric_family(name: str) -> ParametricFamily:
    """Return a family by name.

    Raises
    ------
    UnknownNameError
    """
    if name not in FAMILIES:
        raise UnknownNameError.among("family", name, FAMILIES)
    return FAMILIES[name]()
