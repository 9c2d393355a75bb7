"""Options that several commands have: numbers with their ranges, times with their units."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

from tyro.conf import arg
from tyro.constructors import PrimitiveConstructorSpec

UNITS = {"ms": 1e-3, "s": 1.0, "min": 60.0, "h": 3600.0}  # [s]


def given(metavar: str, default: str) -> Any:
    """Return an option's help texts: the name of its value, and its default in words."""
    return arg(metavar=metavar, help_behavior_hint=f"(default: {default})")


def seconds(text: str) -> float:
    """Return a time [s] from a text with a unit, such as ``20ms`` or ``0.02s``.

    Raises
    ------
    ValueError
    """
    told = re.fullmatch(r"(\d+\.?\d*|\.\d+)(ms|s|min|h)|0", text)
    if told is None:
        raise ValueError(f"{text!r} is no time with a unit, such as 20ms, 0.02s or 5min")
    return float(told[1]) * UNITS[told[2]] if told[1] else 0.0


def ranged(
    read: Callable[[str], Any], metavar: str, low: float, high: float = math.inf, *, above: bool
) -> PrimitiveConstructorSpec[Any]:
    """Return a kind of number for an option.

    Parameters
    ----------
    read : callable
        Takes the text; raises ValueError.
    metavar : str
        Name of the number in the help; its unit, where it has one.
    low, high : float
        Bounds. The upper one is allowed if it is finite.
    above : bool
        If true, the lower one is not allowed.
    """
    bounds = f"above {low:g}" if above else f"at least {low:g}"
    bounds += f" and at most {high:g}" if high < math.inf else ""

    def checked(words: list[str]) -> Any:
        value = read(words[0])
        if not (low < value if above else low <= value) or not value <= high or value == math.inf:
            raise ValueError(f"{words[0]}: must be {bounds}")
        return value

    return PrimitiveConstructorSpec(
        nargs=1, metavar=metavar, instance_from_str=checked,
        is_instance=lambda value: True, str_from_instance=lambda value: [str(value)],
    )  # fmt: skip


COUNT, WHOLE = (ranged(int, "N", low, above=False) for low in (1, 0))
TIME = ranged(seconds, "TIME", 0, above=True)
FROM_NOTHING = ranged(seconds, "TIME", 0, above=False)
RATE = ranged(float, "HZ", 125, 1000, above=False)

Count = Annotated[int, COUNT]
Number = Annotated[int, WHOLE]
"""Seed, or a count that may be zero."""
All = Annotated[int | None, COUNT, given("N", "all")]
Workers = Annotated[int, COUNT]
AllCores = Annotated[int | None, COUNT, given("N", "all cores")]
Cluster = Annotated[str | None, given("ADDRESS", "this machine")]
Output = Annotated[Path | None, given("FILE", "standard output")]
Folder = Annotated[Path, arg(metavar="DIR")]
