"""Contests by kind of arm, and thinking that is charged: the arm rests meanwhile."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from gcm_learn.arms import PLANAR, SPATIAL, ByKind
from gcm_learn.collision import least_distance
from gcm_learn.evaluation.methods import Method
from gcm_learn.evaluation.movements import hand_movement, joint_movement
from gcm_learn.motion import resting_in_space
from gcm_learn.planners import Problem, first_catch_on
from gcm_learn.scene import later, pack
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


@dataclass(frozen=True)
class ContestKind:
    """Contests between methods on situations with one kind of arm."""

    example: str | None
    """Family of the situations that methods answer beforehand; None for the first one itself."""
    movement: Callable[..., dict[str, Any]]
    """Numbers of an answer's path, of situation, result and path."""
    resting: Callable[[Any, float], str]
    """Outcome of a rest in a situation for some time [s]."""


CONTESTS = ByKind(
    {
        PLANAR: ContestKind("crossing-swarm", hand_movement, hand_resting),
        SPATIAL: ContestKind("crossing-swarm-space", joint_movement, joints_resting),
    },
    default=ContestKind(None, joint_movement, joints_resting),
)


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
    """Return the outcome of a rest for `delay` [s]: caught, touched, or nothing (empty)."""
    return "" if delay <= 0.0 else CONTESTS.of(situation).resting(situation, delay)
