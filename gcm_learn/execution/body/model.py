"""The arm and a situation's bodies as a model of MuJoCo.

Everything is in the frame of the arm's base, in metres, with gravity turned into that frame.  Links
are capsules; a small ball is the hand, which alone meets targets.  Obstacles are moved from outside
(`mocap` in MuJoCo's words).  Targets are free bodies, put where their motion law has them until
something touches them.  Touches are found for listed pairs only.  Links meet obstacles that they do
not ignore, the hand meets targets, and links meet others that they must not overlap.

A gripper meets no target: each has a weld to the hand, which is open at first. Targets
with a place meet obstacles.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from functools import lru_cache
from typing import Any, NamedTuple
from xml.etree import ElementTree as Xml

import numpy as np

from gcm_learn.arms import rotation_of
from gcm_learn.errors import MissingExtraError, PhysicsError
from gcm_learn.execution.body.kinds import (
    MECHANICS,
    LinkCapsule,
    Segment,
    Turning,
    rested,
    strongest,
)
from gcm_learn.situation import AnyArmBody, Body, Motor, Shape, numbers_of

STEP = 0.002
"""Of the physics [s]."""
BALL_DENSITY = 368.0
"""Of targets: a tennis ball of 58 g and 6.7 cm, as the paper's [kg/m^3]."""
SMALLEST = 1e-4
"""Radius of links and hands that have none [m]."""
STUCK = 1e-6
"""Way of joints whose range is a single value [rad or m]."""
LIGHTEST = {"boundmass": 1e-12, "boundinertia": 1e-14}
"""Mass and inertia of segments that have none [kg, kg m^2]."""
RIGID = {"solref": (2.0 * STEP, 1.0), "solimp": (0.999, 0.9999, 1e-3)}
"""Bonds of followers to their leaders, and of what is gripped, as stiff as the step allows."""
GEOMS = ("sphere", "box", "capsule", "cylinder")  # shapes whose names and sizes MuJoCo shares
TYPES = {"revolute": "hinge", "prismatic": "slide"}
LINK, CATCHER = -1, -2  # codes of geometries that are no body's; those of bodies are their numbers


UNLISTED = {"contype": 0, "conaffinity": 0}  # touches nothing but what it is paired with


class Thing(NamedTuple):
    """Part of a body that a model needs."""

    name: str
    role: str
    shape: Shape
    place: bool = False
    """True if it is carried."""
    ignore: tuple[str, ...] = ()
    """Obstacles that it does not meet."""


def mujoco() -> Any:
    """Return the module mujoco.

    Raises
    ------
    MissingExtraError
    """
    try:
        import mujoco as library
    except ImportError:
        raise MissingExtraError("physics", "mujoco", "sim") from None
    return library


def model_xml(
    arm: Any, body: AnyArmBody, things: Sequence[Body | Thing] | None = None, grips: bool = False
) -> str:
    """Return the model in MuJoCo's own format (MJCF).

    Parameters
    ----------
    arm : SpatialArm or Chain
    body : ArmBody or ChainBody
    things : sequence of Body or Thing, optional
        Bodies about the arm. Without them the arm has neither contacts nor limits of joints, as
        inverse dynamics wants it.
    grips : bool
        Whether the hand is a gripper.
    """
    alone = things is None
    root = Xml.Element("mujoco", model="gcm_learn")
    gravity = rotation_of(arm.base.rotation).T @ np.array(body.gravity)
    option = _add(root, "option", timestep=STEP, gravity=gravity, integrator="implicitfast")
    _add(option, "flag", autoreset="disable", constraint="disable" if alone else "enable")
    _add(root, "compiler", angle="radian", autolimits="true", **LIGHTEST)
    world = _add(root, "worldbody")
    _add_arm(world, arm, body, alone)
    for k, thing in enumerate(things or ()):
        _add_thing(world, thing, f"body{k}", body.metres)
    if things is not None:
        _add_pairs(_add(root, "contact"), arm, body, things, grips)
    motors, bonds = _add(root, "actuator"), _add(root, "equality")
    leads = MECHANICS.of(arm).leads(arm)
    factors, offsets = MECHANICS.of(arm).lines(arm, body.metres)
    leaders = np.flatnonzero(leads)
    for j, row in enumerate(factors):
        if leads[j]:
            _add(motors, "general", name=f"motor{j}", joint=f"joint{j}", biastype="affine")
        elif not alone:
            k = int(np.argmax(np.abs(row)))
            line = (offsets[j], row[k], 0.0, 0.0, 0.0)
            _add(bonds, "joint", joint1=f"joint{j}", joint2=f"joint{leaders[k]}", polycoef=line,
                 **RIGID)  # fmt: skip
    carrier = MECHANICS.of(arm).segments(arm, body)[MECHANICS.of(arm).hand(arm)[0]].name
    for k, thing in enumerate(things or ()):
        if grips and thing.role == "target":
            _add(bonds, "weld", name=f"grip{k}", body1=carrier, body2=f"body{k}", active="false",
                 **RIGID)  # fmt: skip
    return Xml.tostring(root, encoding="unicode")


def compiled(xml: str) -> Any:
    """Return the MuJoCo model of an XML text.

    Raises
    ------
    PhysicsError
        With MuJoCo's message.
    """
    try:
        return mujoco().MjModel.from_xml_string(xml)
    except ValueError as error:
        reason = " ".join(str(error).split())
        raise PhysicsError(f"MuJoCo cannot make a model of it: {reason}") from None


def model_of(arm: Any, body: AnyArmBody, bodies: Sequence[Body], grips: bool = False) -> Any:
    """Return the model of an arm among bodies, cached for equal arms wherever they move.

    A gripper changes its model, so it gets a copy.
    """
    things = tuple(
        Thing(one.name, one.role, one.shape, one.place is not None, one.ignore) for one in bodies
    )
    model = _kept(*rested(arm, body), things, grips)
    return copy(model) if grips else model


@lru_cache(maxsize=256)
def _kept(arm: Any, body: AnyArmBody, things: tuple[Thing, ...], grips: bool) -> Any:
    model = compiled(model_xml(arm, body, things, grips))
    most = strongest(arm, body)
    model.actuator_gainprm[:, 0] = 1.0
    model.actuator_forcelimited[:] = 1  # a torque of 0 is a limit, too
    model.actuator_forcerange[:] = np.stack([-most, most], axis=1)
    return model


class Coupling(NamedTuple):
    """State of all joints of a model by the coordinates, in MuJoCo's order and units."""

    factors: np.ndarray  # (m, n)
    offsets: np.ndarray  # (m,)
    own: Any  # index of the coordinates among the joints

    @property
    def size(self) -> int:
        """Number m of joints; targets come after them."""
        return len(self.offsets)

    def place(self, data: Any, joints: np.ndarray, rates: np.ndarray) -> None:
        """Write the state of all joints at coordinates and rates (n,), in MuJoCo's units."""
        data.qpos[: self.size] = self.factors @ joints + self.offsets
        data.qvel[: self.size] = self.factors @ rates


def coupling_of(model: Any, arm: Any, metres: float) -> Coupling:
    """Return the coupling of an arm's joints in the order of its model: branch by branch."""
    mechanics = MECHANICS.of(arm)
    factors, offsets = mechanics.lines(arm, metres)
    at = np.array([int(model.joint(f"joint{j}").qposadr[0]) for j in range(len(factors))])
    order, own = np.argsort(at), at[np.flatnonzero(mechanics.leads(arm))]
    plain = len(own) == len(at) and bool((np.diff(at) == 1).all())
    return Coupling(factors[order], offsets[order], slice(0, len(own)) if plain else own)


def codes_of(model: Any, bodies: int) -> list[int]:
    """Return the number of each geometry's body; LINK or CATCHER for parts of the arm.

    Parameters
    ----------
    model : MjModel
    bodies : int
        Number of bodies about the arm.
    """
    codes = [LINK] * model.ngeom
    codes[model.geom("hand").id] = CATCHER
    for k in range(bodies):
        codes[model.geom(f"body{k}").id] = k
    return codes


def _add_arm(world: Xml.Element, arm: Any, body: AnyArmBody, alone: bool) -> None:
    mechanics = MECHANICS.of(arm)
    carrier, point, ball = mechanics.hand(arm)
    metric, j = mechanics.metric(arm, body.metres), 0
    leads, left = mechanics.leads(arm), list(zip(arm.joint_range, metric, strict=True))[::-1]
    made: list[Xml.Element] = []
    for k, segment in enumerate(mechanics.segments(arm, body)):
        parent = world if segment.parent < 0 else made[segment.parent]
        if segment.inertia is not None:
            parent = _add_segment(parent, segment, body.metres)
        made.append(parent)
        for joint in segment.joints:
            own = left.pop() if leads[j] else None
            limits = {} if alone or own is None else {"range": _range(*own)}
            _add_joint(parent, f"joint{j}", joint, body.joints[j], limits)
            j += 1
        if not alone:
            for link in segment.links:
                _add_link(parent, link, body.metres)
            if k == carrier:
                size, place = max(ball * body.metres, SMALLEST), np.array(point) * body.metres
                _add(parent, "geom", name="hand", type="sphere", size=size, pos=place, **UNLISTED)


def _add_segment(parent: Xml.Element, segment: Segment, metres: float) -> Xml.Element:
    """Return a body that hangs from another."""
    place, inertia = np.array(segment.place) * metres, segment.inertia
    assert inertia is not None
    made = _add(parent, "body", name=segment.name, pos=place, quat=segment.turn)
    _add(made, "inertial", pos=inertia.centre, quat=inertia.turn, mass=inertia.mass,
         diaginertia=inertia.moments)  # fmt: skip
    return made


def _add_joint(
    parent: Xml.Element, name: str, joint: Turning, motor: Motor, limits: dict[str, Any]
) -> None:
    _add(parent, "joint", name=name, type=TYPES[joint.type], axis=joint.axis,
         armature=motor.armature, damping=motor.damping, **limits)  # fmt: skip


def _range(given: tuple[float, float], metric: float) -> list[float]:
    low, high = given[0] * metric, given[1] * metric
    return [low, high] if low < high else [low - STUCK, low + STUCK]


def _add_link(parent: Xml.Element, link: LinkCapsule, metres: float) -> None:
    """Add a capsule; a sphere where both ends are equal."""
    start, end = np.array(link.start) * metres, np.array(link.end) * metres
    size: dict[str, Any] = {"size": max(link.radius * metres, SMALLEST)}
    if (start == end).all():
        size |= {"type": "sphere", "pos": start}
    else:
        size |= {"type": "capsule", "fromto": [*start, *end]}
    _add(parent, "geom", name=f"link{link.number}", **size, **UNLISTED)


def _add_pairs(
    contact: Xml.Element, arm: Any, body: AnyArmBody, things: Sequence[Body | Thing], grips: bool
) -> None:
    """Add the pairs of links, hand and bodies that may touch."""
    mechanics = MECHANICS.of(arm)
    links = sorted(link.number for s in mechanics.segments(arm, body) for link in s.links)
    ignored = set(mechanics.ignored(arm))
    for k, thing in enumerate(things):
        if thing.role == "target":
            if not grips:
                _add(contact, "pair", geom1="hand", geom2=f"body{k}")
            for i, other in enumerate(things if grips and thing.place else ()):
                if other.role == "obstacle" and other.name not in thing.ignore:
                    _add(contact, "pair", geom1=f"body{k}", geom2=f"body{i}")
            continue
        for i in links:
            if (i, thing.name) not in ignored:
                _add(contact, "pair", geom1=f"link{i}", geom2=f"body{k}")
    for first, second in mechanics.pairs(arm):
        _add(contact, "pair", geom1=f"link{first}", geom2=f"link{second}")


def _add_thing(world: Xml.Element, thing: Body | Thing, name: str, metres: float) -> None:
    """Add a target as a free body, or an obstacle as a body that is moved from outside."""
    free = thing.role == "target"
    held = _add(world, "body", name=name, **({} if free else {"mocap": "true"}))
    if free:
        _add(held, "freejoint", name=name)
    if thing.shape.kind not in GEOMS:
        raise PhysicsError(f"body {thing.name!r}: physics has no {thing.shape.kind}")
    kind, size = thing.shape.kind, numbers_of(thing.shape)
    _add(held, "geom", name=name, type=kind, size=np.array(size) * metres, density=BALL_DENSITY,
         **UNLISTED)  # fmt: skip


def _add(parent: Xml.Element, tag: str, **fields: Any) -> Xml.Element:
    """Add a child element, with numbers as MuJoCo reads them."""
    return Xml.SubElement(parent, tag, {name: _written(value) for name, value in fields.items()})


def _written(value: Any) -> str:
    if isinstance(value, str):
        return value
    return " ".join(repr(float(part)) if not isinstance(part, int) else str(part)
                    for part in np.ravel(value).tolist())  # fmt: skip
