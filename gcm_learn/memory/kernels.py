"""Remembered paths bent to a new situation, timed and checked: compiled, without Python between.

A trace is a path in polar coordinates about the shoulder, in the frame in which the hand starts in
direction 0 and the elbow is on the right: `KNOTS` rows (angle, share of the ring, time, earliest).
What a kernel writes is in the arm-plane coordinates of the situation that it is given.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from gcm_learn.arm.clearance import least_distance
from gcm_learn.arm.kinematics import elbow_of
from gcm_learn.planners.interception import approach, first_catch
from gcm_learn.planners.verification import PARTS, joint_turns, nearest_to_shoulder
from gcm_learn.situation.kernels import (
    HAND,
    PART,
    TOP_SPEED,
    Bodies,
    arm_distance,
    pose_at,
)

KNOTS = 24  # of a trace, see `gcm_learn.memory.traces`
ANGLE, RING, TIME, EARLIEST = range(4)  # columns of a knot
POLAR, CARTESIAN = 0, 1  # in which coordinates paths are bent
HURRY, KEEP = 0, 1  # waits are kept and the rest is hurried, or all times are kept
HOLDS, LATE, TOUCHES, SINGULAR = range(4)  # what becomes of a trace

_TURNS = 60  # instants of interception that are tried at most
_STRIDE = 48.0  # steps in a horizon while there is no target to be met
_CLOSE = 1e-3  # share of the horizon within which the instant is found
_SLACK = 1.0 + 2e-9  # against rounding of the speed limits
_JOINT_SLACK = 1.01  # joint speeds vary within the pieces on which they are measured
_HOLE = 2e-3  # distance that paths keep from the hole of the ring [forearm lengths]
_HUB = 0.03  # distance that paths keep from the shoulder, where joints jump [forearm lengths]
_ORDER = (2, 0, 1, 3)  # of the instants at which touches are looked for: far ones first


class Query(NamedTuple):
    """What an adaptation must know of a situation."""

    bodies: Bodies
    table: np.ndarray  # (g, n, 12): poses of all bodies at g instants from 0 to the horizon
    x: float  # hand at t = 0 [forearm lengths]
    y: float
    angle: float  # its direction [rad]
    ring: float  # its share of the ring: 0 at the inner rim, 1 at the outer one
    rho: float
    side: float
    near: float  # rims of the ring
    far: float
    speed: float  # of the hand, less a hair
    shoulder: float  # largest joint speeds [rad/s], 0 if there are none
    elbow: float
    horizon: float
    reach: float  # signed distance to a target that surely is a catch
    floor: float  # distance at which the limb touches
    instant: float  # resolution of interceptions [s]
    soonest: float  # no movement can catch before [s]


@njit(cache=True)
def pose_table(bodies, horizon, instants):
    """Poses (instants, n, 12) of all bodies at instants from 0 to the horizon."""
    n = bodies.rows.shape[0]
    out = np.zeros((instants, n, 12))
    for g in range(instants):
        t = horizon * g / (instants - 1)
        poses = out[g]
        for b in range(n):
            pose_at(bodies, b, t, poses)
    return out


@njit(cache=True)
def _wrapped(angle):
    """An angle within [-pi, pi]."""
    return angle - 2.0 * np.pi * np.round(angle / (2.0 * np.pi))


@njit(cache=True)
def shares(traces, m, near, far, out):
    """Share of its length that trace m has behind it at every knot, for rims of the ring.

    A path that goes nowhere is shared out by time.
    """
    n = traces.shape[1]
    out[0] = 0.0
    for k in range(1, n):
        r0 = near + traces[m, k - 1, RING] * (far - near)
        r1 = near + traces[m, k, RING] * (far - near)
        turn = traces[m, k, ANGLE] - traces[m, k - 1, ANGLE]
        out[k] = out[k - 1] + np.sqrt((r1 - r0) ** 2 + max(r0 * r1, 0.0) * turn * turn)
    total = out[n - 1]
    if total < 1e-6:
        last = max(traces[m, n - 1, TIME], 1e-9)
        for k in range(n):
            out[k] = traces[m, k, TIME] / last
        out[n - 1] = 1.0
        return
    for k in range(n):
        out[k] /= total


@njit(cache=True)
def bend(traces, goals, m, query, goal_x, goal_y, style, share, hand):
    """Bend trace m so that it starts at the hand and ends at a target that is at the goal.

    The path of the memory is moved by the difference of the two hands at its start and by that of
    the two targets at its end, in between by as much of each as is left of the way.

    Parameters
    ----------
    traces, goals : (n, KNOTS, 4), (n, 2) ndarray
    goal_x, goal_y : float
        Centre of the target when it is to be caught.
    style : int
        POLAR or CARTESIAN.
    share : (KNOTS,) ndarray
        Of `shares`.
    hand : (KNOTS + 1, 2) ndarray
        Where the knots are written.
    """
    n = traces.shape[1]
    near, width = query.near, query.far - query.near
    low = max(_HOLE, _HUB - near) / width
    low = min(low, query.ring)
    hand[0, 0], hand[0, 1] = query.x, query.y
    goal_r = np.sqrt(goal_x * goal_x + goal_y * goal_y)
    goal_a = query.side * (np.arctan2(goal_y, goal_x) - query.angle)
    first = query.ring - traces[m, 0, RING]
    around = _wrapped(goal_a - goals[m, 0])
    outward = (goal_r - near) / width - goals[m, 1]
    r_old = near + goals[m, 1] * width
    dx = goal_r * np.cos(goal_a) - r_old * np.cos(goals[m, 0])
    dy = goal_r * np.sin(goal_a) - r_old * np.sin(goals[m, 0])
    for k in range(1, n):
        w = share[k]
        a, u = np.float64(traces[m, k, ANGLE]), np.float64(traces[m, k, RING])
        if style == POLAR:
            a += w * around
            u += (1.0 - w) * first + w * outward
        else:
            r = near + u * width
            x = r * np.cos(a) + (1.0 - w) * first * width + w * dx
            y = r * np.sin(a) + w * dy
            a, u = np.arctan2(y, x), (np.sqrt(x * x + y * y) - near) / width
        r = near + min(max(u, low), 1.0 - 1e-9) * width
        a = query.angle + query.side * a
        hand[k, 0], hand[k, 1] = r * np.cos(a), r * np.sin(a)


@njit(cache=True)
def _pace(traces, m, query, tempo, hand, time):
    """Times of the knots: as early as the limits allow, and no wait cut short; the last one."""
    n = traces.shape[1]
    column = EARLIEST if tempo == HURRY else TIME
    time[0] = 0.0
    if query.shoulder > 0.0:
        turns = joint_turns(hand[:n], query.rho, query.side, PARTS)
    for k in range(1, n):
        dx, dy = hand[k, 0] - hand[k - 1, 0], hand[k, 1] - hand[k - 1, 1]
        least = np.sqrt(dx * dx + dy * dy) / query.speed
        if query.shoulder > 0.0:
            least = max(least, _JOINT_SLACK * turns[k - 1, 0] / query.shoulder)
            least = max(least, _JOINT_SLACK * turns[k - 1, 1] / query.elbow)
        time[k] = max(time[k - 1] + least * _SLACK, np.float64(traces[m, k, column]))
    return time[n - 1]


@njit(cache=True)
def _meet(traces, goals, m, query, b, style, tempo, share, poses, time, hand):
    """Bend trace m to where target b can be met and time it: the instant, or -1.

    The sooner the instant, the better; it is found by conservative advancement: a hand that comes
    late by some time needs at least that part of it in which hand and target can close the gap.
    The path's last knot is where the hand catches.
    """
    n = traces.shape[1]
    bodies = query.bodies
    closing = query.speed / (query.speed + bodies.rows[b, TOP_SPEED])
    t = query.soonest
    for _ in range(_TURNS):
        if t > query.horizon:
            return -1.0
        pose_at(bodies, b, t, poses)
        bend(traces, goals, m, query, poses[b, 0], poses[b, 1], style, share, hand)
        x, y, found = approach(
            bodies, poses, b, hand[n - 1, 0], hand[n - 1, 1], query.reach, query.far
        )
        if not found or x * x + y * y < query.near * query.near:
            t += query.horizon / _STRIDE
            continue
        hand[n - 1, 0], hand[n - 1, 1] = x, y
        late = _pace(traces, m, query, tempo, hand, time) - t
        if late <= 0.0:
            return t
        t += late if late < _CLOSE * query.horizon else max(late * closing, query.instant)
    return -1.0


@njit(cache=True)
def adapt(traces, goals, m, query, style, tempo, share, poses, time, hand, best_time, best_hand):
    """Bend trace m to the target that it can catch first.

    Parameters
    ----------
    share, poses, time, hand : ndarray
        Room for (KNOTS,), (bodies, 12), (KNOTS + 1,) and (KNOTS + 1, 2) numbers.
    best_time, best_hand : (KNOTS + 1,), (KNOTS + 1, 2) ndarray
        Where the path is written, cut where the hand comes within reach of any target.

    Returns
    -------
    count : int
        Samples of the path, 0 if no target can be met in time.
    body : int
    """
    n = traces.shape[1]
    shares(traces, m, query.near, query.far, share)
    best, bodies = -1.0, query.bodies
    for b in range(bodies.rows.shape[0]):
        if bodies.rows[b, PART] != HAND:
            continue
        t = _meet(traces, goals, m, query, b, style, tempo, share, poses, time, hand)
        if t < 0.0 or 0.0 <= best <= t:
            continue
        best = t
        for k in range(n):
            best_time[k], best_hand[k, 0], best_hand[k, 1] = time[k], hand[k, 0], hand[k, 1]
        best_time[n], best_hand[n, 0], best_hand[n, 1] = t, hand[n - 1, 0], hand[n - 1, 1]
    if best < 0.0:
        return 0, -1
    t, body = first_catch(bodies, best_time, best_hand, query.reach, 0.25 * query.instant)
    if body < 0:
        return 0, -1
    return _cut(best_time, best_hand, t), body


@njit(cache=True)
def _cut(time, hand, t):
    """End a path at an instant within it; the number of samples that are left."""
    k = 0
    while k < time.size - 1 and time[k] < t:
        k += 1
    if k > 0 and time[k] > t:
        s = (t - time[k - 1]) / (time[k] - time[k - 1])
        hand[k, 0] = hand[k - 1, 0] + s * (hand[k, 0] - hand[k - 1, 0])
        hand[k, 1] = hand[k - 1, 1] + s * (hand[k, 1] - hand[k - 1, 1])
        time[k] = t
    return k + 1


@njit(cache=True)
def _touches_at_a_look(query, time, hand, count):
    """Whether the limb touches an obstacle at one of the instants of the table.

    Necessary for a path to hold, and cheap: the bodies' poses are known.
    """
    instants, n = query.table.shape[0], query.bodies.rows.shape[0]
    step = query.horizon / (instants - 1)
    last = int(time[count - 1] / step)
    for phase in _ORDER:
        k = 0
        for g in range(phase, last + 1, 4):
            t = g * step
            while k < count - 2 and time[k + 1] < t:
                k += 1
            x, y = hand[k, 0], hand[k, 1]
            if count > 1 and time[k + 1] > time[k]:
                s = min((t - time[k]) / (time[k + 1] - time[k]), 1.0)
                x += s * (hand[k + 1, 0] - x)
                y += s * (hand[k + 1, 1] - y)
            ex, ey = elbow_of(x, y, query.rho, query.side)
            poses = query.table[g]
            for b in range(n):
                if query.bodies.rows[b, PART] == HAND:
                    continue
                if arm_distance(query.bodies, poses, b, x, y, ex, ey) <= query.floor:
                    return True
    return False


@njit(cache=True)
def check(query, time, hand, count):
    """What becomes of a path (its first `count` samples): HOLDS, TOUCHES or SINGULAR.

    The same test of the limb as that of every plan, after a coarse one that spares most of it.
    """
    if count > 1 and nearest_to_shoulder(hand[:count]) < max(query.near, 0.5 * _HUB):
        return SINGULAR
    if _touches_at_a_look(query, time, hand, count):
        return TOUCHES
    # With this resolution nothing is bisected that is sure to stay above the floor.
    distance, _ = least_distance(
        query.bodies, time[:count], hand[:count], query.rho, query.side, query.floor, 1e300
    )
    return HOLDS if distance > query.floor else TOUCHES


@njit(cache=True)
def transfer(traces, goals, chosen, query, style, tempo):
    """When memories, bent to a situation, catch in it.

    Parameters
    ----------
    traces, goals : (n, KNOTS, 4), (n, 2) ndarray of float32
        All memories.
    chosen : (m,) ndarray of int64
        Which of them to try.
    query : Query
    style, tempo : int

    Returns
    -------
    (m,) ndarray
        Catch times [s], negative where the bent path does not hold.
    """
    n, count = traces.shape[1], query.bodies.rows.shape[0]
    share, poses = np.empty(n), np.zeros((count, 12))
    time, hand = np.empty(n + 1), np.empty((n + 1, 2))
    best_time, best_hand = np.empty(n + 1), np.empty((n + 1, 2))
    out = np.full(chosen.size, -1.0)
    for i in range(chosen.size):
        samples, _ = adapt(
            traces, goals, chosen[i], query, style, tempo, share, poses, time, hand,
            best_time, best_hand,
        )  # fmt: skip
        if samples > 0 and check(query, best_time, best_hand, samples) == HOLDS:
            out[i] = best_time[samples - 1]
    return out


@njit(cache=True)
def first_that_holds(traces, goals, chosen, query, styles, tries, novelty):
    """Try memories in order until one holds.

    Parameters
    ----------
    traces, goals, chosen, query :
        As of `transfer`, the most promising first.
    styles : (s, 2) ndarray of int64
        Styles and tempos that each is tried in.
    tries : int
        Paths that are checked at most.
    novelty : float
        A path that stays this near to one that has failed is not checked [forearm lengths].

    Returns
    -------
    place : int
        Position in `chosen`, -1 if none holds.
    body : int
        The target that is caught.
    checked : int
        Paths that were checked.
    time, hand : (m,), (m, 2) ndarray
        The path that holds.
    """
    n, count = traces.shape[1], query.bodies.rows.shape[0]
    share, poses = np.empty(n), np.zeros((count, 12))
    time, hand = np.empty(n + 1), np.empty((n + 1, 2))
    best_time, best_hand = np.empty(n + 1), np.empty((n + 1, 2))
    failed = np.empty((tries, n + 1, 3))
    checked, kept = 0, 0
    for i in range(chosen.size):
        for s in range(styles.shape[0]):
            if checked >= tries:
                return -1, -1, checked, best_time[:0], best_hand[:0]
            samples, body = adapt(
                traces, goals, chosen[i], query, styles[s, 0], styles[s, 1], share, poses, time,
                hand, best_time, best_hand,
            )  # fmt: skip
            if samples == 0:
                if novelty <= 0.0:
                    checked += 1
                continue
            if novelty > 0.0 and _known(failed, kept, query, best_time, best_hand, samples, novelty):
                continue
            checked += 1
            if check(query, best_time, best_hand, samples) == HOLDS:
                return i, body, checked, best_time[:samples], best_hand[:samples]
            _keep(failed, kept, query, best_time, best_hand, samples)
            kept += 1
    return -1, -1, checked, best_time[:0], best_hand[:0]


@njit(cache=True)
def _keep(failed, row, query, time, hand, count):
    """Note a path; samples that it does not have are its last one."""
    for k in range(failed.shape[1]):
        j = min(k, count - 1)
        failed[row, k, 0], failed[row, k, 1] = hand[j, 0], hand[j, 1]
        failed[row, k, 2] = query.speed * time[j]


@njit(cache=True)
def _known(failed, rows, query, time, hand, count, novelty):
    """Whether one of the noted paths is everywhere as near as `novelty`, time included."""
    limit = novelty * novelty
    for row in range(rows):
        apart = 0.0
        for k in range(failed.shape[1]):
            j = min(k, count - 1)
            d2 = (failed[row, k, 0] - hand[j, 0]) ** 2 + (failed[row, k, 1] - hand[j, 1]) ** 2
            apart = max(apart, d2 + (failed[row, k, 2] - query.speed * time[j]) ** 2)
            if apart > limit:
                break
        if apart <= limit:
            return True
    return False


