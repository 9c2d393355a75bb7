"""The form of situations: fields and types, so that what is judged is what was meant."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping
from typing import Any

from gcm_learn.referee.form import is_number
from gcm_learn.referee.tolerances import Unreadable

Check = Callable[[Any], bool]
UNIT = 1e-5
"""By which the length of a direction or a quaternion may differ from 1; *contract*."""
FOLLOWING = 1e-6
"""By which a follower may be outside its range at t = 0, relative and absolute; *contract*."""
FASTEST = 1e4
"""Rate of a pendulum's changes beyond which it is no pendulum [1/s]."""


def positive(value: Any) -> bool:
    """Tell if a value is a number above 0."""
    return is_number(value) and value > 0


def _not_negative(value: Any) -> bool:
    return is_number(value) and value >= 0


def _text(value: Any) -> bool:
    return isinstance(value, str)


def _list_of(check: Check, count: int | None = None) -> Check:
    """Return a check of lists whose entries all pass another, of a length if one is given."""

    def checked(value: Any) -> bool:
        fits = isinstance(value, list) and (len(value) == count if count else len(value) > 0)
        return fits and all(map(check, value))

    return checked


def _unit(count: int) -> Check:
    """Return a check of vectors of length 1."""

    def checked(value: Any) -> bool:
        return _list_of(is_number, count)(value) and abs(math.hypot(*value) - 1.0) <= UNIT

    return checked


def _either(*choices: Any) -> Check:
    return lambda value: isinstance(value, str | None) and value in choices


def _increasing(value: Any) -> bool:
    numbers = _list_of(is_number)(value) and value[0] == 0
    return numbers and all(a < b for a, b in itertools.pairwise(value))


def _range(value: Any) -> bool:
    return _list_of(is_number, 2)(value) and value[0] <= value[1]


def _index(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and value >= 0


def _ignored(value: Any) -> bool:
    """Tell if a value is null or a list of a link's index or name and an obstacle's name."""
    pairs = isinstance(value, list) and all(isinstance(p, list) and len(p) == 2 for p in value)
    return value is None or (
        pairs and all((_index(i) or _text(i)) and _text(name) for i, name in value)
    )


def _maybe(check: Check) -> Check:
    return lambda value: value is None or check(value)


V2, V3, V4 = (_list_of(is_number, n) for n in (2, 3, 4))
FLIGHT = {"position": V3, "velocity": V3, "acceleration": V3}
TURN = {"orientation": _unit(4), "spin": V3}
Fields = dict[str, Check]
SHAPES: dict[str, Fields] = {
    "disc": {"radius": positive},
    "polygon": {"vertices": _list_of(V2)},
    "sphere": {"radius": positive},
    "box": {"half_extents": _list_of(positive, 3)},
    "capsule": {"radius": positive, "half_length": positive},
    "cylinder": {"radius": positive, "half_length": positive},
}
SWING: Fields = {
    "pivot": V3, "axis": _unit(3), "down": _unit(3), "length": positive, "gravity": _not_negative,
    "angle": is_number, "rate": is_number,
}  # fmt: skip
LAWS: dict[str, tuple[Fields, Fields]] = {
    "quadratic": (FLIGHT, TURN),
    "pendulum": (SWING, {"damping": _not_negative, "hang": _not_negative}),
    "sampled": (
        {"times": _increasing, "positions": _list_of(V3)}, {"orientations": _list_of(_unit(4))},
    ),
}  # fmt: skip
LEVEL: tuple[Fields, Fields] = (
    {"position": V2, "velocity": V2, "acceleration": V2}, {"angle": is_number, "spin": is_number},
)  # fmt: skip
BASE: Fields = {"origin": V3, "rotation": _unit(4)}
JOINT: tuple[Fields, Fields] = (
    {"axis": _unit(3), "range": _range, "max_speed": positive},
    {"name": _text, "type": _either("revolute", "prismatic"), **BASE, "max_acceleration": positive},
)
LINK: Fields = {"joint": _index, "from": V3, "to": V3, "radius": positive}
MODELS: dict[str, tuple[Fields, Fields]] = {
    "gcm-learn/arm@1": ({}, {}),
    "gcm-learn/arm@2": (
        {"max_jerk": positive, "parent": _index, "follows": lambda value: _object(value)},
        {"name": _text},
    ),
}
"""Fields of joints and of links that formats of arm files add."""
ARMS: dict[str, tuple[Fields, Fields]] = {
    "planar": (
        {"hand": V2, "max_hand_speed": positive},
        {
            "upper_arm": positive, "elbow": _either("left", "right"), "thickness": _not_negative,
            "max_joint_speed": _maybe(_list_of(positive, 2)), "grasp": _not_negative,
        },
    ),
    "spatial": (
        {
            "upper_arm": V3, "forearm": V3, "joints": V4, "joint_range": _list_of(_range, 4),
            "max_joint_speed": _list_of(positive, 4), "grasp": _not_negative,
        },
        {
            "joint_rates": V4, "max_hand_speed": _maybe(positive), "thickness": _not_negative,
            "max_joint_acceleration": _maybe(_list_of(positive, 4)),
        },
    ),
    "chain": (
        {"posture": _list_of(is_number), "grasp": _not_negative},
        {
            "rates": _maybe(_list_of(is_number)), "max_hand_speed": _maybe(positive),
            "max_acceleration": _maybe(_list_of(positive)), "ignore": _ignored,
        },
    ),
}  # fmt: skip
"""Required and optional fields by kind of arm."""


def check_situation(situation: Any, version: int, kind: str) -> None:
    """Refuse a situation whose fields are not those of its format.

    Raises
    ------
    Unreadable
        With the field and the reason, on one line.
    """
    required: Fields = {
        "format": _text,
        "horizon": positive,
        "arm": _object,
        "bodies": _list_of(_object),
    }
    optional: Fields = {"name": _text, "plane": _object} if version == 1 else {"name": _text}
    if version == 3:
        optional["catch"] = _either("any", "all", "most")
    _fields(situation, "", required, optional)
    _arm(situation["arm"], version, kind)
    solid = version > 1 or "plane" in situation
    if "plane" in situation:
        plane = situation["plane"]
        _fields(plane, "plane", {"origin": V3, "x": _unit(3), "y": _unit(3)}, {})
        _orthogonal(plane, "plane", "x", "y")
    for k, body in enumerate(situation["bodies"]):
        _body(body, f"bodies[{k}]", version, solid)
    names = [body["name"] for body in situation["bodies"]]
    if len(set(names)) < len(names):
        raise Unreadable("bodies: two have the same name")
    if not any(body["role"] == "target" for body in situation["bodies"]):
        raise Unreadable("bodies: there is no target")


def _orthogonal(given: Any, path: str, first: str, second: str) -> None:
    if abs(sum(a * b for a, b in zip(given[first], given[second], strict=True))) > UNIT:
        raise Unreadable(f"{path}: {first} and {second} are not orthogonal")


def _object(value: Any) -> bool:
    return isinstance(value, Mapping)


def _fields(given: Any, path: str, required: Fields, optional: Fields) -> None:
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
    named: Fields = {} if version == 1 else {"kind": _text}
    based: Fields = {} if version == 1 else {"base": _object}
    more: Fields = (
        {"model": lambda value: _text(value) or _object(value)} if kind == "chain" else {}
    )
    _fields(arm, "arm", {**named, **required, **more}, {**optional, **based})
    _fields(arm.get("base", {}), "arm.base", {}, BASE)


def check_model(model: Any, arm: Mapping[str, Any]) -> None:
    """Refuse an arm file's object that is none, or that does not fit the arm of a situation."""
    path, objects = "arm.model", _list_of(_object)
    pair = _list_of(_index, 2)
    _fields(
        model, path,
        {"format": _either(*MODELS), "joints": objects, "links": objects, "hand": _object},
        {
            "name": _text, "source": _text,
            "self_collision": lambda v: v == [] or _list_of(pair)(v),
        },
    )  # fmt: skip
    n, (of_joints, of_links) = len(model["joints"]), MODELS[model["format"]]
    for k, joint in enumerate(model["joints"]):
        _fields(joint, f"{path}.joints[{k}]", JOINT[0], {**JOINT[1], **of_joints})
        _check_tree(model["joints"], k, f"{path}.joints[{k}]")
    _fields(model["hand"], f"{path}.hand", {"joint": _index, "point": V3}, {"axis": _unit(3)})
    for k, link in enumerate(model["links"]):
        _fields(link, f"{path}.links[{k}]", LINK, of_links)
        if link["joint"] > n:
            raise Unreadable(f"{path}.links[{k}].joint: there are {n} joints")
    if not 1 <= model["hand"]["joint"] <= n:
        raise Unreadable(f"{path}.hand.joint: there are {n} joints")
    if any(i == j or max(i, j) >= len(model["links"]) for i, j in model.get("self_collision", [])):
        raise Unreadable(f"{path}.self_collision: not a pair of links")
    leaders = [joint for joint in model["joints"] if "follows" not in joint]
    for name in ("max_acceleration", "max_jerk"):
        if len({name in joint for joint in leaders}) > 1:
            raise Unreadable(f"{path}.joints: some have a {name}")
    n = len(leaders)
    for name in ("posture", "rates", "max_acceleration"):
        if arm.get(name) is not None and len(arm[name]) != n:
            raise Unreadable(f"arm.{name}: has {len(arm[name])} numbers, there are {n} coordinates")
    _check_followers(model["joints"], arm["posture"])


def _check_tree(joints: Any, k: int, path: str) -> None:
    """Refuse a joint (from 0) that stands on, or follows, what does not come before it."""
    if joints[k].get("parent", k) > k:
        raise Unreadable(f"{path}.parent: is not before the joint")
    if "follows" in joints[k]:
        follows = joints[k]["follows"]
        line: Fields = {"joint": _index, "factor": is_number}
        _fields(follows, f"{path}.follows", line, {"offset": is_number})
        if not 1 <= follows["joint"] <= k or "follows" in joints[follows["joint"] - 1]:
            raise Unreadable(f"{path}.follows.joint: is no leader before the joint")


def _check_followers(joints: Any, posture: Any) -> None:
    """Refuse a start at which a follower is outside its range."""
    leaders = [k for k, joint in enumerate(joints, 1) if "follows" not in joint]
    for k, joint in enumerate(joints):
        if "follows" in joint:
            line, (low, high) = joint["follows"], joint["range"]
            value = line["factor"] * posture[leaders.index(line["joint"])] + line.get("offset", 0.0)
            slack = [FOLLOWING * max(1.0, abs(end)) for end in (low, high)]
            if not low - slack[0] <= value <= high + slack[1]:
                raise Unreadable(f"arm.posture: puts joints[{k}] at {value:g}, out of its range")


def _body(body: Any, path: str, version: int, solid: bool) -> None:
    approach: Fields = {"approach": _object} if version == 3 else {}
    required: Fields = {
        "role": _either("target", "obstacle"), "name": _text, "shape": _object, "motion": _object,
    }  # fmt: skip
    _fields(body, path, required, approach)
    if "approach" in body:
        if body["role"] != "target":
            raise Unreadable(f"{path}.approach: is for targets")
        angle: Fields = {"within": lambda v: is_number(v) and 0 <= v <= math.pi}
        _fields(body["approach"], f"{path}.approach", {"axis": _unit(3), **angle}, {})
    shape, kind = body["shape"], body["shape"].get("kind")
    if kind not in [k for k in SHAPES if (k not in ("disc", "polygon")) == solid]:
        raise Unreadable(f"{path}.shape.kind: {str(kind)[:60]} is not a kind of shape here")
    _fields(shape, f"{path}.shape", {"kind": _text, **SHAPES[kind]}, {})
    if kind == "polygon" and _area(shape["vertices"]) <= 0.0:
        raise Unreadable(f"{path}.shape.vertices: are not counter-clockwise")
    _motion(body["motion"], f"{path}.motion", version, solid)


def _area(vertices: list[Any]) -> float:
    """Return twice the area of a polygon, positive if it is counter-clockwise."""
    pairs = zip(vertices, [*vertices[1:], vertices[0]], strict=True)
    return sum(a[0] * b[1] - a[1] * b[0] for a, b in pairs)


def _motion(motion: Any, path: str, version: int, solid: bool) -> None:
    kind = motion.get("kind")
    known = ["quadratic", *(["pendulum"] if solid else [])]
    known += ["piecewise", "sampled"] if version == 3 else []
    if kind not in known:
        raise Unreadable(f"{path}.kind: {str(kind)[:60]} is not a kind of motion here")
    if kind == "piecewise":
        _pieces(motion, path)
        return
    required, optional = LAWS[kind] if solid else LEVEL
    _fields(motion, path, {"kind": _text, **required}, optional)
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
    _fields(motion, path, {"kind": _text, "pieces": _list_of(_object)}, {})
    for k, piece in enumerate(motion["pieces"]):
        _fields(piece, f"{path}.pieces[{k}]", {"start": is_number, **FLIGHT}, TURN)
    if not _increasing([piece["start"] for piece in motion["pieces"]]):
        raise Unreadable(f"{path}.pieces: their starts do not increase from 0")
