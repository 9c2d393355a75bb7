"""Checks of the form of situations: their fields, and the types of these fields."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from gcm_learn.referee.form import is_number
from gcm_learn.referee.tolerances import Unreadable

Check = Callable[[Any], bool]
UNIT = 1e-5
"""By which the length of a direction or a quaternion may differ from 1; *contract*."""
FASTEST = 1e4
"""Rate of a pendulum's changes beyond which it is no pendulum [1/s]."""


def positive(value: Any) -> bool:
    """Tell if a value is a number above 0."""
    return is_number(value) and value > 0


def _not_negative(value: Any) -> bool:
    return is_number(value) and value >= 0


def text(value: Any) -> bool:
    """Tell if a value is a string."""
    return isinstance(value, str)


def is_object(value: Any) -> bool:
    """Tell if a value is an object of JSON."""
    return isinstance(value, Mapping)


def list_of(check: Check, count: int | None = None) -> Check:
    """Return a check of non-empty lists whose entries pass `check`, of length `count` if given."""

    def checked(value: Any) -> bool:
        fits = isinstance(value, list) and (len(value) == count if count else len(value) > 0)
        return fits and all(map(check, value))

    return checked


def unit_of(count: int) -> Check:
    """Return a check of vectors of length 1."""

    def checked(value: Any) -> bool:
        return list_of(is_number, count)(value) and abs(math.hypot(*value) - 1.0) <= UNIT

    return checked


def either(*choices: Any) -> Check:
    """Return a check that a value is one of the given strings."""
    return lambda value: isinstance(value, str | None) and value in choices


def _increasing(value: Any) -> bool:
    numbers = list_of(is_number)(value) and value[0] == 0
    return numbers and all(a < b for a, b in itertools.pairwise(value))


def pair_of_ends(value: Any) -> bool:
    """Return whether a value is a pair of a low end and a high end."""
    return list_of(is_number, 2)(value) and value[0] <= value[1]


def index(value: Any) -> bool:
    """Tell if a value is a whole number from 0 on."""
    return isinstance(value, int) and not isinstance(value, bool) and value >= 0


def _ignored(value: Any) -> bool:
    """Tell if a value is null or a list of a link's index or name and an obstacle's name."""
    pairs = isinstance(value, list) and all(isinstance(p, list) and len(p) == 2 for p in value)
    return value is None or (
        pairs and all((index(i) or text(i)) and text(name) for i, name in value)
    )


def _maybe(check: Check) -> Check:
    return lambda value: value is None or check(value)


V2, V3, V4 = (list_of(is_number, n) for n in (2, 3, 4))
FLIGHT = {"position": V3, "velocity": V3, "acceleration": V3}
TURN = {"orientation": unit_of(4), "spin": V3}
Fields = dict[str, Check]
SHAPES: dict[str, Fields] = {
    "disc": {"radius": positive},
    "polygon": {"vertices": list_of(V2)},
    "sphere": {"radius": positive},
    "box": {"half_extents": list_of(positive, 3)},
    "capsule": {"radius": positive, "half_length": positive},
    "cylinder": {"radius": positive, "half_length": positive},
    "cloud": {"points": list_of(V3), "radius": positive},
    "mesh": {"vertices": list_of(V3), "triangles": list_of(list_of(index, 3))},
}
SURFACES = ("cloud", "mesh")
"""Shapes of obstacles of version 4."""
SWING: Fields = {
    "pivot": V3, "axis": unit_of(3), "down": unit_of(3), "length": positive,
    "gravity": _not_negative, "angle": is_number, "rate": is_number,
}  # fmt: skip
LAWS: dict[str, tuple[Fields, Fields]] = {
    "quadratic": (FLIGHT, TURN),
    "pendulum": (SWING, {"damping": _not_negative, "hang": _not_negative}),
    "sampled": (
        {"times": _increasing, "positions": list_of(V3)}, {"orientations": list_of(unit_of(4))},
    ),
}  # fmt: skip
LEVEL: tuple[Fields, Fields] = (
    {"position": V2, "velocity": V2, "acceleration": V2}, {"angle": is_number, "spin": is_number},
)  # fmt: skip
BASE: Fields = {"origin": V3, "rotation": unit_of(4)}
ARMS: dict[str, tuple[Fields, Fields]] = {
    "planar": (
        {"hand": V2, "max_hand_speed": positive},
        {
            "upper_arm": positive, "elbow": either("left", "right"), "thickness": _not_negative,
            "max_joint_speed": _maybe(list_of(positive, 2)), "grasp": _not_negative,
        },
    ),
    "spatial": (
        {
            "upper_arm": V3, "forearm": V3, "joints": V4, "joint_range": list_of(pair_of_ends, 4),
            "max_joint_speed": list_of(positive, 4), "grasp": _not_negative,
        },
        {
            "joint_rates": V4, "max_hand_speed": _maybe(positive), "thickness": _not_negative,
            "max_joint_acceleration": _maybe(list_of(positive, 4)),
        },
    ),
    "chain": (
        {"posture": list_of(is_number), "grasp": _not_negative},
        {
            "rates": _maybe(list_of(is_number)), "max_hand_speed": _maybe(positive),
            "max_acceleration": _maybe(list_of(positive)), "ignore": _ignored,
        },
    ),
}  # fmt: skip
"""Required and optional fields by kind of arm."""


ASKED: dict[str, Fields] = {
    "hold": {"seconds": _not_negative, "relative_speed": positive},
    "place": {"position": V3, "within": positive},
    "margin": {"now": _not_negative, "rate": _not_negative},
}
BODY: Fields = {
    "approach": lambda v: is_object(v) or (list_of(is_object)(v) and len(v) <= 2),
    **dict.fromkeys(ASKED, is_object),
    "ignore": lambda v: v == [] or list_of(text)(v), "ignore_for": positive,
}  # fmt: skip
"""Optional fields of bodies in version 4; the first of them in version 3, too."""
FOURTH: dict[str, Fields] = {
    "spatial": {"max_joint_jerk": _maybe(list_of(positive, 4)), "joint_accelerations": V4},
    "chain": {
        "max_jerk": _maybe(list_of(positive)), "accelerations": _maybe(list_of(is_number)),
    },
}  # fmt: skip
"""Optional fields of arms that version 4 adds."""


def check_situation(situation: Any, version: int, kind: str) -> None:
    """Refuse a situation that does not have the fields of its format, with their types.

    Raises
    ------
    Unreadable
        With the field and the reason, on one line.
    """
    required: Fields = {
        "format": text,
        "horizon": positive,
        "arm": is_object,
        "bodies": list_of(is_object),
    }
    optional: Fields = {"name": text, "plane": is_object} if version == 1 else {"name": text}
    if version >= 3:
        optional["catch"] = either("any", "all", "most")
    if version >= 4:
        optional |= {"end": either("free", "rest"), "end_by": _not_negative}
    fields(situation, "", required, optional)
    _arm(situation["arm"], version, kind)
    solid = version > 1 or "plane" in situation
    if "plane" in situation:
        plane = situation["plane"]
        fields(plane, "plane", {"origin": V3, "x": unit_of(3), "y": unit_of(3)}, {})
        _orthogonal(plane, "plane", "x", "y")
    for k, body in enumerate(situation["bodies"]):
        _body(body, f"bodies[{k}]", version, solid)
    names = [body["name"] for body in situation["bodies"]]
    if len(set(names)) < len(names):
        raise Unreadable("bodies: two have the same name")
    roles = {body["name"]: body["role"] for body in situation["bodies"]}
    if "target" not in roles.values():
        raise Unreadable("bodies: there is no target")
    for k, body in enumerate(situation["bodies"]):
        for name in body.get("ignore", ()):
            if roles.get(name) != "obstacle":
                raise Unreadable(f"bodies[{k}].ignore: {name[:60]} is not an obstacle")


def _orthogonal(given: Any, path: str, first: str, second: str) -> None:
    if abs(sum(a * b for a, b in zip(given[first], given[second], strict=True))) > UNIT:
        raise Unreadable(f"{path}: {first} and {second} are not orthogonal")


def fields(given: Any, path: str, required: Fields, optional: Fields) -> None:
    """Refuse an object with missing, unknown or wrong fields."""
    if not isinstance(given, Mapping):
        raise Unreadable(f"{path or 'situation'}: is not an object")
    for name in required:
        if name not in given:
            raise Unreadable(f"{path}.{name}: is missing".lstrip("."))
    known = {**optional, **required}
    for name, value in given.items():
        if name not in known:
            raise Unreadable(f"{path}.{name}: is unknown".lstrip("."))
        if not known[name](value):
            raise Unreadable(f"{path}.{name}: {str(value)[:60]} is not allowed".lstrip("."))


def _arm(arm: Any, version: int, kind: str) -> None:
    required, optional = ARMS[kind]
    named: Fields = {} if version == 1 else {"kind": text}
    based: Fields = {} if version == 1 else {"base": is_object}
    more: Fields = (
        {"model": lambda value: text(value) or is_object(value)} if kind == "chain" else {}
    )
    fourth = FOURTH[kind] if version >= 4 else {}
    fields(arm, "arm", {**named, **required, **more}, {**optional, **based, **fourth})
    fields(arm.get("base", {}), "arm.base", {}, BASE)


def _body(body: Any, path: str, version: int, solid: bool) -> None:
    required: Fields = {
        "role": either("target", "obstacle"), "name": text, "shape": is_object, "motion": is_object,
    }  # fmt: skip
    more: Fields = BODY if version >= 4 else {"approach": is_object} if version == 3 else {}
    fields(body, path, required, more)
    _asked(body, path, version)
    shape, kind = body["shape"], body["shape"].get("kind")
    known = [k for k in SHAPES if (k not in ("disc", "polygon")) == solid]
    if kind not in known or (kind in SURFACES and (version < 4 or body["role"] == "target")):
        raise Unreadable(f"{path}.shape.kind: {str(kind)[:60]} is not a kind of shape here")
    fields(shape, f"{path}.shape", {"kind": text, **SHAPES[kind]}, {})
    if kind == "mesh" and np.max(shape["triangles"]) >= len(shape["vertices"]):
        raise Unreadable(f"{path}.shape.triangles: there are {len(shape['vertices'])} vertices")
    if kind == "polygon" and _area(shape["vertices"]) <= 0.0:
        raise Unreadable(f"{path}.shape.vertices: are not counter-clockwise")
    _motion(body["motion"], f"{path}.motion", version, solid)


def _asked(body: Any, path: str, version: int) -> None:
    """Refuse wrong fields of approach, hold, place and margin."""
    for name in set(body) & set(BODY):
        if (body["role"] == "obstacle") != (name == "margin"):
            raise Unreadable(
                f"{path}.{name}: is for {'obstacles' if name == 'margin' else 'targets'}"
            )
    listed = body.get("approach", [])
    for k, approach in enumerate(listed if isinstance(listed, list) else [listed]):
        place = f"{path}.approach[{k}]" if isinstance(listed, list) else f"{path}.approach"
        angle: Fields = {"within": lambda v: is_number(v) and 0 <= v <= math.pi}
        hand: Fields = {"hand": unit_of(3)} if version >= 4 else {}
        fields(approach, place, {"axis": unit_of(3), **angle}, hand)
    for name, required in ASKED.items():
        if name in body:
            fields(body[name], f"{path}.{name}", required, {})
    for name, other in (("place", "hold"), ("ignore", "place"), ("ignore_for", "ignore")):
        if name in body and other not in body:
            raise Unreadable(f"{path}.{name}: is without {other}")


def _area(vertices: list[Any]) -> float:
    """Return twice the area of a polygon, positive if it is counter-clockwise."""
    pairs = zip(vertices, [*vertices[1:], vertices[0]], strict=True)
    return sum(a[0] * b[1] - a[1] * b[0] for a, b in pairs)


def _motion(motion: Any, path: str, version: int, solid: bool) -> None:
    kind = motion.get("kind")
    known = ["quadratic", *(["pendulum"] if solid else [])]
    known += ["piecewise", "sampled"] if version >= 3 else []
    if kind not in known:
        raise Unreadable(f"{path}.kind: {str(kind)[:60]} is not a kind of motion here")
    if kind == "piecewise":
        _pieces(motion, path)
        return
    required, optional = LAWS[kind] if solid else LEVEL
    fields(motion, path, {"kind": text, **required}, optional)
    if kind == "pendulum":
        _orthogonal(motion, path, "axis", "down")
        rates = math.sqrt(motion["gravity"] / motion["length"]), abs(motion["rate"])
        if max(*rates, motion.get("damping", 0.0)) > FASTEST:
            raise Unreadable(f"{path}: swings too fast")
    if kind == "sampled":
        for name in ("positions", "orientations"):
            if len(motion.get(name, motion["times"])) != len(motion["times"]):
                raise Unreadable(f"{path}.{name}: there are {len(motion['times'])} times")


def _pieces(motion: Any, path: str) -> None:
    fields(motion, path, {"kind": text, "pieces": list_of(is_object)}, {})
    for k, piece in enumerate(motion["pieces"]):
        fields(piece, f"{path}.pieces[{k}]", {"start": is_number, **FLIGHT}, TURN)
    if not _increasing([piece["start"] for piece in motion["pieces"]]):
        raise Unreadable(f"{path}.pieces: their starts do not increase from 0")
