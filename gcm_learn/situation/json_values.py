"""Situations to JSON values and back: the exchange formats ``gcm-learn/situation@1`` and ``@2``."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from functools import lru_cache
from typing import Any, TypeVar

from gcm_learn.arms import Arm, Base, SpatialArm
from gcm_learn.checks import quote, sequence, show
from gcm_learn.errors import SituationError
from gcm_learn.situation.json_text import RepeatedField
from gcm_learn.situation.motion import Motion, Pendulum, PlanarQuadratic, SolidQuadratic
from gcm_learn.situation.shapes import PLANAR, SOLID, Shape
from gcm_learn.situation.situation import AnySituation, Body, Plane, Situation

FORMAT = "gcm-learn/situation@1"
SPATIAL_FORMAT = "gcm-learn/situation@2"

_SHAPES: dict[str, type[Shape]] = {record.kind: record for record in PLANAR + SOLID}
_MOTIONS = (PlanarQuadratic.kind, Pendulum.kind)

_Record = TypeVar("_Record")


def situation_from_json(obj: object) -> Situation[Any]:
    """Return the situation that a parsed JSON value describes.

    Parameters
    ----------
    obj : object
        What `json.loads` returns for one situation; an absent `name` means "".

    Raises
    ------
    SituationError
        With the path of the offending field, e.g. ``"bodies[1].shape.radius"``.
    """
    members = object_from(obj, "")
    spatial = _format(members) == SPATIAL_FORMAT
    check_names(members, "", Situation, extra=("format",), optional=("name",))
    if spatial and "plane" in members:
        raise SituationError("plane", f"is for planar arms ({quote(SPATIAL_FORMAT)} has none)")
    bodies = sequence(members["bodies"], "bodies", "bodies")
    return Situation(
        name=members.get("name", ""),
        horizon=members["horizon"],
        arm=(_spatial_arm if spatial else _planar_arm)(members["arm"], "arm"),
        bodies=tuple(_body(body, f"bodies[{k}]") for k, body in enumerate(bodies)),
        plane=record_from(Plane, members["plane"], "plane") if "plane" in members else None,
    )


def _format(members: dict[str, Any]) -> str:
    """Return the `format` of a situation."""
    known = f"{quote(FORMAT)} or {quote(SPATIAL_FORMAT)}"
    if "format" not in members:
        raise SituationError("format", f"is missing (must be {known})")
    given = members["format"]
    if not isinstance(given, str) or given not in (FORMAT, SPATIAL_FORMAT):
        raise SituationError("format", f"must be {known} (got {show(given)})")
    return given


def _planar_arm(obj: object, path: str) -> Arm:
    """Return the arm of ``@1``."""
    return record_from(Arm, obj, path)


def _spatial_arm(obj: object, path: str) -> SpatialArm:
    """Return the arm of ``@2``."""
    _kind(obj, path, (SpatialArm.kind,))
    members = object_from(obj, path)
    check_names(members, path, SpatialArm, extra=("kind",))
    values = {name: value for name, value in members.items() if name != "kind"}
    if "base" in values:
        values["base"] = record_from(Base, values["base"], f"{path}.base")
    return made_from(SpatialArm, values, path)


def _body(obj: object, path: str) -> Body:
    """Return one entry of `bodies`."""
    members = object_from(obj, path)
    check_names(members, path, Body)
    shape = _shape(members["shape"], f"{path}.shape")
    motion = _motion(members["motion"], f"{path}.motion", solid=isinstance(shape, SOLID))
    return made_from(Body, members | {"shape": shape, "motion": motion}, path)


def _shape(obj: object, path: str) -> Shape:
    """Return the shape that `kind` names."""
    return record_from(_SHAPES[_kind(obj, path, tuple(_SHAPES))], obj, path, extra=("kind",))


def _motion(obj: object, path: str, *, solid: bool) -> Motion:
    """Return the motion that `kind` names; `solid` tells which of the quadratic ones."""
    record: type[Motion] = SolidQuadratic if solid else PlanarQuadratic
    if _kind(obj, path, _MOTIONS) == Pendulum.kind:
        if not solid:
            raise SituationError(f"{path}.kind", '"pendulum" needs a 3D shape')
        record = Pendulum
    return record_from(record, obj, path, extra=("kind",))


def _kind(obj: object, path: str, known: Sequence[str]) -> str:
    """Return the `kind` of a shape or motion."""
    members = object_from(obj, path)
    if "kind" not in members:
        raise SituationError(f"{path}.kind", f"is missing (known: {', '.join(known)})")
    kind = members["kind"]
    if not isinstance(kind, str) or kind not in known:
        reason = f"must be one of {', '.join(known)} (got {show(kind)})"
        raise SituationError(f"{path}.kind", reason)
    return kind


def record_from(
    record: type[_Record], obj: object, path: str, extra: Sequence[str] = ()
) -> _Record:
    """Return a record whose fields carry the names of the JSON fields, `extra` aside."""
    members = object_from(obj, path)
    check_names(members, path, record, extra)
    return made_from(record, {k: v for k, v in members.items() if k not in extra}, path)


def made_from(record: type[_Record], members: dict[str, Any], path: str) -> _Record:
    """Return ``record(**members)``; its errors get the full path."""
    try:
        return record(**members)
    except SituationError as error:
        raise SituationError(_join(path, error.field), error.reason) from None


def object_from(obj: object, path: str) -> dict[str, Any]:
    """Return `obj` if it is a JSON object without repeated keys."""
    if not isinstance(obj, dict):
        raise SituationError(path, f"must be an object (got {show(obj)})")
    if isinstance(obj, RepeatedField):
        raise SituationError(_join(path, _shown(obj.key)), "is given twice")
    return obj


def check_names(
    members: dict[str, Any],
    path: str,
    record: type,
    extra: Sequence[str] = (),
    optional: Sequence[str] = (),
) -> None:
    """Refuse unknown, missing and null fields; `extra` and `optional` correct the record's."""
    fields = dataclasses.fields(record)
    known = {field.name for field in fields}.union(extra)
    for key in members:
        if key not in known:
            reason = f"is not a known field (known: {', '.join(sorted(known))})"
            raise SituationError(_join(path, _shown(key)), reason)
    for field in fields:
        needed = field.default is dataclasses.MISSING and field.name not in optional
        if needed and field.name not in members:
            raise SituationError(_join(path, field.name), "is missing")
    for key, value in members.items():
        if value is None:
            raise SituationError(_join(path, key), "must not be null (leave the field out)")


def _join(path: str, field: str) -> str:
    """Return the path of `field` inside `path`."""
    return f"{path}.{field}" if path and field else path or field


def _shown(key: object) -> str:
    """Return a key as errors show it: plain when it looks like a field, else quoted."""
    name = str(key)
    plain = name.isascii() and name.isidentifier() and len(name) <= 40
    return name if plain else quote(name)


def situation_to_json(situation: AnySituation) -> dict[str, Any]:
    """Return the JSON object of a situation; `situation_from_json` gives back an equal one."""
    spatial = isinstance(situation.arm, SpatialArm)
    result: dict[str, Any] = {
        "format": SPATIAL_FORMAT if spatial else FORMAT,
        "name": situation.name,
        "horizon": situation.horizon,
        "arm": _arm_to_json(situation.arm),
    }
    if situation.plane is not None:
        result["plane"] = _members_of(situation.plane)
    result["bodies"] = [_body_to_json(body) for body in situation.bodies]
    return result


def _arm_to_json(arm: Arm | SpatialArm) -> dict[str, Any]:
    """Return the JSON object of an arm."""
    if isinstance(arm, Arm):
        return _members_of(arm)
    return {"kind": arm.kind, **_members_of(arm), "base": _members_of(arm.base)}


def _body_to_json(body: Body) -> dict[str, Any]:
    """Return the JSON object of a body."""
    return {
        "role": body.role,
        "name": body.name,
        "shape": {"kind": body.shape.kind, **_members_of(body.shape)},
        "motion": {"kind": body.motion.kind, **_members_of(body.motion)},
    }


def _members_of(record: Arm | SpatialArm | Base | Plane | Shape | Motion) -> dict[str, Any]:
    """Return the fields of a record as JSON values; those that are None stay absent."""
    kind: type = type(record)
    values = {name: getattr(record, name) for name in _names_of(kind)}
    return {name: _listed(value) for name, value in values.items() if value is not None}


@lru_cache(maxsize=32)
def _names_of(kind: type) -> tuple[str, ...]:
    return tuple(field.name for field in dataclasses.fields(kind))


def _listed(value: object) -> object:
    """Return `value` with lists in place of tuples."""
    if not isinstance(value, tuple):
        return value
    nested = len(value) > 0 and isinstance(value[0], tuple)
    return [_listed(item) for item in value] if nested else list(value)
