"""The check that stands behind the word "caught"."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from gcm_learn.arm.clearance import RESOLUTION, least_distance
from gcm_learn.arm.kinematics import SIDE, joints_of
from gcm_learn.arm.trajectory import Trajectory
from gcm_learn.planners.interception import target_distance
from gcm_learn.situation import Situation
from gcm_learn.situation.kernels import Bodies, pose_at

SAFETY = 1e-4  # clearance that a plan keeps beyond "does not touch" [forearm lengths]
CATCH_SAFETY = 1e-6  # how much nearer than `grasp` the hand must come [forearm lengths]
SPEED_TOLERANCE = 1e-7  # relative; the contract grants 1e-6
PARTS = 8  # pieces of a segment on which joint speeds are measured


@dataclass(frozen=True)
class Verdict:
    """Whether a trajectory keeps the promise of "caught"."""

    good: bool
    clearance: float
    """Smallest distance of limb and obstacles, less the thickness; only the order of magnitude of
    the failure when `good` is False."""
    reason: str
    """Empty, or what is wrong, in one clause."""


@njit(cache=True)
def joint_turns(hand, rho, side, parts):
    """Largest turn of each joint over one of `parts` equal pieces of every segment (n - 1, 2)."""
    n = hand.shape[0]
    out = np.zeros((n - 1, 2))
    piece = np.empty((parts + 1, 2))
    for k in range(n - 1):
        for p in range(parts + 1):
            for a in range(2):
                piece[p, a] = hand[k, a] + p / parts * (hand[k + 1, a] - hand[k, a])
        joints = joints_of(piece, rho, side)
        for p in range(parts):
            for a in range(2):
                out[k, a] = max(out[k, a], abs(joints[p + 1, a] - joints[p, a]))
    return out


@njit(cache=True)
def nearest_to_shoulder(hand):
    """Smallest distance of a polyline (n, 2) to the origin."""
    best = np.sqrt(hand[0, 0] ** 2 + hand[0, 1] ** 2)
    for k in range(hand.shape[0] - 1):
        x, y = hand[k, 0], hand[k, 1]
        dx, dy = hand[k + 1, 0] - x, hand[k + 1, 1] - y
        length2 = dx * dx + dy * dy
        s = min(max(-(x * dx + y * dy) / length2, 0.0), 1.0) if length2 > 0.0 else 0.0
        best = min(best, np.sqrt((x + s * dx) ** 2 + (y + s * dy) ** 2))
    return best


def verify(situation: Situation, bodies: Bodies, trajectory: Trajectory, body: int) -> Verdict:
    """Check a trajectory against everything that "caught" promises.

    Parameters
    ----------
    situation : Situation
    bodies : Bodies
        The situation packed.
    trajectory : Trajectory
    body : int
        Index of the target that is caught at the trajectory's end.

    Returns
    -------
    Verdict
    """
    arm = situation.arm
    reason = _kinematic_fault(situation, trajectory) or _miss(situation, bodies, trajectory, body)
    if reason:
        return Verdict(False, 0.0, reason)
    rho, side = arm.upper_arm, SIDE[arm.elbow]
    safety = min(SAFETY, 0.5 * start_clearance(situation, bodies))
    distance, when = least_distance(
        bodies, trajectory.time, trajectory.hand, rho, side, arm.thickness + safety, RESOLUTION
    )
    if distance <= arm.thickness + safety:
        return Verdict(False, distance - arm.thickness, f"the limb is touched at t = {when:.3f} s")
    free = np.inf if distance > 1e200 else distance - arm.thickness
    return Verdict(True, float(free), "")


def start_clearance(situation: Situation, bodies: Bodies) -> float:
    """Distance of the limb at t = 0 to the obstacles, less the thickness [forearm lengths]."""
    arm = situation.arm
    distance, _ = least_distance(
        bodies, np.zeros(1), np.array([arm.hand]), arm.upper_arm, SIDE[arm.elbow], -1.0, 1.0
    )
    return float(distance) - arm.thickness


def _kinematic_fault(situation: Situation, trajectory: Trajectory) -> str:
    """What of start, horizon, ring and speeds is not kept, or nothing."""
    arm, hand, time = situation.arm, trajectory.hand, trajectory.time
    if time[0] != 0.0 or tuple(hand[0]) != arm.hand:
        return "the path does not start at the hand"
    if time[-1] > situation.horizon:
        return f"the catch at {time[-1]:.3f} s comes after the horizon"
    if np.hypot(hand[:, 0], hand[:, 1]).max() > arm.reach * (1.0 + 1e-9):
        return "the path leaves the reachable ring"
    if len(time) > 1 and nearest_to_shoulder(hand) < arm.inner_reach * (1.0 - 1e-9):
        return "the path leaves the reachable ring"
    if len(time) == 1:
        return ""
    spans = np.diff(time)
    steps = np.sqrt((np.diff(hand, axis=0) ** 2).sum(axis=1))
    if np.any(steps > arm.max_hand_speed * spans * (1.0 + SPEED_TOLERANCE)):
        return "the hand would have to be faster than max_hand_speed"
    if arm.max_joint_speed is not None:
        turns = joint_turns(hand, arm.upper_arm, SIDE[arm.elbow], PARTS) * PARTS
        limits = np.asarray(arm.max_joint_speed) * (1.0 + SPEED_TOLERANCE)
        if np.any(turns > limits * spans[:, None]):
            return "a joint would have to be faster than max_joint_speed"
    return ""


def _miss(situation: Situation, bodies: Bodies, trajectory: Trajectory, body: int) -> str:
    """Whether the hand misses the target at the end."""
    poses = np.zeros((len(situation.bodies), 12))
    pose_at(bodies, body, trajectory.duration, poses)
    distance = target_distance(bodies, poses, body, *trajectory.hand[-1])
    if distance > situation.arm.grasp - 0.5 * CATCH_SAFETY:
        return "the hand misses the target"
    return ""
