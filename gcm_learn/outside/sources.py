"""Files of a folder, of an archive or single ones, as texts and as values."""

from __future__ import annotations

import bz2
import gzip
import lzma
import re
import tarfile
import zlib
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import Any

from gcm_learn.errors import FileFormatError, MissingExtraError
from gcm_learn.outside.nodes import Node
from gcm_learn.situation import JsonTextError, parse

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
