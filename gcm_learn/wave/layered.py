"""Layered marching: earliest arrivals when the hand may wait.

In every cell the time line falls into safe intervals, spans in which a limb resting there touches
nothing.  When waiting is free, all that matters of an interval is the earliest moment at which the
hand can be in it (safe interval path planning: Phillips and Likhachev, ICRA 2011).  So the static
picture becomes a few sheets: sheet m holds the arrivals in the m-th interval that was reached.

A state is a cell with one of its intervals, in the order in which they are reached.  Fronts run on
from states as in `wave.marching`, straight from a source.  What is new: a state that is blocked or
ends makes a note to come back when its cell is free again (`REOPEN`); then the hand enters from any
neighbour in which it can have waited.  Intervals are found by conservative advancement and only for
cells that are reached.  Lengths are in cells, times in crossings of a cell.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.collision.intervals import NEVER, meet, shorten, target_ways
from gcm_learn.collision.occupancy import blocked_cells
from gcm_learn.compiled import njit
from gcm_learn.scene.bodies import poses_at
from gcm_learn.wave.agenda import (
    ARRIVAL,
    ARRIVE,
    CELL,
    END,
    FROM_HAND,
    ITSELF,
    PASSING,
    SETTLED,
    SOURCE,
    VIA,
    keep_free,
    keep_useful,
    pop,
    push,
    put_off,
    seed,
)
from gcm_learn.wave.kernels import GRASP, KAPPA, SHORTEST
from gcm_learn.wave.marching import (
    BEYOND,
    BUCKETS,
    PER_CELL,
    ROOT2,
    STEP_I,
    STEP_J,
    UNKNOWN,
    bare,
    row_of,
    step_time,
)


@njit
def offset(source, i, j, W, hand_i, hand_j, states):
    """Vector (di, dj) from cell (i, j) to a source."""
    if source == FROM_HAND:
        return hand_i - i, hand_j - j
    k = states[source, CELL]
    row = row_of(k, W)
    return float(row - i), float(k - row * W - j)


@njit(inline="always")
def waits_in(k, time, latest, spans):
    """Tell whether the hand has come to cell k and may be there at `time`."""
    return latest[k] >= 0 and spans[latest[k], END] >= time


@njit(forceinline=True)
def bend(s, k, q, di, dj, n, now, turns, circle, latest, spans):
    """When the front of state s in cell k is in the neighbour q = k + (di, dj), going round a cell.

    Returns the time and the state that it goes round: this one, or beside it one that was reached
    earlier; (NEVER, -1) if q is reached across a corner only, where nothing squeezes through.
    """
    W = n + 2
    limited = turns.shape[0] > 0
    if di != 0 and dj != 0:
        if not (waits_in(k + di * W, now, latest, spans) or waits_in(k + dj, now, latest, spans)):
            return NEVER, -1
        step = ROOT2
        if limited:
            step = step_time(turns, circle, bare(q, n), bare(k, n), 0, 0.0, step)
        return now + step, s
    best, home = 1.0, s
    if limited:
        best = step_time(turns, circle, bare(q, n), bare(k, n), 0, 0.0, best)
    best += now
    side = W if di == 0 else 1
    for e in (k - side, k + side):
        if not waits_in(e, now, latest, spans):
            continue
        step = ROOT2
        if limited:
            step = step_time(turns, circle, bare(q, n), bare(e, n), 0, 0.0, step)
        if spans[latest[e], ARRIVAL] + step < best:
            best, home = spans[latest[e], ARRIVAL] + step, latest[e]
    return best, home


@njit
def expand(  # noqa: C901  one decision; a call in this loop costs more than it clears up
    first, last, n, hand_i, hand_j, turns, circle, states, spans, latest, status, tent, again,
    source_of, via_of, queue, counts, bucket,
):  # fmt: skip
    """Offer the fronts of new states to the neighbours of their cells, as marching does.

    The differences: a reached neighbour counts only while its interval lasts, and may be entered
    again after that.
    """
    W = n + 2
    limited = turns.shape[0] > 0
    for s in range(first, last):
        k = states[s, CELL]
        home = states[s, SOURCE]
        if home == ITSELF:
            home = s
        ci = row_of(k, W)
        cj = k - ci * W
        now = spans[s, ARRIVAL]
        for d in range(8):
            di, dj = STEP_I[d], STEP_J[d]
            q = k + di * W + dj
            if status[q] != UNKNOWN and status[q] != PASSING:
                continue
            if source_of[q] == home and tent[q] < NEVER:
                continue
            dy, dx = offset(home, ci + di, cj + dj, W, hand_i, hand_j, states)
            ax, ay = abs(dx), abs(dy)
            sx, sy = (1 if dx > 0.0 else -1), (W if dy > 0.0 else -W)
            major = q + sx if ax >= ay else q + sy
            corner = q + sx + sy
            if min(ax, ay) <= 1e-9:
                corner = major
            elif abs(ax - ay) <= 1e-9:
                major = corner
            bent, home_of_bend = bend(s, k, q, di, dj, n, now, turns, circle, latest, spans)
            if home_of_bend < 0:
                continue
            time, source, via = bent, home_of_bend, home_of_bend
            if k == major or k == corner:
                beside = corner if k == major else major
                other = latest[beside]
                open_ = status[beside] == BEYOND  # the ring is convex outwards: rays may graze it
                if open_ or (other >= 0 and spans[other, END] >= now):
                    rival = home if open_ else states[other, SOURCE]
                    if rival == ITSELF:
                        rival = other
                    start = 0.0 if home == FROM_HAND else spans[home, ARRIVAL]
                    time, source, via = start + np.sqrt(dx * dx + dy * dy), home, home
                    if rival != home and other != home:
                        dy, dx = offset(rival, ci + di, cj + dj, W, hand_i, hand_j, states)
                        start = 0.0 if rival == FROM_HAND else spans[rival, ARRIVAL]
                        later = start + np.sqrt(dx * dx + dy * dy)
                        if later > time:
                            time, source, via = later, rival, rival
                    if limited:
                        slope = min(ax, ay) / max(ax, ay, 1e-9)
                        share = slope if k == major else 1.0 - slope
                        time, to = now, k
                        if other >= 0:
                            time += share * max(spans[other, ARRIVAL] - now, -1.0)
                            to = beside
                        time += step_time(
                            turns, circle, bare(q, n), bare(k, n), bare(to, n), share,
                            np.sqrt(1.0 + slope * slope),
                        )  # fmt: skip
                    if time > bent + 1e-9:  # the straight front is late here: go round by a cell
                        time, source, via = bent, home_of_bend, home_of_bend
            if latest[q] >= 0 and time <= spans[latest[q], END]:
                continue
            if again[q] < NEVER and time <= again[q]:
                continue  # known to be blocked until then; `way_in` will find this state
            if time >= tent[q] + (1e-9 if source == home else -1e-9):  # a straight ray wins a tie
                continue
            tent[q], source_of[q], via_of[q] = time, source, via
            push(q, time, ARRIVE, bucket, queue, counts)


@njit
def write_down(
    total, free, kappa, end, places, start, until, limits, origins, states, spans, latest, status,
    passing,
):  # fmt: skip
    """Make states of the cells that were found free: `free` of them, after the first `total`."""
    for i in range(free):
        s, k = total + i, places[i]
        states[s, CELL], states[s, SOURCE] = k, origins[i, 0]
        states[s, VIA], latest[k] = origins[i, 1], s
        # Untouched for as long as it is of use is as good as for ever.
        lasts = until[i] >= limits[i]
        spans[s, ARRIVAL] = start[i]
        spans[s, END] = end if lasts else until[i] / kappa
        status[k] = SETTLED if lasts else PASSING
        passing[i] = not lasts


@njit
def march_layers(
    n, hand_i, hand_j, limb, outside, gap, turns, circle, bodies, c, lookback, explore, speed, end,
    ignore, states, spans, refused,
):  # fmt: skip
    """March over cells and sheets until a target is met.

    Parameters
    ----------
    hand_i, hand_j : float
        Hand in lattice coordinates.
    outside : ((n + 2)^2,) uint8 ndarray
        UNKNOWN where the hand can be, CLOSED elsewhere.
    gap : (n * n,) ndarray
        Distance at which an obstacle occupies a cell.
    turns, circle
        As for marching.
    c : (CONSTANTS,) ndarray
        As for marching.
    lookback : float
        How long a cell must have been free before it is entered [crossings].
    explore : bool
        Reach also what is of no use any more for meeting a target.
    speed : float
        Of the front [forearm lengths / s].
    end, ignore : float
        Horizon; meetings before `ignore` do not count [crossings].
    states : (m, 3) int32 ndarray
        Filled with cell, source and predecessor; cells are indices of the padded lattice.
    spans : (m, 2) float64 ndarray
        Filled with arrival and end of the safe interval [crossings].
    refused : (n * n,) bool ndarray
        Set where an obstacle was when a front came.

    Returns
    -------
    count : int
        Number of states.
    state, body : int
        Where the target is met, -1 if it is not.
    time : float
        When [crossings].
    """
    W = n + 2
    kappa, shortest = c[KAPPA], c[SHORTEST]
    coarse = 0.2 * kappa  # resolution of intervals and meetings [s]; plans are verified anyway
    status, latest = outside.copy(), np.full(W * W, -1, dtype=np.int32)
    tent, again = np.full(W * W, NEVER), np.full(W * W, NEVER)
    source_of, via_of = np.full((2, W * W), -9, dtype=np.int32)
    queue = np.empty((20 * n * n, 3), dtype=np.int32)
    counts = np.full(2 + BUCKETS, -1, dtype=np.int64)
    counts[0] = 0
    cells, places = np.empty(n * n, dtype=np.int64), np.empty(n * n, dtype=np.int64)
    since, until, start, limits = np.empty((4, n * n))
    origins = np.empty((n * n, 2), dtype=np.int32)
    ways = target_ways(bodies, c[GRASP], end * kappa)
    blocked, turn_of = np.empty(n * n, dtype=np.bool_), np.zeros(W * W, dtype=np.int32)
    poses = np.zeros((bodies.rows.shape[0], 12))
    scratch = np.zeros_like(poses)
    hand_i, hand_j = hand_i + 1.0, hand_j + 1.0
    seed(n, hand_i, hand_j, turns, circle, status, tent, source_of, via_of, queue, counts)
    total, met, body, when, bucket, idle = 0, -1, -1, end * kappa, 0, 0
    while idle < BUCKETS and bucket <= end * PER_CELL and bucket <= when / kappa * PER_CELL:
        slot = 1 + bucket % BUCKETS
        idle += 1
        now = min((bucket + 1.0) / PER_CELL, end)
        posed = False
        while counts[slot] >= 0:
            idle = 0
            count = pop(
                slot, bucket, n, end, turns, circle, latest, tent, again, source_of, via_of, states,
                spans, queue, counts, places, cells, start, origins, turn_of,
            )  # fmt: skip
            if count > 0 and not posed:
                poses_at(bodies, now * kappa, poses)
                posed = True
            count = keep_useful(
                count, ways, end * kappa, when, explore, speed, kappa, lookback, limb, places,
                cells, start, origins, limits, since,
            )  # fmt: skip
            blocked_cells(
                bodies, poses, limb, gap, cells, since, count, now * kappa, shortest, blocked,
                scratch,
            )  # fmt: skip
            # Surely in a later bucket, or a cell could be refused here for ever.
            until[:count] = (now + 1e-6) * kappa
            put_off(
                count, blocked, until, places, cells, bodies, limb, gap, kappa, limits, lookback,
                bucket, status, again, queue, counts, scratch,
            )  # fmt: skip
            for i in range(count):
                refused[cells[i]] |= blocked[i]
            room = states.shape[0] - total
            free = keep_free(count, room, blocked, places, cells, start, origins, limits)
            for i in range(free):
                since[i], until[i] = start[i] * kappa, limits[i]
            shorten(bodies, limb, gap, cells, since, until, free, end * kappa, coarse, scratch)
            for i in range(free):
                since[i] = max(since[i], ignore * kappa)
            index, target, t = meet(
                bodies, limb, c[GRASP], cells, since, until, free, coarse, when, scratch
            )
            if index >= 0:
                met, body, when = total + index, target, t
            write_down(
                total, free, kappa, end, places, start, until, limits, origins, states, spans,
                latest, status, blocked,
            )  # fmt: skip
            put_off(
                free, blocked, until, places, cells, bodies, limb, gap, kappa, limits, lookback,
                bucket, status, again, queue, counts, scratch,
            )  # fmt: skip
            expand(
                total, total + free, n, hand_i, hand_j, turns, circle, states, spans, latest,
                status, tent, again, source_of, via_of, queue, counts, bucket,
            )  # fmt: skip
            total += free
        bucket += 1
    return total, met, body, when / kappa
