"""Named tuples and classes that numba returns to Python, made without running Python code.

Numba makes them by Python functions. The handler of a signal, such as that of Ctrl-C, may raise
within one, and numba overlooks that: the process ends by a segmentation fault. Functions in C run
no handlers.
"""

from __future__ import annotations

from functools import cache, partial
from typing import Any

from numba.core import pythonapi, serialize
from numba.core.boxing import box_tuple
from numba.core.types.containers import NamedTuple, NamedUniTuple


def replace_numbas() -> None:
    """Let numba use what is here, in this process."""
    for kind in (NamedTuple, NamedUniTuple):
        pythonapi._boxers.functions[kind] = _box_named_tuple
    if not hasattr(serialize._numba_unpickle, "cache_info"):
        serialize._numba_unpickle = cache(serialize._numba_unpickle)


def _box_named_tuple(typ: Any, val: Any, c: Any) -> Any:
    """Return a pointer to the named tuple of a native value."""
    make = partial(tuple.__new__, typ.instance_class)
    maker = c.pyapi.unserialize(c.pyapi.serialize_object(make))
    items = box_tuple(typ, val, c)
    made = c.pyapi.call_function_objargs(maker, (items,))
    c.pyapi.decref(maker)
    c.pyapi.decref(items)
    return made
