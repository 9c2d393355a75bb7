"""Files that are written whole or not at all, hashes of content, and the user's folders."""

from __future__ import annotations

import contextlib
import hashlib
import os
import secrets
import shutil
import stat
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

APP = "gcm_learn"
TEMPORARY = ".gcm-learn-"
"""Beginning of the names of unfinished files."""
UNFINISHED = ".tmp"
"""Their ending, unless a library requires the suffix of the file that they become."""


@contextlib.contextmanager
def whole_file(
    path: str | os.PathLike[str], *, suffix: str | None = None, durable: bool = False
) -> Iterator[Path]:
    """Yield a temporary file to write to; it becomes `path` when the block ends without an error.

    The temporary file is made at once, so that a folder that is missing or cannot be written to is
    noticed before the work begins. After any error, Ctrl-C included, it is gone and `path` is what
    it was before. A pipe or device has no name to swap: it is yielded itself.

    Parameters
    ----------
    path : path-like
        An existing file is replaced; its permissions are kept.
    suffix : str, optional
        Suffix of the temporary file; by default that of `path`.
    durable : bool
        Survive a power cut: what is written reaches the disk before it gets its name.

    Raises
    ------
    OSError
        If `path` cannot be written to; its file name is that of `path`.
    """
    real = Path(os.path.realpath(path))
    try:
        mode = _mode_of(real)
        special = mode is not None and not stat.S_ISREG(mode)
        place = Path(path) if special else _reserved(real, suffix, mode)
    except OSError as error:
        error.filename = os.fspath(path)
        raise
    if special:
        yield place
        return
    try:
        yield place
        if durable:
            to_disk(place)
        os.replace(place, real)
    except BaseException:
        with contextlib.suppress(OSError):
            place.unlink()
        raise


@contextlib.contextmanager
def whole_folder(path: Path) -> Iterator[Path]:
    """Yield a folder to fill; it becomes `path` when the block ends, unless `path` exists by then.

    The folders above `path` are made.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    place = path.with_name(temporary_name())
    try:
        place.mkdir()
        yield place
        try:
            place.rename(path)
        except OSError:
            if not path.exists():  # else another process was faster
                raise
    finally:
        shutil.rmtree(place, ignore_errors=True)


def write_whole(
    path: str | os.PathLike[str], content: str | bytes | memoryview, *, durable: bool = False
) -> None:
    """Write a file whole or not at all, see `whole_file`; text is written as it is, in UTF-8."""
    raw = content.encode() if isinstance(content, str) else content
    with whole_file(path, suffix=UNFINISHED, durable=durable) as place:
        place.write_bytes(raw)


def temporary_name(suffix: str = UNFINISHED) -> str:
    """A name for an unfinished file, unlike any other."""
    return f"{TEMPORARY}{secrets.token_hex(6)}{suffix}"


def is_unfinished(name: str) -> bool:
    """Return whether a name is that of an unfinished file."""
    return name.startswith(".") and (name.startswith(TEMPORARY) or name.endswith(UNFINISHED))


def to_disk(path: Path) -> None:
    """Wait until a file's content is on the disk."""
    with open(path, "r+b") as stream:
        os.fsync(stream.fileno())


def _mode_of(path: Path) -> int | None:
    """Mode of a file that may be overwritten; None if the file is missing."""
    try:
        mode = path.stat().st_mode
    except FileNotFoundError:
        return None
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(None, "is a directory")
    if not os.access(path, os.W_OK):
        raise PermissionError(None, "Permission denied")
    return mode


def _reserved(path: Path, suffix: str | None, mode: int | None) -> Path:
    """Make an empty temporary file beside `path`, with the permissions `mode` if given."""
    place = path.with_name(temporary_name(path.suffix if suffix is None else suffix))
    os.close(os.open(place, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666))
    if mode is not None:
        place.chmod(stat.S_IMODE(mode))
    return place


def content_hash(*parts: str | bytes | memoryview) -> str:
    """SHA-256 of the parts joined in order, as 64 hexadecimal digits."""
    digest = hashlib.sha256()
    for part in parts:
        digest.update(part.encode() if isinstance(part, str) else part)
    return digest.hexdigest()


def stream_hash(stream: BinaryIO) -> str:
    """SHA-256 of the rest of a stream, as 64 hexadecimal digits."""
    return hashlib.file_digest(stream, "sha256").hexdigest()  # type: ignore[arg-type]


def content_number(content: bytes, size: int = 8) -> int:
    """A number of `size` bytes that follows from content alone."""
    return int.from_bytes(hashlib.sha256(content).digest()[:size], "little")


def user_cache(name: str) -> Path:
    """Folder for files that can be made again, on Linux ``~/.cache/gcm_learn/NAME``; not made."""
    from platformdirs import user_cache_path

    return user_cache_path(APP, appauthor=False) / name


def user_data(name: str) -> Path:
    """Folder for files the user keeps, on Linux ``~/.local/share/gcm_learn/NAME``; not made."""
    from platformdirs import user_data_path

    return user_data_path(APP, appauthor=False) / name
