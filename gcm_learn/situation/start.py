"""Checks of an arm at t = 0 that need its kinematics or the bodies around it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from gcm_learn.arms import CHAIN, ByKind, hand_speed, unknown_obstacle
from gcm_learn.errors import SituationError
from gcm_learn.situation.body import Body

SLACK = 1e-6
"""Share by which the hand may be over its limit at t = 0."""
CHECKED = ("gcm-learn/situation@3",)
"""Formats in which the hand's speed at t = 0 is checked."""

_RATES = ByKind({CHAIN: "rates"}, default="joint_rates")
"""Names of the rates at t = 0 in files."""


def check_start(arm: Any, bodies: Iterable[Body], version: str) -> None:
    """Refuse pairs of unknown obstacles, and rates beyond the hand's limit.

    Parameters
    ----------
    arm : Arm, SpatialArm or Chain
    bodies : iterable of Body
    version : str
        Format of the situation.
    """
    for k, (_, name) in enumerate(getattr(arm, "ignore", ())):
        if not any(body.name == name and body.role == "obstacle" for body in bodies):
            raise SituationError(f"arm.ignore[{k}]", unknown_obstacle(name))
    rates: tuple[float, ...] = getattr(arm, "joint_rates", None) or ()
    if version in CHECKED and arm.max_hand_speed is not None and any(rates):
        speed = hand_speed(arm, arm.joints, rates)
        if speed > arm.max_hand_speed * (1.0 + SLACK):
            reason = f"move the hand at {speed:.6g} (max {arm.max_hand_speed:g})"
            raise SituationError(f"arm.{_RATES.of(arm)}", reason)
