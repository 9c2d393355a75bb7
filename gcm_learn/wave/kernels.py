"""The wave of Eq. 10 on a lattice, as numba kernels.

Speed comes from three choices.  The stencil vectorises (see `wave.stencil`).  Only blocks of cells
near the front are stepped: ahead of it the lattice rests, behind it the lattice is settled.  A cell
is checked for obstacles once, when the front arrives there.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.collision.occupancy import blocked_cells, met_targets
from gcm_learn.compiled import njit
from gcm_learn.scene.bodies import poses_at
from gcm_learn.wave.params import EXCITED, HAND_POTENTIAL, WaveRun, rhythm
from gcm_learn.wave.stencil import BLOCK, LEFT, two_steps

FREE, FROZEN, CONTACT = 0, 1, 2  # what became of a cell
UP_R, UP_Z = (np.float32(v) for v in EXCITED)
CLAMPED = np.float32(HAND_POTENTIAL)


class WaveLattice(NamedTuple):
    """Lattice of a wave: buffer and layout (`wave.stencil`), and the numbers of the run."""

    B: np.ndarray
    n: int
    W: int
    plane: int
    rate: np.ndarray  # (n * n,): of a cell's dynamics, the q of Eq. 10: 1, or less where it is slow
    active: np.ndarray  # (n + 2, blocks) bool: what is stepped
    points: int  # 5 or 9, of the Laplacian
    start: float  # time of the first state [tau]
    run: WaveRun


class Terms(NamedTuple):
    """Terms on which a front spreads; times in the front's own unit."""

    kappa: float  # seconds per unit
    shortest: float  # resolution of searches in time [s]
    grasp: float  # distance of a cell's centre and a target at which they are in contact
    ignore: float  # contacts before this do not count
    end: float  # horizon
    explore: bool  # go on after the first contact
    lookback: float  # share of the time since the front was next door that a cell must be free
    speed: float  # of the front [forearms/s]


class ReachedCells(NamedTuple):
    """Batch of cells that the front reaches together, with the results of their checks."""

    cells: np.ndarray
    since: np.ndarray  # when the front was next door
    when: np.ndarray
    blocked: np.ndarray
    body: np.ndarray  # target that is met
    met: np.ndarray  # when


@njit
def batch_of(n):
    """Make a batch for all cells of an n x n lattice."""
    since, when, met = np.empty(n * n), np.empty(n * n), np.empty(n * n)
    cells, body = np.empty(n * n, dtype=np.int64), np.empty(n * n, dtype=np.int64)
    return ReachedCells(cells, since, when, np.empty(n * n, dtype=np.bool_), body, met)


@njit(_nrt=False)
def live_weight(points, corner):
    """Weight of an edge or corner neighbour in the discrete Laplacian."""
    if points == 5:
        return np.float32(0.0 if corner else 1.0)
    return np.float32(1.0 / 6.0 if corner else 4.0 / 6.0)


@njit
def prepare(ground, inside, rest_r, rest_z):
    """Fill the buffer for a lattice at rest: no-flux at its border and outside the ring."""
    B, n, W, plane = ground.B, ground.n, ground.W, ground.plane
    rate, step, points = ground.rate, ground.run.step, ground.points
    B[:] = 0.0
    for i in range(n):
        for j in range(n):
            if not inside[i * n + j]:
                continue
            k = (i + 1) * W + j + LEFT
            B[k] = rest_r
            B[k + plane] = rest_r
            B[k + 2 * plane] = rest_z
            B[k + 3 * plane] = step * rate[i * n + j]
            live = np.float32(0.0)
            for di in range(-1, 2):
                for dj in range(-1, 2):
                    a, b = i + di, j + dj
                    if (di != 0 or dj != 0) and 0 <= a < n and 0 <= b < n and inside[a * n + b]:
                        live += live_weight(points, di != 0 and dj != 0)
            B[k + 4 * plane] = live
            B[k + 5 * plane] = -1.0


@njit(_nrt=False)
def excite(ground, disc, away):
    """Excite cells `disc` (m,), `away` (m,) [cells] from the hand; clamp the first, the hand's."""
    B, plane = ground.B, ground.plane
    for i in range(disc.size):
        k = entry_of(disc[i], ground)
        B[k] = B[k + plane] = UP_R if i > 0 else CLAMPED
        B[k + 5 * plane] = away[i] * ground.run.slowness
        if i > 0:
            B[k + 2 * plane] = UP_Z
    B[entry_of(disc[0], ground) + 3 * plane] = 0.0


@njit(_nrt=False, forceinline=True)
def entry_of(m, ground):
    """Place of a cell in a plane of the buffer."""
    return (m // ground.n + 1) * ground.W + m % ground.n + LEFT


@njit(forceinline=True)
def insulate(B, k, W, plane, points):
    """Cut a cell out of the lattice: it neither changes nor is seen by its neighbours."""
    B[k] = B[k + plane] = 0.0
    B[k + 3 * plane] = 0.0
    for di in range(-1, 2):
        for dj in range(-1, 2):
            if di != 0 or dj != 0:
                B[k + di * W + dj + 4 * plane] -= live_weight(points, di != 0 and dj != 0)


@njit(forceinline=True)
def hold(B, k, plane):
    """Stop a cell's dynamics; the neighbours still see its potential (Eq. 10 with q = 0)."""
    B[k + plane] = B[k]
    B[k + 3 * plane] = 0.0


@njit(forceinline=True)
def next_door(B, k, W, plane):
    """Arrival of the earliest edge neighbour that passes the front on, -1 if none.

    Only through an edge does it arrive: two insulated cells that touch at a corner are a wall.
    """
    best = np.float32(-1.0)
    for e in (k - W, k - 1, k + 1, k + W):
        c = B[e + 5 * plane]
        # Insulated cells and the padding have no potential; where it is negative, nobody has been.
        if B[e] > 0.0 and c >= 0.0 and (best < 0.0 or c < best):
            best = c
    return best


@njit(_nrt=False, forceinline=True)
def stirred(B, start, other, quiet):
    """Return whether a potential of a block differs between its two time levels.

    Parameters
    ----------
    other : int
        Offset of the other time level in the buffer.
    quiet : float32
        Difference that does not count.
    """
    count, up = np.int32(0), np.uint64(other)
    for k in range(np.uint64(start), np.uint64(start) + np.uint64(BLOCK)):
        count += np.int32(abs(B[k] - B[k + up]) > quiet)
    return count > 0


@njit
def find_runs(ground, threshold, lo, hi, watch):
    """Renew the set of active blocks; returns the numbers of runs and of watched blocks.

    A block stays active while a potential in it still changes by more than `quiet` a step.  It
    wakes its neighbours in the four directions, sideways only when its edge cells change.  Active
    blocks are listed as runs lo:hi.  Blocks with a cell above a tenth of the threshold are listed
    in `watch`: it may cross the threshold before the next renewal.
    """
    B, W, plane, active = ground.B, ground.W, ground.plane, ground.active
    quiet = np.float32(ground.run.quiet * ground.run.step)
    rows, blocks = active.shape
    wake = np.zeros((rows, blocks), dtype=np.bool_)
    for i in range(1, rows - 1):
        for b in range(blocks):
            if not active[i, b]:
                continue
            start = i * W + LEFT + b * BLOCK
            if not stirred(B, start, plane, quiet):
                continue
            wake[i, b] = wake[i - 1, b] = wake[i + 1, b] = True
            if b > 0 and abs(B[start] - B[start + plane]) > quiet:
                wake[i, b - 1] = True
            last = start + BLOCK - 1
            if b + 1 < blocks and abs(B[last] - B[last + plane]) > quiet:
                wake[i, b + 1] = True
    runs, watched = 0, 0
    low = np.float32(0.1) * threshold
    for i in range(1, rows - 1):
        inside = False
        for b in range(blocks):
            active[i, b] = wake[i, b]
            start = i * W + LEFT + b * BLOCK
            if not wake[i, b]:
                inside = False
                continue
            if not inside:
                lo[runs] = start
                runs += 1
                inside = True
            hi[runs - 1] = start + BLOCK
            if crossed(B, np.uint64(start), 5 * plane, low):
                watch[watched] = start
                watched += 1
    return runs, watched


@njit
def every_block(ground, lo, hi, watch):
    """List every block of every row as active and watched."""
    n, W, blocks = ground.n, ground.W, ground.active.shape[1]
    for i in range(n):
        lo[i] = (i + 1) * W + LEFT
        hi[i] = lo[i] + np.uint64(blocks * BLOCK)
        for b in range(blocks):
            watch[i * blocks + b] = lo[i] + np.uint64(b * BLOCK)
    return n, n * blocks


@njit(forceinline=True)
def crossed(B, start, arrived, level):
    """Return whether any cell of a block is above a level and has no arrival yet.

    Parameters
    ----------
    arrived : int
        Offset of the plane of arrivals in the buffer.
    """
    count = np.int32(0)
    a = np.uint64(arrived)
    for k in range(start, start + np.uint64(BLOCK)):
        count += np.int32((B[k] >= level) & (B[k + a] < np.float32(0.0)))
    return count > 0


@njit(_nrt=False, forceinline=True)
def when_crossed(B, k, other, tau, before, run):
    """Time at which the potential at k crossed the threshold before a check at `tau` [tau].

    Parameters
    ----------
    other : int
        Offset of the other time level in the buffer.
    before : float
        Arrival next door, which comes first [tau].
    """
    rise = B[k] - B[k + other]
    back = run.step * (B[k] - np.float32(run.threshold)) / rise if rise > 0.0 else 0.0
    return max(tau - min(back, run.lag), before)


@njit
def arrivals(ground, watch, watched, tau, batch):
    """Find and record the cells that crossed the threshold since the last look; returns how many.

    The batch is filled with them, with the arrival next door and their own [tau].
    """
    B, n, W, plane = ground.B, ground.n, ground.W, ground.plane
    threshold = np.float32(ground.run.threshold)
    found, since, when = batch.cells, batch.since, batch.when
    count = 0
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
                continue
            found[count] = corner + k
            when[count] = when_crossed(B, k, plane, tau, before, ground.run)
            since[count] = before
            count += 1
    # Written down only now, so that no cell passes on what has not been judged yet.
    for i in range(count):
        B[entry_of(found[i], ground) + 5 * plane] = when[i]
    return count


@njit
def judge(postures, terms, batch, count, now, state):
    """Mark the cells just reached: FROZEN where an obstacle touches, CONTACT at a target (Eq. 11).

    A cell freezes when its limb is touched at any instant from the front's arrival next door
    (`since`) until now.  This covers the time between two looks and, with the gap, the space
    between cells.

    Returns
    -------
    cell, body : int
        The earliest contact among them, -1 if none.
    time : float
        Its time, in the front's unit.
    """
    contact, contact_body, contact_time = -1, -1, -1.0
    kappa, shortest = terms.kappa, terms.shortest
    found, since, when, blocked, body, met = batch
    for i in range(count):
        since[i] *= kappa
    t1 = now * kappa
    blocked_cells(postures, found, since, count, t1, shortest, blocked)
    met_targets(postures, terms.grasp, found, since, count, t1, shortest, body, met)
    for i in range(count):
        if blocked[i]:
            state[found[i]] = FROZEN
        elif body[i] >= 0 and met[i] >= terms.ignore * kappa:
            state[found[i]] = CONTACT
            time = max(met[i] / kappa, when[i])
            if contact < 0 or time < contact_time:
                contact, contact_body, contact_time = found[i], body[i], time
    return contact, contact_body, contact_time


@njit
def freeze(ground, batch, count, state):
    """Take the batch's frozen and contacted cells out of the dynamics."""
    for i in range(count):
        m = batch.cells[i]
        if state[m] == FREE:
            continue
        k = entry_of(m, ground)
        if ground.run.held:
            hold(ground.B, k, ground.plane)
        else:
            insulate(ground.B, k, ground.W, ground.plane, ground.points)


@njit
def propagate(ground, terms, postures, state):
    """Run the wave until contact, end or horizon; the buffer must be prepared and excited.

    Parameters
    ----------
    ground, terms, postures : WaveLattice, Terms, Postures
        Times of the terms are mental.
    state : (n * n,) uint8 ndarray
        Filled with FREE, FROZEN or CONTACT.

    Returns
    -------
    cell, body : int
        First contact, -1 if none.
    time : float
        Mental time of the first contact.
    steps : int
        Euler steps made.
    """
    n, W, blocks, end = ground.n, ground.W, ground.active.shape[1], terms.end
    d, eps = np.float32(ground.run.diffusion), np.float32(ground.run.epsilon * ground.run.step)
    threshold = np.float32(ground.run.threshold)
    pairs, looks = rhythm(ground.run)
    batch = batch_of(n)
    lo = np.zeros(n * blocks, dtype=np.uint64)
    hi, watch = np.zeros_like(lo), np.zeros_like(lo)
    runs, watched = every_block(ground, lo, hi, watch)
    contact, body, time = -1, -1, -1.0
    look, tau = 0, ground.start
    while tau < end and runs > 0 and (contact < 0 or terms.explore):
        for _ in range(pairs):
            two_steps(ground.B, lo, hi, runs, d, eps, W, ground.points)
        look += 1
        tau = ground.start + look * 2 * pairs * ground.run.step
        count = arrivals(ground, watch, watched, tau, batch)
        if count > 0:
            now = min(tau, end)
            poses_at(postures.bodies, now * terms.kappa, postures.poses)
            cell, target, t = judge(postures, terms, batch, count, now, state)
            if cell >= 0 and contact < 0:
                contact, body, time = cell, target, t
            freeze(ground, batch, count, state)
        if look % looks == 0:
            runs, watched = find_runs(ground, threshold, lo, hi, watch)
    return contact, body, time, 2 * pairs * look
