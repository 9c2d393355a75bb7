"""Files of situations in the exchange formats ``gcm-learn/situation@1`` to ``@3``."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from gcm_learn.checks import quote
from gcm_learn.errors import FileFormatError, SituationError
from gcm_learn.situation.json_text import JsonTextError, line_of, parse
from gcm_learn.situation.json_values import situation_from_json, situation_to_json
from gcm_learn.situation.situation import AnySituation
from gcm_learn.storage import write_whole

__all__ = [
    "read_situations",
    "situation_from_json",
    "situation_to_json",
    "write_situations",
]


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
    """Return all of standard input; a replaced one may be a text stream without a buffer."""
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
    """Return the situations of a text that has one on each line, under different names."""
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
