"""Moves in the joints of an arm: how long they take, whether they are free.

A move is straight in the joints. If the hand's speed limits it, it is cut into pieces, each as
fast as its own limits let it be.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.arms.curves import line
from gcm_learn.arms.limbs import dof, hand_rate, hand_travel
from gcm_learn.collision.postures import Desk, desk_of, move_is_free
from gcm_learn.compiled import njit
from gcm_learn.scene import Scene

PIECES = 24  # of a move, at most
LONGEST = 0.3  # turn of a joint in a piece of a move that the hand's speed limits [rad]
SLOWER = 1e-4  # share of the hand's speed that is not used, so that its check is quick
HAIR = 2e-9  # share of the speed limits that is not used, against rounding
NEVER = 1e300


class Study(NamedTuple):
    """A scene to plan for, the rules to keep, and scratch arrays."""

    scene: Scene
    touch: float  # distance at which an obstacle counts as touching the limb
    catch: float  # signed distance to a target at which the hand surely catches
    instant: float  # resolution in time [s]
    desk: Desk
    pace: np.ndarray  # (PIECES,): when the pieces of the move timed last end, from its begin [s]
    near: np.ndarray  # (n,): joints
    far: np.ndarray  # (n,)
    posture: np.ndarray  # (n,)
    goal: np.ndarray  # (n,)
    low: np.ndarray  # (n,)
    high: np.ndarray  # (n,)
    jacobian: np.ndarray  # (3, n)
    turns: np.ndarray  # (3, n): angular velocity of the hand by the joints
    slopes: np.ndarray  # (5, n): of what pulls a posture to a target; see `pull`
    system: np.ndarray  # (6, 8): equations and their solution; see `least_rates`
    branches: np.ndarray  # (4, n)


@njit
def study_of(scene, rules):
    """Return the `Study` of a `Scene` and its `Rules`, with new scratch arrays."""
    n = dof(scene.limb)
    return Study(
        scene, rules.touch, rules.catch, rules.instant,
        desk_of(scene), np.zeros(PIECES), np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n),
        np.zeros(n), np.zeros(n), np.zeros((3, n)), np.zeros((3, n)), np.zeros((5, n)),
        np.zeros((6, 8)), np.zeros((4, n)),
    )  # fmt: skip


@njit(_nrt=False)
def turning_time(rate, q, p):
    """Return the time in which joints at speeds `rate` (n,) turn from q to p (n,) [s]."""
    most = 0.0
    for j in range(rate.size):
        most = max(most, abs(p[j] - q[j]) / rate[j])
    return most


@njit(_nrt=False)
def time_of(study, q, p):
    """Return the least time of the move from q to p (n,); write its pieces' ends to ``study.pace``.

    Returns
    -------
    time : float
        [s]
    pieces : int
    """
    limits, limb, pace = study.scene.limits, study.scene.limb, study.pace
    turning = turning_time(limits.joint_speed, q, p) * (1.0 + HAIR)
    pace[0] = turning
    if limits.speed == np.inf or hand_travel(limb, q, p) <= limits.speed * turning:
        return turning, 1
    longest = 0.0
    for j in range(dof(limb)):
        longest = max(longest, abs(p[j] - q[j]))
    count = min(max(int(np.ceil(longest / LONGEST)), 1), PIECES)
    curve, work = study.desk.curve, study.desk.joints
    line(q, p, curve)
    total, before = 0.0, hand_rate(limb, curve, 0.0, work)
    for k in range(count):
        middle = hand_rate(limb, curve, (k + 0.5) / count, work)
        after = hand_rate(limb, curve, (k + 1.0) / count, work)
        # how far a parabola rises above three of its points, and a half for what is none
        top = max(before, middle, after) + 0.2 * abs(before - 2.0 * middle + after)
        total += max(turning, top / limits.speed * (1.0 + SLOWER)) / count
        pace[k] = total
        before = after
    return total, count


@njit(_nrt=False)
def between(q, p, share, out):
    """Write the joints at a share of the move from q to p (n,) into `out`."""
    for j in range(out.size):
        out[j] = q[j] + share * (p[j] - q[j]) if share < 1.0 else p[j]


@njit(_nrt=False)
def timed_move_is_free(study, q, since, p, until, pieces):
    """Return whether the move timed last is free if it lasts from `since` to `until` [s]."""
    if pieces == 1:
        return move_is_free(study.scene, q, since, p, until, study.touch, study.desk)
    stretch = (until - since) / study.pace[pieces - 1]
    near, far = study.near, study.far
    between(q, p, 0.0, near)
    for k in range(pieces):
        between(q, p, (k + 1.0) / pieces, far)
        begin = since + stretch * study.pace[k - 1] if k > 0 else since
        end = since + stretch * study.pace[k] if k + 1 < pieces else until
        if not move_is_free(study.scene, near, begin, far, end, study.touch, study.desk):
            return False
        near, far = far, near
    return True


@njit(_nrt=False)
def rest_is_free(study, q, since, until):
    """Return whether a limb that rests at joints q (n,) stays free."""
    if until <= since:
        return True
    return move_is_free(study.scene, q, since, q, until, study.touch, study.desk)
