"""What layered marching has yet to look at: a queue of cells by time, and what comes out of it.

Entries are of two kinds: a front comes to a cell (`ARRIVE`), or a cell is free again (`REOPEN`).
Lengths are in cells, times in crossings of a cell.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.collision.intervals import NEVER, last_use, next_free
from gcm_learn.compiled import njit
from gcm_learn.wave.marching import (
    BUCKETS,
    PER_CELL,
    ROOT2,
    START_RADIUS,
    STEP_I,
    STEP_J,
    UNKNOWN,
    bare,
    step_time,
)

SETTLED, PASSING = 1, 4  # not to be entered any more; reached, but safe only for a while
SPARE = 1 + BUCKETS  # entry of `counts` that heads the list of queue entries to be used again
ARRIVE, REOPEN = 0, 1  # kinds of queue entries
FROM_HAND, ITSELF = -1, -2  # sources that are no earlier state

# Columns of a state: cell (padded index), source and predecessor (states); arrival, end.
CELL, SOURCE, VIA = 0, 1, 2
ARRIVAL, END = 0, 1


@njit
def push(k, time, kind, bucket, queue, counts):
    """Put cell k into the bucket of a time, not before the one being worked on."""
    # One turn of the buckets is all that the queue can tell apart: later visits ask again.
    ahead = min(max(int(time * PER_CELL), bucket), bucket + BUCKETS - 1)
    slot = 1 + (ahead & (BUCKETS - 1))
    entry = counts[SPARE]
    if entry >= 0:
        counts[SPARE] = queue[entry, 1]
    elif counts[0] < queue.shape[0]:
        entry = counts[0]
        counts[0] = entry + 1
    else:
        return
    queue[entry, 0], queue[entry, 1], queue[entry, 2] = k, counts[slot], kind
    counts[slot] = entry


@njit
def way_in(k, time, n, turns, circle, latest, states, spans):
    """State of a neighbour in which the hand can wait to be in cell k at `time`; -1 if none.

    Among those that are possible the one that was reached first: it has most room to wait.
    """
    W = n + 2
    best = -1
    for d in range(8):
        s = latest[k + STEP_I[d] * W + STEP_J[d]]
        if s < 0:
            continue
        step = ROOT2 if STEP_I[d] != 0 and STEP_J[d] != 0 else 1.0
        if turns.shape[0] > 0:
            step = step_time(turns, circle, bare(k, n), bare(states[s, CELL], n), 0, 0.0, step)
        leave = time - step
        if spans[s, ARRIVAL] <= leave <= spans[s, END]:
            if best < 0 or spans[s, ARRIVAL] < spans[best, ARRIVAL]:
                best = s
    return best


@njit
def keep_useful(
    count, ways, end, when, explore, speed, kappa, lookback, limb, places, cells, start, origins,
    limits, since,
):  # fmt: skip
    """Drop those of `count` cells from which no target can be met any more; returns the rest.

    `limits` (n * n,) is filled with how long the rest are of use, given that a target can be met at
    `when`, and `since` with from when on they have to be free [s].
    """
    useful = 0
    for i in range(count):
        last = end
        if not explore:
            last = last_use(ways, end, speed, limb[cells[i], 0], limb[cells[i], 1])
        if start[i] * kappa <= last:
            places[useful], cells[useful], start[useful] = places[i], cells[i], start[i]
            origins[useful, 0], origins[useful, 1] = origins[i, 0], origins[i, 1]
            limits[useful] = last if explore else min(last, when)
            since[useful] = max(start[i] - lookback, 0.0) * kappa
            useful += 1
    return useful


@njit
def keep_free(count, room, blocked, places, cells, start, origins, limits):
    """Drop the blocked ones of `count` cells, and what there is no `room` for; returns the rest."""
    free = 0
    for i in range(count):
        if not blocked[i] and free < room:
            places[free], cells[free], start[free] = places[i], cells[i], start[i]
            limits[free] = limits[i]
            origins[free, 0], origins[free, 1] = origins[i, 0], origins[i, 1]
            free += 1
    return free


@njit
def seed(n, hand_i, hand_j, turns, circle, status, tent, source_of, via_of, queue, counts):
    """Reach the cells around the hand straight from it."""
    W = n + 2
    reach = int(START_RADIUS) + 1
    for i in range(max(int(hand_i) - reach, 1), min(int(hand_i) + reach + 2, n + 1)):
        for j in range(max(int(hand_j) - reach, 1), min(int(hand_j) + reach + 2, n + 1)):
            k = i * W + j
            away = np.sqrt((i - hand_i) ** 2 + (j - hand_j) ** 2)
            if status[k] == UNKNOWN and away <= START_RADIUS:
                if turns.shape[0] > 0:
                    away = step_time(turns, circle, bare(k, n), n * n, 0, 0.0, away)
                tent[k], source_of[k], via_of[k] = away, FROM_HAND, FROM_HAND
                push(k, away, ARRIVE, 0, queue, counts)


@njit
def pop(
    slot, bucket, n, end, turns, circle, latest, tent, again, source_of, via_of, states, spans,
    queue, counts, places, cells, start, origins, turn_of,
):  # fmt: skip
    """Take the entries of a bucket that are due; returns how many states they may become.

    Entries for later turns of the buckets go back into the queue; stale ones are dropped.
    """
    count = 0
    entry = counts[slot]
    counts[slot] = -1
    while entry >= 0:
        k, kind, used = queue[entry, 0], queue[entry, 2], entry
        entry = queue[entry, 1]
        queue[used, 1] = counts[SPARE]
        counts[SPARE] = used
        due = tent[k] if kind == ARRIVE else again[k]
        if due >= NEVER or due > end:
            continue
        if int(due * PER_CELL) > bucket:
            push(k, due, kind, bucket, queue, counts)
            continue
        s = latest[k]
        if kind == ARRIVE:
            tent[k] = NEVER
            if s >= 0 and due <= spans[s, END]:
                continue
            source, via = source_of[k], via_of[k]
        else:
            again[k] = NEVER
            if s >= 0 and due <= spans[s, END]:
                continue
            via = way_in(k, due, n, turns, circle, latest, states, spans)
            if via < 0:
                continue
            source = ITSELF
        a = turn_of[k]
        if a < count and places[a] == k:  # both kinds in one bucket: one interval, so one state
            if due >= start[a]:
                continue
        else:
            a = turn_of[k] = count
            count += 1
        places[a], start[a], origins[a, 0], origins[a, 1] = k, due, source, via
        cells[a] = bare(k, n)
    return count


@njit
def put_off(
    count, which, moments, places, cells, bodies, limb, gap, kappa, limits, lookback, bucket,
    status, again, queue, counts, scratch,
):  # fmt: skip
    """Make notes to look again, after their `moments` [s], at `which` of `count` cells."""
    for i in range(count):
        if which[i]:
            come_back(
                places[i], cells[i], moments[i] / kappa, bodies, limb, gap, kappa, limits[i],
                lookback, bucket, status, again, queue, counts, scratch,
            )  # fmt: skip


@njit
def come_back(
    k, m, time, bodies, limb, gap, kappa, limit, lookback, bucket, status, again, queue, counts,
    scratch,
):  # fmt: skip
    """Make a note to look at a cell again when it is free, before `limit` [s].

    Times are in crossings else.
    """
    t = next_free(bodies, limb, m, gap[m], time * kappa, limit, 0.25 * kappa, scratch)
    if t >= NEVER:
        status[k] = SETTLED  # not to be entered any more
        return
    due = t / kappa + lookback
    if due < again[k]:
        again[k] = due
        push(k, due, REOPEN, bucket, queue, counts)
