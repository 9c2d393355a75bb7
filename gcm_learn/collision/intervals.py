"""Safe intervals: when a limb at rest in a cell is touched, free again, or met by a target.

All by conservative advancement, and only for the cells that are asked about.  Times in seconds.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.collision.distance import room_at
from gcm_learn.collision.occupancy import first_touch, passes_by
from gcm_learn.compiled import njit
from gcm_learn.scene.bodies import HAND, PART, REACH, TOP_SPEED, drift, pose_at

NEVER = 1e300
INSTANTS = 24  # at which targets are sampled, to bound how long a place is of use


@njit
def next_free(postures, m, t, end, step):
    """Find the first moment from t [s] on at which the limb of cell m is free, or NEVER.

    Searched in steps of `step` [s], longer where the depth in the gap allows it.
    """
    bodies, limb, gap, scratch = postures.bodies, postures.limb, postures.gap[m], postures.scratch
    hx, hy, ex, ey = limb[m, 0], limb[m, 1], limb[m, 2], limb[m, 3]
    count = bodies.rows.shape[0]
    clear, b = 0, 0
    while clear < count:  # until every body in turn has been found clear at the same moment
        if bodies.rows[b, PART] != HAND:
            speed = bodies.rows[b, TOP_SPEED]
            room = room_at(bodies, b, t, hx, hy, ex, ey, gap, scratch)
            while room <= 0.0:
                if speed == 0.0:
                    return NEVER
                # Inside a body the distance is cut off at 0, and the whole gap has to pass.
                t += max(step, -room / speed)
                clear = 0
                if t > end:
                    return NEVER
                room = room_at(bodies, b, t, hx, hy, ex, ey, gap, scratch)
        clear += 1
        b = b + 1 if b + 1 < count else 0
    return t


@njit
def target_ways(bodies, gap, end):
    """Sample the places of targets at INSTANTS over [0, end], for `last_use`.

    Returns
    -------
    (INSTANTS + 1, targets, 4) ndarray
        Centre, and from what distance of it a hand meets the target around that instant.
    """
    count = bodies.rows.shape[0]
    ways = np.empty((INSTANTS + 1, count, 4))
    poses = np.zeros((count, 12))
    step, targets = end / INSTANTS, 0
    for b in range(count):
        if bodies.rows[b, PART] != HAND:
            continue
        for i in range(INSTANTS + 1):
            pose_at(bodies, b, step * i, poses)
            early, late = step * max(i - 1, 0), step * min(i + 1, INSTANTS)
            for a in range(3):
                ways[i, targets, a] = poses[b, a]
            ways[i, targets, 3] = gap + bodies.rows[b, REACH] + drift(bodies, b, early, late)
        targets += 1
    return ways[:, :targets]


@njit
def last_use(ways, end, speed, x, y, z=0.0):
    """Last moment at which a hand at (x, y, z) may still meet a target before `end` [s].

    -1 if it cannot at all; never too early.
    """
    last, step = -1.0, end / INSTANTS
    for i in range(ways.shape[0]):
        late = min(step * (i + 1), end)
        for b in range(ways.shape[1]):
            dx, dy, dz = x - ways[i, b, 0], y - ways[i, b, 1], z - ways[i, b, 2]
            away = np.sqrt(dx * dx + dy * dy + dz * dz) - ways[i, b, 3]
            last = max(last, late - max(away, 0.0) / speed)
    return last


@njit
def shorten(postures, cells, since, until, count, shortest):
    """Lower `until` to the first touch of each cell that is free at `since`."""
    bodies, limb, gap, _, scratch = postures
    for b in range(bodies.rows.shape[0]):
        if bodies.rows[b, PART] == HAND or bodies.rows[b, TOP_SPEED] == 0.0:
            continue
        for i in range(count):
            m = cells[i]
            hx, hy, ex, ey = limb[m, 0], limb[m, 1], limb[m, 2], limb[m, 3]
            if passes_by(bodies, b, hx, hy, ex, ey, gap[m], since[i], until[i], scratch):
                continue
            t = first_touch(
                bodies, b, hx, hy, ex, ey, gap[m], since[i], until[i], shortest, scratch
            )
            if t >= 0.0:
                until[i] = t


@njit
def meet(postures, gap, cells, since, until, count, shortest, best):
    """Find the earliest time at which a target comes to one of the cells in its safe interval.

    A target comes when it is within `gap` of the hand; times from `best` on do not count.
    Returns (index or -1, body, time [s]).
    """
    bodies, limb, _, _, scratch = postures
    index, body = -1, -1
    for b in range(bodies.rows.shape[0]):
        if bodies.rows[b, PART] != HAND:
            continue
        for i in range(count):
            end = min(until[i], best)
            if since[i] > end:
                continue
            hx, hy = limb[cells[i], 0], limb[cells[i], 1]
            if passes_by(bodies, b, hx, hy, hx, hy, gap, since[i], end, scratch):
                continue
            t = first_touch(bodies, b, hx, hy, hx, hy, gap, since[i], end, shortest, scratch)
            if t >= 0.0 and t < best:
                index, body, best = i, b, t
    return index, body, best
