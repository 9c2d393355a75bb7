"""Files made by others: where they are from, and values with the path that messages name."""

from __future__ import annotations

import bz2
import gzip
import lzma
import math
import re
import tarfile
import zlib
from collections.abc import Callable, Collection, Iterable, Iterator
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from gcm_learn.checks import number, quote, show
from gcm_learn.errors import FileFormatError, MissingExtraError, SituationError, not_known
from gcm_learn.situation import JsonTextError, parse

_Made = TypeVar("_Made")
NEAR_UNIT = 1e-3
"""Largest error of a quaternion's length; nearer ones are normalised."""


@dataclass(frozen=True)
class Node:
    """A value of a file.

    Parameters
    ----------
    file : str
        Name of the file, for messages.
    path : str
        Path of the value, such as ``world.collision_objects[3].id``; empty for the whole file.
    value : object
        Dictionaries, lists, strings and numbers, as parsers of JSON and YAML return them.
    """

    file: str
    path: str
    value: Any

    def error(self, reason: str) -> FileFormatError:
        """Return the error that names the file, the field and a reason."""
        return FileFormatError(": ".join(filter(None, (self.file, self.path, reason))))

    def members(self, known: Collection[str] | None = None) -> dict[str, Any]:
        """Return the members of an object; refuse names that are not in `known`, if that is given.

        Raises
        ------
        FileFormatError
        """
        if not isinstance(self.value, dict):
            raise self.error(f"must be an object (got {show(self.value)})")
        for key in self.value:
            if not isinstance(key, str):
                raise self.error(f"has a member that is not named by text ({show(key)})")
            if known is not None and key not in known:
                raise self.inside(key).error(not_known(key, known))
        return self.value

    def inside(self, name: str) -> Node:
        """Return the member called `name`; its value is None if the member is missing."""
        path = f"{self.path}.{name}" if self.path else name
        return Node(self.file, path, self.members().get(name))

    def at(self, name: str) -> Node:
        """Return a member that must be there."""
        found = self.inside(name)
        if found.value is None:
            raise found.error("is missing")
        return found

    def find(self, name: str) -> Node | None:
        """Return the member called `name`, or None if the member is missing, null or empty."""
        found = self.inside(name)
        return None if found.value in (None, [], {}, "") else found

    def rows(self) -> list[Node]:
        """Return the entries of a list."""
        if not isinstance(self.value, list):
            raise self.error(f"must be a list (got {show(self.value)})")
        return [Node(self.file, f"{self.path}[{k}]", item) for k, item in enumerate(self.value)]

    def text(self) -> str:
        """Return a string."""
        if not isinstance(self.value, str):
            raise self.error(f"must be a string (got {show(self.value)})")
        return self.value

    def number(self) -> float:
        """Return a finite number; text such as ``1e-05``, a word in YAML, counts as a number."""
        value = self.value
        if isinstance(value, str):
            try:
                value = float(value)
            except ValueError:
                raise self.error(f"must be a number (got {quote(self.value)})") from None
        return self.checked(number, value, "")

    def numbers(self, size: int | None = None, names: str = "") -> tuple[float, ...]:
        """Return the numbers of a list, or of an object with a member for each letter of `names`.

        Parameters
        ----------
        size : int, optional
            Number of entries that a list must have.
        names : str
        """
        if names and isinstance(self.value, dict):
            self.members(names)
            return tuple(self.at(name).number() for name in names)
        rows = self.rows()
        if size is not None and len(rows) != size:
            raise self.error(f"must be a list of {size} numbers (got {len(rows)})")
        return tuple(row.number() for row in rows)

    def point(self) -> tuple[float, float, float]:
        """Return a place (3,), from a list or from an object with x, y and z."""
        x, y, z = self.numbers(3, "xyz")
        return (x, y, z)

    def turn(self) -> tuple[float, float, float, float]:
        """Return the unit quaternion (w, x, y, z) of numbers in the order x, y, z, w.

        Four zeros are no turn, as in MoveIt.
        """
        given = self.numbers(4, "xyzw")
        length = math.hypot(*given)
        if length == 0.0:
            return (1.0, 0.0, 0.0, 0.0)
        if abs(length - 1.0) > NEAR_UNIT:
            raise self.error(f"must be a quaternion of length 1 (got {length:.9g})")
        x, y, z, w = (part / length for part in given)
        return (w, x, y, z)

    def checked(self, make: Callable[..., _Made], *values: Any) -> _Made:
        """Return ``make(*values)``; turn its errors into errors about this value."""
        try:
            return make(*values)
        except SituationError as error:
            raise self.error(str(error).removeprefix(": ")) from None


def unique(names: Iterator[tuple[Node, str]]) -> None:
    """Refuse the second of two equal names."""
    seen: set[str] = set()
    for node, name in names:
        if name in seen:
            raise node.error(f"{quote(name)} is given twice")
        seen.add(name)


_OPENERS: dict[str, Callable[..., Any]] = {".gz": gzip.open, ".bz2": bz2.open, ".xz": lzma.open}
_DAMAGED = (tarfile.TarError, EOFError, zlib.error, lzma.LZMAError)


Careful = Callable[[], AbstractContextManager[object]]


def texts(source: Path, wanted: str, careful: Careful = nullcontext) -> list[tuple[str, str]]:
    """Return name and text of the files of a source, in the order of their names.

    Parameters
    ----------
    source : Path
        A folder, searched with all folders in it, a tar archive, or a file that may be compressed.
    wanted : str
        Regular expression that names of files in folders and archives match.
    careful : callable
        Context in which a file that is no text raises its error.

    Raises
    ------
    FileFormatError
        If the source cannot be read or has no such file.
    """
    try:
        found = sorted(_files(source, wanted))
    except (OSError, ValueError, *_DAMAGED) as error:
        reason = getattr(error, "strerror", None) or error
        raise FileFormatError(f"{source}: cannot be read ({reason})") from None
    if not found:
        raise FileFormatError(f"{source}: has no file whose name matches {wanted}")
    made = []
    for name, content in found:
        with careful():
            try:
                made.append((name, content.decode("utf-8-sig")))
            except UnicodeDecodeError as error:
                raise FileFormatError(f"{name}: is not UTF-8 text ({error.reason})") from None
    return made


def _files(source: Path, wanted: str) -> Iterator[tuple[str, bytes]]:
    match = re.compile(wanted).fullmatch
    if source.is_dir():
        for path in source.rglob("*"):
            if match(path.name) and path.is_file():
                yield str(path), path.read_bytes()
    elif tarfile.is_tarfile(source):
        with tarfile.open(source) as archive:
            for member in archive:
                content = archive.extractfile(member)
                if content is not None and match(Path(member.name).name):
                    yield f"{source}/{member.name}", content.read()
    else:
        with _OPENERS.get(source.suffix.lower(), open)(source, "rb") as stream:
            yield str(source), stream.read()


def json_nodes(
    sources: Iterable[Path], wanted: str, careful: Careful = nullcontext
) -> Iterator[Node]:
    """Return the value of every JSON file; see `texts`.

    Raises
    ------
    FileFormatError
    """
    for source in sources:
        for name, text in texts(source, wanted, careful):
            with careful():
                try:
                    yield Node(name, "", parse(text))
                except JsonTextError as error:
                    reason = f"not valid JSON: {error.reason}"
                    raise FileFormatError(f"{name}:{error.line}: {reason}") from None


def yaml_node(name: str, text: str) -> Node:
    """Return the value of a YAML text.

    Raises
    ------
    FileFormatError
    MissingExtraError
        Without PyYAML.
    """
    try:
        import yaml
    except ImportError:
        raise MissingExtraError("reading MoveIt's YAML", "pyyaml", "outside") from None
    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    try:
        return Node(name, "", yaml.load(text, loader))
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        line = f":{mark.line + 1}" if mark is not None else ""
        reason = getattr(error, "problem", None) or "cannot be parsed"
        raise FileFormatError(f"{name}{line}: not valid YAML: {reason}") from None
    except (RecursionError, ValueError) as error:
        raise FileFormatError(f"{name}: not valid YAML: {error}") from None
