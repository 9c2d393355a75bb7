"""Belt picking: a part on a belt, among goods, posts and a carrier that comes the other way."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any

from gcm_learn import situation
from gcm_learn.arms import Arm, Chain, SpatialArm
from gcm_learn.cover.families import Parameter, ParametricFamily
from gcm_learn.errors import UnknownNameError

HORIZON = 1.6  # [s]
PART, CARRIER, POST = "part", "carrier", "post"


def belt() -> ParametricFamily:
    """Belt in the plane, behind a row of posts."""
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
    """Belt before a spatial arm; it runs along y."""
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
    """Belt before a Panda; it runs along y, in metres."""
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
    """Return a belt whose obstacles vary first: place of the carrier, place of the posts."""
    along, _, pace, phase, speed = family.parameters
    way, bodies = phase.moves[0][2], family.middle.bodies
    moves = tuple((body.name, "position", way) for body in bodies if body.name.startswith(POST))
    posts = replace(phase, name="posts", moves=moves)
    name = f"{family.name}-varied"
    about = f"{family.summary}, whose places vary"
    middle = replace(family.middle, name=name)
    return ParametricFamily(name, about, middle, (along, phase, posts, speed, pace))


FAMILIES: dict[str, Callable[[], ParametricFamily]] = {
    "belt": belt,
    "belt-space": belt_space,
    "belt-chain": belt_chain,
    "belt-varied": lambda: varied(belt()),
    "belt-space-varied": lambda: varied(belt_space()),
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
