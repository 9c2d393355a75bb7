"""JSON text with line numbers of fields, and conversion of records to JSON objects and back."""

from __future__ import annotations

import dataclasses
import json
import math
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np

from gcm_learn.arms import Chain, ChainJoint, Follows, Link
from gcm_learn.checks import LARGEST, UNIT_LENGTH, UNIT_TOLERANCE, quote, show
from gcm_learn.errors import FileFormatError, SituationError

Made = TypeVar("Made")

_LONGEST_INTEGER = 400
"""Digits from which an integer is read as a float: far beyond the largest float anyway."""

_BLANK = re.compile(r"[ \t\n\r]*")
_STEP = re.compile(r"\[(\d+)\]|([^.\[\]]+)")


class RepeatedField(dict[str, Any]):
    """A JSON object in which one key stands twice; `key` is the first such key."""

    key: str = ""


class JsonTextError(ValueError):
    """The text is not JSON; `line` counts from 1 within the text."""

    def __init__(self, reason: str, line: int) -> None:
        super().__init__(reason)
        self.reason = reason
        self.line = line


def _integer(digits: str) -> int | float:
    """Read an integer; very long ones become floats, as Python refuses to convert them."""
    return int(digits) if len(digits) <= _LONGEST_INTEGER else float(digits)


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Collect an object's members and remember a key that is repeated."""
    members: dict[str, Any] = {}
    for key, value in pairs:
        if key in members:
            repeated = RepeatedField(pairs)
            repeated.key = key
            return repeated
        members[key] = value
    return members


_DECODER = json.JSONDecoder(parse_int=_integer, object_pairs_hook=_object)


def parse(text: str) -> object:
    """Return the one JSON value in `text`.

    NaN and infinities are let through, so that their field can be named; an object with a
    repeated key becomes a `RepeatedField`.
    """
    if not text.strip(" \t\n\r"):
        raise JsonTextError("nothing in it", 1)
    try:
        return _DECODER.decode(text)
    except json.JSONDecodeError as error:
        raise JsonTextError(f"{error.msg} (column {error.colno})", error.lineno) from None
    except RecursionError:
        raise JsonTextError("nested too deeply", 1) from None


def line_of(text: str, field: str) -> int:
    """Return the line of `text` where `field` starts, or else the nearest field around `field`.

    Parameters
    ----------
    text : str
        One JSON value that `parse` accepts.
    field : str
        A path such as ``"bodies[1].shape.radius"``.
    """
    line_start = value_start = _skip(text, 0)
    for index, key in _STEP.findall(field):
        step = int(index) if index else key
        found = next((m for m in _members(text, value_start) if m[0] == step), None)
        if found is None:
            break
        _, line_start, value_start = found
    return text.count("\n", 0, line_start) + 1


def _members(text: str, start: int) -> Iterator[tuple[str | int, int, int]]:
    """Yield (key or index, start of the member, start of its value) for each member."""
    closing = {"{": "}", "[": "]"}.get(text[start])
    if closing is None:
        return
    position, index = _skip(text, start + 1), 0
    while text[position] != closing:
        member, key = position, index
        if closing == "}":
            key, position = _DECODER.raw_decode(text, position)
            position = _skip(text, _skip(text, position) + 1)
        yield key, member, position
        _, position = _DECODER.raw_decode(text, position)
        position = _skip(text, position)
        if text[position] == ",":
            position = _skip(text, position + 1)
        index += 1


def _skip(text: str, position: int) -> int:
    """Return the position of the next character that is not white space."""
    match = _BLANK.match(text, position)
    return match.end() if match else position


def read_value(path: Path | Traversable, name: str, make: Callable[[object], Made]) -> Made:
    """Read the JSON value in a file and return `make` of that value.

    Parameters
    ----------
    path : Path or Traversable
    name : str
        Name of the file in messages.
    make : callable
        It may raise a `SituationError`, whose field is looked up in the file.

    Raises
    ------
    FileFormatError
        One line: ``arm.json:7: joints[2].axis: must have length 1 (got 1.1)``.
    """
    try:
        content = path.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise FileFormatError(f"{name}:1: is not UTF-8 text ({error.reason})") from None
    except (OSError, ValueError) as error:  # ValueError: a path with a null byte
        reason = getattr(error, "strerror", None) or error
        raise FileFormatError(f"{name}: cannot be read ({reason})") from None
    try:
        return make(parse(content))
    except JsonTextError as error:
        raise FileFormatError(f"{name}:{error.line}: not valid JSON: {error.reason}") from None
    except SituationError as error:
        raise FileFormatError(f"{name}:{line_of(content, error.field)}: {error}") from None


_Record = TypeVar("_Record")


class Renamed(NamedTuple):
    """Names of a record's fields in files, where they differ; and fields that may be null."""

    names: dict[str, str]
    null: tuple[str, ...] = ()


RENAMED: dict[type, Renamed] = {
    Link: Renamed({"start": "from", "end": "to"}),
    Chain: Renamed(
        {
            "joints": "posture",
            "joint_rates": "rates",
            "max_joint_acceleration": "max_acceleration",
            "max_joint_jerk": "max_jerk",
            "joint_accelerations": "accelerations",
        },
        null=("max_acceleration", "max_jerk"),
    ),
}
NORMALISED = ("rotation", "orientation", "axis", "down")
"""Fields with unit vectors, which newer formats normalise instead of refusing them."""
NESTED: dict[type, dict[str, type]] = {ChainJoint: {"follows": Follows}}
"""Fields that hold records, by name."""
_NONE = Renamed({})


class RecordLayout(NamedTuple):
    """Fields of a record in files."""

    attributes: dict[str, str]  # name in files to name in the record
    required: tuple[str, ...]  # names in files
    null: tuple[str, ...]


_LAYOUTS: dict[type, RecordLayout] = {}


def layout_of(record: type) -> RecordLayout:
    """Return the fields of a record in files."""
    if record not in _LAYOUTS:
        _LAYOUTS[record] = _layout(record)
    return _LAYOUTS[record]


def _layout(record: Any) -> RecordLayout:
    renamed = RENAMED.get(record, _NONE)
    own = list(record.__annotations__)  # a record that extends another has an order of its own
    fields = sorted(
        (field for field in dataclasses.fields(record) if field.init),
        key=lambda field: own.index(field.name),
    )
    attributes = {renamed.names.get(field.name, field.name): field.name for field in fields}
    required = [
        renamed.names.get(field.name, field.name)
        for field in fields
        if field.default is dataclasses.MISSING
    ]
    return RecordLayout(attributes, tuple(required), renamed.null)


def record_from(
    record: type[_Record],
    obj: object,
    path: str,
    extra: Sequence[str] = (),
    absent: Sequence[str] = (),
) -> _Record:
    """Return a record from a JSON object's members without `extra`; refuse members in `absent`."""
    members = object_from(obj, path)
    check_names(members, path, record, extra, absent=absent)
    values = {k: v for k, v in members.items() if k not in extra}
    for name, inner in NESTED.get(record, {}).items():
        if name in values:
            values[name] = record_from(inner, values[name], join(path, name))
    return made_from(record, values, path)


def records_from(
    record: type[_Record], value: object, path: str, absent: Sequence[str] = ()
) -> tuple[_Record, ...]:
    """Return the records of a JSON list."""
    return tuple(
        record_from(record, item, f"{path}[{k}]", absent=absent)
        for k, item in enumerate(list_from(value, path))
    )


def made_from(record: type[_Record], members: dict[str, Any], path: str) -> _Record:
    """Return a record from members under their names in files; errors get the full path."""
    names = layout_of(record).attributes
    try:
        return record(**{names[name]: value for name, value in members.items()})
    except SituationError as error:
        raise SituationError(join(path, error.field), error.reason) from None


def object_from(obj: object, path: str) -> dict[str, Any]:
    """Return `obj` if it is a JSON object without repeated keys."""
    if not isinstance(obj, dict):
        raise SituationError(path, f"must be an object (got {show(obj)})")
    if isinstance(obj, RepeatedField):
        raise SituationError(join(path, shown(obj.key)), "is given twice")
    return obj


def list_from(value: object, path: str) -> list[Any] | tuple[Any, ...]:
    """Return `value` if it is a list."""
    if not isinstance(value, (list, tuple)):
        raise SituationError(path, f"must be a list of objects (got {show(value)})")
    return value


def kind_from(obj: object, path: str, known: Sequence[str]) -> str:
    """Return the `kind` of an arm, shape or motion."""
    members = object_from(obj, path)
    if "kind" not in members:
        raise SituationError(f"{path}.kind", f"is missing (known: {', '.join(known)})")
    kind = members["kind"]
    if not isinstance(kind, str) or kind not in known:
        reason = f"must be one of {', '.join(known)} (got {show(kind)})"
        raise SituationError(f"{path}.kind", reason)
    return kind


def check_names(
    members: dict[str, Any],
    path: str,
    record: type,
    extra: Iterable[str] = (),
    optional: Sequence[str] = (),
    absent: Iterable[str] = (),
) -> None:
    """Refuse unknown, missing and null fields.

    Parameters
    ----------
    members : dict
    path : str
        Path of the object, for messages.
    record : type
    extra, optional, absent : iterable of str
        Fields that the object has beyond the record's, that it need not have, and that it does
        not have.
    """
    layout = layout_of(record)
    known = set(layout.attributes).union(extra).difference(absent)
    for key in members:
        if key not in known:
            reason = f"is not a known field (known: {', '.join(sorted(known))})"
            raise SituationError(join(path, shown(key)), reason)
    for name in layout.required:
        if name not in members and name not in optional:
            raise SituationError(join(path, name), "is missing")
    for key, value in members.items():
        if value is None and key not in layout.null:
            raise SituationError(join(path, key), "must not be null (leave the field out)")


def normalised_units(obj: Any) -> Any:
    """Return an object, with its unit vectors normalised if they are nearly of length 1."""
    if not isinstance(obj, dict) or isinstance(obj, RepeatedField):
        return obj
    return obj | {name: _unit(obj[name]) for name in NORMALISED if name in obj}


def _unit(value: Any) -> Any:
    """Normalise a vector of nearly length 1; return other values unchanged, for later checks."""
    if not isinstance(value, list) or not all(
        type(part) in (int, float) and abs(part) <= LARGEST for part in value
    ):
        return value
    length = math.hypot(*value)
    if UNIT_TOLERANCE < abs(length - 1.0) <= UNIT_LENGTH:
        return [part / length for part in value]
    return value


def members_of(record: Any, absent: Collection[str] = ()) -> dict[str, Any]:
    """Return a record's fields as JSON values, less `absent`; keep None where files allow null."""
    layout, result = layout_of(type(record)), {}
    for name, field in layout.attributes.items():
        if name in absent:
            continue
        value = getattr(record, field)
        if type(value) is float:  # most are: spare the questions
            result[name] = value
        elif value is not None or name in layout.null:
            result[name] = _plain(value)
    return result


def _plain(value: Any) -> Any:
    """Return lists in place of tuples and arrays, and objects in place of records."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, tuple):
        plain = not value or type(value[0]) is float
        return list(value) if plain else [_plain(item) for item in value]
    return members_of(value) if hasattr(value, "__dataclass_fields__") else value


def join(path: str, field: str) -> str:
    """Return the path of `field` inside `path`."""
    return f"{path}.{field}" if path and field else path or field


def shown(key: object) -> str:
    """Return a key for error messages: plain if it looks like a field, else quoted."""
    name = str(key)
    plain = name.isascii() and name.isidentifier() and len(name) <= 40
    return name if plain else quote(name)
