"""Situations in the exchange formats ``gcm-learn/situation@1`` to ``@4``: values and files."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from gcm_learn.checks import quote, sequence, show
from gcm_learn.errors import FileFormatError, SituationError
from gcm_learn.situation.arm_files import Reading, arm_from, arm_members
from gcm_learn.situation.body import ASKED, Approach, Body
from gcm_learn.situation.json_records import (
    JsonTextError,
    check_names,
    kind_from,
    line_of,
    list_from,
    made_from,
    members_of,
    object_from,
    parse,
    record_from,
    records_from,
)
from gcm_learn.situation.laws import ENDS, FORMATS, Format, Motion
from gcm_learn.situation.motion import PlanarQuadratic, SolidQuadratic
from gcm_learn.situation.shapes import PLANAR, SOLID, SPACE, Shape
from gcm_learn.situation.situation import AnySituation, Plane, Situation
from gcm_learn.situation.surface_files import with_files
from gcm_learn.situation.timed_motion import Piece, Piecewise
from gcm_learn.storage import write_whole

_SOLID: dict[str, type[Shape]] = {record.kind: record for record in SOLID}
_SHAPES = {record.kind: record for record in PLANAR} | _SOLID
_SPACE: dict[str, type[Shape]] = {record.kind: record for record in SPACE}


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
    check_names(members, "", Situation, optional=("name",), absent=version.absent["situation"])
    if not version.planes and "plane" in members:
        raise SituationError("plane", f"is for planar arms ({quote(version.name)} has none)")
    shapes = _SPACE if version.holds else _SOLID
    if version.planes and "plane" not in members:
        shapes = _SHAPES
    bodies = sequence(members["bodies"], "bodies", "bodies")
    return Situation(
        name=members.get("name", ""),
        horizon=members["horizon"],
        arm=arm_from(members["arm"], "arm", reading),
        bodies=tuple(_body(body, f"bodies[{k}]", reading, shapes) for k, body in enumerate(bodies)),
        plane=record_from(Plane, members["plane"], "plane") if "plane" in members else None,
        catch=members.get("catch", version.catches[0]),
        format=version.name,
        end=members.get("end", ENDS[0]),
        end_by=members.get("end_by"),
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
    """Return the body of one entry of `bodies`."""
    members = object_from(obj, path)
    check_names(members, path, Body, absent=reading.format.absent["body"])
    place = f"{path}.shape"
    record = shapes[kind_from(members["shape"], place, tuple(shapes))]
    given = with_files(object_from(members["shape"], place), place, reading.folder)
    shape = record_from(record, given, place, extra=("kind",))
    motion = _motion(members["motion"], f"{path}.motion", isinstance(shape, SPACE), reading)
    values = members | {"shape": shape, "motion": motion}
    if "approach" in members:
        values["approach"] = _approaches(members["approach"], f"{path}.approach", reading.format)
    for name, asked in ASKED.items():
        if name in members:
            values[name] = record_from(asked, members[name], f"{path}.{name}")
    return made_from(Body, values, path)


def _approaches(value: object, path: str, version: Format) -> tuple[Approach, ...]:
    """Return the approaches of a target from one object, or from a list of one or two objects."""
    absent = tuple(version.absent["approach"])
    if not version.holds or not isinstance(value, list):
        return (record_from(Approach, value, path, absent=absent),)
    if not 1 <= len(value) <= 2:
        raise SituationError(path, f"must be one or two approaches (got {len(value)})")
    return records_from(Approach, value, path)


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
    """Return a piecewise motion from its pieces, each a quadratic motion with a start."""
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
    """Return a situation as a JSON object; `situation_from_json` restores an equal situation."""
    version = FORMATS[situation.format]
    result: dict[str, Any] = {
        "format": version.name,
        "name": situation.name,
        "horizon": situation.horizon,
        "arm": arm_members(situation.arm, version),
    }
    if situation.plane is not None:
        result["plane"] = members_of(situation.plane)
    if len(version.catches) > 1:
        result["catch"] = situation.catch
    if version.holds:
        result["end"] = situation.end
    if situation.end_by is not None:
        result["end_by"] = situation.end_by
    result["bodies"] = [_body_to_json(body) for body in situation.bodies]
    return result


def _body_to_json(body: Body) -> dict[str, Any]:
    """Return the JSON object of a body."""
    result: dict[str, Any] = {
        "role": body.role,
        "name": body.name,
        "shape": {"kind": body.shape.kind, **members_of(body.shape)},
        "motion": {"kind": body.motion.kind, **_motion_members(body.motion)},
    }
    if body.approach:
        written = [members_of(approach) for approach in body.approach]
        result["approach"] = written if len(written) > 1 else written[0]
    for name in ASKED:
        if getattr(body, name) is not None:
            result[name] = members_of(getattr(body, name))
    if body.ignore:
        result["ignore"] = list(body.ignore)
    if body.ignore_for is not None:
        result["ignore_for"] = body.ignore_for
    return result


def _motion_members(motion: Motion) -> dict[str, Any]:
    """Return the JSON members of a motion, `kind` aside."""
    if isinstance(motion, Piecewise):
        return {"pieces": [{"start": t, **members_of(law)} for t, law in motion.pieces]}
    return members_of(motion)


__all__ = ["read_situations", "situation_from_json", "situation_to_json", "write_situations"]


Check = Callable[[AnySituation], object]


def read_situations(path: str | Path, check: Check | None = None) -> list[AnySituation]:
    """Read every situation of a file; all are checked before any is returned.

    Parameters
    ----------
    path : str or Path
        A ``.json`` file holds one situation, a ``.jsonl`` file one per line (blank lines are
        skipped). ``-`` is standard input; it and files of any other name may hold either.
        Lines may be those of a suite, e.g. ``data/suites/demo.jsonl``.
    check : callable, optional
        Called with each situation; what it refuses by a SituationError is refused with its line.

    Raises
    ------
    FileFormatError
        One line: ``scene.jsonl:12: arm.hand: (2.4, 0.0) is out of reach (max 2.0)``.
    """
    name = "<stdin>" if str(path) == "-" else _printable(str(path))
    content = _read_text(path, name)
    suffix = Path(path).suffix.lower()
    folder = Path() if str(path) == "-" else Path(path).parent
    if suffix == ".jsonl" or (suffix != ".json" and _starts_with_value_line(content)):
        return _read_lines(content, name, folder, check)
    return [_read_one(content, name, folder, check)]


def _read_text(path: str | Path, name: str) -> str:
    """Return the text of a file or of standard input."""
    try:
        content = _read_stdin() if str(path) == "-" else Path(path).read_bytes()
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = error.object.count(b"\n", 0, error.start) + 1
        raise FileFormatError(f"{name}:{line}: is not UTF-8 text ({error.reason})") from None
    except (OSError, ValueError) as error:
        # ValueError: a path with a null byte
        reason = getattr(error, "strerror", None) or error
        raise FileFormatError(f"{name}: cannot be read ({reason})") from None


def _read_stdin() -> bytes:
    """Return all bytes of standard input, even if a text stream without a buffer replaces it."""
    content = getattr(sys.stdin, "buffer", sys.stdin).read()
    return content.encode("utf-8", "surrogateescape") if isinstance(content, str) else content


def _starts_with_value_line(content: str) -> bool:
    """Return whether the first line that is not blank is JSON, and is followed by others."""
    lines = [line for line in content.split("\n") if line.strip()]
    if len(lines) < 2:
        return False
    try:
        parse(lines[0])
    except JsonTextError:
        return False
    return True


def _read_one(content: str, name: str, folder: Path, check: Check | None) -> AnySituation:
    """Return the only situation of a text, which may span lines."""
    try:
        situation = situation_from_json(parse(content), folder)
        if check is not None:
            check(situation)
        return situation
    except JsonTextError as error:
        raise FileFormatError(f"{name}:{error.line}: not valid JSON: {error.reason}") from None
    except SituationError as error:
        raise FileFormatError(f"{name}:{line_of(content, error.field)}: {error}") from None


def _read_lines(content: str, name: str, folder: Path, check: Check | None) -> list[AnySituation]:
    """Return the situations of a text with one situation on each line; refuse repeated names."""
    situations: list[AnySituation] = []
    for number, line in _filled_lines(content):
        try:
            situations.append(_named_situation(parse(line), folder))
            if check is not None:
                check(situations[-1])
        except JsonTextError as error:
            raise FileFormatError(f"{name}:{number}: not valid JSON: {error.reason}") from None
        except SituationError as error:
            raise FileFormatError(f"{name}:{number}: {error}") from None
    if not situations:
        raise FileFormatError(f"{name}:1: no situation in the file")
    _check_unique(situations, [number for number, _ in _filled_lines(content)], name)
    return situations


def _filled_lines(content: str) -> Iterator[tuple[int, str]]:
    """Yield (line number, line) of the lines that are not blank."""
    for number, line in enumerate(content.split("\n"), start=1):
        if line.strip(" \t\r"):
            yield number, line


def _named_situation(obj: object, folder: Path) -> AnySituation:
    """Return the situation of a parsed line, where the name is required.

    A line of a suite's file holds its situation beside what is known about it.
    """
    if type(obj) is dict and "suite" in obj and isinstance(obj.get("situation"), dict):
        obj = obj["situation"]
    situation = situation_from_json(obj, folder)
    if isinstance(obj, dict) and "name" not in obj:
        raise SituationError("name", "is missing (required where a file holds several)")
    return situation


def _check_unique(situations: Sequence[AnySituation], lines: Sequence[int], name: str) -> None:
    """Refuse two situations of the same name."""
    first: dict[str, int] = {}
    for situation, line in zip(situations, lines, strict=True):
        if situation.name in first:
            reason = f"{quote(situation.name)} is already the name in line {first[situation.name]}"
            raise FileFormatError(f"{name}:{line}: name: {reason}")
        first[situation.name] = line


def write_situations(path: str | Path, situations: Sequence[AnySituation]) -> None:
    """Write situations to a file that `read_situations` reads back equal.

    The file appears complete or not at all.

    Parameters
    ----------
    path : str or Path
        A ``.json`` file takes exactly one situation, any other gets one per line.
    situations : sequence of Situation
        Under different names, unless there is only one.
    """
    path = Path(path)
    if path.suffix.lower() == ".json":
        if len(situations) != 1:
            reason = f"a .json file holds 1 situation (got {len(situations)}), a .jsonl file many"
            raise FileFormatError(f"{_printable(str(path))}: {reason}")
        content = json.dumps(situation_to_json(situations[0]), indent=2, allow_nan=False) + "\n"
    else:
        _check_unique(situations, range(1, len(situations) + 1), _printable(str(path)))
        objects = (situation_to_json(situation) for situation in situations)
        content = "".join(json.dumps(obj, allow_nan=False) + "\n" for obj in objects)
    write_whole(path, content)


def _printable(text: str) -> str:
    """Return `text` with line breaks and other invisible characters escaped."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)
