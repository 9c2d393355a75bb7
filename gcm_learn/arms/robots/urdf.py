"""Robots from URDF files, read by yourdfpy; meshes by trimesh."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from gcm_learn.arms.robots import tree
from gcm_learn.arms.robots.tree import Drive, Hull, Inertial, Robot, RobotJoint, RobotLink
from gcm_learn.errors import MissingExtraError, RobotError

PACKAGE = "package://"
FULL_TURN = 2.0 * math.pi
"""Range to either side that joints without an end get [rad]."""
MESHES = (".stl", ".obj", ".dae")


def read_urdf(path: Path, packages: tuple[Path, ...] = ()) -> Robot:
    """Read a robot from a URDF file.

    Parameters
    ----------
    path : Path
    packages : tuple of Path
        Folders in which ``package://NAME`` is looked for, as ``FOLDER/NAME`` or as a folder that is
        called NAME itself. The folders above the file are looked through in any case.

    Raises
    ------
    RobotError
        One line that names the link or joint.
    MissingExtraError
        If yourdfpy is not installed.
    """
    loaded = _parsed(path).robot
    find = _finder(path, packages)
    links = {}
    for link in loaded.links:
        hulls = [hull for given in link.collisions for hull in _hulls(link.name, given, find)]
        links[link.name] = RobotLink(link.name, tuple(hulls), _inertial(link))
    joints = [_joint(given) for given in loaded.joints]
    for joint in joints:
        for end in (joint.parent, joint.child):
            if end not in links:
                raise RobotError(f"joint {joint.name!r}: there is no link {end!r}")
    return Robot(loaded.name or path.stem, links, joints)


def _parsed(path: Path) -> Any:
    """Return yourdfpy's record of a file, without scenes and meshes."""
    try:
        from yourdfpy import URDF
    except ImportError as error:
        raise MissingExtraError("URDF files", "yourdfpy", "robots") from error
    logging.getLogger("yourdfpy").setLevel(logging.CRITICAL)  # what is wrong is raised here
    try:
        return URDF.load(
            str(path), build_scene_graph=False, build_collision_scene_graph=False,
            load_meshes=False, load_collision_meshes=False,
        )  # fmt: skip
    except Exception as error:  # lxml's, yourdfpy's and those of Python's conversions
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise RobotError(f"is no URDF that can be read ({reason})") from None


def _inertial(link: Any) -> Inertial | None:
    """Return the mass of a link."""
    given = link.inertial
    if given is None or given.mass is None:
        return None
    pose = np.eye(4) if given.origin is None else np.array(given.origin, float)
    inertia = np.zeros((3, 3)) if given.inertia is None else np.array(given.inertia, float)
    return Inertial(float(given.mass), np.zeros(3), inertia).moved(pose)


def _joint(given: Any) -> RobotJoint:
    """Return a joint of yourdfpy as ours."""
    limit, bounds, speed, follows = given.limit, None, None, None
    if limit is not None:
        speed = limit.velocity or None
        if limit.lower is not None or limit.upper is not None:
            bounds = (limit.lower or 0.0, limit.upper or 0.0)
    if given.mimic is not None:
        factor = 1.0 if given.mimic.multiplier is None else given.mimic.multiplier
        follows = (given.mimic.joint, float(factor), float(given.mimic.offset or 0.0))
    axis = np.array([1.0, 0.0, 0.0] if given.axis is None else given.axis, float)
    length = float(np.linalg.norm(axis))
    if given.type != "fixed" and length == 0.0:
        raise RobotError(f"joint {given.name!r}: its axis has no length")
    origin = np.eye(4) if given.origin is None else np.array(given.origin, float)
    direction = tuple((axis / length).tolist()) if length else (1.0, 0.0, 0.0)
    damping = 0.0 if given.dynamics is None else float(given.dynamics.damping or 0.0)
    drive = Drive(None if limit is None else limit.effort or None, 0.0, damping)
    return RobotJoint(
        given.name, given.type, given.parent, given.child, origin, direction, bounds, speed,
        follows, drive,
    )  # fmt: skip


def _hulls(link: str, given: Any, find: Callable[[str], Path]) -> Iterator[Hull]:
    """Yield the convex parts of a collision element, in the frame of its link."""
    shape, origin = given.geometry, np.eye(4) if given.origin is None else np.array(given.origin)
    if shape.sphere is not None:
        made = [tree.ball(shape.sphere.radius)]
    elif shape.box is not None:
        made = [tree.box(shape.box.size)]
    elif shape.cylinder is not None:
        made = [tree.cylinder(shape.cylinder.radius, 0.5 * shape.cylinder.length)]
    elif shape.mesh is not None:
        made = _mesh(link, shape.mesh, find)
    else:
        raise RobotError(f"link {link!r}: its collision geometry is no box, cylinder, sphere, mesh")
    for hull in made:
        yield hull.moved(origin)


def _mesh(link: str, given: Any, find: Callable[[str], Path]) -> list[Hull]:
    """Return the hulls of a mesh file."""
    path = find(given.filename)
    if path.suffix.lower() not in MESHES:
        kinds = ", ".join(kind[1:] for kind in MESHES)
        raise RobotError(f"link {link!r}: {given.filename}: only meshes of {kinds} are read")
    if not path.is_file():
        raise RobotError(f"link {link!r}: {given.filename}: is not there ({path})")
    import trimesh

    try:
        loaded: Any = trimesh.load(path, force="mesh", process=False)
        vertices, faces = np.asarray(loaded.vertices, float), np.asarray(loaded.faces)
    except Exception as error:  # of as many kinds as there are formats
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise RobotError(f"link {link!r}: {given.filename}: cannot be read ({reason})") from None
    if not len(vertices) or not np.isfinite(vertices).all():
        raise RobotError(f"link {link!r}: {given.filename}: has no vertices that are numbers")
    scale = 1.0 if given.scale is None else np.asarray(given.scale, float)
    return tree.mesh(vertices * scale, faces)


def _finder(path: Path, packages: tuple[Path, ...]) -> Callable[[str], Path]:
    """Return a function from the name of a mesh in a file to its path."""
    above = path.resolve().parents

    def find(name: str) -> Path:
        if not name.startswith(PACKAGE):
            return path.parent / name.removeprefix("file://")
        package, _, inside = name.removeprefix(PACKAGE).partition("/")
        for folder in (*packages, *above):
            for root in (folder / package, folder if folder.name == package else None):
                if root is not None and (root / inside).is_file():
                    return root / inside
        looked = ", ".join(str(folder) for folder in packages) or "the folders above the file"
        raise RobotError(f"{name}: is not found in {looked}; name a folder with --packages")

    return find
