"""Times for a path without times, within the arm's speed limits."""

from __future__ import annotations

import numpy as np

from gcm_learn.arms import Arm
from gcm_learn.arms.planar_limb import SIDE, joints_of
from gcm_learn.compiled import njit
from gcm_learn.motion.verification import PARTS, joint_turns

SPACING = 0.02  # samples of a straight path are at most this far apart [forearm lengths]
JOINT_SLACK = 1.01  # joint speeds vary within the pieces on which they are measured
MOST_PIECES = 64
JOINT_TOLERANCE = 1e-4  # of hands on joints that are linear between samples [forearm lengths]
_SLACK = 1.0 + 1e-9  # against rounding of the speed limits


def refine(arm: Arm, time: np.ndarray, hand: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Add samples (times (n,), hands (n, 2)) until joints, too, may be taken as linear between."""
    return _refine(time, hand, arm.upper_arm, SIDE[arm.elbow], JOINT_TOLERANCE)


def segment_times(arm: Arm, hand: np.ndarray) -> np.ndarray:
    """Least time (n - 1,) for every segment of a hand path (n, 2) under the arm's limits [s]."""
    steps = np.sqrt((np.diff(hand, axis=0) ** 2).sum(axis=1))
    least = steps / arm.max_hand_speed
    if arm.max_joint_speed is not None and len(hand) > 1:
        turns = JOINT_SLACK * joint_turns(hand, arm.upper_arm, SIDE[arm.elbow], PARTS)
        least = np.maximum(least, (turns / np.asarray(arm.max_joint_speed)).max(axis=1))
    return least * _SLACK


def keep_limits(arm: Arm, hand: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Return times (n,) for a hand path: `wanted`, delayed where the arm is not fast enough.

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


@njit
def _refine(time, hand, rho, side, tolerance):
    """Split segments until joints that are linear between samples keep the hand on its way.

    Parameters
    ----------
    time, hand : (n,), (n, 2) ndarray
    tolerance : float
        Largest distance of the two hands half way through a segment [forearm lengths].

    Returns
    -------
    time, hand : (m,), (m, 2) ndarray
        The same movement with more samples.
    """
    n = time.size
    joints = joints_of(hand, rho, side)
    pieces = np.ones(n, dtype=np.int64)
    total = 1
    for k in range(n - 1):
        first = 0.5 * (joints[k, 0] + joints[k + 1, 0])
        second = first + 0.5 * (joints[k, 1] + joints[k + 1, 1])
        ex = rho * np.cos(first) + np.cos(second) - 0.5 * (hand[k, 0] + hand[k + 1, 0])
        ey = rho * np.sin(first) + np.sin(second) - 0.5 * (hand[k, 1] + hand[k + 1, 1])
        # The error falls with the square of the segment's length.
        error = np.sqrt(ex * ex + ey * ey) / tolerance
        pieces[k] = min(max(int(np.ceil(np.sqrt(error))), 1), MOST_PIECES)
        total += pieces[k]
    new_time, new_hand = np.empty(total), np.empty((total, 2))
    m = 0
    for k in range(n - 1):
        for p in range(pieces[k]):
            s = p / pieces[k]
            new_time[m] = time[k] + s * (time[k + 1] - time[k])
            new_hand[m, 0] = hand[k, 0] + s * (hand[k + 1, 0] - hand[k, 0])
            new_hand[m, 1] = hand[k, 1] + s * (hand[k + 1, 1] - hand[k, 1])
            m += 1
    new_time[m], new_hand[m, 0], new_hand[m, 1] = time[n - 1], hand[n - 1, 0], hand[n - 1, 1]
    return new_time, new_hand


@njit
def spread(time, hand, spacing):
    """Return a path with samples at most `spacing` apart, without the first of two equal samples.

    Parameters
    ----------
    time, hand : (n,), (n, 2) ndarray
    spacing : float
        [forearm lengths]

    Returns
    -------
    time, hand : (m,), (m, 2) ndarray
    """
    n = time.size
    pieces = np.zeros(n, dtype=np.int64)
    for k in range(n - 1):
        length = np.hypot(hand[k + 1, 0] - hand[k, 0], hand[k + 1, 1] - hand[k, 1])
        waits = 1 if time[k + 1] > time[k] else 0
        pieces[k] = max(int(np.ceil(length / spacing)), waits)
    total = pieces.sum() + 1
    new_time, new_hand = np.empty(total), np.empty((total, 2))
    m = 0
    for k in range(n - 1):
        for p in range(pieces[k]):
            s = (p * (1.0 / pieces[k]) + k) - k  # rounded as a position on the whole path
            new_time[m] = time[k] + s * (time[k + 1] - time[k])
            for a in range(2):
                new_hand[m, a] = hand[k, a] + s * (hand[k + 1, a] - hand[k, a])
            m += 1
    new_time[m], new_hand[m] = time[n - 1], hand[n - 1]
    return new_time, new_hand


def straight_path(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Samples (m, 2) of a straight path, at most SPACING apart, both ends included."""
    pieces = max(int(np.ceil(np.hypot(*(end - start)) / SPACING)), 1)
    return start + np.linspace(0.0, 1.0, pieces + 1)[:, None] * (end - start)
