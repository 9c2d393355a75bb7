"""Thinking that is charged: the world goes on meanwhile, and joints that turn turn on."""

from __future__ import annotations

from typing import Any

import numpy as np

from gcm_learn.evaluation.kinds import resting
from gcm_learn.planners import SpatialProblem
from gcm_learn.scene import later

LOOKS = 4  # at an arm that goes on while one thinks


def after(situation: Any, budget: float) -> Any | str:
    """Return a situation `budget` [s] later, or what happened to the arm before.

    An arm whose joints move and cannot stop at once goes on as it did; any other rests. If it
    is touched or caught meanwhile, nobody is asked: all methods share that fate.
    """
    if budget >= situation.horizon:
        return "late"
    rates = getattr(situation.arm, "joint_rates", None)
    if rates is None or not any(rates):
        return resting(situation, budget) or later(situation, budget)
    moved = None
    for share in np.linspace(0.0, 1.0, LOOKS + 1)[1:]:
        moved = coasting(situation, share * budget)
        if moved is None or SpatialProblem(moved, "rest").start_clearance <= 0.0:
            return "touched"
    return moved


def coasting(situation: Any, t: float) -> Any | None:
    """The situation t [s] later, its joints turning on; None where one comes to its end."""
    arm = situation.arm
    joints = tuple(q + t * rate for q, rate in zip(arm.joints, arm.joint_rates, strict=True))
    ends = zip(joints, arm.joint_range, strict=True)
    if not all(low <= q <= high for q, (low, high) in ends):
        return None
    return later(situation, t, joints=joints, rates=arm.joint_rates)
