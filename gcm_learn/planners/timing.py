"""From an untimed path to one that keeps the arm's speed limits."""

from __future__ import annotations

import numpy as np

from gcm_learn.arm.kinematics import SIDE
from gcm_learn.planners.verification import PARTS, joint_turns
from gcm_learn.situation.situation import Arm

SPACING = 0.02  # samples of a straight way are at most this far apart [forearm lengths]
_SLACK = 1.0 + 1e-9  # against rounding of the speed limits


def segment_times(arm: Arm, hand: np.ndarray) -> np.ndarray:
    """Least time (n - 1,) for every segment of a hand path (n, 2) under the arm's limits [s]."""
    steps = np.sqrt((np.diff(hand, axis=0) ** 2).sum(axis=1))
    least = steps / arm.max_hand_speed
    if arm.max_joint_speed is not None and len(hand) > 1:
        turns = joint_turns(hand, arm.upper_arm, SIDE[arm.elbow], PARTS) * PARTS
        least = np.maximum(least, (turns / np.asarray(arm.max_joint_speed)).max(axis=1))
    return least * _SLACK


def keep_limits(arm: Arm, hand: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Times (n,) for a hand path: the wanted ones, delayed where the arm is not fast enough.

    Parameters
    ----------
    arm : Arm
    hand : (n, 2) ndarray
    wanted : (n,) ndarray
        When the front was there [s]; the first is taken as 0.

    Returns
    -------
    (n,) ndarray
        Starting at 0, with no segment shorter than the limits allow.
    """
    # t[k] = max(wanted[k], t[k - 1] + least[k]): a running maximum once the least is taken off.
    sooner = np.concatenate([[0.0], np.cumsum(segment_times(arm, hand))])
    late = np.maximum.accumulate(np.concatenate([[0.0], wanted[1:] - sooner[1:]]))
    return sooner + np.maximum(late, 0.0)


def straight_way(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Samples (m, 2) of a straight way, at most SPACING apart, both ends included."""
    pieces = max(int(np.ceil(np.hypot(*(end - start)) / SPACING)), 1)
    return start + np.linspace(0.0, 1.0, pieces + 1)[:, None] * (end - start)
