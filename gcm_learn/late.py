"""Names of a package that are imported at their first use."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable, Mapping, Sequence
from typing import Any


def late_names(
    package: str, places: Mapping[str, Sequence[str]]
) -> tuple[Callable[[str], Any], dict[str, str]]:
    """Return the `__getattr__` of a package, and the place of each late name.

    Parameters
    ----------
    package : str
        Name of the package.
    places : mapping of str to sequence of str
        Names by the module that has them, relative to the package.

    Returns
    -------
    getattr : callable
        Imports a name's module at the first use, and keeps the name in the package.
    place : dict of str to str
        Module of each name.
    """
    place = {name: module for module, names in places.items() for name in names}

    def get(name: str) -> Any:
        if name not in place:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        value = getattr(importlib.import_module(f".{place[name]}", package), name)
        setattr(sys.modules[package], name, value)
        return value

    return get, place
