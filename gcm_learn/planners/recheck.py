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
JOINT_SLACK = 1e-6  # of joints that follow from hands [rad]


def broken_promise(situation: AnySituation, plan: Plan) -> str | None:
    """Return the first promise of a caught plan that does not hold.

    Parameters
    ----------
    situation : Situation
    plan : Plan
        Of this situation.

    Returns
    -------
    str or None
        None when all promises hold, or nothing was promised.
    """
    return judged_anew(situation, plan)[0]


def judged_anew(situation: AnySituation, plan: Plan) -> tuple[str | None, float | None]:
    """Return the first promise of a caught plan that does not hold, and the plan's clearance."""
    if plan.status != "caught":
        return None, None
    moves = plan.trajectory
    if moves is None or plan.catch_time is None or plan.catch_body is None:
        return "a catch without a trajectory, a time or a body", None
    if kind_of(moves.arm) != kind_of(situation):
        return "moves an arm of the other kind", None
    if moves.arm != situation.arm:
        return "moves another arm", None
    if plan.catch_body not in [target.name for target in situation.targets]:
        return f"catches {plan.catch_body!r}, which is no target", None
    if situation.catch == "all" and len(situation.targets) > 1:
        return f"catches one of {len(situation.targets)} targets, and all have to be caught", None
    if not abs(moves.duration - plan.catch_time) <= PLACE_SLACK:
        return "does not end at the catch", None
    parts = (moves.time, moves.hand, moves.joints, moves.rates)
    if not all(np.isfinite(part).all() for part in parts if part is not None):
        return "has numbers that are not finite", None
    return _verified(situation, moves, plan.catch_body)


def _verified(
    situation: AnySituation, moves: Movement, target: str
) -> tuple[str | None, float | None]:
    """Return what verification says against a movement, and the clearance."""
    scene = pack(situation)
    body = [body.name for body in situation.bodies].index(target)
    rules = rules_of(scene)._replace(touch=scene.limb.thickness)  # planners keep a little more
    verdict = verify(scene, rules, moves, body)
    if verdict.reason is not None:
        return str(verdict.reason), None
    if moves.path is not None and not _agree(moves, moves.path):
        return "has joints that do not lead the hand along its path", None
    return None, verdict.clearance


def _agree(moves: Movement, path: np.ndarray) -> bool:
    """Return whether joints of a planar arm lead to its hands, up to whole turns."""
    off = moves.joints - Movement.of_hand(moves.arm, moves.time, path).joints
    turns = 2.0 * np.pi * np.round(off[0] / (2.0 * np.pi))
    return bool((np.abs(off - turns) <= JOINT_SLACK).all())
