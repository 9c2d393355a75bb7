"""A second check of what a plan promises."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gcm_learn.arms import kind_of
from gcm_learn.motion import Movement, rules_of, verify
from gcm_learn.scene import pack
from gcm_learn.situation import AnySituation

if TYPE_CHECKING:
    from gcm_learn.planners.plan import Plan

PLACE_SLACK = 1e-9  # of times [s]


def broken_promise(situation: AnySituation, plan: Plan) -> str | None:
    """Return what a caught plan breaks.

    Parameters
    ----------
    situation : Situation
    plan : Plan
        Of this situation.

    Returns
    -------
    str or None
        The first promise that does not hold; None when all do, or nothing was promised.
    """
    if plan.status != "caught":
        return None
    moves = plan.trajectory
    if moves is None or plan.catch_time is None or plan.catch_body is None:
        return "a catch without a trajectory, a time or a body"
    if kind_of(moves.arm) != kind_of(situation):
        return "moves an arm of the other kind"
    if moves.arm != situation.arm:
        return "moves another arm"
    if plan.catch_body not in [target.name for target in situation.targets]:
        return f"catches {plan.catch_body!r}, which is no target"
    if not abs(moves.duration - plan.catch_time) <= PLACE_SLACK:
        return "does not end at the catch"
    if not all(np.isfinite(part).all() for part in (moves.time, moves.hand, moves.joints)):
        return "has numbers that are not finite"
    return _refusal(situation, moves, plan.catch_body)


def _refusal(situation: AnySituation, moves: Movement, target: str) -> str | None:
    """Return what verification says against a movement."""
    scene = pack(situation)
    body = [body.name for body in situation.bodies].index(target)
    rules = rules_of(scene)._replace(touch=scene.limb.thickness)  # planners keep a little more
    reason = verify(scene, rules, moves, body).reason
    return None if reason is None else str(reason)
