"""Checks of single values, shared by records of arms, bodies and situations.

Each check returns the value in its stored form (Python floats, tuples) or raises a
`SituationError` that names the field and says what was given.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from numbers import Real

import numpy as np

from gcm_learn.errors import SituationError

LARGEST = 1e50
"""Largest magnitude of any number: positions at any time can still be squared without overflow."""

UNIT_TOLERANCE = 1e-6
"""Largest error of lengths and right angles of given axes."""

UNIT_LENGTH = 1e-5
"""Largest error of lengths of axes and quaternions that are normalised."""

AT_LIMIT = 1e-5
"""Share of the larger of 1 and a bound by which a value beyond it is the bound."""

ROUNDING = 1e-15
"""Largest error of the length of a normalised vector."""


def put(record: object, name: str, value: object) -> None:
    """Store a checked `value` in a frozen record that is still being made."""
    object.__setattr__(record, name, value)


def quote(text: str, limit: int = 40) -> str:
    """Return `text` in quotes, on one line, in ASCII and cut after `limit` characters."""
    return json.dumps(text if len(text) <= limit else text[:limit] + "...")


def show(value: object) -> str:
    """Describe a value of any type and size in a few words on one line."""
    if value is None or isinstance(value, bool):
        return json.dumps(value)
    if isinstance(value, str):
        return quote(value)
    if isinstance(value, int):
        # repr() refuses integers of more than 4300 digits
        bits = value.bit_length()
        return repr(value) if bits < 128 else f"an integer of {bits} bits"
    if isinstance(value, float):
        return repr(float(value))
    if isinstance(value, (list, tuple)):
        return f"a list of {len(value)}"
    return "an object" if isinstance(value, dict) else f"a value of type {type(value).__name__}"


def number(value: object, field: str) -> float:
    """Return `value` as a float; booleans, NaN, infinities and absurd sizes are refused."""
    if type(value) is float and -LARGEST <= value <= LARGEST:  # most are: spare the slow questions
        return value
    if isinstance(value, bool) or not isinstance(value, Real):
        raise SituationError(field, f"must be a number (got {show(value)})")
    try:
        result = float(value)
    except OverflowError:
        raise SituationError(field, f"is too large ({show(value)}, max {LARGEST:g})") from None
    if not math.isfinite(result):
        raise SituationError(field, f"must be finite (got {result!r})")
    if abs(result) > LARGEST:
        raise SituationError(field, f"is too large ({result!r}, max {LARGEST:g})")
    return result


def whole(value: object, field: str) -> int:
    """Return `value` as an integer; booleans and fractions are refused."""
    result = number(value, field)
    if result != int(result):
        raise SituationError(field, f"must be a whole number (got {result!r})")
    return int(result)


def positive(value: object, field: str) -> float:
    """Return `value` as a float above zero."""
    result = number(value, field)
    if result <= 0.0:
        raise SituationError(field, f"must be positive (got {result!r})")
    return result


def non_negative(value: object, field: str) -> float:
    """Return `value` as a float of at least zero."""
    result = number(value, field)
    if result < 0.0:
        raise SituationError(field, f"must not be negative (got {result!r})")
    return result


def sequence(value: object, field: str, content: str) -> Sequence[object]:
    """Return a list, tuple or array as a sequence; `content` names its items in messages."""
    if isinstance(value, np.ndarray):
        return list(value)
    if not isinstance(value, (list, tuple)):
        raise SituationError(field, f"must be a list of {content} (got {show(value)})")
    return value


def vector(value: object, field: str, size: int) -> tuple[float, ...]:
    """Return `value` as a tuple of `size` floats."""
    if type(value) is tuple and len(value) == size:
        for item in value:
            if type(item) is not float or not -LARGEST <= item <= LARGEST:
                break
        else:  # most are as they should be: spare the slow questions
            return value
    items = sequence(value, field, f"{size} numbers")
    if len(items) != size:
        raise SituationError(field, f"must be a list of {size} numbers (got {len(items)})")
    return tuple(number(item, f"{field}[{k}]") for k, item in enumerate(items))


def positive_vector(value: object, field: str, size: int) -> tuple[float, ...]:
    """Return `value` as a tuple of `size` floats above zero."""
    return tuple(positive(x, f"{field}[{k}]") for k, x in enumerate(vector(value, field, size)))


def unit_vector(
    value: object, field: str, size: int = 3, *, tolerance: float = UNIT_TOLERANCE
) -> tuple[float, ...]:
    """Return `value` as a tuple of `size` floats whose Euclidean length is one."""
    result = vector(value, field, size)
    length = math.hypot(*result)
    if abs(length - 1.0) > tolerance:
        raise SituationError(field, f"must have length 1 (got {length:.9g})")
    return result


def normalised(value: object, field: str, size: int = 3) -> tuple[float, ...]:
    """Return `value` scaled to length 1; its own length may be off by `UNIT_LENGTH`.

    A vector that is off by rounding only stays, so that normalising twice changes nothing.
    """
    result = unit_vector(value, field, size, tolerance=UNIT_LENGTH)
    length = math.hypot(*result)
    return result if abs(length - 1.0) <= ROUNDING else tuple(part / length for part in result)


def in_ranges(
    values: Sequence[float], ranges: Sequence[tuple[float, float]], field: str
) -> tuple[float, ...]:
    """Return values within their ranges; set values barely outside to the bound, refuse others."""
    result = []
    for k, (value, (low, high)) in enumerate(zip(values, ranges, strict=True)):
        bound = min(max(value, low), high)
        if abs(value - bound) > AT_LIMIT * max(1.0, abs(bound)):
            raise SituationError(f"{field}[{k}]", f"{value} is outside its range [{low}, {high}]")
        result.append(bound)
    return tuple(result)


def orthogonal(first: Sequence[float], second: Sequence[float], field: str, other: str) -> None:
    """Refuse `second` (called `field`) unless it is orthogonal to `first` (called `other`)."""
    product = math.fsum(a * b for a, b in zip(first, second, strict=True))
    if abs(product) > UNIT_TOLERANCE:
        raise SituationError(field, f"must be orthogonal to {other} (dot product {product:.9g})")


def text(value: object, field: str) -> str:
    """Return `value` if it is a string that can be written as UTF-8."""
    if not isinstance(value, str):
        raise SituationError(field, f"must be a string (got {show(value)})")
    if not value.isascii() and any("\ud800" <= character <= "\udfff" for character in value):
        raise SituationError(field, f"is not valid Unicode (lone surrogate in {quote(value)})")
    return value


def choice(value: object, field: str, allowed: Sequence[str]) -> str:
    """Return `value` if it is one of the strings in `allowed`."""
    if not isinstance(value, str) or value not in allowed:
        names = " or ".join(quote(name) for name in allowed)
        raise SituationError(field, f"must be {names} (got {show(value)})")
    return value
