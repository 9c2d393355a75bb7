"""Agenda of layered marching: a queue of cells by time, and batches taken from the queue.

Entries are of two kinds: a front comes to a cell (`ARRIVE`), or a cell is free again (`REOPEN`).
Lengths are in cells, times in crossings of a cell.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.charts import START_RADIUS
from gcm_learn.collision.intervals import NEVER, last_use, next_free
from gcm_learn.compiled import njit
from gcm_learn.wave.buckets import BucketQueue, left_in, put, take
from gcm_learn.wave.plane import BUCKETS, PER_CELL, ROOT2, STEP_I, STEP_J, UNKNOWN, bare, step_time

SETTLED, PASSING = 1, 4  # not to be entered any more; reached, but safe only for a while
ARRIVE, REOPEN = 0, 1  # kinds of queue entries: an item is twice the cell and its kind
FROM_HAND, ITSELF = -1, -2  # sources that are no earlier state

# Columns of a state: cell (padded index), source and predecessor (states); arrival, end.
CELL, SOURCE, VIA = 0, 1, 2
ARRIVAL, END = 0, 1


class Sheets(NamedTuple):
    """The states that have been reached."""

    states: np.ndarray  # (m, 3) int32: cell, source and predecessor
    spans: np.ndarray  # (m, 2): arrival and end of the safe interval [crossings]
    latest: np.ndarray  # ((n + 2)^2,): a cell's last state, -1 if none


class Agenda(NamedTuple):
    """State of the cells of the padded lattice, and a queue of cells."""

    status: np.ndarray
    tent: np.ndarray  # when the next front comes
    again: np.ndarray  # when a cell that was blocked is free
    source_of: np.ndarray  # of the next front
    via_of: np.ndarray
    queue: BucketQueue  # cells and kinds
    turn_of: np.ndarray  # place of a cell in the batch


class CheckedCells(NamedTuple):
    """Batch of cells that are checked together, as candidates for new states."""

    places: np.ndarray  # in the padded lattice
    cells: np.ndarray  # without padding
    start: np.ndarray  # arrival [crossings]
    origins: np.ndarray  # (m, 2): source and predecessor
    limits: np.ndarray  # until when they are of use [s]
    since: np.ndarray  # known to be free from then on [s]
    until: np.ndarray  # and till then
    which: np.ndarray  # bool: to be checked again after `until`


@njit(_nrt=False)
def push(k, time, kind, bucket, agenda):
    """Queue cell k in the bucket of `time`, or in the current one, `bucket`, if that is later."""
    # One turn of the buckets is all that the queue can tell apart: later visits ask again.
    ahead = min(max(int(time * PER_CELL), bucket), bucket + BUCKETS - 1)
    if left_in(agenda.queue) > 0:
        put(2 * k + kind, ahead & (BUCKETS - 1), agenda.queue)


@njit(_nrt=False)
def way_in(k, time, plane, sheets):
    """State of a neighbour in which the hand can wait to be in cell k at `time`; -1 if none.

    It is the possible state that was reached first, in which the hand can wait longest.
    """
    n, states, spans = plane.n, sheets.states, sheets.spans
    best = -1
    for d in range(8):
        s = sheets.latest[k + STEP_I[d] * (n + 2) + STEP_J[d]]
        if s < 0:
            continue
        step = ROOT2 if STEP_I[d] != 0 and STEP_J[d] != 0 else 1.0
        if plane.turns.shape[0] > 0:
            step = step_time(plane, bare(k, n), bare(states[s, CELL], n), 0, 0.0, step)
        leave = time - step
        if spans[s, ARRIVAL] <= leave <= spans[s, END]:
            if best < 0 or spans[s, ARRIVAL] < spans[best, ARRIVAL]:
                best = s
    return best


@njit(_nrt=False)
def keep(i, to, batch):
    """Copy entry i of a batch to place `to`, which is not after i."""
    batch.places[to], batch.cells[to], batch.start[to] = (
        batch.places[i], batch.cells[i], batch.start[i],
    )  # fmt: skip
    batch.origins[to, 0], batch.origins[to, 1] = batch.origins[i, 0], batch.origins[i, 1]
    batch.limits[to] = batch.limits[i]


@njit(_nrt=False)
def keep_useful(count, ways, when, limb, terms, batch):
    """Drop cells from which no target can be met any more; returns the number of others.

    `ways` are the targets', a target can be met at `when` [s].
    """
    useful, kappa, end = 0, terms.kappa, terms.end * terms.kappa
    for i in range(count):
        last, m = end, batch.cells[i]
        if not terms.explore:
            last = last_use(ways, end, terms.speed, limb[m, 0], limb[m, 1])
        if batch.start[i] * kappa <= last:
            keep(i, useful, batch)
            batch.limits[useful] = last if terms.explore else min(last, when)
            batch.since[useful] = max(batch.start[i] - terms.lookback, 0.0) * kappa
            useful += 1
    return useful


@njit(_nrt=False)
def keep_free(count, room, batch):
    """Drop blocked cells, and all beyond `room`; returns the number of others."""
    free = 0
    for i in range(count):
        if not batch.which[i] and free < room:
            keep(i, free, batch)
            free += 1
    return free


@njit(_nrt=False)
def seed(plane, agenda):
    """Queue the cells around the hand, with arrivals straight from the hand."""
    n, hand_i, hand_j = plane.n, plane.hand_i, plane.hand_j
    reach = int(START_RADIUS) + 1
    for i in range(max(int(hand_i) - reach, 1), min(int(hand_i) + reach + 2, n + 1)):
        for j in range(max(int(hand_j) - reach, 1), min(int(hand_j) + reach + 2, n + 1)):
            k = i * (n + 2) + j
            away = np.sqrt((i - hand_i) ** 2 + (j - hand_j) ** 2)
            if agenda.status[k] == UNKNOWN and away <= START_RADIUS:
                if plane.turns.shape[0] > 0:
                    away = step_time(plane, bare(k, n), n * n, 0, 0.0, away)
                agenda.tent[k], agenda.source_of[k], agenda.via_of[k] = away, FROM_HAND, FROM_HAND
                push(k, away, ARRIVE, 0, agenda)


@njit(_nrt=False)
def pop(bucket, plane, terms, agenda, sheets, batch):
    """Take the entries of a bucket that are due; returns how many states they may become.

    Entries for later turns of the buckets go back into the queue; stale ones are dropped.
    """
    queue, tent, again = agenda.queue, agenda.tent, agenda.again
    places, start, turn_of = batch.places, batch.start, agenda.turn_of
    slot, count = bucket % BUCKETS, 0
    while queue.heads[slot] >= 0:
        item = take(slot, queue)
        k, kind = item >> 1, item & 1
        due = tent[k] if kind == ARRIVE else again[k]
        if due >= NEVER or due > terms.end:
            continue
        if int(due * PER_CELL) > bucket:
            push(k, due, kind, bucket, agenda)
            continue
        s = sheets.latest[k]
        if kind == ARRIVE:
            tent[k] = NEVER
            if s >= 0 and due <= sheets.spans[s, END]:
                continue
            source, via = agenda.source_of[k], agenda.via_of[k]
        else:
            again[k] = NEVER
            if s >= 0 and due <= sheets.spans[s, END]:
                continue
            via = way_in(k, due, plane, sheets)
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
        places[a], start[a], batch.origins[a, 0], batch.origins[a, 1] = k, due, source, via
        batch.cells[a] = bare(k, plane.n)
    return count


@njit(_nrt=False)
def put_off(count, bucket, postures, terms, agenda, batch):
    """Queue the cells marked in `which` again, for the time at which they are free.

    The time is after `until`; a cell that stays blocked to its limit is never entered again.
    """
    kappa = terms.kappa
    for i in range(count):
        if not batch.which[i]:
            continue
        k, time = batch.places[i], batch.until[i] / kappa
        t = next_free(postures, batch.cells[i], time * kappa, batch.limits[i], 0.25 * kappa)
        if t >= NEVER:
            agenda.status[k] = SETTLED
            continue
        due = t / kappa + terms.lookback
        if due < agenda.again[k]:
            agenda.again[k] = due
            push(k, due, REOPEN, bucket, agenda)
