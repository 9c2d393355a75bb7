"""Does a plan keep what ``caught`` promises? Asked once more, after planning."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gcm_learn.collision import arm_distance
from gcm_learn.motion import Trajectory, clearance
from gcm_learn.scene import elbow_position, pack_bodies, poses_at
from gcm_learn.situation import Situation

if TYPE_CHECKING:
    from gcm_learn.planners.plan import Plan

SPEED_SLACK = 1e-6  # relative, as the exchange contract allows
PLACE_SLACK = 1e-9  # [forearms]


def broken_promise(situation: Situation, plan: Plan) -> str | None:
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
    if plan.trajectory is None or plan.catch_time is None or plan.catch_body is None:
        return "a catch without a trajectory, a time or a body"
    trajectory, arm = plan.trajectory, situation.arm
    if np.abs(trajectory.hand[0] - arm.hand).max() > PLACE_SLACK or trajectory.time[0] != 0.0:
        return "does not start at the hand"
    if (
        abs(trajectory.duration - plan.catch_time) > PLACE_SLACK
        or trajectory.duration > situation.horizon
    ):
        return "does not end at the catch, within the horizon"
    if _too_fast(trajectory.time, trajectory.hand, arm.max_hand_speed):
        return "hand too fast"
    if arm.max_joint_speed is not None and any(
        _too_fast(trajectory.time, trajectory.joints[:, k : k + 1], limit)
        for k, limit in enumerate(arm.max_joint_speed)
    ):
        return "joint too fast"
    if _distance_to_catch(situation, trajectory, plan.catch_body) > arm.grasp + PLACE_SLACK:
        return "hand is not at the target"
    if clearance(situation, trajectory)[0] <= 0.0:
        return "limb touches an obstacle"
    return None


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
