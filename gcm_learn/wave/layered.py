"""Layered marching: earliest arrivals when the hand may wait.

In every cell the time line falls into safe intervals, spans in which a limb resting there touches
nothing.  When waiting is free, only the earliest moment at which the hand can be in an interval
counts.  This is safe interval path planning (Phillips and Likhachev, ICRA 2011).  So the static
picture becomes a few sheets: sheet m holds the arrivals in the m-th interval that was reached.

A state is a cell with one of its intervals, in the order in which they are reached.  Fronts run on
from states as in `wave.marching`, straight from a source.  In addition, a state that is blocked or
ends makes a note to come back when its cell is free again (`REOPEN`).  The hand then enters from
any neighbour in which it can have waited.  Intervals are found by conservative advancement and only
for cells that are reached.  Lengths are in cells, times in crossings of a cell.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.collision.intervals import NEVER, meet, shorten, target_ways
from gcm_learn.collision.occupancy import blocked_cells
from gcm_learn.compiled import njit
from gcm_learn.scene.bodies import poses_at
from gcm_learn.wave import agendas
from gcm_learn.wave.buckets import queue_of
from gcm_learn.wave.plane import (
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

COARSE = 0.2  # resolution of intervals and meetings [crossings]; plans are verified anyway


@njit(_nrt=False)
def offset(source, i, j, plane, states):
    """Vector (di, dj) from cell (i, j) to a source."""
    if source == agendas.FROM_HAND:
        return plane.hand_i - i, plane.hand_j - j
    k, W = states[source, agendas.CELL], plane.n + 2
    row = row_of(k, W)
    return float(row - i), float(k - row * W - j)


@njit(_nrt=False, forceinline=True)
def waits_in(k, time, sheets):
    """Tell whether the hand has come to cell k and may be there at `time`."""
    s = sheets.latest[k]
    return s >= 0 and sheets.spans[s, agendas.END] >= time


@njit(_nrt=False, forceinline=True)
def bend(s, k, q, di, dj, plane, sheets):
    """Compute the arrival in q = k + (di, dj) of the front of state s in cell k, bent round a cell.

    Returns the time and the state that it is bent round: s, or an earlier state beside s.  Returns
    (NEVER, -1) if q is reached across a corner only, which is too narrow.
    """
    n, latest, spans = plane.n, sheets.latest, sheets.spans
    W, now = n + 2, spans[s, agendas.ARRIVAL]
    limited = plane.turns.shape[0] > 0
    if di != 0 and dj != 0:
        if not (waits_in(k + di * W, now, sheets) or waits_in(k + dj, now, sheets)):
            return NEVER, -1
        step = ROOT2
        if limited:
            step = step_time(plane, bare(q, n), bare(k, n), 0, 0.0, step)
        return now + step, s
    best, home = 1.0, s
    if limited:
        best = step_time(plane, bare(q, n), bare(k, n), 0, 0.0, best)
    best += now
    side = W if di == 0 else 1
    for e in (k - side, k + side):
        if not waits_in(e, now, sheets):
            continue
        step = ROOT2
        if limited:
            step = step_time(plane, bare(q, n), bare(e, n), 0, 0.0, step)
        if spans[latest[e], agendas.ARRIVAL] + step < best:
            best, home = spans[latest[e], agendas.ARRIVAL] + step, latest[e]
    return best, home


@njit(_nrt=False)
def expand(first, last, bucket, plane, sheets, agenda):  # noqa: C901  one decision, innermost
    """Offer the fronts of new states to the neighbours of their cells, as marching does.

    The differences: a reached neighbour counts only while its interval lasts, and may be entered
    again after that.
    """
    n, states, spans, latest = plane.n, sheets.states, sheets.spans, sheets.latest
    status, tent, again, source_of = agenda.status, agenda.tent, agenda.again, agenda.source_of
    W = n + 2
    limited = plane.turns.shape[0] > 0
    for s in range(first, last):
        k = states[s, agendas.CELL]
        home = states[s, agendas.SOURCE]
        if home == agendas.ITSELF:
            home = s
        ci = row_of(k, W)
        cj = k - ci * W
        now = spans[s, agendas.ARRIVAL]
        for d in range(8):
            di, dj = STEP_I[d], STEP_J[d]
            q = k + di * W + dj
            if status[q] != UNKNOWN and status[q] != agendas.PASSING:
                continue
            if source_of[q] == home and tent[q] < NEVER:
                continue
            dy, dx = offset(home, ci + di, cj + dj, plane, states)
            ax, ay = abs(dx), abs(dy)
            sx, sy = (1 if dx > 0.0 else -1), (W if dy > 0.0 else -W)
            major = q + sx if ax >= ay else q + sy
            corner = q + sx + sy
            if min(ax, ay) <= 1e-9:
                corner = major
            elif abs(ax - ay) <= 1e-9:
                major = corner
            bent, home_of_bend = bend(s, k, q, di, dj, plane, sheets)
            if home_of_bend < 0:
                continue
            time, source, via = bent, home_of_bend, home_of_bend
            if k == major or k == corner:
                beside = corner if k == major else major
                other = latest[beside]
                open_ = status[beside] == BEYOND  # the ring is convex outwards: rays may graze it
                if open_ or (other >= 0 and spans[other, agendas.END] >= now):
                    rival = home if open_ else states[other, agendas.SOURCE]
                    if rival == agendas.ITSELF:
                        rival = other
                    start = 0.0 if home == agendas.FROM_HAND else spans[home, agendas.ARRIVAL]
                    time, source, via = start + np.sqrt(dx * dx + dy * dy), home, home
                    if rival != home and other != home:
                        dy, dx = offset(rival, ci + di, cj + dj, plane, states)
                        start = 0.0 if rival == agendas.FROM_HAND else spans[rival, agendas.ARRIVAL]
                        later = start + np.sqrt(dx * dx + dy * dy)
                        if later > time:
                            time, source, via = later, rival, rival
                    if limited:
                        slope = min(ax, ay) / max(ax, ay, 1e-9)
                        share = slope if k == major else 1.0 - slope
                        time, to = now, k
                        if other >= 0:
                            time += share * max(spans[other, agendas.ARRIVAL] - now, -1.0)
                            to = beside
                        length = np.sqrt(1.0 + slope * slope)
                        time += step_time(plane, bare(q, n), bare(k, n), bare(to, n), share, length)
                    if time > bent + 1e-9:  # the straight front is late here: go round by a cell
                        time, source, via = bent, home_of_bend, home_of_bend
            if latest[q] >= 0 and time <= spans[latest[q], agendas.END]:
                continue
            if again[q] < NEVER and time <= again[q]:
                continue  # known to be blocked until then; `way_in` will find this state
            if time >= tent[q] + (1e-9 if source == home else -1e-9):  # a straight ray wins a tie
                continue
            tent[q], source_of[q], agenda.via_of[q] = time, source, via
            agendas.push(q, time, agendas.ARRIVE, bucket, agenda)


@njit(_nrt=False)
def write_down(total, free, terms, sheets, agenda, batch):
    """Make states of the cells that were found free: `free` of them, after the first `total`."""
    states, spans = sheets.states, sheets.spans
    for i in range(free):
        s, k = total + i, batch.places[i]
        states[s, agendas.CELL], states[s, agendas.SOURCE] = k, batch.origins[i, 0]
        states[s, agendas.VIA], sheets.latest[k] = batch.origins[i, 1], s
        # Untouched for as long as it is of use is as good as for ever.
        lasts = batch.until[i] >= batch.limits[i]
        spans[s, agendas.ARRIVAL] = batch.start[i]
        spans[s, agendas.END] = terms.end if lasts else batch.until[i] / terms.kappa
        agenda.status[k] = agendas.SETTLED if lasts else agendas.PASSING
        batch.which[i] = not lasts


@njit
def agenda_of(plane):
    """Return an agenda in which nothing is reached yet."""
    n = plane.n
    size = (n + 2) * (n + 2)
    none = np.full((2, size), -9, dtype=np.int32)
    queue, turns = queue_of(20 * n * n, BUCKETS), np.zeros(size, dtype=np.int32)
    tent, again = np.full(size, NEVER), np.full(size, NEVER)
    return agendas.Agenda(plane.outside.copy(), tent, again, none[0], none[1], queue, turns)


@njit
def batch_of(n):
    """Make a batch for all cells of an n x n lattice."""
    cells, places = np.empty(n * n, dtype=np.int64), np.empty(n * n, dtype=np.int64)
    since, until, start, limits = np.empty((4, n * n))
    origins, which = np.empty((n * n, 2), dtype=np.int32), np.empty(n * n, dtype=np.bool_)
    return agendas.CheckedCells(places, cells, start, origins, limits, since, until, which)


@njit
def march_layers(plane, terms, postures, sheets, refused):
    """March over cells and sheets until a contact, or with `explore` to the horizon.

    Parameters
    ----------
    plane, terms, postures : PlaneLattice, Terms, Postures
        Times of the terms are in crossings; `explore` reaches also what is of no use any more for
        meeting a target.
    sheets : Sheets
        Filled; `latest` is -1 everywhere.
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
    kappa, end, coarse = terms.kappa, terms.end, COARSE * terms.kappa
    agenda, batch = agenda_of(plane), batch_of(plane.n)
    heads, cells, since, until = agenda.queue.heads, batch.cells, batch.since, batch.until
    ways = target_ways(postures.bodies, terms.grasp, end * kappa)
    agendas.seed(plane, agenda)
    total, met, body, when, bucket, idle = 0, -1, -1, end * kappa, 0, 0
    last = end * PER_CELL
    while (
        idle < BUCKETS and bucket <= last and (terms.explore or bucket <= when / kappa * PER_CELL)
    ):
        idle += 1
        now = min((bucket + 1.0) / PER_CELL, end)
        posed = False
        while heads[bucket % BUCKETS] >= 0:
            idle = 0
            count = agendas.pop(bucket, plane, terms, agenda, sheets, batch)
            if count > 0 and not posed:
                poses_at(postures.bodies, now * kappa, postures.poses)
                posed = True
            count = agendas.keep_useful(count, ways, when, postures.limb, terms, batch)
            blocked_cells(postures, cells, since, count, now * kappa, terms.shortest, batch.which)
            # Surely in a later bucket, or a cell could be refused here for ever.
            until[:count] = (now + 1e-6) * kappa
            agendas.put_off(count, bucket, postures, terms, agenda, batch)
            for i in range(count):
                refused[cells[i]] |= batch.which[i]
            free = agendas.keep_free(count, sheets.states.shape[0] - total, batch)
            for i in range(free):
                since[i], until[i] = batch.start[i] * kappa, batch.limits[i]
            shorten(postures, cells, since, until, free, coarse)
            for i in range(free):
                since[i] = max(since[i], terms.ignore * kappa)
            index, target, t = meet(postures, terms.grasp, cells, since, until, free, coarse, when)
            if index >= 0:
                met, body, when = total + index, target, t
            write_down(total, free, terms, sheets, agenda, batch)
            agendas.put_off(free, bucket, postures, terms, agenda, batch)
            expand(total, total + free, bucket, plane, sheets, agenda)
            total += free
        bucket += 1
    return total, met, body, when / kappa
