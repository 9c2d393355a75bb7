"""Checks of an arm at t = 0 that need its kinematics or the bodies around it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from gcm_learn.arms import CHAIN, SPATIAL, ByKind, kind_of
from gcm_learn.arms.chain import unknown_obstacle
from gcm_learn.arms.chain_limb import jacobian
from gcm_learn.arms.spatial_limb import hand_jacobian
from gcm_learn.errors import SituationError
from gcm_learn.situation.body import Body

SLACK = 1e-6
"""Share by which the hand may be over its limit at t = 0."""
CHECKED = ("gcm-learn/situation@3",)
"""Formats in which the hand's speed at t = 0 is checked."""

Derivative = Callable[[Any, np.ndarray, np.ndarray], None]
_RATES: ByKind[tuple[Derivative, str]] = ByKind(
    {SPATIAL: (hand_jacobian, "joint_rates"), CHAIN: (jacobian, "rates")}
)


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
        derivative, field = _RATES.of(arm)
        columns = np.zeros((3, len(rates)))
        derivative(kind_of(arm).pack(arm, ()), np.array(arm.joints), columns)
        speed = float(np.linalg.norm(columns @ np.array(rates)))
        if speed > arm.max_hand_speed * (1.0 + SLACK):
            reason = f"move the hand at {speed:.6g} (max {arm.max_hand_speed:g})"
            raise SituationError(f"arm.{field}", reason)
