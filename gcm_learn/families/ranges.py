"""Ranges to draw from: dataclass fields with their checks, and functions that draw from them."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

from gcm_learn.checks import number as checked_number, show
from gcm_learn.errors import FamilyError, SituationError

Range = tuple[float, float]
Counts = tuple[int, int]
LARGEST = 1000  # bound of numbers that have no tighter one: what is squared stays finite
_Item = TypeVar("_Item")
_Check = Callable[[object, str], object]


def span(low: float, high: float, least: float = 0.0, most: float = LARGEST) -> Any:
    """A field for a range (low, high) of numbers, both between `least` and `most`."""
    return dataclasses.field(
        default=(low, high), metadata={"check": lambda v, f: _pair(v, f, least, most)}
    )


def counts(low: int, high: int, least: int = 0) -> Any:
    """A field for a range (low, high) of whole numbers, both included."""
    return dataclasses.field(
        default=(low, high), metadata={"check": lambda v, f: _count_pair(v, f, least)}
    )


def number(default: float, least: float = 0.0, most: float = 1.0) -> Any:
    """A field for one number, by default a share."""
    return dataclasses.field(
        default=default, metadata={"check": lambda v, f: _number(v, f, least, most)}
    )


def options(*default: float) -> Any:
    """A field for a list of non-negative numbers, from which one is drawn."""
    return dataclasses.field(default=default, metadata={"check": _options})


def positives(*default: float) -> Any:
    """A field for a list of numbers above zero, which may be empty."""
    return dataclasses.field(default=default, metadata={"check": _positives})


@dataclass(frozen=True)
class Ranges:
    """Base of all records of ranges: every field is checked when a record is made."""

    def __post_init__(self) -> None:
        """Check every field and store it in its plain form."""
        for field in dataclasses.fields(self):
            check: _Check | None = field.metadata.get("check")
            value = getattr(self, field.name)
            if check is not None:
                object.__setattr__(self, field.name, check(value, field.name))
            elif not isinstance(value, kind := type(_default(field))):
                reason = f"must be {kind.__name__} (got {show(value)})"
                raise FamilyError(field.name, reason)


def _default(field: dataclasses.Field[Any]) -> object:
    """Return the default of a nested record."""
    made_by = field.default_factory
    return field.default if made_by is dataclasses.MISSING else made_by()


def pick(rng: np.random.Generator, ends: Range) -> float:
    """Draw uniformly from a range; a range without width takes nothing from the generator."""
    low, high = ends
    return low if low == high else low + (high - low) * rng.random()


def pick_count(rng: np.random.Generator, ends: Counts) -> int:
    """Draw a whole number from a range, both ends included."""
    return int(rng.integers(ends[0], ends[1] + 1))


def pick_sign(rng: np.random.Generator) -> float:
    """Draw 1 or -1."""
    return 1.0 if rng.random() < 0.5 else -1.0


def pick_angle(rng: np.random.Generator) -> float:
    """Draw a direction [rad]."""
    return math.pi * (2.0 * rng.random() - 1.0)


def choose(rng: np.random.Generator, items: Sequence[_Item]) -> _Item:
    """Draw one of the items."""
    return items[int(rng.integers(len(items)))]


def _number(value: object, field: str, least: float, most: float) -> float:
    try:
        result = checked_number(value, field)
    except SituationError as error:
        raise FamilyError(error.field, error.reason) from None
    if not least <= result <= most:
        bound = f"at least {least:g}" if result < least else f"at most {most:g}"
        raise FamilyError(field, f"must be {bound} (got {result!r})")
    return result


def _two(value: object, field: str) -> Sequence[object]:
    if not isinstance(value, tuple | list) or len(value) != 2:
        raise FamilyError(field, f"must be a range [low, high] (got {show(value)})")
    return value


def _ordered(low: _Item, high: _Item, field: str) -> tuple[_Item, _Item]:
    if low > high:  # type: ignore[operator]
        raise FamilyError(field, f"low {low!r} is above high {high!r}")
    return low, high


def _pair(value: object, field: str, least: float, most: float) -> Range:
    low, high = (_number(v, field, least, most) for v in _two(value, field))
    return _ordered(low, high, field)


def _count_pair(value: object, field: str, least: int) -> Counts:
    ends = _two(value, field)
    for end in ends:
        if isinstance(end, bool) or not isinstance(end, int):
            raise FamilyError(field, f"must be whole numbers (got {show(end)})")
        if not least <= end <= LARGEST:
            bound = f"at least {least}" if end < least else f"at most {LARGEST}"
            raise FamilyError(field, f"must be {bound} (got {show(end)})")
    return _ordered(int(ends[0]), int(ends[1]), field)  # type: ignore[call-overload]


def _options(value: object, field: str) -> tuple[float, ...]:
    if not isinstance(value, tuple | list) or not value:
        raise FamilyError(field, f"must be a list of numbers (got {show(value)})")
    return tuple(_number(v, field, 0.0, LARGEST) for v in value)


def _positives(value: object, field: str) -> tuple[float, ...]:
    if not isinstance(value, tuple | list):
        raise FamilyError(field, f"must be a list of numbers (got {show(value)})")
    return tuple(_number(v, f"{field}[{k}]", 1e-9, 1e9) for k, v in enumerate(value))
