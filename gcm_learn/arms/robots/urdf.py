"""Robots from the elements of URDF files; meshes by trimesh."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import chain
from math import inf
from pathlib import Path
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np
from scipy.spatial.transform import Rotation

from gcm_learn.arms.robots import tree
from gcm_learn.arms.robots.tree import Drive, Hull, Inertial, Robot, RobotJoint, RobotLink
from gcm_learn.arms.robots.urdf_checks import check
from gcm_learn.errors import MissingExtraError, RobotError

MESHES = (".stl", ".obj", ".dae")
MANIFEST = "package.xml"


def read_urdf(
    robot: Element, path: Path, packages: Sequence[Path] = (), visual: bool = False
) -> Robot:
    """Read a robot from the root of a URDF file, which is changed.

    Its meshes are looked for in packages, see `_finder`. With `visual` links without collision
    geometry get that of their looks. Errors are those of `read_robot`.
    """
    notes = list(check(robot))
    for link in robot.findall("link") if visual else ():
        for look in link.findall("visual") if link.find("collision") is None else ():
            look.tag = "collision"
    notes += check(robot) if visual else ()
    find = _finder(path, packages)
    links = {link.name: link for link in (_link(given, find) for given in robot.findall("link"))}
    joints = [_joint(given) for given in robot.findall("joint")]
    children = {joint.child for joint in joints}
    for joint in joints:
        for end in {joint.parent, joint.child}.difference(links):
            if end in children or not children.issuperset(links):
                raise RobotError(f"joint {joint.name!r}: there is no link {end!r}")
            links[end] = RobotLink(end, ())  # the only root, such as "world"
    return Robot(robot.get("name") or path.stem, links, joints, tuple(notes))


def _numbers(element: Element | None, name: str, default: str = "") -> list[float]:
    """Return the numbers of an attribute."""
    given = default if element is None else element.get(name, default)
    return [float(word) for word in given.split()]


def _number(element: Element | None, name: str) -> float:
    """Return an attribute as a number, 0 if the attribute is missing."""
    return _numbers(element, name, "0")[0]


def _pose(part: Element) -> np.ndarray:
    """Return the pose (4, 4) of the origin of a part."""
    origin, pose = part.find("origin"), np.eye(4)
    pose[:3, :3] = Rotation.from_euler("xyz", _numbers(origin, "rpy", "0 0 0")).as_matrix()
    pose[:3, 3] = _numbers(origin, "xyz", "0 0 0")
    return pose


def _link(given: Element, find: Callable[[str], Path]) -> RobotLink:
    """Return a link with its geometry and mass."""
    name = given.get("name", "")
    hulls = [hull for part in given.findall("collision") for hull in _hulls(name, part, find)]
    return RobotLink(name, tuple(hulls), _inertial(given), given.find("visual") is not None)


def _inertial(link: Element) -> Inertial | None:
    """Return the mass of a link."""
    given = link.find("inertial")
    if given is None or given.find("mass") is None:
        return None
    terms = given.find("inertia")
    rows = [[_number(terms, f"i{min(a, b)}{max(a, b)}") for b in "xyz"] for a in "xyz"]
    mass = _number(given.find("mass"), "value")
    return Inertial(mass, np.zeros(3), np.array(rows)).moved(_pose(given))


def _joint(given: Element) -> RobotJoint:
    """Return a joint."""
    name, kind, limit = given.get("name", ""), given.get("type", ""), given.find("limit")
    follows, mimic = None, given.find("mimic")
    if mimic is not None:
        (factor,) = _numbers(mimic, "multiplier", "1")
        follows = (mimic.get("joint", ""), factor, _number(mimic, "offset"))
    axis = np.array(_numbers(given.find("axis"), "xyz", "1 0 0"))
    length = float(np.linalg.norm(axis))
    if kind != "fixed" and length == 0.0:
        raise RobotError(f"joint {name!r}: its axis has no length")
    x, y, z = (axis / length).tolist() if length else (1.0, 0.0, 0.0)
    bounds = hard = _range(limit, "lower", "upper")
    soft = _range(given.find("safety_controller"), "soft_lower_limit", "soft_upper_limit")
    if hard and soft and kind != "continuous":
        bounds = max(hard[0], soft[0]), min(hard[1], soft[1])
        if bounds[0] >= bounds[1] and hard[0] < hard[1]:
            ends = f"{soft[0]:g} to {soft[1]:g}"
            raise RobotError(f"joint {name!r}: safety_controller: {ends} leaves it no range")
    damping = _number(given.find("dynamics"), "damping")
    drive = Drive(_number(limit, "effort") or None, damping=damping)
    parent, child = (given.findall(end)[0].get("link", "") for end in ("parent", "child"))
    return RobotJoint(
        name, kind, parent, child, _pose(given), (x, y, z), bounds,
        _number(limit, "velocity") or None, follows, drive, soft=bounds != hard,
    )  # fmt: skip


def _range(part: Element | None, low: str, high: str) -> tuple[float, float] | None:
    """Return a range of two attributes; a missing one counts as 0 (URDF), two give None."""
    if part is None or part.get(low) is part.get(high) is None:
        return None
    return _number(part, low), _number(part, high)


def _hulls(link: str, given: Element, find: Callable[[str], Path]) -> list[Hull]:
    """Return the convex parts of a collision element, in the frame of its link."""
    shape = given.findall("geometry/*")[0]
    radius, half = _number(shape, "radius"), 0.5 * _number(shape, "length")
    if shape.tag == "mesh":
        made = _mesh(f"link {link!r}: {shape.get('filename')}", shape, find)
    elif shape.tag == "box":
        made = [tree.box(_numbers(shape, "size"))]
    elif shape.tag == "sphere":
        made = [tree.ball(radius)]
    else:
        made = [(tree.cylinder if shape.tag == "cylinder" else tree.capsule)(radius, half)]
    return [hull.moved(_pose(given)) for hull in made]


def _mesh(where: str, given: Element, find: Callable[[str], Path]) -> list[Hull]:
    """Return the hulls of a mesh file; `up_axis` turns nothing, as in rviz and Gazebo."""
    path, unit = find(given.get("filename", "")), None
    if path.suffix.lower() not in MESHES:
        kinds = ", ".join(kind[1:] for kind in MESHES)
        raise RobotError(f"{where}: only meshes of {kinds} are read")
    if not path.is_file():
        raise RobotError(f"{where}: is not there ({path})")
    try:
        import collada  # noqa: F401 - by which trimesh reads dae
        import trimesh
    except ImportError as error:
        raise MissingExtraError("a mesh", "trimesh and pycollada", "robots") from error
    try:
        loaded: Any = trimesh.load(path, force="mesh", process=False)
        vertices, faces = np.asarray(loaded.vertices, float), np.asarray(loaded.faces)
        if path.suffix.lower() == ".dae":
            unit = ElementTree.parse(path).find("{*}asset/{*}unit")
        metres = float("1" if unit is None else unit.get("meter", "1"))
    except Exception as error:  # of as many kinds as there are formats
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise RobotError(f"{where}: cannot be read ({reason})") from None
    if not 0.0 < metres < inf:
        raise RobotError(f"{where}: its unit is {metres:g} m")
    if not len(vertices) or not np.isfinite(vertices).all():
        raise RobotError(f"{where}: has no vertices that are numbers")
    return tree.mesh(vertices * metres * np.array(_numbers(given, "scale", "1")), faces)


def _finder(path: Path, packages: Sequence[Path]) -> Callable[[str], Path]:
    """Return a function that maps the name of a mesh in a file to its path.

    ``package://NAME`` and ``model://NAME`` are folders of that name, or whose ``package.xml`` has
    it. Given folders and all below, those above the file and those beside them are searched.
    """
    above = path.resolve().parents
    known: dict[str, Path] = {}

    def find(name: str) -> Path:
        scheme, _, rest = name.rpartition("://")
        if scheme in ("", "file"):
            return path.parent / rest
        if scheme not in ("package", "model"):
            raise RobotError(f"{name}: only files, package:// and model:// are read")
        package, _, inside = rest.partition("/")
        first = (known[package],) if package in known else ()
        for folder in chain(first, _folders(package, packages, above)):
            if (folder / inside).is_file():
                known[package] = folder
                return folder / inside
        looked = ", ".join(map(str, packages)) or "the folders above the file"
        raise RobotError(f"{name}: is not found in {looked}; name a folder with --packages")

    return find


def _folders(package: str, given: Sequence[Path], above: Sequence[Path]) -> Iterator[Path]:
    """Yield folders that a package may be: by their names, then by their manifests."""
    for folder in (*given, *above):
        yield from (folder / package, folder) if folder.name == package else (folder / package,)
    below = (folder.rglob(MANIFEST) for folder in given)
    near = (folder.glob(way) for folder in above for way in (MANIFEST, f"*/{MANIFEST}"))
    for manifest in chain.from_iterable(map(sorted, chain(below, near))):
        try:
            name = ElementTree.parse(manifest).findtext("name") or ""
        except (ElementTree.ParseError, OSError):
            continue
        if name.strip() == package:
            yield manifest.parent
