"""Latency-aware evaluation: the world runs while an agent thinks, so thinking is charged."""

from __future__ import annotations

import numpy as np

from gcm_learn.arms import SpatialArm
from gcm_learn.collision import least_distance
from gcm_learn.evaluation.methods import Method
from gcm_learn.motion import resting_in_space
from gcm_learn.planners import Problem, first_catch_on
from gcm_learn.scene import later, pack
from gcm_learn.situation import AnySituation, Situation, planar

_ANY = 1e9  # resolution of clearance: whether the limb touches is exact whatever it is


def charged(method: Method, situation: AnySituation, delay: float) -> str | None:
    """Outcome if the hand rests for `delay` [s] before it does what was thought out.

    None if it cannot rest: its joints move at t = 0, and their accelerations are limited.

    The agent knows how long it thinks, so it thinks about the situation as it will be then.
    Its hand rests meanwhile: it may be touched, or a target may come to it.
    """
    if any(getattr(situation.arm, "joint_rates", None) or ()):
        return None
    outcome = resting(situation, delay)
    if outcome or delay >= situation.horizon:
        return outcome or "late"
    # mypy has no type variable that is either kind
    return method.run(later(situation, delay)).outcome  # type: ignore[type-var]


def resting(situation: AnySituation, delay: float) -> str:
    """What happens to a hand that rests for `delay` [s]: caught, touched, or nothing (empty)."""
    if delay <= 0.0:
        return ""
    if isinstance(situation.arm, SpatialArm):
        touched, met = resting_in_space(pack(situation), min(delay, situation.horizon))
        return "caught" if 0.0 <= met <= touched else "touched" if touched < delay else ""
    return _resting_in_plane(planar(situation, "resting"), delay)


def _resting_in_plane(situation: Situation, delay: float) -> str:
    arm, problem = situation.arm, Problem(situation, "rest")
    time = np.array([0.0, min(delay, situation.horizon)])
    hand = np.array([arm.hand, arm.hand])
    met, _ = first_catch_on(problem, time, hand)
    if met >= 0.0:
        time[1] = met
    distance, _ = least_distance(problem.scene, time, hand, arm.thickness, _ANY)
    if distance <= arm.thickness:
        return "touched"
    return "caught" if met >= 0.0 else ""
