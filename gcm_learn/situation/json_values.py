"""Situations to JSON values and back: the exchange formats ``gcm-learn/situation@1`` to ``@3``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from gcm_learn.checks import quote, sequence, show
from gcm_learn.errors import SituationError
from gcm_learn.situation.arm_json import Reading, arm_from, arm_members
from gcm_learn.situation.body import Approach, Body
from gcm_learn.situation.formats import FORMATS, Format
from gcm_learn.situation.json_records import (
    check_names,
    kind_from,
    list_from,
    made_from,
    members_of,
    object_from,
    record_from,
)
from gcm_learn.situation.laws import Motion
from gcm_learn.situation.motion import PlanarQuadratic, SolidQuadratic
from gcm_learn.situation.shapes import PLANAR, SOLID, Shape
from gcm_learn.situation.situation import AnySituation, Plane, Situation
from gcm_learn.situation.timed_motion import Piece, Piecewise

_SOLID: dict[str, type[Shape]] = {record.kind: record for record in SOLID}
_SHAPES = {record.kind: record for record in PLANAR} | _SOLID


def situation_from_json(obj: object, folder: str | Path = ".") -> Situation[Any]:
    """Return the situation that a parsed JSON value describes.

    Parameters
    ----------
    obj : object
        A value as `json.loads` returns for one situation; an absent `name` means "".
    folder : str or Path
        Folder to which paths of arm files are relative; the working directory by default.

    Raises
    ------
    SituationError
        With the path of the offending field, e.g. ``"bodies[1].shape.radius"``.
    """
    members = object_from(obj, "")
    version = _format(members)
    reading = Reading(version, Path(folder))
    check_names(members, "", Situation, optional=("name",), absent=version.absent)
    if not version.planes and "plane" in members:
        raise SituationError("plane", f"is for planar arms ({quote(version.name)} has none)")
    shapes = _SHAPES if version.planes and "plane" not in members else _SOLID
    bodies = sequence(members["bodies"], "bodies", "bodies")
    return Situation(
        name=members.get("name", ""),
        horizon=members["horizon"],
        arm=arm_from(members["arm"], "arm", reading),
        bodies=tuple(_body(body, f"bodies[{k}]", reading, shapes) for k, body in enumerate(bodies)),
        plane=record_from(Plane, members["plane"], "plane") if "plane" in members else None,
        catch=members.get("catch", version.catches[0]),
        format=version.name,
    )


def _format(members: dict[str, Any]) -> Format:
    """Return the `format` of a situation."""
    known = " or ".join(quote(name) for name in FORMATS)
    if "format" not in members:
        raise SituationError("format", f"is missing (must be {known})")
    given = members["format"]
    if not isinstance(given, str) or given not in FORMATS:
        raise SituationError("format", f"must be {known} (got {show(given)})")
    return FORMATS[given]


def _body(obj: object, path: str, reading: Reading, shapes: dict[str, type[Shape]]) -> Body:
    """Return one entry of `bodies`."""
    members = object_from(obj, path)
    check_names(members, path, Body, absent=reading.format.absent)
    place, shape = f"{path}.shape", members["shape"]
    record = shapes[kind_from(shape, place, tuple(shapes))]
    shape = record_from(record, shape, place, extra=("kind",))
    motion = _motion(members["motion"], f"{path}.motion", isinstance(shape, SOLID), reading)
    values = members | {"shape": shape, "motion": motion}
    if "approach" in members:
        values["approach"] = record_from(Approach, members["approach"], f"{path}.approach")
    return made_from(Body, values, path)


def _motion(obj: object, path: str, solid: bool, reading: Reading) -> Motion:
    """Return the motion that `kind` names, of a solid or a planar shape."""
    kind = kind_from(obj, path, reading.format.motion_kinds)
    known = [record for record in reading.format.motions if record.kind == kind]
    record = next((r for r in known if solid != issubclass(r, PlanarQuadratic)), None)
    if record is None:
        raise SituationError(f"{path}.kind", f"{quote(kind)} needs a 3D shape")
    if record is Piecewise:
        return _piecewise(obj, path, reading)
    return record_from(record, reading.near(obj), path, extra=("kind",))


def _piecewise(obj: object, path: str, reading: Reading) -> Piecewise:
    """Return the pieces of a motion, each a quadratic one with a start."""
    members = object_from(obj, path)
    check_names(members, path, Piecewise, extra=("kind",))
    pieces = []
    for k, item in enumerate(list_from(members["pieces"], f"{path}.pieces")):
        inside = f"{path}.pieces[{k}]"
        if "start" not in object_from(item, inside):
            raise SituationError(f"{inside}.start", "is missing")
        law = record_from(SolidQuadratic, reading.near(item), inside, extra=("start",))
        pieces.append(Piece(item["start"], law))
    return made_from(Piecewise, {"pieces": tuple(pieces)}, path)


def situation_to_json(situation: AnySituation) -> dict[str, Any]:
    """Return the JSON object of a situation; `situation_from_json` gives back an equal one."""
    version = FORMATS[situation.format]
    result: dict[str, Any] = {
        "format": version.name,
        "name": situation.name,
        "horizon": situation.horizon,
        "arm": arm_members(situation.arm),
    }
    if situation.plane is not None:
        result["plane"] = members_of(situation.plane)
    if "catch" not in version.absent:
        result["catch"] = situation.catch
    result["bodies"] = [_body_to_json(body) for body in situation.bodies]
    return result


def _body_to_json(body: Body) -> dict[str, Any]:
    """Return the JSON object of a body."""
    result = {
        "role": body.role,
        "name": body.name,
        "shape": {"kind": body.shape.kind, **members_of(body.shape)},
        "motion": {"kind": body.motion.kind, **_motion_members(body.motion)},
    }
    if body.approach is not None:
        result["approach"] = members_of(body.approach)
    return result


def _motion_members(motion: Motion) -> dict[str, Any]:
    """Return the JSON members of a motion, `kind` aside."""
    if isinstance(motion, Piecewise):
        return {"pieces": [{"start": t, **members_of(law)} for t, law in motion.pieces]}
    return members_of(motion)
