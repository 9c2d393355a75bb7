"""Remembered paths bent to a new situation, and timed.

A trace is a path in polar coordinates about the shoulder, in the frame in which the hand starts in
direction 0 and the elbow is on the right: `KNOTS` rows (angle, share of the ring, time, earliest).
What a kernel writes is in the arm-plane coordinates of the situation that it is given.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.compiled import njit
from gcm_learn.motion.interception import approach, target_distance
from gcm_learn.motion.rules import Rules
from gcm_learn.motion.verification import PARTS, joint_turns
from gcm_learn.scene.bodies import HAND, PART, REACH, TOP_SPEED, pose_at
from gcm_learn.scene.scene import Scene

KNOTS = 24  # of a trace, see `gcm_learn.recall.waypoints`
ANGLE, RING, TIME, EARLIEST = range(4)  # columns of a knot
POLAR, CARTESIAN = 0, 1  # in which coordinates paths are bent
HURRY, KEEP = 0, 1  # waits are kept and the rest is hurried, or all times are kept

_TURNS = 60  # instants of interception that are tried at most
_LONGEST = 60.0  # times the lateness that a step may be long
_STRIDE = 48.0  # steps in a horizon while there is no target to be met
_CLOSE = 1e-3  # share of the horizon within which the instant is found
_SLACK = 1.0 + 2e-9  # against rounding of the speed limits
_JOINT_SLACK = 1.01  # joint speeds vary within the pieces on which they are measured
_PARTS = 4 * PARTS  # of a piece between knots, which plans cut finer
_HOLE = 2e-3  # distance that paths keep from the hole of the ring [forearm lengths]
_RIM = 4e-3  # share of the ring that joints with limits keep from the outer rim, where they race
HUB = 0.03  # distance that paths keep from the shoulder, where joints jump [forearm lengths]


class Query(NamedTuple):
    """What an adaptation must know of a situation."""

    scene: Scene
    rules: Rules
    table: np.ndarray  # (g, n, 12): poses of all bodies at g instants from 0 to the horizon
    angle: float  # direction of the hand at t = 0 [rad]
    ring: float  # its share of the ring: 0 at the inner rim, 1 at the outer one
    soonest: float  # no movement can catch before [s]


class Desk(NamedTuple):
    """Room for one adaptation after the other."""

    share: np.ndarray  # (KNOTS,)
    base: np.ndarray  # (KNOTS, 2)
    poses: np.ndarray  # (n, 12)
    time: np.ndarray  # (KNOTS + 1,)
    hand: np.ndarray  # (KNOTS + 1, 2)
    best_time: np.ndarray  # (KNOTS + 1,)
    best_hand: np.ndarray  # (KNOTS + 1, 2)


@njit
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


@njit
def _wrapped(angle):
    """An angle within [-pi, pi]."""
    return angle - 2.0 * np.pi * np.round(angle / (2.0 * np.pi))


@njit(_nrt=False)
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


@njit(_nrt=False)
def _lay(traces, m, query, style, share, base):
    """Trace m with its start moved to the hand: (angle, share) or, bent in x and y, (x, y)."""
    n = traces.shape[1]
    width = query.scene.limb.far - query.scene.limb.near
    first = query.ring - traces[m, 0, RING]
    for k in range(n):
        a, u = np.float64(traces[m, k, ANGLE]), np.float64(traces[m, k, RING])
        left = (1.0 - share[k]) * first
        if style == POLAR:
            base[k, 0], base[k, 1] = a, u + left
        else:
            r = query.scene.limb.near + u * width
            base[k, 0], base[k, 1] = r * np.cos(a) + left * width, r * np.sin(a)


@njit(_nrt=False)
def _ends_by(goals, m, query, goal_x, goal_y, style):
    """By how much the end of memory m has to be moved when the target is at the goal."""
    width = query.scene.limb.far - query.scene.limb.near
    r = np.sqrt(goal_x * goal_x + goal_y * goal_y)
    a = query.scene.limb.side * (np.arctan2(goal_y, goal_x) - query.angle)
    if style == POLAR:
        return _wrapped(a - goals[m, 0]), (r - query.scene.limb.near) / width - goals[m, 1]
    old = query.scene.limb.near + goals[m, 1] * width
    return (
        r * np.cos(a) - old * np.cos(np.float64(goals[m, 0])),
        r * np.sin(a) - old * np.sin(np.float64(goals[m, 0])),
    )


@njit(_nrt=False)
def _lowest(query):
    """Share of the ring below which no path is bent."""
    low = max(_HOLE, HUB - query.scene.limb.near) / (query.scene.limb.far - query.scene.limb.near)
    return min(low, query.ring)


@njit(_nrt=False)
def _highest(query):
    """Share of the ring above which no path is bent."""
    high = 1.0 - _RIM if query.scene.limits.shoulder < np.inf else 1.0 - 1e-9
    return max(high, query.ring)


@njit(_nrt=False)
def bend(base, query, style, share, end, hand):
    """Write a path that starts at the hand and whose end is moved.

    The path of the memory is moved by the difference of the two hands at its start and by that of
    the two targets at its end, in between by as much of each as is left of the way.

    Parameters
    ----------
    base : (KNOTS, 2) ndarray
        Of `_lay`.
    style : int
        POLAR or CARTESIAN.
    share : (KNOTS,) ndarray
        Of `shares`.
    end : (float, float)
        Of `_ends_by`.
    hand : (KNOTS + 1, 2) ndarray
        Where the knots are written, in the situation's coordinates.
    """
    near, width = query.scene.limb.near, query.scene.limb.far - query.scene.limb.near
    low, high = _lowest(query), _highest(query)
    hand[0, 0], hand[0, 1] = query.scene.limb.x, query.scene.limb.y
    for k in range(1, base.shape[0]):
        a, u = base[k, 0] + share[k] * end[0], base[k, 1] + share[k] * end[1]
        if style != POLAR:
            a, u = np.arctan2(u, a), (np.sqrt(a * a + u * u) - near) / width
        r = near + min(max(u, low), high) * width
        a = query.angle + query.scene.limb.side * a
        hand[k, 0], hand[k, 1] = r * np.cos(a), r * np.sin(a)


@njit(_nrt=False)
def _soonest_end(traces, m, query, tempo, style, base, share, end):
    """When a path whose end is so moved can be at its end: nearly, and without trigonometry."""
    column = EARLIEST if tempo == HURRY else TIME
    near, width = query.scene.limb.near, query.scene.limb.far - query.scene.limb.near
    low = _lowest(query)
    slowness = 1.0 / query.rules.speed
    a0, r0, t = base[0, 0], base[0, 1], 0.0
    if style == POLAR:
        r0 = near + r0 * width
    for k in range(1, base.shape[0]):
        a, r = base[k, 0] + share[k] * end[0], base[k, 1] + share[k] * end[1]
        if style == POLAR:
            r = near + min(max(r, low), 1.0) * width
            turn2 = (a - a0) ** 2  # the law of cosines, the cosine by its series
            way2 = (r - r0) ** 2 + r * r0 * turn2 * (1.0 - turn2 / 12.0)
        else:
            way2 = (a - a0) ** 2 + (r - r0) ** 2
        t = max(t + np.sqrt(max(way2, 0.0)) * slowness, np.float64(traces[m, k, column]))
        a0, r0 = a, r
    return t


@njit
def _pace(traces, m, query, tempo, hand, time):
    """Times of the knots: as early as the limits allow, and no wait cut short; the last one."""
    n = traces.shape[1]
    column = EARLIEST if tempo == HURRY else TIME
    time[0] = 0.0
    if query.scene.limits.shoulder < np.inf:
        turns = joint_turns(hand[:n], query.scene.limb.rho, query.scene.limb.side, _PARTS)
    for k in range(1, n):
        dx, dy = hand[k, 0] - hand[k - 1, 0], hand[k, 1] - hand[k - 1, 1]
        least = np.sqrt(dx * dx + dy * dy) / query.rules.speed
        if query.scene.limits.shoulder < np.inf:
            least = max(least, _JOINT_SLACK * turns[k - 1, 0] / query.scene.limits.shoulder)
            least = max(least, _JOINT_SLACK * turns[k - 1, 1] / query.scene.limits.elbow)
        time[k] = max(time[k - 1] + least * _SLACK, np.float64(traces[m, k, column]))
    return time[n - 1]


@njit(_nrt=False)
def _away(query, b, poses, t):
    """How long target b surely stays out of reach, of the ring or of a straight hand [s]."""
    size = query.scene.bodies.rows[b, REACH] + query.rules.catch
    x, y = poses[b, 0], poses[b, 1]
    top = query.scene.bodies.rows[b, TOP_SPEED]
    ring = np.sqrt(x * x + y * y) - size - query.scene.limb.far
    limb, speed = query.scene.limb, query.rules.speed
    way = np.sqrt((x - limb.x) ** 2 + (y - limb.y) ** 2) - size - speed * t
    wait = way / (speed + top)
    if ring > 0.0:
        wait = max(wait, ring / top if top > 0.0 else 1e300)
    return wait


@njit
def meet(traces, goals, m, query, b, style, tempo, desk):
    """Bend trace m to where target b can be met and time it: the instant, or -1.

    The sooner the instant, the better; it is found by conservative advancement: a hand that comes
    late by some time needs at least that part of it in which hand and target can close the gap.
    Most of the advance is made on lengths alone. The path's last knot is where the hand catches.
    """
    n = traces.shape[1]
    bodies = query.scene.bodies
    closing = query.rules.speed / (query.rules.speed + bodies.rows[b, TOP_SPEED])
    close = _CLOSE * query.scene.limits.horizon
    limb = query.scene.limb
    rim = limb.near + min(_highest(query), 1.0) * (limb.far - limb.near)
    t, rough = query.soonest, True
    before, late_before = -1.0, 0.0
    for _ in range(_TURNS):
        if t > query.scene.limits.horizon:
            return -1.0
        pose_at(bodies, b, t, desk.poses)
        away = _away(query, b, desk.poses, t)
        if away > close:
            t, before = t + away, -1.0
            continue
        end = _ends_by(goals, m, query, desk.poses[b, 0], desk.poses[b, 1], style)
        if rough:
            late = _soonest_end(traces, m, query, tempo, style, desk.base, desk.share, end) - t
            rough = late > close
        if not rough:
            bend(desk.base, query, style, desk.share, end, desk.hand)
            x, y, found = approach(
                bodies, desk.poses, b, desk.hand[n - 1, 0], desk.hand[n - 1, 1], query.rules.catch,
                rim,
            )  # fmt: skip
            if not found or x * x + y * y < query.scene.limb.near * query.scene.limb.near:
                t, before, rough = t + query.scene.limits.horizon / _STRIDE, -1.0, True
                continue
            desk.hand[n - 1, 0], desk.hand[n - 1, 1] = x, y
            late = _pace(traces, m, query, tempo, desk.hand, desk.time) - t
            if late <= 0.0:
                return t
        step = late * closing
        if before >= 0.0 and late < late_before:  # the secant, where hand gains on target
            step = max(step, late * min((t - before) / (late_before - late), _LONGEST))
        before, late_before = t, late
        t += max(step, query.rules.instant)
    return -1.0


@njit
def desk_for(query):
    """Room for adaptations to a situation."""
    return Desk(
        np.empty(KNOTS),
        np.empty((KNOTS, 2)),
        np.zeros((query.scene.bodies.rows.shape[0], 12)),
        np.empty(KNOTS + 1),
        np.empty((KNOTS + 1, 2)),
        np.empty(KNOTS + 1),
        np.empty((KNOTS + 1, 2)),
    )


@njit
def adapt(traces, goals, m, query, style, tempo, desk):
    """Bend trace m to the target that it can catch first.

    The path is written into `desk.best_time` and `desk.best_hand`, and ends at the first knot at
    which the hand is within reach of any target.

    Returns
    -------
    count : int
        Samples of the path, 0 if no target can be met in time.
    body : int
    """
    shares(traces, m, query.scene.limb.near, query.scene.limb.far, desk.share)
    _lay(traces, m, query, style, desk.share, desk.base)
    best, body, bodies = -1.0, -1, query.scene.bodies
    for b in range(bodies.rows.shape[0]):
        if bodies.rows[b, PART] != HAND:
            continue
        t = meet(traces, goals, m, query, b, style, tempo, desk)
        if t < 0.0 or 0.0 <= best <= t:
            continue
        best, body = t, b
        keep(desk, t)
    if best < 0.0:
        return 0, -1
    return _first_knot_at_a_target(query, desk, body)


@njit(_nrt=False)
def keep(desk, t):
    """Keep the path that was just bent and timed as the best, with the hand at its end until t."""
    n = desk.hand.shape[0] - 1
    for k in range(n):
        desk.best_time[k] = desk.time[k]
        desk.best_hand[k, 0], desk.best_hand[k, 1] = desk.hand[k, 0], desk.hand[k, 1]
    desk.best_time[n] = t
    desk.best_hand[n, 0], desk.best_hand[n, 1] = desk.hand[n - 1, 0], desk.hand[n - 1, 1]


@njit
def _first_knot_at_a_target(query, desk, body):
    """Samples of the best path until a target is within reach, and that target."""
    bodies, count = query.scene.bodies, desk.best_time.size
    for k in range(count - 1):
        x, y = desk.best_hand[k, 0], desk.best_hand[k, 1]
        for b in range(bodies.rows.shape[0]):
            if bodies.rows[b, PART] != HAND:
                continue
            pose_at(bodies, b, desk.best_time[k], desk.poses)
            dx, dy = x - desk.poses[b, 0], y - desk.poses[b, 1]
            limit = query.rules.catch + bodies.rows[b, REACH]
            if dx * dx + dy * dy > limit * limit:
                continue
            if target_distance(bodies, desk.poses, b, x, y) <= query.rules.catch:
                return k + 1, b
    return count, body
