"""Checks of a situation's demands on its arm: start, holds, approaches, end."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from gcm_learn import arms
from gcm_learn.checks import quote
from gcm_learn.errors import SituationError
from gcm_learn.situation.body import Body

SLACK = 1e-6
"""Share by which the hand may be over its limit at t = 0."""
ROUNDING = 1e-9
"""Angle by which two approaches may contradict each other [rad]."""
CHECKED = ("gcm-learn/situation@3", "gcm-learn/situation@4")
"""Formats in which the hand's speed at t = 0 is checked."""
_SPATIAL = ("joint_rates", "max_joint_jerk", "joint_accelerations")
_NAMES = arms.ByKind(
    {arms.CHAIN: ("rates", "max_jerk", "accelerations"), arms.SPATIAL: _SPATIAL}, default=_SPATIAL
)
"""Names in files of rates at t = 0, limits of jerk and accelerations at t = 0."""


def check_start(arm: Any, bodies: Sequence[Body], version: str) -> None:
    """Refuse pairs of unknown obstacles, and rates beyond the hand's limit.

    Parameters
    ----------
    arm : Arm, SpatialArm or Chain
    bodies : sequence of Body
    version : str
        Format of the situation.
    """
    for k, (_, name) in enumerate(getattr(arm, "ignore", ())):
        _check_obstacle(name, bodies, f"arm.ignore[{k}]")
    rates: tuple[float, ...] = getattr(arm, "joint_rates", None) or ()
    if version in CHECKED and arm.max_hand_speed is not None and any(rates):
        speed = arms.hand_speed(arm, arm.joints, rates)
        if speed > arm.max_hand_speed * (1.0 + SLACK):
            reason = f"move the hand at {speed:.6g} (max {arm.max_hand_speed:g})"
            raise SituationError(f"arm.{_NAMES.of(arm)[0]}", reason)


def _check_obstacle(name: str, bodies: Sequence[Body], field: str) -> None:
    if not any(body.name == name and body.role == "obstacle" for body in bodies):
        raise SituationError(field, f"{quote(name)} is not the name of an obstacle")


def check_asked(arm: Any, bodies: Sequence[Body], end: str) -> None:
    """Refuse holds and rest without limits of acceleration, and targets with impossible demands.

    Parameters
    ----------
    arm : Arm, SpatialArm or Chain
    bodies : sequence of Body
    end : str
        Of the situation.
    """
    limited = getattr(arm, "max_joint_acceleration", None) is not None
    reason = "needs limits of acceleration, which the arm does not have"
    if end == "rest" and not limited:
        raise SituationError("end", f'"rest" {reason}')
    for k, body in enumerate(bodies):
        if body.hold is not None and not limited:
            raise SituationError(f"bodies[{k}].hold", reason)
        for i, name in enumerate(body.ignore):
            _check_obstacle(name, bodies, f"bodies[{k}].ignore[{i}]")
        if len(body.approach) > 1:
            _check_approaches(arm, body, f"bodies[{k}].approach")


def _check_approaches(arm: Any, body: Body, field: str) -> None:
    """Refuse two approaches that no hand keeps together."""
    first, second = body.approach
    axes = _angle(first.axis, second.axis)
    hands = _angle(*(one.hand or arm.hand_axis for one in body.approach))
    granted = first.within + second.within
    if abs(hands - axes) > granted + ROUNDING:
        reason = f"the hand's axes are {hands:.6g} rad apart, the target's {axes:.6g}"
        raise SituationError(field, f"no hand can keep both: {reason}, within {granted:.6g}")


def _angle(first: Sequence[float], second: Sequence[float]) -> float:
    """Angle between two directions [rad]."""
    return math.atan2(np.linalg.norm(np.cross(first, second)), np.dot(first, second))


def newer_of_arm(arm: Any) -> Iterator[str]:
    """Yield fields of an arm that ``gcm-learn/situation@4`` adds, other than by the model."""
    jerk = getattr(arm, "max_joint_jerk", None)
    if jerk is not None and jerk != _jerk_of_model(arm):
        yield f"arm.{_NAMES.of(arm)[1]}"
    if any(getattr(arm, "joint_accelerations", None) or ()):
        yield f"arm.{_NAMES.of(arm)[2]}"


def _jerk_of_model(arm: Any) -> tuple[float, ...] | None:
    if arms.kind_of(arm) is not arms.CHAIN:
        return None
    jerk: tuple[float, ...] | None = with_jerk_of_model(arm).max_joint_jerk
    return jerk


def without_jerk(arm: Any) -> Any:
    """Return an arm without limits of jerk."""
    if getattr(arm, "max_joint_jerk", None) is None:
        return arm
    return replace(arm, max_joint_jerk=None, joint_accelerations=None)


def with_jerk_of_model(arm: arms.Chain) -> arms.Chain:
    """Return a chain with the limits of jerk of its model, if the model has any."""
    return replace(arm, max_joint_jerk=arms.FROM_MODEL, joint_accelerations=None)
