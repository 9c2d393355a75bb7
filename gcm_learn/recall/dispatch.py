"""Functions that kernels call by the type of their first argument: one loop for all arms."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from numba.extending import overload


def by_type(table: Mapping[type, Callable[..., Any]]) -> Callable[..., Any]:
    """Return a function that calls the entry for the NamedTuple type of its first argument.

    Kernels are specialised when they are compiled, so a call costs as much as one of the entry.
    Compiled code is kept by the sources that a module imports, so the table has to stand in a
    module that imports its entries.

    Parameters
    ----------
    table : dict of type to kernel
        Kernels that take the same arguments.
    """

    def chosen(first: Any, *rest: Any) -> Any:
        return table[type(first)](first, *rest)

    for kind, kernel in table.items():
        _specialise(chosen, kind, kernel)
    return chosen


def _specialise(chosen: Callable[..., Any], kind: type, kernel: Any) -> None:
    """Let compiled code call a kernel where the first argument is of a type, with its options."""
    counts = getattr(kernel, "targetoptions", {}).get("_nrt", True)

    def entry(first: Any, *rest: Any) -> Any:
        return kernel.py_func if getattr(first, "instance_class", None) is kind else None

    overload(chosen, jit_options={"_nrt": counts}, strict=False)(entry)
