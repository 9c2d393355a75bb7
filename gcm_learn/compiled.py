"""Where compiled kernels are kept: one folder for each state of their sources.

Numba renews a cached function when its own file changes, but not when a function that it calls does
(the callee is compiled into the caller).  After an update such a cache would silently run old code.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from pathlib import Path

from numba import config

FOLDERS = ("situation", "arm", "wave", "maps", "planners")  # whose functions make maps and plans
CONSTANTS = "params.py"  # what holds numbers for compiled functions and none of these itself
ABOVE = ("encoder", "memory", "envs")  # whose compiled functions call them


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
