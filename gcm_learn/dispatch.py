"""Functions that kernels call by the type of their first argument: one kernel for all arms.

Numba picks the entry when it compiles, so a call costs as much as one of the entry.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from numba.extending import overload

_TABLES: dict[Callable[..., Any], dict[type | None, Callable[..., Any]]] = {}

_CALLS: tuple[Callable[..., Any], ...] = (
    lambda f: lambda a: f(a),
    lambda f: lambda a, b: f(a, b),
    lambda f: lambda a, b, c: f(a, b, c),
    lambda f: lambda a, b, c, d: f(a, b, c, d),
    lambda f: lambda a, b, c, d, e: f(a, b, c, d, e),
    lambda f: lambda a, b, c, d, e, g: f(a, b, c, d, e, g),
    lambda f: lambda a, b, c, d, e, g, h: f(a, b, c, d, e, g, h),
    lambda f: lambda a, b, c, d, e, g, h, i: f(a, b, c, d, e, g, h, i),
    lambda f: lambda a, b, c, d, e, g, h, i, j: f(a, b, c, d, e, g, h, i, j),
)
"""Calls of a compiled function by the number of arguments less one.

A thin call shares the function's code, which is kept on disk; its body would be compiled anew.
"""


def by_type(table: Mapping[type | None, Callable[..., Any]]) -> Any:
    """Return a function that calls the entry for the NamedTuple type of its first argument.

    Code is kept under the hash of the sources that a module imports.  So the table has to stand in
    a module that imports its entries.

    Parameters
    ----------
    table : dict of type to kernel
        Kernels that take the same arguments; the one of None is for all other types.
    """

    def chosen(first: Any, *rest: Any) -> Any:
        entries = _TABLES[chosen]
        return entries.get(type(first), entries.get(None))(first, *rest)  # type: ignore[misc]

    _TABLES[chosen] = {}
    for kind, kernel in table.items():
        register(chosen, kind, kernel)
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
    table = _TABLES[function]
    table[kind] = kernel

    def entry(first: Any, *rest: Any) -> Any:
        made = getattr(first, "instance_class", None)
        mine = kind is (made if made in table else None)
        return _CALLS[len(rest)](kernel) if mine else None

    counts = getattr(kernel, "targetoptions", {}).get("_nrt", True)
    overload(function, jit_options={"_nrt": counts, "no_cfunc_wrapper": True}, strict=False)(entry)
