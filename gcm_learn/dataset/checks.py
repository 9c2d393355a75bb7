"""Checks of single values of a specification; one-line errors name the field and the fault."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Mapping

from gcm_learn.errors import SpecError, not_among


def integer(value: object, field: str, least: int, most: int) -> None:
    """Refuse anything but a whole number in a range."""
    if isinstance(value, bool) or not isinstance(value, int):
        raise SpecError(field, f"must be a whole number (got {value!r})")
    if not least <= value <= most:
        bound = f"at least {least}" if value < least else f"at most {most}"
        raise SpecError(field, f"must be {bound} (got {value})")


def number(value: object, field: str) -> float:
    """Return a finite number; refuse anything else."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise SpecError(field, f"must be a finite number (got {value!r})")
    return float(value)


def positive(value: object, field: str) -> None:
    """Refuse anything but a number above zero."""
    if number(value, field) <= 0.0:
        raise SpecError(field, f"must be positive (got {value!r})")


def share(value: object, field: str) -> None:
    """Refuse anything but a number from 0 to 1."""
    if not 0.0 <= number(value, field) <= 1.0:
        raise SpecError(field, f"must be a share, 0 to 1 (got {value!r})")


def choice(value: object, field: str, allowed: Collection[str]) -> None:
    """Refuse anything but one of the allowed strings."""
    if not isinstance(value, str) or value not in allowed:
        raise SpecError(field, not_among(value, allowed))


def distinct(values: object, field: str, allowed: Collection[str]) -> None:
    """Refuse anything but a list of different allowed strings."""
    if not isinstance(values, tuple | list):
        raise SpecError(field, f"must be a list (got {values!r})")
    for k, value in enumerate(values):
        choice(value, f"{field}[{k}]", allowed)
        if value in values[:k]:
            raise SpecError(f"{field}[{k}]", f"{value!r} is given twice")


def shares(values: object, field: str, allowed: Collection[str]) -> None:
    """Refuse anything but a table of shares, not all of them zero."""
    if not isinstance(values, Mapping):
        raise SpecError(field, f"must be a table (got {values!r})")
    for name, value in values.items():
        if name not in allowed:
            raise SpecError(f"{field}.{name}", f"is not one of {', '.join(allowed)}")
        if number(value, f"{field}.{name}") < 0.0:
            raise SpecError(f"{field}.{name}", f"must not be negative (got {value!r})")
    if sum(values.values()) <= 0.0:
        raise SpecError(field, "must have a share above zero")


def name(value: object, field: str) -> None:
    """Refuse anything but a plain word, which can stand in file names."""
    if not isinstance(value, str) or not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9._-]{0,63}", value):
        reason = "must be a word of letters, digits, '.', '-' and '_'"
        raise SpecError(field, f"{reason} (got {value!r})")
