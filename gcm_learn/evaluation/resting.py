"""Outcomes of an arm that rests while its agent thinks."""

from __future__ import annotations

import numpy as np

from gcm_learn.collision import least_distance
from gcm_learn.motion import resting_in_space
from gcm_learn.planners import Problem, first_catch_on
from gcm_learn.scene import pack
from gcm_learn.situation import AnySituation, Situation

_ANY = 1e9  # resolution of clearance: contact is exact whatever it is


def hand_resting(situation: Situation, delay: float) -> str:
    """Return the outcome for a planar arm: caught, touched, or nothing (empty)."""
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


def joints_resting(situation: AnySituation, delay: float) -> str:
    """Return the outcome for a spatial arm: caught, touched, or nothing (empty)."""
    touched, met = resting_in_space(pack(situation), min(delay, situation.horizon))
    return "caught" if 0.0 <= met <= touched else "touched" if touched < delay else ""
