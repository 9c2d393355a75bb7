"""JSON text to values, and field paths back to lines of the text."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any, TypeVar

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
    """Read an integer; Python refuses to convert very long ones."""
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
    """Return the line of `text` on which `field` starts, or the nearest field around it.

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
    """Yield (key or index, where the member starts, where its value starts)."""
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
    """Return what a function makes of the JSON value in a file.

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
