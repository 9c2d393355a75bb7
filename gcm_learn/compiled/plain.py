"""Functions compiled by numba unchanged, for versions whose private parts are not known.

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
    """Return `function` as a kernel that is compiled at its first call."""
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
    """Numba's cache of a function, with errors ignored."""

    def __init__(self, kept: Any) -> None:
        self._kept = kept

    def __getattr__(self, name: str) -> Any:
        return getattr(self._kept, name)

    def load_overload(self, *asked: Any) -> Any:
        """Return the kept code of a signature; None if the code has to be compiled."""
        code = None
        with contextlib.suppress(Exception):
            code = self._kept.load_overload(*asked)
        if code is None:
            tell_listeners()
        return code

    def save_overload(self, *made: Any) -> None:
        """Keep the code of a signature on disk, if that can be done."""
        with contextlib.suppress(Exception):
            self._kept.save_overload(*made)
