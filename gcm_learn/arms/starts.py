"""Rates and accelerations at t = 0, which only arms with limits have."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from gcm_learn.checks import vector
from gcm_learn.errors import SituationError


class Start(NamedTuple):
    """Names of what an arm has at t = 0, and the word for too much of it."""

    field: str
    needs: str
    """Field of the limits without which it must not be given."""
    excess: str


def started(
    given: object, start: Start, most: Sequence[float] | None, limits: Sequence[float] | None
) -> tuple[float, ...] | None:
    """Return rates or accelerations (n,) at t = 0, zero by default; `limits` of None give None.

    Parameters
    ----------
    given : object
    start : Start
    most : (n,) sequence of float, optional
        Largest sizes; there are some wherever there are limits.
    limits : (n,) sequence of float, optional
        Limits of the next derivative, `needs`.
    """
    if given is None:
        return None if limits is None else (0.0,) * len(limits)
    if limits is None or most is None:
        raise SituationError(start.field, f"are given without {start.needs}")
    values = vector(given, start.field, len(most))
    for k, (value, limit) in enumerate(zip(values, most, strict=True)):
        if abs(value) > limit:
            reason = f"{value} is too {start.excess} (max {limit})"
            raise SituationError(f"{start.field}[{k}]", reason)
    return values
