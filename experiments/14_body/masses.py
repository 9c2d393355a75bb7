"""Arms with other masses than their controllers take them for."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from gcm_learn.execution import Controller, Execution, body_for, execute
from gcm_learn.situation import AnyArmBody, ArmBody, ChainBody, Situation

OFF = 1.1  # masses of the heavy arm, which its controller takes for the shipped ones
CONDITIONS = {
    "known": (1.0, Controller()),
    "heavy": (OFF, Controller()),
    "gravity": (1.0, Controller("gravity")),
}
"""Ratio of the arm's masses to those that its controller believes in, and the controller."""


CARRIED = {ArmBody: "bones", ChainBody: "frames"}
"""Fields of bodies with masses."""


def heavier(body: AnyArmBody, factor: float) -> Any:
    """Return the same arm of heavier stuff."""
    field = CARRIED[type(body)]
    parts = tuple(
        replace(part, mass=factor * part.mass, inertia=_times(factor, part.inertia))
        for part in getattr(body, field)
    )
    return replace(body, **{field: parts})


def _times(factor: float, value: Any) -> Any:
    """Return numbers, in tuples of any depth, times a factor."""
    return tuple(_times(factor, v) for v in value) if isinstance(value, tuple) else factor * value


def followed(plan: Any, situation: Situation[Any], condition: str) -> Execution:
    """Execute a plan under a condition; the controller believes in the shipped masses."""
    factor, controller = CONDITIONS[condition]
    body = body_for(situation.arm)
    return execute(plan, situation, heavier(body, factor), controller, believed=body)
