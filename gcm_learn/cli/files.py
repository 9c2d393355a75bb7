"""Output files that appear whole or not at all."""

from __future__ import annotations

import contextlib
import os
import re
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, TextIO

from gcm_learn.cli.failures import CommandFailure, why
from gcm_learn.storage import whole_file

LONGEST_NAME = 80
FORMATS = (".png", ".pdf", ".svg")
"""Endings of pictures."""


@contextlib.contextmanager
def staged(target: Path, *, option: str = "--out") -> Iterator[Path]:
    """Yield a temporary file, which becomes `target` when the block ends without an error.

    See `storage.whole_file`, whose error becomes one that names the option.

    Raises
    ------
    CommandFailure
        When `target` cannot be written to.
    """
    with contextlib.ExitStack() as stack:
        try:
            place = stack.enter_context(whole_file(target))
        except OSError as error:
            raise CommandFailure(f"{option} {target}: {why(error)}") from None
        yield place


@contextlib.contextmanager
def output(out: Path | None) -> Iterator[TextIO]:
    """Give a stream to `out`, which appears whole or not at all, or to standard output (``-``)."""
    if out is None or str(out) == "-":
        if sys.stdout is None:
            raise CommandFailure("standard output is closed")
        yield sys.stdout
        return
    with staged(out) as place:
        try:
            with open(place, "w", encoding="utf-8") as stream:
                yield stream
        except OSError as error:
            if error.filename is not None or isinstance(error, BrokenPipeError):
                raise  # of another file, or of a reader that went away
            raise CommandFailure(f"--out {out}: {why(error)}") from None


def refuse_missing(*places: str | Path) -> None:
    """Refuse a path that is not there, before libraries are loaded; ``-`` and addresses pass.

    Raises
    ------
    CommandFailure
    """
    for place in map(str, places):
        if place != "-" and "://" not in place and not os.path.exists(place):
            raise CommandFailure(f"{place}: cannot be read (No such file or directory)")


def refuse_same(places: Mapping[str, Path | None]) -> None:
    """Refuse two arguments that name the same file; the error is about the later argument.

    Parameters
    ----------
    places : mapping of str to Path or None
        By the argument. Standard output, devices and what is not given never are the same.

    Raises
    ------
    CommandFailure
    """
    seen: dict[Path, str] = {}
    for option, place in places.items():
        if place is None or str(place) == "-" or (place.exists() and not place.is_file()):
            continue
        before = seen.setdefault(place.resolve(), option)
        if before != option:
            raise CommandFailure(f"{option} {place}: is the file of {before}, too")


def made_folder(path: Path, *, option: str) -> Path:
    """Make the folder `path` if it is missing, check that it takes files, and return it."""
    try:
        path.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=path):
            pass
    except OSError as error:
        raise CommandFailure(f"{option} {path}: {why(error)}") from None
    return path


class FileNames:
    """Turns names of situations into file names that are safe and differ from each other.

    Two names count as equal when they only differ in case: some file systems hold them so.
    """

    def __init__(self) -> None:
        self._taken: set[str] = set()

    def unused(self, name: str) -> str:
        """Return a file name for `name`, without suffix, that was not returned before."""
        plain = re.sub(r"[^A-Za-z0-9._-]+", "_", name).strip("._-")[:LONGEST_NAME] or "situation"
        candidate, count = plain, 1
        while candidate.lower() in self._taken:
            count += 1
            candidate = f"{plain}-{count}"
        self._taken.add(candidate.lower())
        return candidate


def drawn_into(
    folder: Path, ending: str, draw: Callable[[Any, Any, Path], None], *, option: str
) -> Callable[[Any, Any], None]:
    """Return a function that draws a situation into a file named after the situation.

    Parameters
    ----------
    folder : Path
        Made when it is missing.
    ending : str
        Of the files, without a dot.
    draw : callable
        Takes a situation, what came of it, and the file.
    option : str
        Names the folder in messages.
    """
    made_folder(folder, option=option)
    names = FileNames()

    def drawn(situation: Any, done: Any) -> None:
        with staged(folder / f"{names.unused(situation.name)}.{ending}", option=option) as place:
            draw(situation, done, place)

    return drawn


def require_suffix(target: Path, known: Sequence[str], option: str = "--out") -> None:
    """Refuse a file name that does not end in one of the `known` formats."""
    if target.suffix.lower() not in known:
        raise CommandFailure(f"{option} {target}: the name must end in {' or '.join(known)}")
