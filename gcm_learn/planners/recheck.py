"""Does a plan keep what ``caught`` promises? Asked once more, after planning."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

import numpy as np

from gcm_learn.arms import Arm, SpatialArm, elbow_position
from gcm_learn.collision import arm_distance
from gcm_learn.motion import SpatialTrajectory, Trajectory, clearance, rules_of, verify
from gcm_learn.scene import pack, pack_bodies, poses_at
from gcm_learn.situation import AnySituation, Situation

if TYPE_CHECKING:
    from gcm_learn.planners.plan import AnyPlan

SPEED_SLACK = 1e-6  # relative, as the exchange contract allows
PLACE_SLACK = 1e-9  # [forearms]


def broken_promise(situation: AnySituation, plan: AnyPlan) -> str | None:
    """Say what a caught plan breaks.

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
    if situation.is_spatial != isinstance(moves, SpatialTrajectory):
        return "moves an arm of the other kind"
    if plan.catch_body not in [target.name for target in situation.targets]:
        return f"catches {plan.catch_body!r}, which is no target"
    if not _starts(situation, moves):
        return "does not start at the hand"
    if abs(moves.duration - plan.catch_time) > PLACE_SLACK or moves.duration > situation.horizon:
        return "does not end at the catch, within the horizon"
    if isinstance(moves, SpatialTrajectory):
        return _broken_in_space(cast("Situation[SpatialArm]", situation), moves, plan.catch_body)
    return _broken_in_the_plane(cast("Situation", situation), moves, plan.catch_body)


def _starts(situation: AnySituation, moves: Trajectory | SpatialTrajectory) -> bool:
    """Whether a movement begins where the arm is at t = 0."""
    arm = situation.arm
    if not isinstance(arm, Arm):
        off = moves.joints[0] - np.asarray(arm.joints)
    else:
        off = moves.hand[0] - np.asarray(arm.hand)
    return bool(moves.time[0] == 0.0 and np.abs(off).max() <= PLACE_SLACK)


def _broken_in_the_plane(situation: Situation, moves: Trajectory, body: str) -> str | None:
    arm = situation.arm
    if _too_fast(moves.time, moves.hand, arm.max_hand_speed):
        return "hand too fast"
    if arm.max_joint_speed is not None and any(
        _too_fast(moves.time, moves.joints[:, k : k + 1], limit)
        for k, limit in enumerate(arm.max_joint_speed)
    ):
        return "joint too fast"
    if _distance_to_catch(situation, moves, body) > arm.grasp + PLACE_SLACK:
        return "hand is not at the target"
    if clearance(situation, moves)[0] <= 0.0:
        return "limb touches an obstacle"
    return None


def _broken_in_space(
    situation: Situation[SpatialArm], moves: SpatialTrajectory, body: str
) -> str | None:
    """Limits in space hold between samples as well, so they are judged as planners have it."""
    if moves.arm != situation.arm:
        return "moves another arm"
    scene = pack(situation)
    index = [b.name for b in situation.bodies].index(body)
    verdict = verify(scene, rules_of(scene), moves, index)
    return None if verdict.reason is None else str(verdict.reason)


def _too_fast(time: np.ndarray, place: np.ndarray, limit: float) -> bool:
    moved = np.linalg.norm(np.diff(place, axis=0), axis=1)
    return bool((moved > limit * np.diff(time) * (1.0 + SPEED_SLACK)).any())


def _distance_to_catch(situation: Situation, trajectory: Trajectory, name: str) -> float:
    """Distance of the hand to the body of a name at the trajectory's end."""
    index = [body.name for body in situation.bodies].index(name)
    bodies = pack_bodies(situation)
    poses = np.zeros((len(situation.bodies), 12))
    poses_at(bodies, trajectory.duration, poses)
    hand = trajectory.hand[-1]
    elbow = elbow_position(hand, situation.arm.upper_arm, situation.arm.elbow)
    return float(arm_distance(bodies, poses, index, hand[0], hand[1], elbow[0], elbow[1]))
