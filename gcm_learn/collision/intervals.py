"""Safe intervals: when a limb at rest in a cell is touched, free again, or met by a target.

All by conservative advancement, and only for the cells that are asked about.  Times in seconds.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.collision.distance import room_at, segment_point2, segments_distance2
from gcm_learn.collision.occupancy import first_touch
from gcm_learn.compiled import njit
from gcm_learn.scene.bodies import ACCELERATION, HAND, PART, REACH, SWING, TOP_SPEED, drift, pose_at

NEVER = 1e300
INSTANTS = 24  # at which targets are looked at to tell how long a place is of use


@njit
def next_free(postures, m, t, end, step):
    """First moment from t [s] on at which no obstacle is near the limb of cell m; NEVER if none.

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
def way_of(bodies, b, t0, t1, scratch, chord):
    """Bound where body b goes in [t0, t1]: chord (4,) of its centre and how far it gets from it.

    A quadratic motion departs from its chord by at most |a| (t1 - t0)^2 / 8.  The body's reach is
    included; a pendulum is not bounded (NEVER).
    """
    if bodies.rows[b, SWING] >= 0.0:
        return NEVER
    pose_at(bodies, b, t0, scratch)
    chord[0], chord[1] = scratch[b, 0], scratch[b, 1]
    pose_at(bodies, b, t1, scratch)
    chord[2], chord[3] = scratch[b, 0], scratch[b, 1]
    a2 = bodies.rows[b, ACCELERATION] ** 2 + bodies.rows[b, ACCELERATION + 1] ** 2
    return bodies.rows[b, REACH] + np.sqrt(a2) * (t1 - t0) ** 2 / 8.0


@njit
def target_ways(bodies, gap, end):
    """Where targets are at INSTANTS over [0, end], for `last_use`.

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
def last_use(ways, end, speed, x, y):
    """Last moment at which a hand at (x, y) may still meet a target before `end` [s].

    -1 if it cannot at all; never too early.
    """
    last, step = -1.0, end / INSTANTS
    for i in range(ways.shape[0]):
        late = min(step * (i + 1), end)
        for b in range(ways.shape[1]):
            dx, dy, dz = x - ways[i, b, 0], y - ways[i, b, 1], ways[i, b, 2]
            away = np.sqrt(dx * dx + dy * dy + dz * dz) - ways[i, b, 3]
            last = max(last, late - max(away, 0.0) / speed)
    return last


@njit
def safe_until(postures, cells, since, until, count, end, shortest):
    """Find when each of the cells that are free at `since` is touched next; `end` if never.

    Parameters
    ----------
    cells, since : (count,) ndarray
        Flat indices and times [s].
    until : (count,) ndarray
        Filled [s].
    """
    until[:count] = end
    shorten(postures, cells, since, until, count, end, shortest)


@njit
def shorten(postures, cells, since, until, count, end, shortest):
    """Lower `until` where one of the cells that are free at `since` is touched before; see above.

    No `until` is later than `end`.
    """
    bodies, limb, gap, _, scratch = postures
    if count == 0:
        return
    chord = np.empty(4)
    early = since[:count].min()
    for b in range(bodies.rows.shape[0]):
        if bodies.rows[b, PART] == HAND or bodies.rows[b, TOP_SPEED] == 0.0:
            continue
        width = way_of(bodies, b, early, end, scratch, chord)
        for i in range(count):
            m = cells[i]
            if width < NEVER:
                hx, hy, ex, ey = limb[m, 0], limb[m, 1], limb[m, 2], limb[m, 3]
                far = (width + gap[m]) ** 2
                if (
                    segments_distance2(hx, hy, ex, ey, chord[0], chord[1], chord[2], chord[3]) > far
                    and segments_distance2(0.0, 0.0, ex, ey, chord[0], chord[1], chord[2], chord[3])
                    > far
                ):
                    continue
            t = first_touch(
                bodies, b, limb[m, 0], limb[m, 1], limb[m, 2], limb[m, 3], gap[m],
                since[i], until[i], shortest, scratch,
            )  # fmt: skip
            if t >= 0.0:
                until[i] = t


@njit
def meet(postures, gap, cells, since, until, count, shortest, best):
    """Find the earliest moment at which a target comes to one of the cells while it is safe.

    A target comes when it is within `gap` of the hand; `best` bounds what is of interest.
    Returns (index or -1, body, time [s]).
    """
    bodies, limb, _, _, scratch = postures
    index, body = -1, -1
    if count == 0:
        return index, body, best
    chord = np.empty(4)
    early = since[:count].min()
    for b in range(bodies.rows.shape[0]):
        if bodies.rows[b, PART] != HAND or early > best:
            continue
        width = way_of(bodies, b, early, best, scratch, chord)
        for i in range(count):
            end = min(until[i], best)
            if since[i] > end:
                continue
            m = cells[i]
            hx, hy = limb[m, 0], limb[m, 1]
            if (
                width < NEVER
                and segment_point2(hx, hy, chord[0], chord[1], chord[2], chord[3])
                > (width + gap) ** 2
            ):
                continue
            t = first_touch(bodies, b, hx, hy, hx, hy, gap, since[i], end, shortest, scratch)
            if t >= 0.0 and t < best:
                index, body, best = i, b, t
    return index, body, best
