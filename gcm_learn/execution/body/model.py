"""The arm and a situation's bodies as a model of MuJoCo.

Everything is in the frame of the arm's base, in metres, with gravity turned into that frame.  Each
bone is a capsule of the arm's thickness; a small ball is the hand, which alone meets targets.
Obstacles are moved from outside (`mocap` in MuJoCo's words).  Targets are free bodies, put where
their motion law has them until something touches them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple
from xml.etree import ElementTree as Xml

import numpy as np

from gcm_learn.arms import Base, SpatialArm, rotation_of
from gcm_learn.errors import MissingExtraError, PhysicsError
from gcm_learn.situation import ArmBody, Body, Shape, numbers_of

STEP = 0.002
"""Of the physics [s]."""
BALL_DENSITY = 368.0
"""Of targets: a tennis ball of 58 g and 6.7 cm, as the paper's [kg/m^3]."""
HAND = 0.5
"""Radius of the hand's ball, as a share of the grasp; a bone's radius at most."""
SMALLEST = 1e-4
"""Radius of bones and hands that have none [m]."""
STUCK = 1e-6
"""Turn of joints whose range is a single angle [rad]."""
GEOMS = ("sphere", "box", "capsule", "cylinder")  # shapes whose names and sizes MuJoCo shares
AXES = ("0 1 0", "0 0 1", "1 0 0", "0 0 1")
LIMB, CATCHER = 1, 2  # bits of what may touch


class Thing(NamedTuple):
    """Part of a body that a model needs."""

    name: str
    role: str
    shape: Shape


def mujoco() -> Any:
    """The library.

    Raises
    ------
    MissingExtraError
    """
    try:
        import mujoco as library
    except ImportError:
        raise MissingExtraError("physics", "mujoco", "sim") from None
    return library


def model_xml(arm: SpatialArm, body: ArmBody, things: Sequence[Body | Thing] | None = None) -> str:
    """The model in MuJoCo's own format (MJCF).

    Parameters
    ----------
    arm : SpatialArm
    body : ArmBody
    things : sequence of Body or Thing, optional
        What moves about the arm. Without it the arm has neither contacts nor limits of joints, as
        inverse dynamics wants it.
    """
    alone = things is None
    root = Xml.Element("mujoco", model="gcm_learn")
    gravity = rotation_of(arm.base.rotation).T @ np.array(body.gravity)
    option = _add(root, "option", timestep=STEP, gravity=gravity, integrator="implicitfast")
    _add(option, "flag", autoreset="disable", constraint="disable" if alone else "enable")
    _add(root, "compiler", angle="radian", autolimits="true")
    world = _add(root, "worldbody")
    _add_arm(world, arm, body, alone)
    for k, thing in enumerate(things or ()):
        _add_thing(world, thing, f"body{k}", body.metres)
    motors = _add(root, "actuator")
    for j, motor in enumerate(body.joints):
        force = [-motor.torque, motor.torque]
        _add(motors, "general", name=f"motor{j}", joint=f"joint{j}", forcerange=force,
             biastype="affine")  # fmt: skip
    return Xml.tostring(root, encoding="unicode")


def compiled(xml: str) -> Any:
    """A model of MuJoCo.

    Raises
    ------
    PhysicsError
        With what MuJoCo says of it.
    """
    try:
        return mujoco().MjModel.from_xml_string(xml)
    except ValueError as error:
        reason = " ".join(str(error).split())
        raise PhysicsError(f"MuJoCo cannot make a model of it: {reason}") from None


def model_of(arm: SpatialArm, body: ArmBody, bodies: Sequence[Body]) -> Any:
    """The model of an arm among bodies; kept for the next one like it, wherever that moves."""
    things = tuple(Thing(one.name, one.role, one.shape) for one in bodies)
    return _kept(*rested(arm, body), things)


@lru_cache(maxsize=256)
def _kept(arm: SpatialArm, body: ArmBody, things: tuple[Thing, ...]) -> Any:
    model = compiled(model_xml(arm, body, things))
    model.actuator_gainprm[:, 0] = 1.0
    return model


def rested(arm: SpatialArm, body: ArmBody) -> tuple[SpatialArm, ArmBody]:
    """Return arm and body in the frame of the base: at rest, gravity turned."""
    start: Any = tuple(low for low, _ in arm.joint_range)
    still = replace(arm, base=Base(), joints=start, joint_rates=None, max_joint_acceleration=None)
    pull: Any = rotation_of(arm.base.rotation).T @ np.array(body.gravity)
    return still, replace(body, gravity=tuple(pull.round(12).tolist()))


def _add_arm(world: Xml.Element, arm: SpatialArm, body: ArmBody, alone: bool) -> None:
    radius = max(arm.thickness * body.metres, SMALLEST)
    parent, place, ends = world, np.zeros(3), (arm.upper_arm, arm.forearm)
    for i, (name, end, bone) in enumerate(
        zip(("upper_arm", "forearm"), ends, body.bones, strict=True)
    ):
        parent = _add(parent, "body", name=name, pos=place)
        _add(parent, "inertial", pos=bone.centre, mass=bone.mass, diaginertia=bone.inertia)
        for j in (2 * i, 2 * i + 1):
            _add_joint(parent, arm, body, j, alone)
        place = np.array(end) * body.metres
        if not alone:
            _add(parent, "geom", name=name, type="capsule", size=radius,
                 fromto=[0.0, 0.0, 0.0, *place], contype=LIMB, conaffinity=0)  # fmt: skip
    if not alone:
        ball = max(min(HAND * arm.grasp, arm.thickness) * body.metres, SMALLEST)
        _add(parent, "geom", name="hand", type="sphere", size=ball, pos=place,
             contype=CATCHER, conaffinity=0)  # fmt: skip


def _add_joint(parent: Xml.Element, arm: SpatialArm, body: ArmBody, j: int, alone: bool) -> None:
    motor = body.joints[j]
    limits: dict[str, Any] = {}
    if not alone:
        low, high = arm.joint_range[j]
        limits = {"range": [low, high] if low < high else [low - STUCK, low + STUCK]}
    _add(parent, "joint", name=f"joint{j}", type="hinge", axis=AXES[j], armature=motor.armature,
         damping=motor.damping, **limits)  # fmt: skip


def _add_thing(world: Xml.Element, thing: Body | Thing, name: str, metres: float) -> None:
    """A target as a free body, an obstacle as one that is moved from outside."""
    free = thing.role == "target"
    held = _add(world, "body", name=name, **({} if free else {"mocap": "true"}))
    if free:
        _add(held, "freejoint", name=name)
    kind, size = _solid(thing)
    _add(held, "geom", name=name, type=kind, size=np.array(size) * metres, density=BALL_DENSITY,
         contype=0, conaffinity=CATCHER if free else LIMB)  # fmt: skip


def _solid(thing: Body | Thing) -> tuple[str, list[float]]:
    """Return MuJoCo's name and sizes of a thing's shape; the sizes are the shape's own."""
    if thing.shape.kind not in GEOMS:
        raise PhysicsError(f"body {thing.name!r}: physics has no {thing.shape.kind}")
    return thing.shape.kind, numbers_of(thing.shape)


def _add(parent: Xml.Element, tag: str, **fields: Any) -> Xml.Element:
    """A child, with numbers as MuJoCo reads them."""
    return Xml.SubElement(parent, tag, {name: _written(value) for name, value in fields.items()})


def _written(value: Any) -> str:
    if isinstance(value, str):
        return value
    return " ".join(repr(float(part)) if not isinstance(part, int) else str(part)
                    for part in np.ravel(value).tolist())  # fmt: skip
