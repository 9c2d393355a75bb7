"""From a robot's tree of links to a chain: fixed joints folded, links covered by capsules."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np
from scipy.spatial.transform import Rotation

from gcm_learn.arms.chain_model import ChainJoint, ChainModel, Hand, Link
from gcm_learn.arms.robots.capsules import FittedCapsule, reduced
from gcm_learn.arms.robots.fits import MOST, Cover, Freedom, covered
from gcm_learn.arms.robots.following import MOVING, Placed, arranged
from gcm_learn.arms.robots.pairs import RigidLink
from gcm_learn.arms.robots.tree import Drive, Hull, Inertial, Robot, RobotJoint, together
from gcm_learn.arms.robots.urdf import read_urdf
from gcm_learn.arms.robots.urdf_checks import is_xacro
from gcm_learn.errors import RobotError, SituationError

FULL_TURN = 2.0 * math.pi
"""Range to either side that joints without an end get [rad]."""
CLEAR = 1e-12  # shorter numbers of rotations are rounding
PARALLEL = 1.0 - 1e-6
"""Least cosine of the angle of slides along one line."""


class Fitted(NamedTuple):
    """A chain that was made from a robot."""

    model: ChainModel
    covers: tuple[Cover, ...]
    parts: tuple[tuple[Hull, ...], ...]
    """Convex parts that each link of the model holds, in the frame of its joint."""
    freedom: Freedom
    """How free the arm is of itself."""
    masses: tuple[Inertial, ...]
    """(m + 1) Mass that each frame carries, the base first."""
    drives: tuple[Drive, ...]
    """(m) Motors of the joints; a follower's motor has no torque."""


def read_robot(
    path: str | Path, packages: Sequence[str | Path] = (), visual: bool = False
) -> Robot:
    """Read a robot from a file; the root element tells URDF from MJCF.

    Packages and models are also searched in the given folders. With `visual`, links without
    collision geometry get their visual geometry.

    Raises
    ------
    RobotError
        One line that begins with the path.
    """
    file = Path(path)
    try:
        text = file.read_bytes()
        if file.suffix == ".xacro" or is_xacro(text):
            raise RobotError(f"this is xacro, expand it first: xacro {path} > robot.urdf")
        whole = ElementTree.fromstring(text)
        for element in whole.iter():
            element.tag = element.tag.rpartition("}")[2]
        root = whole.tag
        if root not in ("robot", "mujoco"):
            raise RobotError(f"is no URDF (<robot>) and no MJCF (<mujoco>): begins with <{root}>")
        if root == "robot":
            return read_urdf(whole, file, tuple(Path(folder) for folder in packages), visual)
        from gcm_learn.arms.robots.mjcf import read_mjcf

        return read_mjcf(file, visual)
    except ElementTree.ParseError as error:
        raise RobotError(f"{path}: is not XML ({error})") from None
    except OSError as error:
        raise RobotError(f"{path}: cannot be read ({error.strerror or error})") from None
    except RobotError as error:
        raise RobotError(f"{path}: {error}") from None


def chain_of(
    robot: Robot,
    base: str,
    tip: str,
    *,
    point: Sequence[float] = (0.0, 0.0, 0.0),
    axis: Sequence[float] = (0.0, 0.0, 1.0),
    at: Mapping[str, float] | None = None,
    max_speed: Sequence[float] | None = None,
    max_acceleration: Sequence[float] | None = None,
    max_jerk: Sequence[float] | None = None,
    torque: Sequence[float] | None = None,
    armature: Sequence[float] | None = None,
    tool: float | None = None,
    capsules: int | None = None,
    name: str | None = None,
    source: str = "",
    seed: int = 0,
) -> Fitted:
    """Make a chain of the joints between two links of a robot.

    Fixed joints are folded. Joints that follow the chain's move with them, on the chain or beside
    it. All other joints stand at their given value; their links count, carried by the joint that
    they hang from.

    Parameters
    ----------
    robot : Robot
    base, tip : str
        Links at both ends; the frame of `base` is that of the chain's base.
    point, axis : (3,) sequence of float
        The hand's place and the direction in which it reaches, in the frame of `tip`.
    at : dict of str to float
        Values of joints that stand still [rad or lengths]; 0, or the nearest that is allowed, if
        not given.
    max_speed, max_acceleration, max_jerk : (n,) sequence of float, optional
        Of the coordinates, that is, of joints that follow no other [rad/s, rad/s^2, rad/s^3];
        speeds are those of the file else.
    torque, armature : (n,) sequence of float, optional
        Of the chain's motors, see `Drive`; those of the file else.
    tool : float, optional
        Radius of a capsule from the origin of `tip` to `point`; there is none if not given.
    capsules : int, optional
        That cover a link, at most; an arm has 40 in all, unless more links move apart.
    name, source : str, optional
    seed : int
        Of the postures by which pairs for self-collision are found.

    Raises
    ------
    RobotError
        One line that names the link or joint.
    """
    way = _way(robot, base, tip)
    placed, frames = arranged(robot, base, way, at or {})
    if not placed:
        raise RobotError(f"no joint moves between {base!r} and {tip!r}")
    moving = [one.joint for one in placed if one.follows is None]
    speeds = iter(_listed(max_speed, "max_speed", moving))
    forces = iter(_listed(max_acceleration, "max_acceleration", moving))
    jerks = iter(_listed(max_jerk, "max_jerk", moving))
    joints: list[ChainJoint] = []
    for k, one in enumerate(placed):
        if one.follows is None:
            joints.append(_chain_joint(one, k, None, next(speeds), next(forces), next(jerks)))
        else:
            joints.append(_chain_joint(one, k, joints[one.follows.joint - 1]))
    last, pose = frames[tip]
    hand = Hand(last, _tuple(pose[:3, :3] @ point + pose[:3, 3]), _tuple(pose[:3, :3] @ axis))
    solids = _solids(robot, frames)
    if tool is not None:
        if not 0.0 < tool < math.inf:
            raise RobotError(f"tool: must be above 0 (got {tool:g})")
        reach = FittedCapsule(pose[:3, 3], np.array(hand.point), tool)
        solids.append(RigidLink(f"tool of {tip}", last, [reach.hull._replace(link=len(solids))]))
    bare = Link(0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 1.0)
    model = ChainModel(name or robot.name, tuple(joints), (bare,), hand, (), source)
    made = covered(model, solids, _joined(robot), capsules or MOST, seed)
    drives = _drives(
        placed, _listed(torque, "torque", moving), _listed(armature, "armature", moving)
    )
    return Fitted(*made, _masses(robot, frames, len(placed)), drives)


def _listed(
    given: Sequence[float] | None, field: str, moving: Sequence[RobotJoint]
) -> Sequence[float | None]:
    if given is None:
        return [None] * len(moving)
    if len(given) == 1:
        return list(given) * len(moving)
    if len(given) != len(moving):
        names = ", ".join(joint.name for joint in moving)
        raise RobotError(f"{field}: must have 1 or {len(moving)} numbers, for {names}")
    return list(given)


def _way(robot: Robot, base: str, tip: str) -> list[RobotJoint]:
    """Return the joints on the path from link `base` out to link `tip`."""
    for what, link in (("base", base), ("tip", tip)):
        if link not in robot.links:
            known = ", ".join(robot.links)
            raise RobotError(f"{what}: there is no link {link!r} (known: {known})")
    above = {joint.child: joint for joint in robot.joints}
    way: list[RobotJoint] = []
    at = tip
    while at != base:
        if at not in above or len(way) > len(robot.joints):
            raise RobotError(f"tip: {tip!r} does not hang from {base!r}")
        way.insert(0, above[at])
        at = way[0].parent
    for joint in way:
        if joint.type not in (*MOVING, "fixed"):
            raise RobotError(f"joint {joint.name!r}: is {joint.type}, which a chain cannot be")
    return way


def _chain_joint(
    placed: Placed, k: int, leader: ChainJoint | None, speed: float | None = None,
    force: float | None = None, jerk: float | None = None,
) -> ChainJoint:  # fmt: skip
    """Return joint k (from 0) of the arm; a follower without limits gets them from its leader."""
    joint, pose, line = placed.joint, placed.pose, placed.follows
    speed = joint.max_speed if speed is None else speed
    bounds = (-FULL_TURN, FULL_TURN) if joint.type == "continuous" else joint.range
    if leader is not None and line is not None:
        ends = sorted(line.factor * end + line.offset for end in leader.range)
        free = joint.type == "continuous" or bounds is None
        bounds = (ends[0], ends[1]) if free else bounds
        speed = abs(line.factor) * leader.max_speed if speed is None else speed
    if speed is None:
        raise RobotError(f"joint {joint.name!r}: has no largest speed; give --max-speed")
    if bounds is None:
        way = ", or make its type continuous" if joint.type == "revolute" else ""
        raise RobotError(f"joint {joint.name!r}: has no range; give its limits{way}")
    quaternion = Rotation.from_matrix(pose[:3, :3]).as_quat(scalar_first=True)
    quaternion = np.where(np.abs(quaternion) < CLEAR, 0.0, quaternion)
    try:
        return ChainJoint(
            axis=_tuple(placed.axis),
            range=bounds,
            max_speed=speed,
            type="prismatic" if joint.type == "prismatic" else "revolute",
            origin=_tuple(pose[:3, 3]),
            rotation=_tuple(quaternion),
            max_acceleration=force,
            max_jerk=jerk,
            name=joint.name,
            parent=None if placed.parent == k else placed.parent,
            follows=line,
        )
    except SituationError as error:
        raise RobotError(f"joint {joint.name!r}: {error}") from None


def _solids(robot: Robot, frames: Mapping[str, tuple[int, np.ndarray]]) -> list[RigidLink]:
    """Return the links that can touch anything, in the frames that carry them."""
    solids: list[RigidLink] = []
    for link in robot.links.values():
        if link.hulls and link.name in frames:
            number, pose = frames[link.name]
            hulls = [reduced(h.moved(pose)._replace(link=len(solids))) for h in link.hulls]
            solids.append(RigidLink(link.name, number, hulls))
    if not solids:
        looks = any(link.looks for link in robot.links.values())
        raise RobotError(f"has no collision geometry{'; try --visual' if looks else ''}")
    return solids


def _joined(robot: Robot) -> set[frozenset[str]]:
    """Return the pairs of link names that one joint joins; in MJCF links are bodies.

    Tubes of a telescope, which slide along one line, lie in each other and count as joined.
    """
    above = {joint.child: joint for joint in robot.joints if joint.type != "fixed"}
    pairs = set()
    for joint in above.values():
        child, axis = joint.child.removesuffix(f" at {joint.name}"), np.array(joint.axis)
        pairs.add(frozenset((joint.parent, child)))
        while joint.type == "prismatic" and joint.parent in above:
            axis = joint.origin[:3, :3] @ axis
            joint = above[joint.parent]
            if joint.type != "prismatic" or abs(axis @ joint.axis) < PARALLEL:
                break
            pairs.add(frozenset((joint.parent, child)))
    return pairs


def _drives(
    placed: Sequence[Placed], torques: Sequence[float | None], rotors: Sequence[float | None]
) -> tuple[Drive, ...]:
    """Return the motors of joints, of which some numbers may be given; followers have none."""
    made, listed = [], iter(zip(torques, rotors, strict=True))
    for joint, follows in ((one.joint, one.follows) for one in placed):
        torque, rotor = next(listed) if follows is None else (0.0, None)
        given = {"torque": torque, "armature": rotor}
        made.append(joint.drive._replace(**{k: v for k, v in given.items() if v is not None}))
    return tuple(made)


def _masses(
    robot: Robot, frames: Mapping[str, tuple[int, np.ndarray]], count: int
) -> tuple[Inertial, ...]:
    """Return the mass that each frame carries, of all links fixed in that frame."""
    parts: list[list[Inertial]] = [[] for _ in range(count + 1)]
    for name, (number, pose) in frames.items():
        inertial = robot.links[name].inertial
        if inertial is not None:
            parts[number].append(inertial.moved(pose))
    return tuple(map(together, parts))


def _tuple(values: Any) -> Any:
    return tuple(float(value) + 0.0 for value in values)
