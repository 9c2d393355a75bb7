"""Functions that dispatch on the type of their first argument, so that one kernel suits all arms.

Numba picks the entry when it compiles, and calls it directly.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, ClassVar

from numba.extending import overload

from gcm_learn.compiled.kernels import INSIDE

if INSIDE:
    from numba.core import types
    from numba.core.typing.templates import AbstractTemplate, infer_global

_TABLES: dict[Callable[..., Any], dict[type | None, Callable[..., Any]]] = {}


def by_type(table: Mapping[type | None, Callable[..., Any]]) -> Any:
    """Return a function that calls the kernel for its first argument's NamedTuple type.

    Code is kept under the hash of the sources that a module imports.  So the table has to stand in
    a module that imports its entries.

    Parameters
    ----------
    table : dict of type to kernel
        Kernels that take the same arguments; the one of None is for all other types.
    """

    def chosen(first: Any, *rest: Any) -> Any:
        table = _TABLES[chosen]
        return (table.get(type(first)) or table[None])(first, *rest)

    _TABLES[chosen] = dict(table)
    if INSIDE:
        infer_global(chosen, types.Function(_template(chosen)))
    else:
        overload(chosen)(lambda first, *rest: _called(_entry(chosen, first)))
    return chosen


def register(function: Any, kind: type | None, kernel: Any) -> None:
    """Add an entry to a function of `by_type`.

    Parameters
    ----------
    function : callable
        Made by `by_type`.
    kind : type, optional
        NamedTuple of the first argument; None for all types without an entry.
    kernel : callable
        Compiled function.
    """
    _TABLES[function][kind] = kernel


def _entry(function: Callable[..., Any], first: Any) -> Any:
    """Return the entry for numba's type of a first argument, or None."""
    table: Mapping[type | None, Any] = _TABLES[function]
    return table.get(getattr(first, "instance_class", None), table.get(None))


def _called(kernel: Any) -> Any:
    """Return a function that calls `kernel`; None if there is no kernel."""
    return None if kernel is None else lambda first, *rest: kernel(first, *rest)


def _template(function: Callable[..., Any]) -> type[AbstractTemplate]:
    """Return a numba template that takes the type and code of a call from the matching entry.

    An `overload` would put a function around the entry.  Numba would optimise all code below once
    more for it.
    """

    class Template(AbstractTemplate):  # type: ignore[misc]
        key = function
        codes: ClassVar[dict[tuple[Any, ...], Any]] = {}  # by the types of arguments

        def generic(self, args: tuple[Any, ...], kws: dict[str, Any]) -> Any:
            kernel = _entry(function, args[0])
            if kernel is None:
                return None
            called = types.Dispatcher(kernel)
            signature: Any = called.get_call_type(self.context, args, kws)
            self.codes[signature.args] = called.get_impl_key(signature)
            return signature

        def get_impl_key(self, signature: Any) -> Any:
            return self.codes[signature.args]

    return Template
