"""The wave of Eq. 10 on a lattice, as numba kernels.

Speed comes from three choices.  (1) The stencil vectorises (see `wave.stencil`).  (2) Only blocks
of cells near the front are stepped: ahead of it the lattice rests, behind it it is settled.
(3) Whether a cell is occupied is asked once, when the front arrives there.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.collision.occupancy import blocked_cells, met_targets
from gcm_learn.compiled import njit
from gcm_learn.scene.bodies import poses_at
from gcm_learn.wave.stencil import BLOCK, LEFT, two_steps

FREE, FROZEN, CONTACT = 0, 1, 2  # what became of a cell

CONSTANTS = 8  # length of the array of float constants below
STEP, DIFFUSION, EPSILON, THRESHOLD, KAPPA, GRASP, QUIET, SHORTEST = range(CONSTANTS)


@njit
def live_weight(points, corner):
    """Weight of an edge or corner neighbour in the discrete Laplacian."""
    if points == 5:
        return np.float32(0.0 if corner else 1.0)
    return np.float32(1.0 / 6.0 if corner else 4.0 / 6.0)


@njit
def prepare(B, n, W, plane, points, inside, rate, step, rest_r, rest_z):
    """Fill the buffer for a lattice at rest: no-flux at its border and outside the ring.

    A cell's dynamics run at its `rate` (n * n,), the q of Eq. 10: 1, or less where the front is to
    be slower.
    """
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


@njit
def excite(B, n, W, plane, hand_cell, hand_x, hand_y, spacing, radius, slowness, limb, inside):
    """Clamp the hand's neuron and excite a disc of `radius` [cells] around the hand."""
    for m in range(n * n):
        away = np.sqrt((limb[m, 0] - hand_x) ** 2 + (limb[m, 1] - hand_y) ** 2) / spacing
        if inside[m] and away <= radius:
            k = (m // n + 1) * W + m % n + LEFT
            B[k] = B[k + plane] = 3.0
            B[k + 2 * plane] = 1.0 / 7.0
            B[k + 5 * plane] = away * slowness
    k = (hand_cell // n + 1) * W + hand_cell % n + LEFT
    B[k] = B[k + plane] = 5.0
    B[k + 3 * plane] = 0.0
    B[k + 5 * plane] = 0.0


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
    """Stop a cell's dynamics and leave its potential to be seen (Eq. 10 with q = 0)."""
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


@njit
def find_runs(B, W, plane, active, quiet, threshold, lo, hi, watch):
    """Renew the set of active blocks; returns the numbers of runs and of watched blocks.

    A block stays active while a potential in it still changes by more than `quiet` a step, and
    wakes its neighbours in the four directions (sideways only when its edge cells change).
    Active blocks are listed as runs lo:hi; those in which a cell may cross the threshold before
    the next renewal, being above a tenth of it, are listed in `watch`.
    """
    rows, blocks = active.shape
    wake = np.zeros((rows, blocks), dtype=np.bool_)
    size, up = np.uint64(BLOCK), np.uint64(plane)
    for i in range(1, rows - 1):
        for b in range(blocks):
            if not active[i, b]:
                continue
            start = i * W + LEFT + b * BLOCK
            moving = np.int32(0)
            for k in range(np.uint64(start), np.uint64(start) + size):
                moving += np.int32(abs(B[k] - B[k + up]) > quiet)
            if moving == 0:
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
            if crossed(B, np.uint64(start), plane, low):
                watch[watched] = start
                watched += 1
    return runs, watched


@njit
def every_block(n, W, blocks, lo, hi, watch):
    """List every block of every row as active and watched."""
    for i in range(n):
        lo[i] = (i + 1) * W + LEFT
        hi[i] = lo[i] + np.uint64(blocks * BLOCK)
        for b in range(blocks):
            watch[i * blocks + b] = lo[i] + np.uint64(b * BLOCK)
    return n, n * blocks


@njit(forceinline=True)
def crossed(B, start, plane, level):
    """Tell whether any cell of a block is above a level and has no arrival yet."""
    count = np.int32(0)
    a = np.uint64(5 * plane)
    for k in range(start, start + np.uint64(BLOCK)):
        count += np.int32((B[k] >= level) & (B[k + a] < np.float32(0.0)))
    return count > 0


@njit
def arrivals(B, n, W, plane, watch, watched, threshold, step, tau, lag, found, since, when):
    """Find and record the cells that crossed the threshold since the last look.

    Parameters
    ----------
    lag : float
        Mental time since the last look.
    found : (n * n,) int64 ndarray
        Filled with their flat indices.
    since, when : (n * n,) ndarray
        Filled with the arrival next door and their own [tau].

    Returns
    -------
    int
        How many there are.
    """
    count = 0
    for w in range(watched):
        if not crossed(B, watch[w], plane, threshold):
            continue
        first = np.int64(watch[w])
        corner = (first // W - 1) * n + first % W - LEFT - first
        for k in range(first, first + BLOCK):
            if B[k] < threshold or B[k + 5 * plane] >= 0.0:
                continue
            before = np.float64(next_door(B, k, W, plane))
            if before < 0.0:
                continue
            rise = B[k] - B[k + plane]
            back = step * (B[k] - threshold) / rise if rise > 0.0 else 0.0
            found[count] = corner + k
            when[count] = max(tau - min(back, lag), before)
            since[count] = before
            count += 1
    # Written down only now, so that no cell passes on what has not been judged yet.
    for i in range(count):
        k = (found[i] // n + 1) * W + found[i] % n + LEFT
        B[k + 5 * plane] = when[i]
    return count


@njit
def judge(
    found, since, when, count, limb, gap, bodies, poses, c, now, ignore, state,
    blocked, body, met, scratch,
):  # fmt: skip
    """Decide what becomes of the cells that the front has just reached (Eq. 11).

    A cell freezes when its limb is touched at any instant between the front's arrival next door
    (`since`) and now: this covers the time between two looks and, with the gap, the space between
    cells.  Times are in the front's own unit, c[KAPPA] seconds each.

    Returns
    -------
    cell, body : int
        The earliest contact among them, -1 if none.
    time : float
        Its time.
    """
    contact, contact_body, contact_time = -1, -1, -1.0
    kappa, shortest = c[KAPPA], c[SHORTEST]
    for i in range(count):
        since[i] *= kappa
    t1 = now * kappa
    blocked_cells(bodies, poses, limb, gap, found, since, count, t1, shortest, blocked, scratch)
    met_targets(
        bodies, poses, limb, c[GRASP], found, since, count, t1, shortest, body, met, scratch
    )
    for i in range(count):
        if blocked[i]:
            state[found[i]] = FROZEN
        elif body[i] >= 0 and met[i] >= ignore * kappa:
            state[found[i]] = CONTACT
            time = max(met[i] / kappa, when[i])
            if contact < 0 or time < contact_time:
                contact, contact_body, contact_time = found[i], body[i], time
    return contact, contact_body, contact_time


@njit
def freeze(B, n, W, plane, points, found, count, state, held):
    """Take the frozen and contacted ones among the cells just found out of the dynamics."""
    for i in range(count):
        m = found[i]
        if state[m] == FREE:
            continue
        k = (m // n + 1) * W + m % n + LEFT
        if held:
            hold(B, k, plane)
        else:
            insulate(B, k, W, plane, points)


@njit
def propagate(
    B, n, W, plane, blocks, points, limb, gap, bodies, c, held, explore, tau0, tau_end, ignore,
    state,
):  # fmt: skip
    """Run the wave until contact, end or horizon; the buffer must be prepared and excited.

    Parameters
    ----------
    n, W, plane, blocks : int
        `Layout` of the buffer.
    points : int
        5 or 9, of the Laplacian.
    gap : (n * n,) ndarray
        Distance at which an obstacle occupies a cell: thickness and margin.
    c : (CONSTANTS,) ndarray
        Float constants, indexed by the names above.
    held : bool
        Frozen cells keep their potential instead of being cut out.
    explore : bool
        Go on after the first contact.
    tau0, tau_end : float
        Mental time of the prepared state and of the horizon.
    ignore : float
        Contacts before this mental time do not count.
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
    f4 = np.float32
    step, threshold = c[STEP], f4(c[THRESHOLD])
    d, eps, quiet = f4(c[DIFFUSION]), f4(c[EPSILON] * step), f4(c[QUIET] * step)
    pairs = max(1, int(0.6 / step + 1e-9))  # pairs of Euler steps between looks at the front
    looks = max(1, int(3.6 / (2 * pairs * step)))  # looks between renewals of the runs
    poses = np.zeros((bodies.rows.shape[0], 12))
    scratch = np.zeros_like(poses)
    found, blocked = np.zeros(n * n, dtype=np.int64), np.zeros(n * n, dtype=np.bool_)
    since, when, met_time = np.empty(n * n), np.empty(n * n), np.empty(n * n)
    met_body = np.empty(n * n, dtype=np.int64)
    active = np.ones((n + 2, blocks), dtype=np.bool_)
    lo = np.zeros(n * blocks, dtype=np.uint64)
    hi, watch = np.zeros_like(lo), np.zeros_like(lo)
    runs, watched = every_block(n, W, blocks, lo, hi, watch)
    contact, body, time = -1, -1, -1.0
    look, tau = 0, tau0
    while tau < tau_end and runs > 0 and (contact < 0 or explore):
        for _ in range(pairs):
            two_steps(B, lo, hi, runs, d, eps, W, points)
        look += 1
        tau = tau0 + look * 2 * pairs * step
        count = arrivals(
            B, n, W, plane, watch, watched, threshold, step, tau, 2 * pairs * step,
            found, since, when,
        )  # fmt: skip
        if count > 0:
            now = min(tau, tau_end)
            poses_at(bodies, now * c[KAPPA], poses)
            cell, target, t = judge(
                found, since, when, count, limb, gap, bodies, poses, c, now, ignore, state,
                blocked, met_body, met_time, scratch,
            )  # fmt: skip
            if cell >= 0 and contact < 0:
                contact, body, time = cell, target, t
            freeze(B, n, W, plane, points, found, count, state, held)
        if look % looks == 0:
            runs, watched = find_runs(B, W, plane, active, quiet, threshold, lo, hi, watch)
    return contact, body, time, 2 * pairs * look
