"""Latency-aware evaluation: the world runs while an agent thinks, so thinking is charged."""

from __future__ import annotations

from gcm_learn.evaluation.kinds import CONTESTS
from gcm_learn.evaluation.methods import Method
from gcm_learn.scene import later
from gcm_learn.situation import AnySituation


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
