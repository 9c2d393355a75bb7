"""A dataset's folder, on this machine or wherever fsspec reaches."""

from __future__ import annotations

import contextlib
import os
import posixpath
from pathlib import Path
from typing import BinaryIO, cast

import fsspec
from fsspec.implementations.local import LocalFileSystem
from fsspec.implementations.memory import MemoryFileSystem
from fsspec.registry import known_implementations

from gcm_learn import artifacts
from gcm_learn.errors import DatasetError
from gcm_learn.storage import is_unfinished, stream_hash, temporary_name, user_cache, write_whole

SHARDS = "shards"
MANIFEST = "manifest.json"


class Folder:
    """Files in a folder; they appear whole or not at all.

    Parameters
    ----------
    url : str
        A path, or what fsspec understands: ``s3://bucket/folder``, ``memory://folder``.

    Raises
    ------
    DatasetError
        If fsspec does not know such URLs, or needs another package for them.
    """

    def __init__(self, url: str | os.PathLike[str]) -> None:
        self.url = os.fspath(url)
        try:
            self._files, root = fsspec.core.url_to_fs(self.url)
        except (ImportError, ValueError) as error:
            raise DatasetError(f"{self.url}: {_hint(self.url) or error}") from None
        self._root = root.rstrip("/") or "/"

    @property
    def local(self) -> str | None:
        """Path of the folder if on this machine, else None."""
        return self._root if isinstance(self._files, LocalFileSystem) else None

    def caches(self) -> Path:
        """Return the folder of caches: in the dataset if writable, else in the user's cache.

        Caches of the shipped sample are in the user's cache, too.
        """
        folder = Path(self._root)
        if os.access(folder, os.W_OK) and not _is_sample(folder):
            return folder / "cache"
        return user_cache("maps")

    @property
    def shared(self) -> bool:
        """True if other processes see the same files; ``memory://`` belongs to one process."""
        return not isinstance(self._files, MemoryFileSystem)

    def where(self, name: str) -> str:
        """Return the place of a file for messages: beside the URL that was given."""
        return posixpath.join(self.url, name)

    def path(self, name: str) -> str:
        """Full path of a file within the file system."""
        return posixpath.join(self._root, name)

    def make(self) -> None:
        """Make the dataset's folder and, within it, the folder of the shards."""
        self._files.makedirs(self.path(SHARDS), exist_ok=True)

    def exists(self, name: str) -> bool:
        """Return whether a file exists."""
        return bool(self._files.exists(self.path(name)))

    def names(self, name: str = "") -> list[str]:
        """Return the sorted names of the entries of this folder, or of its subfolder `name`."""
        try:
            found = self._files.ls(self.path(name) if name else self._root, detail=False)
        except (FileNotFoundError, NotADirectoryError):
            return []
        return sorted(posixpath.basename(path.rstrip("/")) for path in found)

    def size(self, name: str) -> int:
        """Size of a file [bytes]."""
        return int(self._files.size(self.path(name)))

    def open(self, name: str) -> BinaryIO:
        """Open a file for reading."""
        if self.local is not None:
            return open(self.path(name), "rb")
        return cast(BinaryIO, self._files.open(self.path(name), "rb"))

    def read(self, name: str) -> bytes:
        """Content of a file."""
        with self.open(name) as stream:
            return stream.read()

    def write(self, name: str, content: bytes | memoryview) -> None:
        """Write a file under a temporary name, then rename it.

        Two processes that write the same file at once do no harm if they write the same.
        """
        target = self.path(name)
        if self.local is not None:
            write_whole(target, content, durable=True)
            return
        temporary = posixpath.join(posixpath.dirname(target), temporary_name())
        try:
            self._files.pipe_file(temporary, bytes(content))
            self._files.mv(temporary, target)
        finally:
            if self._files.exists(temporary):
                self._files.rm_file(temporary)

    def sweep(self, name: str = SHARDS) -> None:
        """Remove the unfinished files that killed writers have left behind."""
        for left in self.names(name):
            if is_unfinished(left):
                self.remove(f"{name}/{left}")

    def remove(self, name: str) -> None:
        """Remove a file if it exists."""
        with contextlib.suppress(FileNotFoundError):
            self._files.rm_file(self.path(name))

    def sha256(self, name: str) -> str:
        """Hash of a file's content."""
        with self.open(name) as stream:
            return stream_hash(stream)


def _hint(url: str) -> str | None:
    """Return the advice to install the package that fsspec needs for a URL, if it needs one."""
    known = known_implementations.get(url.partition("://")[0], {})
    package = known.get("class", "fsspec").partition(".")[0]
    return None if package == "fsspec" else f"needs {package}: pip install {package}"


def _is_sample(folder: Path) -> bool:
    """Return whether a folder is the sample that comes with the package."""
    return folder.resolve() == (artifacts.shipped("data") / "sample").resolve()
