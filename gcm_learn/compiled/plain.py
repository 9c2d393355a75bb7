"""Compiled functions by numba as it is, where its inside is not known.

Numba keeps code by a function's own file, not by those that it calls.  So each function has a
folder by the hash of all of them.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from typing import Any

import numba

from gcm_learn.compiled.notice import folder, tell_listeners
from gcm_learn.compiled.sources import PACKAGE, folder_of, is_edited


def kernel(function: Callable[..., Any], options: dict[str, Any]) -> Any:
    """Return a function that is compiled when it is first called."""
    made = numba.njit(**options)(function)
    module = function.__module__
    if module.startswith(f"{PACKAGE.name}.") and not is_edited(module):
        place = folder() / folder_of(module)
        kept, numba.config.CACHE_DIR = numba.config.CACHE_DIR, str(place)
        with contextlib.suppress(Exception):  # where nothing can be kept
            place.mkdir(parents=True, exist_ok=True)
            made.enable_caching()
            made._cache = _Careful(made._cache)
        numba.config.CACHE_DIR = kept
    return made


class _Careful:
    """Numba's cache of a function, and no reason to fail."""

    def __init__(self, kept: Any) -> None:
        self._kept = kept

    def __getattr__(self, name: str) -> Any:
        return getattr(self._kept, name)

    def load_overload(self, *asked: Any) -> Any:
        """Return the code of a signature; None where it has to be compiled."""
        code = None
        with contextlib.suppress(Exception):
            code = self._kept.load_overload(*asked)
        if code is None:
            tell_listeners()
        return code

    def save_overload(self, *made: Any) -> None:
        """Keep the code of a signature; where that cannot be done it is not kept."""
        with contextlib.suppress(Exception):
            self._kept.save_overload(*made)
