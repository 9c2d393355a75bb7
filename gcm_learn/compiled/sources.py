"""Hashes of the sources that compiled code depends on."""

from __future__ import annotations

import re
import time
from collections.abc import Sequence
from functools import cache
from pathlib import Path

from gcm_learn import storage

PACKAGE = Path(__file__).parents[1]
STARTED = time.time()
UNCALLED = tuple(
    f"gcm_learn.{name}"
    for name in (
        "arms.robots", "compiled.cache", "compiled.notice", "compiled.plain", "compiled.sources",
        "compiled.wheel", "errors", "late", "motion.as_obstacles", "storage",
    )
)  # fmt: skip
"""Modules in which no kernel calls anything."""
_IMPORT = re.compile(
    r"^ *(?:from (gcm_learn[\w.]*) import (\([^)]*\)|[^\n(]*)|import (gcm_learn[\w.]*))", re.M
)


@cache
def source_hash(module: str) -> str:
    """Hash of a module's source and of all package modules that it imports, directly or not."""
    parts: list[str | bytes] = []
    for path in sorted(_sources_of(module)):
        parts += [path.relative_to(PACKAGE).as_posix(), path.read_bytes()]
    return storage.content_hash(*parts)[:16]


def folder_of(module: str) -> str:
    """Return the name of the folder with the code of a module."""
    return f"{module.removeprefix(f'{PACKAGE.name}.')}-{source_hash(module)}"


@cache
def is_edited(module: str) -> bool:
    """Return whether sources of a module's code have changed while this process ran.

    It may have read them before the change. Then the hash is not that of what it compiles, and code
    kept under it would break other processes: so such code is neither kept nor looked for.
    """
    written = [path.stat().st_mtime for path in _sources_of(module)]
    return any(STARTED < when <= time.time() for when in written)


def sources_hash(folders: Sequence[str]) -> str:
    """Hash of the sources in some folders of the package."""
    parts: list[str | bytes] = []
    for name in folders:
        for path in sorted((PACKAGE / name).rglob("*.py")):
            parts += [path.name, path.read_bytes()]
    return storage.content_hash(*parts)[:16]


@cache
def _sources_of(module: str) -> set[Path]:
    """Return the files of a module and of all package modules that it imports, directly or not."""
    found: set[Path] = set()
    waiting = [module]
    while waiting:
        path = _path_of(waiting.pop())
        if path is not None and path not in found:
            found.add(path)
            waiting += _imports_of(path)
    return found


@cache
def _path_of(module: str) -> Path | None:
    """File of a module of the package, None if the name is something else."""
    place = PACKAGE.joinpath(*module.split(".")[1:])
    if place == PACKAGE or module.startswith(UNCALLED):
        return None  # the package's front door imports everything
    for path in (place.with_suffix(".py"), place / "__init__.py"):
        if path.is_file():
            return path
    return None


@cache
def _imports_of(path: Path) -> list[str]:
    """Return modules of the package that a file imports, among other names."""
    found = []
    for parent, names, whole in _IMPORT.findall(path.read_text(encoding="utf-8")):
        found.append(whole or parent)
        found += [f"{parent}.{name}" for name in re.findall(r"\w+", names)]
    return found
