"""Checks of URDF files; each error names the link or joint at fault."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from xml.etree.ElementTree import Element

from gcm_learn.errors import RobotError

NUMBERS = {
    "origin": {"xyz": 3, "rpy": 3},
    "axis": {"xyz": 3},
    "limit": {"lower": 1, "upper": 1, "velocity": 1, "effort": 1},
    "mimic": {"multiplier": 1, "offset": 1},
    "dynamics": {"damping": 1, "friction": 1},
    "mass": {"value": 1},
    "inertia": dict.fromkeys(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), 1),
    "box": {"size": 3},
    "sphere": {"radius": 1},
    "cylinder": {"radius": 1, "length": 1},
    "capsule": {"radius": 1, "length": 1},
    "safety_controller": {"soft_lower_limit": 1, "soft_upper_limit": 1},
    "mesh": {"scale": 3},
}
"""Counts of the numbers in attributes, by element."""
NEEDED = {
    "parent": ("link",),
    "child": ("link",),
    "mimic": ("joint",),
    "mass": ("value",),
    "inertia": tuple(NUMBERS["inertia"]),
    "box": ("size",),
    "sphere": ("radius",),
    "cylinder": ("radius", "length"),
    "capsule": ("radius", "length"),
    "mesh": ("filename",),
}
"""Attributes that an element must have."""
SIZED = ("box", "sphere", "cylinder", "capsule")
"""Elements whose numbers must not be negative."""
SHAPES = (*SIZED, "mesh")


def check(robot: Element) -> Iterator[str]:
    """Refuse a robot whose links or joints lack a required part or have a non-finite number.

    Shapes of size 0 are taken out; a line about each is yielded.

    Raises
    ------
    RobotError
        One line that names the link or joint, the element and the attribute.
    """
    joints = [joint.get("name") for joint in robot.findall("joint")]
    if robot.find("link") is None:
        raise RobotError("has no links")
    for where, part in _named(robot):
        if part.tag == "joint":
            _check_joint(where, part, joints)
        for element in (part, *_inside(part)):
            _check_attributes(where, element)
        for given in part.findall("collision"):
            shape = _checked_shape(where, given)
            size = shape.get("radius") or shape.get("size")
            if size and not any(map(float, size.split())):
                part.remove(given)
                yield f"{part.get('name')}: a {shape.tag} of size 0 is left out"


def is_xacro(text: bytes) -> bool:
    """Return whether a file needs expansion by xacro; a mere mention of xacro does not count."""
    read = re.sub(rb"(?s)<!--.*?-->|<gazebo\b.*?</gazebo>", b"", text)
    return re.search(rb"<xacro:|=\s*[\"'][^\"']*\$[{(]", read) is not None


def _named(robot: Element) -> Iterator[tuple[str, Element]]:
    """Yield links and joints with the words that name them; names differ."""
    for kind in ("link", "joint"):
        seen = set()
        for part in robot.findall(kind):
            name = part.get("name")
            if not name:
                raise RobotError(f"{kind}: one has no name")
            if name in seen:
                raise RobotError(f"{kind} {name!r}: is there twice")
            seen.add(name)
            yield f"{kind} {name!r}", part


def _inside(part: Element) -> Iterator[Element]:
    """Yield the elements of a link or joint that are read."""
    for child in part:
        if part.tag == "joint" or child.tag in ("inertial", "collision"):
            yield from child.iter()


def _check_joint(where: str, joint: Element, names: list[str | None]) -> None:
    for end in ("parent", "child"):
        if joint.find(end) is None:
            raise RobotError(f"{where}: has no {end}")
    if not joint.get("type"):
        raise RobotError(f"{where}: has no type")
    mimic = joint.find("mimic")
    if mimic is not None and mimic.get("joint") not in names:
        raise RobotError(f"{where}: mimic.joint: there is no joint {mimic.get('joint')!r}")


def _checked_shape(where: str, collision: Element) -> Element:
    shapes = collision.findall("geometry/*")
    if len(shapes) != 1 or shapes[0].tag not in SHAPES:
        known, got = ", ".join(SHAPES), ", ".join(shape.tag for shape in shapes) or "nothing"
        raise RobotError(f"{where}: collision.geometry: must be one of {known} (got {got})")
    return shapes[0]


def _check_attributes(where: str, element: Element) -> None:
    for name in NEEDED.get(element.tag, ()):
        if not element.get(name):
            raise RobotError(f"{where}: {element.tag}.{name}: is missing")
    for name, count in NUMBERS.get(element.tag, {}).items():
        given = element.get(name)
        if given is not None:
            _check_numbers(f"{where}: {element.tag}.{name}", given, count, element.tag)


def _check_numbers(field: str, given: str, count: int, tag: str) -> None:
    try:
        numbers = [float(word) for word in given.split()]
    except ValueError:
        numbers = []
    one_scale = tag == "mesh" and len(numbers) == 1
    if (len(numbers) != count and not one_scale) or not all(map(math.isfinite, numbers)):
        many = "a finite number" if count == 1 else f"{count} finite numbers"
        raise RobotError(f"{field}: must be {many} (got {given!r})")
    if tag in SIZED and min(numbers) < 0.0:
        raise RobotError(f"{field}: must not be negative (got {given!r})")
    if tag == "mesh" and 0.0 in numbers:
        raise RobotError(f"{field}: must not be 0 (got {given!r})")
