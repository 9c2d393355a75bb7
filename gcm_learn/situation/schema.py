"""JSON Schemas of the exchange formats, derived from the records that are read.

Types and defaults come from the records' fields and names from `json_records`; this file adds
bounds and choices.  Records judge what a schema cannot, such as a hand out of reach.
"""

from __future__ import annotations

import math
import types
import typing
from collections.abc import Callable, Iterable, Iterator
from dataclasses import is_dataclass
from itertools import chain
from typing import Any

from gcm_learn import arms, referee
from gcm_learn.checks import LARGEST
from gcm_learn.situation.arm_files import ARM_FORMATS, NEW
from gcm_learn.situation.body import OF_TARGETS, ROLES, WITH, Approach, Body, Hold, Margin, Place
from gcm_learn.situation.json_records import layout_of
from gcm_learn.situation.laws import ENDS, FORMATS, Format
from gcm_learn.situation.motion import Pendulum, PlanarQuadratic, SolidQuadratic
from gcm_learn.situation.shapes import (
    PLANAR as FLAT,
    SOLID,
    SPACE,
    Box,
    Capsule,
    Cylinder,
    Disc,
    Polygon,
    Sphere,
)
from gcm_learn.situation.situation import Situation
from gcm_learn.situation.surfaces import Cloud, Mesh
from gcm_learn.situation.timed_motion import Piecewise, Sampled

Schema = dict[str, Any]
DIALECT = "https://json-schema.org/draft/2020-12/schema"

_POSITIVE: Schema = {"exclusiveMinimum": 0}
_NOT_NEGATIVE: Schema = {"minimum": 0}
_FILLED: Schema = {"minItems": 1}
_FOUR: Schema = {"minItems": arms.JOINTS, "maxItems": arms.JOINTS}

NUMBERS: dict[type, dict[str, Schema]] = {
    Situation: {"horizon": _POSITIVE, "end_by": _NOT_NEGATIVE},
    arms.Arm: dict.fromkeys(("max_hand_speed", "max_joint_speed", "upper_arm"), _POSITIVE)
    | dict.fromkeys(("thickness", "grasp"), _NOT_NEGATIVE),
    arms.SpatialArm: dict.fromkeys(
        ("max_hand_speed", "max_joint_speed", "max_joint_acceleration", "max_joint_jerk"), _POSITIVE
    )
    | dict.fromkeys(("thickness", "grasp"), _NOT_NEGATIVE),
    arms.Chain: {"max_hand_speed": _POSITIVE, "grasp": _NOT_NEGATIVE},
    arms.ChainJoint: dict.fromkeys(("max_speed", "max_acceleration", "max_jerk"), _POSITIVE)
    | {"parent": _NOT_NEGATIVE},
    arms.Follows: {"joint": {"minimum": 1}},
    arms.Link: {"radius": _POSITIVE, "joint": _NOT_NEGATIVE},
    arms.Hand: {"joint": {"minimum": 1}},
    arms.ChainModel: {"self_collision": _NOT_NEGATIVE},
    Approach: {"within": {"minimum": 0, "maximum": math.pi}},
    Hold: {"seconds": _NOT_NEGATIVE, "relative_speed": _POSITIVE},
    Place: {"within": _POSITIVE},
    Margin: dict.fromkeys(("now", "rate"), _NOT_NEGATIVE),
    Body: {"ignore_for": _POSITIVE},
    Disc: {"radius": _POSITIVE},
    Sphere: {"radius": _POSITIVE},
    Box: {"half_extents": _POSITIVE},
    Capsule: dict.fromkeys(("radius", "half_length"), _POSITIVE),
    Cylinder: dict.fromkeys(("radius", "half_length"), _POSITIVE),
    Cloud: {"radius": _POSITIVE},
    Pendulum: {"length": _POSITIVE} | dict.fromkeys(("gravity", "damping", "hang"), _NOT_NEGATIVE),
}
"""Bounds of the numbers in fields, under their names in the records."""

LISTS: dict[type, dict[str, Schema]] = {
    Polygon: {"vertices": {"minItems": 3}},
    Sampled: dict.fromkeys(("times", "positions", "orientations"), _FILLED),
    arms.SpatialArm: {"joint_range": _FOUR},
    arms.Chain: {"joints": _FILLED},
}
"""Lengths of lists in fields."""

CHOICES: dict[type, dict[str, tuple[str, ...]]] = {
    arms.Arm: {"elbow": arms.ELBOWS},
    arms.ChainJoint: {"type": arms.JOINT_TYPES},
    Body: {"role": ROLES},
    Situation: {"end": ENDS},
}
"""Strings that are known in fields."""


def schemas() -> dict[str, Schema]:
    """Return the JSON Schemas (draft 2020-12) of situations and arms, by the name of the format."""
    made = {name: _document(name, _situation(version)) for name, version in FORMATS.items()}
    return made | {name: _document(name, _model(name)) for name in ARM_FORMATS}


def _document(name: str, schema: Schema) -> Schema:
    return {"$schema": DIALECT, "title": name, **schema}


def _situation(version: Format) -> Schema:
    """Return the schema of a situation."""
    absent = {*version.absent["situation"]} | (set() if version.planes else {"plane"})
    given = {
        "format": {"const": version.name},
        "arm": {"anyOf": [_ARMS.of(kind)(version) for kind in version.kinds]},
        "bodies": {"type": "array", "contains": _has("role", "target")},
        "catch": {"enum": list(version.catches)},
    }
    result = _object(Situation, given, required=("format",), optional=("name",), absent=absent)
    space = SPACE if version.holds else SOLID
    flat, solid = ({"items": _body(version, shapes)} for shapes in (FLAT, space))
    if not version.planes:
        result["properties"]["bodies"] |= solid
    else:
        result |= {"if": {"required": ["plane"]}}
        result |= {"then": _within("bodies", solid), "else": _within("bodies", flat)}
    return result


def _body(version: Format, shapes: Iterable[type]) -> Schema:
    """Return the schema of a body that has one of `shapes`."""
    flat = shapes is FLAT
    known = [law for law in version.motions if flat == issubclass(law, PlanarQuadratic)]
    given = {
        "shape": {"oneOf": [*chain.from_iterable(map(_shape, shapes))]},
        "motion": {"oneOf": [_motion(law) for law in known]},
        "approach": _approach(version),
    }
    result = _object(Body, given, absent=version.absent["body"])
    if version.approach:
        result |= {"if": _within("role", {"const": "obstacle"})}
        result |= {"then": {"properties": dict.fromkeys(OF_TARGETS, False)}}
    if version.holds:
        result |= {"else": _within("margin", False)}
        result |= {"dependentRequired": {name: [other] for name, other in WITH}}
    return result


def _shape(record: type) -> Iterator[Schema]:
    """Yield the schemas of a shape, of which a mesh has two."""
    given: dict[str, Any] = {"kind": _kind(record)}
    points = {"type": "array", "items": _value(tuple[float, float, float], {}), **_FILLED}
    corner = {"type": "integer", **_NOT_NEGATIVE}
    if record is Cloud:
        given["points"] = {"anyOf": [points, _ending([".npy"])]}
    if record is Mesh:
        file = {"kind": _kind(record), "file": _ending(referee.MESHES), "scale": _number(_POSITIVE)}
        yield {
            "type": "object",
            "properties": file,
            "required": ["kind", "file"],
            "additionalProperties": False,
        }
        three = {"type": "array", "items": corner, "minItems": 3, "maxItems": 3}
        given |= {"vertices": points, "triangles": {"type": "array", "items": three, **_FILLED}}
    yield _object(record, given, required=("kind",))


def _ending(ends: Iterable[str]) -> Schema:
    """Return the schema of names of files that end so, in letters of either size."""
    either = ("".join(f"[{c}{c.upper()}]" if c.isalpha() else "[.]" for c in end) for end in ends)
    return {"type": "string", "pattern": f"({'|'.join(either)})$"}


def _approach(version: Format) -> Schema:
    """Return the schema of the approaches of a target."""
    one = _object(Approach, absent=version.absent["approach"])
    if not version.holds:
        return one
    return {"anyOf": [one, {"type": "array", "items": one, "minItems": 1, "maxItems": 2}]}


def _motion(law: type) -> Schema:
    """Return the schema of a motion law."""
    given: dict[str, Any] = {"kind": _kind(law)}
    if law is Piecewise:
        start = {"start": _number(_NOT_NEGATIVE)}
        piece = _object(SolidQuadratic, start, required=("start",))
        given["pieces"] = {"type": "array", "items": piece, "minItems": 1}
    return _object(law, given, required=("kind",))


def _model(name: str) -> Schema:
    """Return the schema of a file of an arm, in the format of a name."""
    given: dict[str, Any] = {"format": {"const": name}}
    for field, record in (("joints", arms.ChainJoint), ("links", arms.Link)):
        absent = NEW[record] if name == ARM_FORMATS[0] else ()
        given[field] = {"type": "array", "items": _object(record, absent=absent), **_FILLED}
    return _object(arms.ChainModel, given, required=("format",), optional=("name",))


def _spatial(version: Format) -> Schema:
    given = {"kind": _kind(arms.SpatialArm)}
    return _object(arms.SpatialArm, given, required=("kind",), absent=version.absent["arm"])


def _chain(version: Format) -> Schema:
    numbers = {"type": "array", "items": _number(_POSITIVE)}
    limits = {"anyOf": [numbers, {"type": "null"}]}
    index = {"type": "integer", "minimum": 0}
    link = [{"anyOf": [index, {"type": "string"}]}, {"type": "string"}]
    given = {
        "kind": _kind(arms.Chain),
        "model": {"anyOf": [{"type": "string"}, *map(_model, ARM_FORMATS)]},
        "max_acceleration": limits,
        "max_jerk": limits,
        "ignore": {"type": "array", "items": {"type": "array", "prefixItems": link, **_pair()}},
    }
    return _object(arms.Chain, given, required=("kind",), absent=version.absent["arm"])


def _pair() -> Schema:
    return {"minItems": 2, "maxItems": 2}


def _kind(record: Any) -> Schema:
    return {"const": record.kind}


def _has(name: str, value: str) -> Schema:
    """Return the schema of objects that have a field of a value."""
    return {"type": "object", **_within(name, {"const": value}), "required": [name]}


def _within(name: str, schema: Any) -> Schema:
    """Return the schema of objects whose field `name`, if present, fits `schema`."""
    return {"properties": {name: schema}}


def _object(
    record: type,
    given: dict[str, Any] | None = None,
    required: Iterable[str] = (),
    optional: Iterable[str] = (),
    absent: Iterable[str] = (),
) -> Schema:
    """Return the schema of a record.

    Parameters
    ----------
    record : type
    given : dict
        Schemas of fields that are not derived, and of those beyond the record's.
    required, optional, absent : iterable of str
        Fields that must be there, need not be there, and must not be there, other than the
        record says.
    """
    layout, hints = layout_of(record), typing.get_type_hints(record)
    properties = dict(given or {})
    for name, field in layout.attributes.items():
        if name not in properties and name not in absent:
            properties[name] = _field(record, field, hints[field])
    needed = [name for name in layout.required if name not in {*optional, *absent}]
    return {
        "type": "object",
        "properties": {name: value for name, value in properties.items() if name not in absent},
        "required": [*required, *needed],
        "additionalProperties": False,
    }


def _field(record: type, field: str, hint: Any) -> Schema:
    """Return the schema of a field of a record."""
    if field in CHOICES.get(record, {}):
        return {"enum": list(CHOICES[record][field])}
    result = _value(hint, NUMBERS.get(record, {}).get(field, {}))
    return result | LISTS.get(record, {}).get(field, {})


def _value(hint: Any, bounds: Schema) -> Schema:
    """Return the schema of values of a type, with bounds for its numbers."""
    if isinstance(hint, types.UnionType):  # optional fields are left out, never null
        hint = next(part for part in typing.get_args(hint) if part is not types.NoneType)
    if typing.get_origin(hint) is tuple:
        parts = typing.get_args(hint)
        length = {} if parts[-1] is ... else {"minItems": len(parts), "maxItems": len(parts)}
        return {"type": "array", "items": _value(parts[0], bounds), **length}
    if is_dataclass(hint) and isinstance(hint, type):
        return _object(hint)
    if hint is int:
        return {"type": "integer", **bounds}
    return {"type": "string"} if hint is str else _number(bounds)


def _number(bounds: Schema) -> Schema:
    return {"type": "number", "minimum": -LARGEST, "maximum": LARGEST, **bounds}


_ARMS: arms.ByKind[Callable[[Format], Schema]] = arms.ByKind(
    {arms.PLANAR: lambda version: _object(arms.Arm), arms.SPATIAL: _spatial, arms.CHAIN: _chain}
)
