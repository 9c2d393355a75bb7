"""Conditions under which questions are asked, and the world after some thinking."""

from __future__ import annotations

from typing import Any, Literal, NamedTuple, cast

import numpy as np

from gcm_learn.arms import PLANAR, kind_of
from gcm_learn.errors import SuiteError
from gcm_learn.execution import OUTCOMES, RUNNING, ExactPlant, without
from gcm_learn.motion import Movement
from gcm_learn.planners import LIMIT
from gcm_learn.scene import later
from gcm_learn.situation import AnySituation

OWN = "own"


class Condition(NamedTuple):
    """Conditions of an answer."""

    thinking: float | Literal["own"] = 0.0
    """Time that the world goes on before the arm moves [s]; "own" is the processor time."""
    noise: float = 0.0
    """Standard deviation of perceived places [forearm lengths]; with any, the closed loop runs."""
    limit: float = LIMIT
    """Time on the wall for an answer [s]; a later one is an error."""

    @property
    def told(self) -> str:
        """Thinking in words: "0 ms", "20 ms" or "own"."""
        return OWN if self.thinking == OWN else f"{1e3 * float(self.thinking):g} ms"


def check(condition: Condition) -> None:
    """Raise SuiteError for a condition that cannot be."""
    own = condition.thinking == OWN
    if not own and not 0.0 <= float(condition.thinking) < 1e6:
        raise SuiteError(f"thinking: must be from 0 s on, or own (got {condition.thinking})")
    if not 0.0 <= condition.noise <= 1.0:
        raise SuiteError(f"noise: must be from 0 to 1 forearm lengths (got {condition.noise})")
    if not 0.0 < condition.limit <= 1e6:
        raise SuiteError(f"limit: must be above 0 s (got {condition.limit})")


def after(situation: AnySituation, thinking: float) -> AnySituation | str:
    """Return the situation after some thinking time, or the outcome if the episode ended before.

    An arm whose joints move goes on as it moves; any other rests. Where several catches are wanted,
    targets that come to the hand are gone.

    Parameters
    ----------
    situation : Situation
    thinking : float
        [s]

    Returns
    -------
    Situation or str
        An outcome if the episode is over: caught, touched or late.
    """
    if thinking <= 0.0:
        return situation
    plant = ExactPlant(situation)
    plant.follow(_unled(situation.arm, thinking), thinking)
    if plant.outcome != RUNNING:
        return OUTCOMES[plant.outcome]
    left: Any = without(situation, plant.catches)
    arm: Any = plant.arm
    if kind_of(arm) == PLANAR:
        return cast(AnySituation, later(left, thinking))
    start: Any = situation.arm
    rates = start.joint_rates or (0.0,) * len(start.joints)
    ends = zip(start.joints, rates, start.joint_range, strict=True)
    if not all(low <= q + thinking * rate <= high for q, rate, (low, high) in ends):
        return "touched"  # the end of a joint's range
    return cast(AnySituation, later(left, thinking, joints=arm.joints, rates=arm.joint_rates))


def _unled(arm: Any, thinking: float) -> Movement:
    """Return an arm's movement without commands: at rest, or with its joints at constant rates."""
    time = np.array([0.0, 2.0 * thinking])
    if kind_of(arm) == PLANAR:
        return Movement.of_hand(arm, time, np.array([arm.hand, arm.hand]))
    start = np.array(arm.joints)
    if not any(arm.joint_rates or ()):
        return Movement(arm, time, np.array([start, start]))
    rates = np.array(arm.joint_rates)
    return Movement(arm, time, start + time[:, None] * rates, np.array([rates, rates]))
