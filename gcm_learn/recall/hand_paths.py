"""Kernels of remembered hand paths: load, move, time and check them.

A remembered path lies in polar coordinates about the shoulder, in a frame of its own. There the
hand starts in direction 0 and the elbow is on the right. It has `KNOTS` rows (angle, share of the
ring, time, earliest). Kernels write in the arm-plane coordinates of the situation.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.collision.sweep import least_distance
from gcm_learn.compiled import njit
from gcm_learn.motion.interception import approach
from gcm_learn.motion.rules import Rules
from gcm_learn.motion.verification import PARTS, joint_turns, nearest_to_shoulder
from gcm_learn.recall.styles import HURRY, POLAR, Chase
from gcm_learn.scene import Scene
from gcm_learn.scene.bodies import HAND, PART, REACH, TOP_SPEED, pose_at
from gcm_learn.scene.shapes.choice import gap_in_plane

KNOTS = 24  # of a remembered path, see `gcm_learn.recall.waypoints`
ANGLE, RING, TIME, EARLIEST = range(4)  # columns of a knot

_TRIALS = 60  # instants of interception that are tried at most
_STRIDE = 48.0  # steps in a horizon while there is no target to be met
_CLOSE = 1e-3  # share of the horizon within which the instant is found
_SLACK = 1.0 + 2e-9  # against rounding of the speed limits
_JOINT_SLACK = 1.01  # joint speeds vary within the pieces on which they are measured
_PARTS = 4 * PARTS  # of a piece between knots, which plans cut finer
_HOLE = 2e-3  # distance that paths keep from the hole of the ring [forearm lengths]
_RIM = 4e-3  # share of the ring that joints with limits keep from the outer rim, where they race
HUB = 0.03  # distance that paths keep from the shoulder, where joints jump [forearm lengths]


class HandQuery(NamedTuple):
    """Situation in the form that adaptations of hand paths take."""

    scene: Scene
    rules: Rules
    table: np.ndarray  # (g, n, 12): poses at g instants from 0 to the horizon; nan if not asked yet
    angle: float  # direction of the hand at t = 0 [rad]
    ring: float  # its share of the ring: 0 at the inner rim, 1 at the outer one
    soonest: float  # no movement can catch before [s]


class HandWork(NamedTuple):
    """Buffers of the kernels, reused by every adaptation."""

    knots: np.ndarray  # (KNOTS, 4) float32: the remembered path
    wanted: np.ndarray  # (KNOTS,) float32: earliest times at the knots [s]
    goal: np.ndarray  # (2,) float32: direction and share of its target
    share: np.ndarray  # (KNOTS,): of its length that lies behind it
    base: np.ndarray  # (KNOTS, 2): the path with its start moved to the hand
    poses: np.ndarray  # (n, 12)
    time: np.ndarray  # (KNOTS,): the path that was adapted last
    hand: np.ndarray  # (KNOTS, 2)
    best_time: np.ndarray  # (KNOTS + 1,): the best path so far
    best_hand: np.ndarray  # (KNOTS + 1, 2)
    from_base: np.ndarray  # (KNOTS, 2): base of the path before a change
    from_wanted: np.ndarray  # (KNOTS,)
    least_base: np.ndarray  # (KNOTS, 2): base of the change with the least contact
    least_wanted: np.ndarray  # (KNOTS,)


@njit
def hand_work(query):
    """Return buffers for adaptations to a situation."""
    return HandWork(
        np.empty((KNOTS, 4), dtype=np.float32),
        np.empty(KNOTS, dtype=np.float32),
        np.empty(2, dtype=np.float32),
        np.empty(KNOTS),
        np.empty((KNOTS, 2)),
        np.zeros((query.scene.bodies.rows.shape[0], 12)),
        np.empty(KNOTS),
        np.empty((KNOTS, 2)),
        np.empty(KNOTS + 1),
        np.empty((KNOTS + 1, 2)),
        np.empty((KNOTS, 2)),
        np.empty(KNOTS),
        np.empty((KNOTS, 2)),
        np.empty(KNOTS),
    )


@njit
def _wrapped(angle):
    """An angle within [-pi, pi]."""
    return angle - 2.0 * np.pi * np.round(angle / (2.0 * np.pi))


@njit
def bodies_of(query):
    """Return the bodies of a situation."""
    return query.scene.bodies


@njit(_nrt=False)
def load(query, paths, m, style, work):
    """Copy memory m into the workspace, and move its start to the hand.

    Parameters
    ----------
    query : HandQuery
    paths : ((n, KNOTS, 4), (n, 2)) ndarrays of float32
        Knots and goals of all memories.
    m : int
    style : Style
    work : HandWork
    """
    knots, goals = paths
    for k in range(KNOTS):
        for a in range(4):
            work.knots[k, a] = knots[m, k, a]
        work.wanted[k] = knots[m, k, EARLIEST if style.tempo == HURRY else TIME]
    work.goal[0], work.goal[1] = goals[m, 0], goals[m, 1]
    _measure(query, work)
    _move_start(query, style, work)


@njit(_nrt=False)
def _measure(query, work):
    """Write the share of the path's length that lies before each knot.

    A path without length is shared out by time.
    """
    near, far = query.scene.limb.near, query.scene.limb.far
    knots, out = work.knots, work.share
    out[0] = 0.0
    for k in range(1, KNOTS):
        r0 = near + knots[k - 1, RING] * (far - near)
        r1 = near + knots[k, RING] * (far - near)
        turn = knots[k, ANGLE] - knots[k - 1, ANGLE]
        out[k] = out[k - 1] + np.sqrt((r1 - r0) ** 2 + max(r0 * r1, 0.0) * turn * turn)
    total = out[KNOTS - 1]
    if total < 1e-6:
        last = max(knots[KNOTS - 1, TIME], 1e-9)
        for k in range(KNOTS):
            out[k] = knots[k, TIME] / last
        out[KNOTS - 1] = 1.0
        return
    for k in range(KNOTS):
        out[k] /= total


@njit(_nrt=False)
def _move_start(query, style, work):
    """Move the path's start to the hand: base is (angle, share) or, by x and y, (x, y)."""
    near, width = query.scene.limb.near, query.scene.limb.far - query.scene.limb.near
    first = query.ring - work.knots[0, RING]
    for k in range(KNOTS):
        a, u = np.float64(work.knots[k, ANGLE]), np.float64(work.knots[k, RING])
        left = (1.0 - work.share[k]) * first
        if style.space == POLAR:
            work.base[k, 0], work.base[k, 1] = a, u + left
        else:
            r = near + u * width
            work.base[k, 0], work.base[k, 1] = r * np.cos(a) + left * width, r * np.sin(a)


@njit(_nrt=False)
def _ends_by(query, style, work, goal_x, goal_y):
    """Return the move of the path's end: offset from the remembered target to the goal (x, y)."""
    limb, goal = query.scene.limb, work.goal
    width = limb.far - limb.near
    r = np.sqrt(goal_x * goal_x + goal_y * goal_y)
    a = limb.side * (np.arctan2(goal_y, goal_x) - query.angle)
    if style.space == POLAR:
        return _wrapped(a - goal[0]), (r - limb.near) / width - goal[1]
    old = limb.near + goal[1] * width
    return (
        r * np.cos(a) - old * np.cos(np.float64(goal[0])),
        r * np.sin(a) - old * np.sin(np.float64(goal[0])),
    )


@njit(_nrt=False)
def _lowest(query):
    """Share of the ring below which no path is adapted."""
    low = max(_HOLE, HUB - query.scene.limb.near) / (query.scene.limb.far - query.scene.limb.near)
    return min(low, query.ring)


@njit(_nrt=False)
def _highest(query):
    """Share of the ring above which no path is adapted."""
    high = 1.0 - _RIM if query.scene.limits.shoulder < np.inf else 1.0 - 1e-9
    return max(high, query.ring)


@njit(_nrt=False)
def _move_end(query, style, work, end):
    """Write the path from the hand, with its end moved by `end`, in the situation's frame.

    The start moves by the difference of the two hands, the end by that of the two targets. In
    between both moves are weighted by the share of the path's length.
    """
    near, width = query.scene.limb.near, query.scene.limb.far - query.scene.limb.near
    low, high = _lowest(query), _highest(query)
    base, share, hand = work.base, work.share, work.hand
    hand[0, 0], hand[0, 1] = query.scene.limb.x, query.scene.limb.y
    for k in range(1, KNOTS):
        a, u = base[k, 0] + share[k] * end[0], base[k, 1] + share[k] * end[1]
        if style.space != POLAR:
            a, u = np.arctan2(u, a), (np.sqrt(a * a + u * u) - near) / width
        r = near + min(max(u, low), high) * width
        a = query.angle + query.scene.limb.side * a
        hand[k, 0], hand[k, 1] = r * np.cos(a), r * np.sin(a)


@njit(_nrt=False)
def _soonest_end(query, style, work, end):
    """Estimate the earliest arrival [s] of the path with its end moved by `end`, by lengths."""
    near, width = query.scene.limb.near, query.scene.limb.far - query.scene.limb.near
    base, share, low = work.base, work.share, _lowest(query)
    slowness = 1.0 / query.rules.speed
    a0, r0, t = base[0, 0], base[0, 1], 0.0
    if style.space == POLAR:
        r0 = near + r0 * width
    for k in range(1, KNOTS):
        a, r = base[k, 0] + share[k] * end[0], base[k, 1] + share[k] * end[1]
        if style.space == POLAR:
            r = near + min(max(r, low), 1.0) * width
            turn2 = (a - a0) ** 2  # the law of cosines, the cosine by its series
            way2 = (r - r0) ** 2 + r * r0 * turn2 * (1.0 - turn2 / 12.0)
        else:
            way2 = (a - a0) ** 2 + (r - r0) ** 2
        t = max(t + np.sqrt(max(way2, 0.0)) * slowness, np.float64(work.wanted[k]))
        a0, r0 = a, r
    return t


@njit
def _pace(query, work):
    """Write the times of the knots, as early as limits and waits allow; return the last time."""
    limb, limits, hand, time = query.scene.limb, query.scene.limits, work.hand, work.time
    time[0] = 0.0
    if limits.shoulder < np.inf:
        turns = joint_turns(hand, limb.rho, limb.side, _PARTS)
    for k in range(1, KNOTS):
        dx, dy = hand[k, 0] - hand[k - 1, 0], hand[k, 1] - hand[k - 1, 1]
        least = np.sqrt(dx * dx + dy * dy) / query.rules.speed
        if limits.shoulder < np.inf:
            least = max(least, _JOINT_SLACK * turns[k - 1, 0] / limits.shoulder)
            least = max(least, _JOINT_SLACK * turns[k - 1, 1] / limits.elbow)
        time[k] = max(time[k - 1] + least * _SLACK, np.float64(work.wanted[k]))
    return time[KNOTS - 1]


@njit(_nrt=False)
def _away(query, b, poses, t):
    """Return for how long target b stays out of reach of ring and straight hand [s]."""
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


@njit(_nrt=False)
def chase(query, b, _since):
    """Return the settings of the search for the instant at which target b is met."""
    horizon, speed = query.scene.limits.horizon, query.rules.speed
    top = query.scene.bodies.rows[b, TOP_SPEED]
    return Chase(
        query.soonest,
        speed,
        horizon,
        speed / (speed + top),
        _CLOSE * horizon,
        horizon / _STRIDE,
        query.rules.instant,
        _TRIALS,
    )


@njit(_nrt=False)
def away(query, b, t, _speed, work):
    """Return for how long target b surely stays out of reach of ring and straight hand [s]."""
    pose_at(query.scene.bodies, b, t, work.poses)
    return _away(query, b, work.poses, t)


@njit
def lateness(query, b, t, rough, close, style, work):
    """Adapt the path to target b at t [s]; while far too late, compare lengths only.

    Returns
    -------
    late : float
        Time by which the hand comes late [s].
    rough : bool
        True if only lengths were compared.
    found : bool
        False if no hand near the path's end catches.
    """
    last, bodies, limb, hand = KNOTS - 1, query.scene.bodies, query.scene.limb, work.hand
    late, end = 0.0, _ends_by(query, style, work, work.poses[b, 0], work.poses[b, 1])
    if rough:
        late = _soonest_end(query, style, work, end) - t
        rough = late > close
    if not rough:
        _move_end(query, style, work, end)
        catch = query.rules.catch
        rim = limb.near + min(_highest(query), 1.0) * (limb.far - limb.near)
        x, y, found = approach(bodies, work.poses, b, hand[last, 0], hand[last, 1], catch, rim)
        if not found or x * x + y * y < limb.near * limb.near:
            return 0.0, True, False
        hand[last, 0], hand[last, 1] = x, y
        late = _pace(query, work) - t
    return late, rough, True


@njit(_nrt=False)
def keep(work, t, _body):
    """Keep the adapted path as the best, at rest from its end to t [s]; return the sample count."""
    for k in range(KNOTS):
        work.best_time[k] = work.time[k]
        work.best_hand[k, 0], work.best_hand[k, 1] = work.hand[k, 0], work.hand[k, 1]
    work.best_time[KNOTS] = t
    work.best_hand[KNOTS, 0] = work.hand[KNOTS - 1, 0]
    work.best_hand[KNOTS, 1] = work.hand[KNOTS - 1, 1]
    return KNOTS + 1


@njit
def cut(query, work, body):
    """Return the number of samples until a target is within reach of the hand, and the target."""
    bodies, catch = query.scene.bodies, query.rules.catch
    for k in range(KNOTS):
        x, y = work.best_hand[k, 0], work.best_hand[k, 1]
        for b in range(bodies.rows.shape[0]):
            if bodies.rows[b, PART] != HAND:
                continue
            pose_at(bodies, b, work.best_time[k], work.poses)
            dx, dy = x - work.poses[b, 0], y - work.poses[b, 1]
            limit = catch + bodies.rows[b, REACH]
            if dx * dx + dy * dy > limit * limit:
                continue
            if gap_in_plane(bodies, work.poses, b, x, y) <= catch:
                return k + 1, b
    return KNOTS + 1, body


@njit
def check(query, work, count, body):
    """Check the limb on the first samples of the best path.

    Returns
    -------
    count : int
        Samples of the path.
    free : bool
        True if the limb is free and the hand keeps out of the hole of the ring.
    body : int
        Target at its end.
    """
    time, hand, floor = work.best_time[:count], work.best_hand[:count], query.rules.touch
    if count > 1 and nearest_to_shoulder(hand) < max(query.scene.limb.near, 0.5 * HUB):
        return count, False, body
    return count, least_distance(query.scene, time, hand, floor, np.inf)[0] > floor, body


@njit
def failures(_query, most):
    """Return an array that holds `most` paths."""
    return np.empty((most, KNOTS + 1, 3))


@njit(_nrt=False)
def note(query, row, work, count):
    """Write the first `count` samples of the best path into `row`; repeat the last to fill it."""
    for k in range(KNOTS + 1):
        j = min(k, count - 1)
        row[k, 0], row[k, 1] = work.best_hand[j, 0], work.best_hand[j, 1]
        row[k, 2] = query.rules.speed * work.best_time[j]


@njit(_nrt=False)
def is_near(query, row, work, count, novelty):
    """Return whether the best path stays within `novelty` of the path in `row`, time included."""
    limit, speed = novelty * novelty, query.rules.speed
    time, hand, apart = work.best_time, work.best_hand, 0.0
    for k in range(KNOTS + 1):
        j = min(k, count - 1)
        d2 = (row[k, 0] - hand[j, 0]) ** 2 + (row[k, 1] - hand[j, 1]) ** 2
        apart = max(apart, d2 + (row[k, 2] - speed * time[j]) ** 2)
        if apart > limit:
            return False
    return True
