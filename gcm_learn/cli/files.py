"""Output files that appear whole or not at all."""

from __future__ import annotations

import contextlib
import os
import re
import secrets
import stat
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TextIO

from gcm_learn.cli.failures import CommandFailure, why

LONGEST_NAME = 80


@contextlib.contextmanager
def staged(target: Path, *, option: str = "--out") -> Iterator[Path]:
    """Give a place to write to; it becomes `target` when the block ends without an error.

    The place is made at once, so that a folder that is missing or cannot be written to is
    noticed before the work begins. After any error, Ctrl-C included, it is gone and `target`
    is what it was before. A pipe or device has no name to swap: it is written to directly.

    Raises
    ------
    CommandFailure
        When `target` cannot be written to.
    """
    try:
        real, mode = Path(os.path.realpath(target)), _mode_of(target)
        if mode is not None and not stat.S_ISREG(mode):
            place = target
        else:
            place = _reserve(real.parent, target.suffix, mode)
    except OSError as error:
        raise CommandFailure(f"{option} {target}: {why(error)}") from None
    if place == target:
        yield place
        return
    try:
        yield place
        os.replace(place, real)
    except BaseException:
        with contextlib.suppress(OSError):
            place.unlink()
        raise


@contextlib.contextmanager
def output(out: Path | None) -> Iterator[TextIO]:
    """Give a stream to `out`, which appears whole or not at all, or to standard output (``-``)."""
    if out is None or str(out) == "-":
        if sys.stdout is None:
            raise CommandFailure("standard output is closed")
        yield sys.stdout
        return
    with staged(out) as place, open(place, "w", encoding="utf-8") as stream:
        yield stream


def _mode_of(target: Path) -> int | None:
    """Return the mode of an existing file that may be overwritten; None when there is none."""
    try:
        mode = target.stat().st_mode
    except FileNotFoundError:
        return None
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(None, "is a directory")
    if not os.access(target, os.W_OK):
        raise PermissionError(None, "Permission denied")
    return mode


def _reserve(folder: Path, suffix: str, mode: int | None) -> Path:
    """Create an empty file of an unused name in `folder`, with the mode of what it replaces."""
    place = folder / f".gcm-learn-{secrets.token_hex(6)}{suffix}"
    handle = os.open(place, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666)
    try:
        if mode is not None:
            os.fchmod(handle, stat.S_IMODE(mode))
    finally:
        os.close(handle)
    return place


def made_folder(path: Path, *, option: str) -> Path:
    """Return the folder `path`, made when it is missing, after checking that it takes files."""
    try:
        path.mkdir(parents=True, exist_ok=True)
        _reserve(path, "", None).unlink()
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
