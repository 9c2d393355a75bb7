"""Arms with other masses than their controllers take them for."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from gcm_learn.arms import SpatialArm
from gcm_learn.execution import Controller, Execution, body_for, execute
from gcm_learn.situation import ArmBody, Situation

OFF = 1.1  # masses of the heavy arm, which its controller takes for the shipped ones
CONDITIONS = {
    "known": (1.0, Controller()),
    "heavy": (OFF, Controller()),
    "gravity": (1.0, Controller("gravity")),
}
"""Ratio of the arm's masses to those that its controller believes in, and the controller."""


def heavier(body: ArmBody, factor: float) -> ArmBody:
    """Return the same arm of heavier stuff."""
    bones = tuple(
        replace(b, mass=factor * b.mass, inertia=tuple(factor * i for i in b.inertia))
        for b in body.bones
    )
    return replace(body, bones=bones)


def followed(plan: Any, situation: Situation[SpatialArm], condition: str) -> Execution:
    """Execute a plan under a condition; the controller believes in the shipped masses."""
    factor, controller = CONDITIONS[condition]
    body = body_for(situation.arm)
    return execute(plan, situation, heavier(body, factor), controller, believed=body)
