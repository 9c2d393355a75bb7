"""The package's `njit`: numba's, with code cached by content and compiled in parts."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

import numba

TESTED = (0, 61), (0, 68)
"""First and last version of numba whose inside is used; others compile as they do by themselves."""
INSIDE = TESTED[0] <= numba.version_info.short <= TESTED[1] and not os.environ.get(
    "GCM_LEARN_PLAIN"
)
if INSIDE:
    from numba.core.compiler_lock import global_compiler_lock

    from gcm_learn.compiled.parts import kernel, replace_numbas

    replace_numbas()
else:
    from gcm_learn.compiled.plain import kernel


def njit(function: Callable[..., Any] | None = None, **options: Any) -> Any:
    """Compile a function at its first call, as ``numba.njit(cache=True)`` does.

    Parameters
    ----------
    function : callable
    **options
        Numba's own.
    """
    if function is None:
        return lambda later: njit(later, **options)
    return function if numba.config.DISABLE_JIT else kernel(function, options)


def is_compiling() -> bool:
    """Return whether something is compiled now, as far as that is known."""
    return bool(INSIDE and global_compiler_lock.is_locked())
