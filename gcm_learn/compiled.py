"""Where compiled kernels are kept: one folder for each state of their sources.

Numba renews a cached function when its own file changes, but not when a function that it calls does
(the callee is compiled into the caller).  After an update such a cache would silently run old code.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from numba import config
from numba.core.caching import IndexDataCacheFile

FOLDERS = ("situation", "arm", "wave", "maps", "planners")  # whose functions make maps and plans
CONSTANTS = "params.py"  # what holds numbers for compiled functions and none of these itself
ABOVE = ("encoder", "memory", "envs")  # whose compiled functions call them
LOCK = "saving.lock"  # in a folder of numba's cache


def sources_hash(folders: Sequence[str] = FOLDERS) -> str:
    """Hash of the sources in some folders; by default those that maps and plans depend on."""
    digest = hashlib.sha256()
    for folder in folders:
        for path in sorted((Path(__file__).parent / folder).glob("*.py")):
            digest.update(path.name.encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def compiled_hash() -> str:
    """Hash of the sources that hold compiled functions, or constants that they take from elsewhere.

    Tests hold the constants that they import to that.
    """
    digest = hashlib.sha256()
    for folder in FOLDERS + ABOVE:
        for path in sorted((Path(__file__).parent / folder).glob("*.py")):
            source = path.read_bytes()
            if b"njit" in source or path.name == CONSTANTS:
                digest.update(path.name.encode())
                digest.update(source)
    return digest.hexdigest()[:16]


def keep_apart() -> None:
    """Point numba's cache at the folder of the present sources, unless the user has chosen one."""
    if not config.CACHE_DIR:
        config.CACHE_DIR = str(Path(__file__).parent / "__pycache__" / f"kernels-{compiled_hash()}")


def save_in_turn() -> None:
    """Let processes that compile at once write to numba's cache one after the other.

    A function's index is read, added to and written back. Of two processes that do so at once one
    entry is lost, or both number their code alike and one is kept under the other's name. Only
    where the system has such locks.
    """
    if os.name != "posix":
        return
    import fcntl

    plain = IndexDataCacheFile.save
    if getattr(plain, "in_turn", False):
        return

    def save(self: Any, key: Any, data: Any) -> None:
        with contextlib.ExitStack() as stack:
            with contextlib.suppress(OSError):  # saving itself says what is wrong with the folder
                lock = stack.enter_context(open(Path(self._cache_path) / LOCK, "w"))
                fcntl.flock(lock, fcntl.LOCK_EX)
            plain(self, key, data)

    save.in_turn = True  # type: ignore[attr-defined]
    IndexDataCacheFile.save = save  # type: ignore[method-assign]
