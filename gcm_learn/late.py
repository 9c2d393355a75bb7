"""Names of a package that are imported at their first use."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable, Mapping, Sequence
from typing import Any


def late_names(package: str, places: Mapping[str, Sequence[str]]) -> Callable[[str], Any]:
    """Return the `__getattr__` of a package.

    Parameters
    ----------
    package : str
        Name of the package.
    places : mapping of str to sequence of str
        Names by the module that has them, relative to the package.

    Returns
    -------
    callable
        Imports a name's module at the first use, and keeps the name in the package.
    """
    place = {name: module for module, names in places.items() for name in names}
    door = vars(sys.modules[package])
    door["__dir__"] = lambda: sorted({*door, *place})

    def get(name: str) -> Any:
        if name not in place:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        value = getattr(importlib.import_module(f".{place[name]}", package), name)
        setattr(sys.modules[package], name, value)
        return value

    return get
