"""Causal marching: the map of a front of constant speed, cell by cell in order of arrival.

The meaning is that of the wave, at the speed of a Dijkstra search.  A cell is accepted only if its
limb is free when the front gets there.  Distances are measured in cells and times in crossings
(the time the front needs for one cell) while marching.

Every accepted cell remembers the *source* from which its front runs straight: the hand, or a cell
where the front last had to bend round something frozen.  A neighbour inherits the source when the
ray from it to the source passes between two accepted cells of that source.  Its arrival is then the
Euclidean distance: exact in free space and in the shadow of each corner.  Otherwise the front
bends, and the cell that passes it on becomes a source itself.  Any-angle path planning inherits
parents in the same way (Daniel, Nash, Koenig and Felner, Theta*, JAIR 39, 2010).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.charts import START_RADIUS
from gcm_learn.compiled import njit
from gcm_learn.scene.bodies import poses_at
from gcm_learn.wave.buckets import BucketQueue, put, queue_of, take
from gcm_learn.wave.kernels import FREE, batch_of, judge
from gcm_learn.wave.plane import (
    ACCEPTED,
    BEYOND,
    BUCKETS,
    CLOSED,
    PER_CELL,
    ROOT2,
    STEP_I,
    STEP_J,
    UNKNOWN,
    bare,
    row_of,
    step_time,
)

HAND_SOURCE = 0  # a cell of the rim, which is never a source itself
HALF_DIAGONAL = 0.7072  # of a cell; the hand is in a cell whose centre is this near


class MarchingState(NamedTuple):
    """State of the cells of the padded lattice, and a queue of cells."""

    status: np.ndarray
    tent: np.ndarray  # earliest arrival known so far
    origin: np.ndarray  # source of every cell: the index of a cell, or HAND_SOURCE
    queue: BucketQueue  # cells
    places: np.ndarray  # the cells accepted together


def _members() -> np.ndarray:
    """List the set bits of every byte (256, 8) and, in a ninth column, count them."""
    table = np.zeros((256, 9), dtype=np.int64)
    for byte in range(256):
        bits = [d for d in range(8) if byte >> d & 1]
        table[byte, : len(bits)] = bits
        table[byte, 8] = len(bits)
    return table


MEMBERS = _members()


@njit(_nrt=False, forceinline=True)
def away_from(source, i, j, plane):
    """Vector (di, dj) from cell (i, j) to a source."""
    if source == HAND_SOURCE:
        return plane.hand_i - i, plane.hand_j - j
    W = plane.n + 2
    row = row_of(source, W)
    return float(row - i), float(source - row * W - j)


@njit(_nrt=False, forceinline=True)
def push(k, time, bucket, agenda):
    """Queue cell k in the bucket of `time`, or in the current one, `bucket`, if that is later."""
    put(k, max(int(time * PER_CELL), bucket) & (BUCKETS - 1), agenda.queue)


@njit(_nrt=False, forceinline=True)
def bend(k, q, di, dj, plane, agenda):
    """Compute the arrival in q = k + (di, dj) of the front of cell k, bent round a cell.

    Returns the time and the cell that it is bent round: k, or a cell beside k.  Returns (0, -1) if
    q is reached across a corner only, where nothing squeezes through.
    """
    n, tent, status = plane.n, agenda.tent, agenda.status
    W = n + 2
    limited = plane.turns.shape[0] > 0
    if di != 0 and dj != 0:
        if status[k + di * W] != ACCEPTED and status[k + dj] != ACCEPTED:
            return 0.0, -1
        step = ROOT2
        if limited:
            step = step_time(plane, bare(q, n), bare(k, n), 0, 0.0, step)
        return tent[k] + step, k
    step = 1.0
    if limited:
        step = step_time(plane, bare(q, n), bare(k, n), 0, 0.0, step)
    time, source = tent[k] + step, k
    side = W if di == 0 else 1
    for e in (k - side, k + side):
        if status[e] != ACCEPTED:
            continue
        step = ROOT2
        if limited:
            step = step_time(plane, bare(q, n), bare(e, n), 0, 0.0, step)
        if tent[e] + step < time:
            time, source = tent[e] + step, e
    return time, source


@njit(_nrt=False, forceinline=True)
def expand(batch, count, state, plane, agenda, bucket):  # noqa: C901  one decision, innermost
    """Offer the fronts of newly accepted cells to their neighbours.

    The ray from a neighbour q towards the source leaves through the edge between an axis (`major`)
    and a corner neighbour.  If both have been reached, one of them from here, q is reached straight
    from the source.  If they belong to two sources, the later arrival is taken: on the shadow line
    of a corner both agree, and beyond it the nearer source is hidden.  Until then, and
    wherever one of them is closed, the front bends round this cell, which is then the source.

    Parameters
    ----------
    batch, count : ReachedCells, int
        Cells; those that `state` (n * n,) calls frozen are passed over.
    plane, agenda : PlaneLattice, MarchingState
    bucket : int
        The bucket being worked on; nothing is put into an earlier one.
    """
    n, found, places = plane.n, batch.cells, agenda.places
    tent, origin, status = agenda.tent, agenda.origin, agenda.status
    W = n + 2
    limited = plane.turns.shape[0] > 0
    for a in range(count):
        if state[found[a]] != FREE:
            continue
        k = places[a]
        ci = row_of(k, W)
        cj = k - ci * W
        home = origin[k]
        # Which neighbours matter is unpredictable: one mask instead of eight branches.
        mask = 0
        for d in range(8):
            q = k + STEP_I[d] * W + STEP_J[d]
            mask |= ((status[q] == UNKNOWN) & (origin[q] != home)) << d
        for m in range(MEMBERS[mask, 8]):
            d = MEMBERS[mask, m]
            di, dj = STEP_I[d], STEP_J[d]
            q = k + di * W + dj
            dy, dx = away_from(home, ci + di, cj + dj, plane)
            ax, ay = abs(dx), abs(dy)
            sx, sy = (1 if dx > 0.0 else -1), (W if dy > 0.0 else -W)
            major = q + sx if ax >= ay else q + sy
            corner = q + sx + sy
            if min(ax, ay) <= 1e-12:
                corner = major
            elif abs(ax - ay) <= 1e-12 and (
                k == q + sy or (k == corner and status[q + sy] == ACCEPTED)
            ):
                major = q + sy
            if status[major] == BEYOND:  # the ring is convex outwards: rays may graze it
                major = q + sy if major == q + sx else q + sx
            other = corner if k == major else major
            # Around the hand rays are too short for the rule, but no wall may be jumped there.
            near = bucket <= START_RADIUS * PER_CELL and home == HAND_SOURCE and di * dj == 0
            near = near and ax * ax + ay * ay <= START_RADIUS**2
            if near or (
                (k == major or k == corner)
                and (status[other] == ACCEPTED or (k == major and status[other] == BEYOND))
            ):
                source = home
                time = np.sqrt(dx * dx + dy * dy)
                if home != HAND_SOURCE:
                    time += tent[home]
                rival = origin[other]
                if not near and rival != home and other != home and status[other] == ACCEPTED:
                    dy, dx = away_from(rival, ci + di, cj + dj, plane)
                    later = np.sqrt(dx * dx + dy * dy)
                    if rival != HAND_SOURCE:
                        later += tent[rival]
                    if later > time:
                        time, source = later, rival
                if limited and near:
                    time = step_time(plane, bare(q, n), n * n, 0, 0.0, time)
                elif limited:
                    slope = min(ax, ay) / max(ax, ay, 1e-9)
                    share = slope if k == major else 1.0 - slope
                    share *= status[other] == ACCEPTED
                    length = np.sqrt(1.0 + slope * slope)
                    time = tent[k] + share * (tent[other] - tent[k])
                    time += step_time(plane, bare(q, n), found[a], bare(other, n), share, length)
            else:
                time, source = bend(k, q, di, dj, plane, agenda)
                if source < 0:
                    continue
            # A straight ray wins a tie: rays of a bend would run beside the true ones.
            if time >= tent[q] + (1e-9 if source == home else -1e-9):
                continue
            tent[q] = time
            origin[q] = source
            push(q, time, bucket, agenda)


@njit(_nrt=False)
def seed(plane, agenda):
    """Put the hand's cell, or the nearest where the hand can be, into the queue.

    The hand may be in several cells at once, on their borders.
    """
    n, hand_i, hand_j = plane.n, plane.hand_i, plane.hand_j
    reach = int(START_RADIUS) + 1
    nearest = START_RADIUS
    for turn in range(2):
        for i in range(max(int(hand_i) - reach, 1), min(int(hand_i) + reach + 2, n + 1)):
            for j in range(max(int(hand_j) - reach, 1), min(int(hand_j) + reach + 2, n + 1)):
                k = i * (n + 2) + j
                away = np.sqrt((i - hand_i) ** 2 + (j - hand_j) ** 2)
                if agenda.status[k] != UNKNOWN or away > max(nearest, HALF_DIAGONAL):
                    continue
                nearest = min(nearest, away)
                if turn == 1:
                    if plane.turns.shape[0] > 0:
                        away = step_time(plane, bare(k, n), n * n, 0, 0.0, away)
                    agenda.tent[k] = away
                    agenda.origin[k] = HAND_SOURCE
                    push(k, away, 0, agenda)


@njit(_nrt=False, forceinline=True)
def pop(bucket, plane, terms, agenda, batch):
    """Accept the cells waiting in a bucket; returns how many."""
    status, tent, queue = agenda.status, agenda.tent, agenda.queue
    count, n, slot = 0, plane.n, bucket % BUCKETS
    W = n + 2
    while queue.heads[slot] >= 0:
        k = take(slot, queue)
        # Entries made stale by an earlier arrival find their cell closed or accepted.
        if status[k] == UNKNOWN and tent[k] <= terms.end:
            status[k] = ACCEPTED
            agenda.places[count] = k
            # (i - 1) n + (j - 1) with k = i W + j and W = n + 2
            batch.cells[count] = k - 2 * row_of(k, W) - n - 1
            before = tent[k] if tent[k] > START_RADIUS else 0.0
            for e in (k - 1, k + 1, k - W, k + W):
                if status[e] == ACCEPTED and tent[e] < before:
                    before = tent[e]
            batch.since[count] = tent[k] - terms.lookback * (tent[k] - before)
            batch.when[count] = tent[k]
            count += 1
    return count


@njit(_nrt=False, forceinline=True)
def close(batch, count, state, agenda, arrival):
    """Record the arrivals of the accepted cells; close frozen and contacted cells."""
    for f in range(count):
        arrival[batch.cells[f]] = batch.when[f]
        if state[batch.cells[f]] != FREE:
            agenda.status[agenda.places[f]] = CLOSED


@njit
def agenda_of(plane):
    """Return an agenda in which nothing is reached yet."""
    n = plane.n
    size = (n + 2) * (n + 2)
    return MarchingState(
        plane.outside.copy(),
        np.full(size, 1e300),
        np.full(size, -1, dtype=np.int32),
        queue_of(9 * n * n, BUCKETS),
        np.empty(n * n, dtype=np.int64),
    )


@njit
def march(plane, terms, postures, state):
    """March the front over the lattice.

    Parameters
    ----------
    plane, terms, postures : PlaneLattice, Terms, Postures
        Times of the terms are in crossings.
    state : (n * n,) uint8 ndarray
        Filled with FREE, FROZEN or CONTACT.

    Returns
    -------
    arrival : (n * n,) ndarray
        In crossings, -1 where the front never came.
    cell, body : int
        First contact, -1 if none.
    time : float
        Its time [crossings].
    accepted : int
    """
    n, end = plane.n, terms.end
    agenda, batch = agenda_of(plane), batch_of(n)
    heads, arrival = agenda.queue.heads, np.full(n * n, -1.0)
    seed(plane, agenda)
    contact, body, time = -1, -1, -1.0
    bucket, empty, accepted = 0, 0, 0
    while empty < BUCKETS and bucket <= end * PER_CELL and (contact < 0 or terms.explore):
        empty += 1
        now = min((bucket + 1.0) / PER_CELL, end)
        posed = False
        while heads[bucket % BUCKETS] >= 0:
            empty = 0
            count = pop(bucket, plane, terms, agenda, batch)
            if count == 0:
                continue
            if not posed:
                poses_at(postures.bodies, now * terms.kappa, postures.poses)
                posed = True
            cell, target, t = judge(postures, terms, batch, count, now, state)
            if cell >= 0 and (contact < 0 or t < time):
                contact, body, time = cell, target, t
            close(batch, count, state, agenda, arrival)
            expand(batch, count, state, plane, agenda, bucket)
            accepted += count
        bucket += 1
    return arrival, contact, body, time, accepted
