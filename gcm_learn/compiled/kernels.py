"""Compiled functions: numba's `njit`, whose code is kept by content, and in parts."""

from __future__ import annotations

import contextlib
import gc
from collections.abc import Callable, Iterator
from functools import cached_property
from typing import Any

from numba.core import config
from numba.core.registry import CPUDispatcher
from numba.core.types.misc import unliteral

from gcm_learn.compiled.boxing import replace_numbas
from gcm_learn.compiled.cache import Cache, PartCache, is_kept
from gcm_learn.compiled.parts import PartCompiler, WholeCompiler

replace_numbas()


def njit(function: Callable[..., Any] | None = None, **options: Any) -> Any:
    """Compile a function when it is first called, as ``numba.njit(cache=True)`` does.

    Parameters
    ----------
    function : callable
    **options
        Numba's own.
    """
    if function is None:
        return lambda later: njit(later, **options)
    options.setdefault("no_cfunc_wrapper", True)  # for callers in C, and a seventh of compiling
    if config.DISABLE_JIT:
        return function
    options = {"nopython": True, "boundscheck": None} | options
    made = _Kernel(function, targetoptions=options, pipeline_class=WholeCompiler)
    if is_kept(function):
        made._cache = Cache(function)
    return made


class _Kernel(CPUDispatcher):  # type: ignore[misc]
    """Compiled function with two codes: one for Python, and a part for functions that call it.

    Each is compiled at its first call.  A function must not call itself.
    """

    @cached_property
    def _part(self) -> CPUDispatcher:
        """The part, without a wrapper for Python."""
        options = self.targetoptions | {"no_cpython_wrapper": True}
        made = CPUDispatcher(self.py_func, targetoptions=options, pipeline_class=PartCompiler)
        if is_kept(self.py_func):
            made._cache = PartCache(self.py_func)
        return made

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Return the types of a call by another function; compile the part for it.

        Numba has a type for every number in a source, for which it would compile a part once more.
        """
        plain = tuple(unliteral(given) for given in args)
        return self._part.get_call_template(plain, kws)

    def get_overload(self, sig: Any) -> Any:
        """Return the key of the part."""
        return self._part.get_overload(sig)

    def compile(self, sig: Any) -> Any:
        """Compile the function for Python, and load the environments of its parts."""
        with _without_collection():
            entry = super().compile(sig)
        made = self.overloads[tuple(getattr(sig, "args", sig))]
        for environment in made._find_referenced_environments():
            made.codegen.set_env(environment.env_name, environment)
        return entry


@contextlib.contextmanager
def _without_collection() -> Iterator[None]:
    """Pause the collection of garbage, which takes a tenth of compiling and finds little."""
    if not gc.isenabled():
        yield
        return
    gc.disable()
    try:
        yield
    finally:
        gc.enable()
