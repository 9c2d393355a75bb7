"""The wave of Eq. 10 that may wait: the excited region is where the hand can be, at every moment.

A state is a cell in one of its safe intervals, as in `wave.layered`; a cell that is excited again
after an obstacle has gone is another state.  The module `wave.inhibition` has the effects of
obstacles on cells.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.collision.intervals import meet, safe_until
from gcm_learn.collision.occupancy import blocked_cells
from gcm_learn.compiled import njit
from gcm_learn.scene.bodies import poses_at
from gcm_learn.wave.inhibition import (
    ARRIVAL,
    END,
    LOOK,
    PENDING,
    REST_R,
    REST_Z,
    STEP_I,
    STEP_J,
    TOTAL,
    UNFELT,
    hold_up,
    inhibit,
    leap,
    make_date,
    mental,
    seconds,
    turn_page,
)
from gcm_learn.wave.kernels import (
    CLAMPED,
    UP_R,
    UP_Z,
    crossed,
    entry_of,
    every_block,
    find_runs,
    next_door,
    when_crossed,
)
from gcm_learn.wave.params import rhythm
from gcm_learn.wave.stencil import BLOCK, LEFT, two_steps

CELL, VIA = 0, 1  # columns of a state
FELT = np.float32(0.05)  # potential at which a cell feels the front coming
AHEAD = np.float32(-0.5)  # instead of the arrival of a cell that feels it
ROOT2 = float(np.sqrt(2.0))


@njit
def way_back(k, m, when, ground, book):
    """State from which the front came to a cell: where its arrivals fall off most steeply.

    Among neighbours that have been waiting it is the neighbour that was reached first, in which the
    hand can wait longest.  Corner neighbours count if the front can also get there through edges.
    """
    B, n, W, plane = ground.B, ground.n, ground.W, ground.plane
    best, steepest = -1, -1.0
    for d in range(8):
        di, dj = STEP_I[d], STEP_J[d]
        e = k + di * W + dj
        arrival = np.float64(B[e + 5 * plane])
        if B[e] <= 0.0 or arrival < 0.0 or arrival > when:
            continue
        length = 1.0
        if d > 3:
            a, b = k + di * W, k + dj
            through = (B[a] > 0.0 and B[a + 5 * plane] >= 0.0) or (
                B[b] > 0.0 and B[b + 5 * plane] >= 0.0
            )
            if not through:
                continue
            length = ROOT2
        fall = (when - arrival) / length
        if fall > steepest:
            best, steepest = book.latest[m + di * n + dj], fall
    return best


@njit(forceinline=True)
def stirs(B, start, plane):
    """Tell whether any cell of a block feels the front for the first time."""
    count, a = np.int32(0), np.uint64(5 * plane)
    for k in range(start, start + np.uint64(BLOCK)):
        count += np.int32((B[k] >= FELT) & (B[k + a] == UNFELT))
    return count > 0


@njit
def feel(watch, watched, tau, ground, world, book, batch):
    """Inhibit cells in which an obstacle is when the front comes near.

    Otherwise they would draw from the front, at rest, until they are reached: fronts would lag
    along walls and go out in gaps.
    """
    B, n, W, plane, count = ground.B, ground.n, ground.W, ground.plane, 0
    now = min(seconds(tau, world), world.end)
    for w in range(watched):
        if not stirs(B, watch[w], plane):
            continue
        first = np.int64(watch[w])
        corner = (first // W - 1) * n + first % W - LEFT - first
        for k in range(first, first + BLOCK):
            if B[k] >= FELT and B[k + 5 * plane] == UNFELT:
                B[k + 5 * plane] = AHEAD
                batch.cells[count], batch.since[count] = corner + k, now
                count += 1
    if count == 0:
        return
    poses_at(world.postures.bodies, now, world.postures.poses)
    blocked_cells(
        world.postures, batch.cells, batch.since, count, now, world.shortest, batch.blocked
    )
    for i in range(count):
        if batch.blocked[i]:
            book.refused[batch.cells[i]] = True
            inhibit(batch.cells[i], now, ground, world, book)


@njit
def reached(watch, watched, tau, ground, book, batch):
    """Find the cells that crossed the threshold since the last look; returns how many.

    Crossing counts only next to a cell that has been reached and is excited.  Without one a cell
    that goes on rising is put back to rest: it had been charged by cells that are inhibited now.
    """
    B, n, W, plane = ground.B, ground.n, ground.W, ground.plane
    threshold, count = np.float32(ground.run.threshold), 0
    risen = np.float32(0.5) * (threshold + UP_R)
    for w in range(watched):
        if not crossed(B, watch[w], 5 * plane, threshold):
            continue
        first = np.int64(watch[w])
        corner = (first // W - 1) * n + first % W - LEFT - first
        for k in range(first, first + BLOCK):
            if B[k] < threshold or B[k + 5 * plane] >= 0.0:
                continue
            before = np.float64(next_door(B, k, W, plane))
            if before < 0.0:
                if B[k] > risen:
                    B[k], B[k + 2 * plane] = REST_R, REST_Z
                continue
            m = corner + k
            before = max(before, book.opened[m])
            when = when_crossed(B, k, plane, tau, before, ground.run)
            batch.cells[count], batch.since[count], batch.when[count] = m, before, when
            batch.via[count] = way_back(k, m, when, ground, book)
            count += 1
    return count


@njit
def admit(count, tau, ground, world, book, batch):
    """Inhibit reached cells to which an obstacle came; returns the number of others.

    A cell must have been free since the front was next door, or since it was released.
    """
    now = min(seconds(tau, world), world.end)
    room = book.states.shape[0] - book.tally[TOTAL]
    for i in range(count):
        batch.since[i] = seconds(batch.since[i], world)
    poses_at(world.postures.bodies, now, world.postures.poses)
    blocked_cells(
        world.postures, batch.cells, batch.since, count, now, world.shortest, batch.blocked
    )
    free = 0
    for i in range(count):
        m = batch.cells[i]
        if seconds(batch.when[i], world) > world.end:
            continue
        if batch.blocked[i] or free >= room:
            book.refused[m] |= batch.blocked[i]
            inhibit(m, now, ground, world, book)
            continue
        batch.cells[free], batch.via[free], batch.when[free] = m, batch.via[i], batch.when[i]
        batch.since[free] = now
        free += 1
    return free


@njit
def settle(count, ground, world, book, batch, best):
    """Make states of cells that are reached; returns the first meeting (state or -1, body, time).

    `since` has the times [s] at which they are known to be free, `best` [s] bounds what meetings
    are of interest.
    """
    total = book.tally[TOTAL]
    safe_until(
        world.postures, batch.cells, batch.since, batch.until, count, world.end, world.shortest
    )
    for i in range(count):
        m, s = batch.cells[i], total + i
        arrival = seconds(batch.when[i], world)
        if s == 0:  # the hand is there, and has to have time to leave
            batch.until[i] = max(batch.until[i], ground.run.slowness * world.kappa)
        book.states[s, CELL], book.states[s, VIA] = m, batch.via[i]
        book.spans[s, ARRIVAL], book.spans[s, END] = arrival, batch.until[i]
        book.latest[m] = s
        ground.B[entry_of(m, ground) + 5 * ground.plane] = batch.when[i]
        if batch.until[i] < world.end:
            make_date(m, mental(batch.until[i], world), ground, book)
        batch.since[i] = max(arrival, world.ignore)
    book.tally[TOTAL] = total + count
    index, body, time = meet(
        world.postures, world.grasp, batch.cells, batch.since, batch.until, count, world.shortest,
        best,
    )  # fmt: skip
    return (total + index if index >= 0 else -1), body, time


@njit
def set_out(disc, away, ground, world, book, batch):
    """Excite the hand's cell and, as far as it is free, the disc around it.

    Parameters
    ----------
    disc : (m,) ndarray
        Cells, the hand's first, then by distance.
    away : (m,) ndarray
        Their distances from the hand [cells].

    Returns
    -------
    int
        How many cells there are in the batch.
    """
    B, W, plane, count = ground.B, ground.W, ground.plane, 0
    since, blocked = np.zeros(1), np.zeros(1, dtype=np.bool_)
    for i in range(disc.size):
        m, when = disc[i], away[i] * ground.run.slowness
        k, via = entry_of(m, ground), -1
        if i > 0:
            before = np.float64(next_door(B, k, W, plane))
            if before < 0.0:
                continue  # behind cells that are not free
            since[0], now = seconds(before, world), seconds(when, world)
            poses_at(world.postures.bodies, now, world.postures.poses)
            blocked_cells(world.postures, disc[i : i + 1], since, 1, now, world.shortest, blocked)
            if blocked[0]:
                book.refused[m] = True
                inhibit(m, now, ground, world, book)
                continue
            via = way_back(k, m, when, ground, book)
        B[k] = B[k + plane] = UP_R if i > 0 else CLAMPED
        B[k + 2 * plane], B[k + 5 * plane] = UP_Z, when
        batch.cells[count], batch.via[count], batch.when[count] = m, via, when
        batch.since[count] = seconds(when, world)
        book.latest[m] = count  # the number of the state that it is going to be
        count += 1
    B[entry_of(disc[0], ground) + 3 * plane] = 0.0
    return count


@njit
def propagate_layers(disc, away, ground, world, book, batch):
    """Run the wave until a contact or the horizon; the buffer must be prepared.

    Parameters
    ----------
    disc, away : (m,) ndarray
        Cells that are excited at the start, see `set_out`.
    ground, world, book, batch : Ground, World, Book, Batch
        The book is filled.

    Returns
    -------
    state, body : int
        Where a target is met first, -1 if none is.
    time : float
        When [s]; the horizon if none is.
    """
    n, W, blocks = ground.n, ground.W, ground.active.shape[1]
    d, eps = np.float32(ground.run.diffusion), np.float32(ground.run.epsilon * ground.run.step)
    pairs, looks = rhythm(ground.run)
    lo = np.zeros(n * blocks, dtype=np.uint64)
    hi, watch = np.zeros_like(lo), np.zeros_like(lo)
    runs, watched = every_block(ground, lo, hi, watch)
    count = set_out(disc, away, ground, world, book, batch)
    met, body, time = settle(count, ground, world, book, batch, world.end)
    tau = ground.start
    while seconds(tau, world) < (world.end if world.explore else time):
        if runs == 0:
            if book.tally[PENDING] == 0:
                break
            book.tally[LOOK] += leap(ground, world, book)
        for _ in range(pairs):
            two_steps(ground.B, lo, hi, runs, d, eps, W, ground.points)
        book.tally[LOOK] += 1
        tau = ground.start + book.tally[LOOK] * ground.run.lag
        count = reached(watch, watched, tau, ground, book, batch)
        if count > 0:
            count = admit(count, tau, ground, world, book, batch)
            state, target, t = settle(count, ground, world, book, batch, time)
            if state >= 0:
                met, body, time = state, target, t
        feel(watch, watched, tau, ground, world, book, batch)
        woken = turn_page(tau, ground, world, book)
        hold_up(runs, lo, hi, ground)
        if woken or book.tally[LOOK] % looks == 0:
            # At a threshold of 0 every active block with a cell to be reached is watched.
            runs, watched = find_runs(ground, np.float32(0.0), lo, hi, watch)
    return met, body, time
