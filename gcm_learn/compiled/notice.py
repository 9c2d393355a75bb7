"""Folder of compiled code, and a notice when compiling takes long."""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

from numba import config

from gcm_learn import storage

PATIENCE = 1.0  # of compiling, after which it is announced [s]
NOTICE = (
    "gcm-learn: compiling for this kind of arm and planner, one or two minutes, once; "
    "another kind or planner compiles again"
)
UNKEPT = (
    "gcm-learn: compiled code cannot be kept in {folder} ({reason}): every run compiles again; "
    "NUMBA_CACHE_DIR names another folder"
)


def folder() -> Path:
    """Return the folder of compiled code: ``NUMBA_CACHE_DIR`` if set, else the user's cache."""
    return Path(config.CACHE_DIR) if config.CACHE_DIR else storage.user_cache("kernels")


def say_compiling() -> None:
    """Announce on standard error that code is compiled; a terminal's line of progress is wiped."""
    if sys.stderr is not None:
        wipe = "\r\x1b[K" if sys.stderr.isatty() else ""
        lines = "\n".join([NOTICE, *_unkept()])
        print(f"{wipe}{lines}", file=sys.stderr, flush=True)


def _unkept() -> Iterator[str]:
    """Yield the sentence on a folder in which nothing can be written."""
    place = folder()
    try:
        place.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=place, buffering=0) as stream:
            stream.write(bytes(4096))
    except OSError as error:
        yield UNKEPT.format(folder=place, reason=error.strerror or error)


on_compile: list[Callable[[], object]] = [say_compiling]
"""Listeners, each called once and removed when compiling takes longer than `PATIENCE`."""
_missed: list[float] = []  # when the first code was not found [s]


def tell_listeners() -> None:
    """Call and remove the listeners once compiling has taken longer than `PATIENCE`."""
    now = time.monotonic()
    _missed[:] = _missed or [now]
    while on_compile and now - _missed[0] >= PATIENCE:
        on_compile.pop()()


def on_first_compiling(call: Callable[[], object]) -> None:
    """Replace all listeners by `call`; without listeners nothing changes."""
    on_compile[:] = [call] if on_compile else []
