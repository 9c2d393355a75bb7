"""The wave of Eq. 10 in space, as numba kernels.

It is quick for the reasons that `wave.kernels` gives: the stencil vectorises, only blocks of cells
near the front are stepped, and a cell is checked once.  In space the front is a
shell that passes by most cells only once, and the lattice has half a million of them.  So what is
known of a cell, its posture first of all, is found out when its block wakes: ahead of the front.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.arms.limbs import dof
from gcm_learn.arms.spatial_limb import limb_at
from gcm_learn.charts.posture_lattice import NOWHERE, is_there
from gcm_learn.charts.postures import posture_of, turning_time
from gcm_learn.collision.postures import desk_of
from gcm_learn.compiled import njit
from gcm_learn.wave.kernels import CLAMPED, FREE, UP_R, UP_Z, crossed, stirred, when_crossed
from gcm_learn.wave.params import rhythm
from gcm_learn.wave.posture_ground import (
    ADAPTED,
    ARRIVED,
    DOORS,
    GAPS,
    MOST,
    SHARE,
    UNASKED,
    WHOLE,
    cell_of,
    entry_of,
    four_joints,
    insulate,
    is_step,
)
from gcm_learn.wave.posture_judging import freeze, judge_cells
from gcm_learn.wave.posture_stencil import BLOCK, FIELD, LEFT, SLAB, WIDTH, steps

ASLEEP, SEEN, AWAKE = 0, 1, 2  # what this wave knows of a block: nothing, postures, rates as well
SPREAD = 5.0  # how far a ball with sharp edges is felt before the first look [cells]


@njit(_nrt=False)
def _ask(iz, iy, b, ground):
    """Find the postures and elbows of a block's cells."""
    n, elbows, nodes = ground.n, ground.found.elbows, ground.found.nodes
    q = nodes.scratch
    state = WHOLE
    for ix in range((b - 1) * BLOCK, min(b * BLOCK, n)):
        m = ((iz - 1) * n + iy - 1) * n + ix
        if not is_there(nodes, m):
            state = GAPS
            continue
        for j in range(dof(nodes.rule.limb)):
            q[j] = nodes.joints[m, j]
        elbows[m, 0], elbows[m, 1], elbows[m, 2], _, _, _ = limb_at(nodes.rule.limb, q)
    ground.found.asked[iz, iy, b] = state


@njit(_nrt=False)
def _see(iz, iy, b, ground):
    """Cut the cells of a block that have no posture out of the lattice."""
    n, asked = ground.n, ground.found.asked
    if asked[iz, iy, b] == UNASKED:
        _ask(iz, iy, b, ground)
    ground.known[iz, iy, b] = SEEN
    if asked[iz, iy, b] == WHOLE:
        return
    for ix in range((b - 1) * BLOCK, min(b * BLOCK, n)):
        m = ((iz - 1) * n + iy - 1) * n + ix
        if not is_there(ground.found.nodes, m):
            insulate(ground.B, entry_of(m, n))


@njit(_nrt=False)
def _rate(m, ix, iy, iz, ground):
    """Rate of a cell: the mean speed of the hand over the steps from it, as a share of the front's.

    The indices begin with 1, as the indices of blocks do.
    """
    n, joints, unit = ground.n, ground.found.nodes.joints, ground.found.nodes.spacing / ground.speed
    total, count = 0.0, 0
    for d in range(6):
        axis, way = d // 2, 2 * (d % 2) - 1
        place = (ix, iy, iz)[axis] + way
        if place < 1 or place > n:
            continue
        p = m + way * (1, n, n * n)[axis]
        if joints[p, 0] < NOWHERE and is_step(joints, ground.found.nodes.leap, m, p):
            turning = turning_time(
                ground.joint_speed, four_joints(joints, m), four_joints(joints, p)
            )
            total += min(unit / turning, 1.0) if turning > 0.0 else 1.0
            count += 1
    return max(total / count, ground.slowest) if count > 0 else 1.0


@njit
def speeds_at(rule, joint_speed, spacing, hands):
    """Mean speed (k,) of hands (k, 3) over steps of `spacing` along the axes; -1 without a step.

    Steps at which the rule jumps count as if the hand stood still.
    """
    out, q, p = np.full(hands.shape[0], -1.0), np.empty(4), np.empty(4)
    for k in range(hands.shape[0]):
        x, y, z = hands[k, 0], hands[k, 1], hands[k, 2]
        if not posture_of(rule, 0, x, y, z, q):
            continue
        total, count = 0.0, 0
        for d in range(6):
            axis, way = d // 2, (2 * (d % 2) - 1) * spacing
            there = (x + way * (axis == 0), y + way * (axis == 1), z + way * (axis == 2))
            if posture_of(rule, 0, there[0], there[1], there[2], p):
                total += spacing / max(turning_time(joint_speed, q, p), 1e-12)
                count += 1
        if count > 0:
            out[k] = total / count
    return out


@njit(_nrt=False)
def _rouse(iz, iy, b, ground):
    """Get a block ready to be stepped: its own cells' postures, their neighbours', their rates."""
    n, known, blocks = ground.n, ground.known, ground.known.shape[2] - 2
    for d in range(-1, 6):
        axis, way = d // 2, 2 * (d % 2) - 1
        k, j, i = iz, iy, b
        if d >= 0:
            k, j, i = k + (axis == 0) * way, j + (axis == 1) * way, i + (axis == 2) * way
        if 1 <= k <= n and 1 <= j <= n and 1 <= i <= blocks and known[k, j, i] == ASLEEP:
            _see(k, j, i, ground)
    known[iz, iy, b] = AWAKE
    first = ((iz - 1) * n + iy - 1) * n
    if not ground.found.rated[iz, iy, b]:
        ground.found.rated[iz, iy, b] = True
        for ix in range((b - 1) * BLOCK, min(b * BLOCK, n)):
            m = first + ix
            there = ground.found.nodes.joints[m, 0] < NOWHERE
            ground.found.rates[m] = _rate(m, ix + 1, iy, iz, ground) if there else 0.0
    e, rates, step = iz * SLAB + iy * WIDTH + LEFT + SHARE, ground.found.rates, ground.run.step
    for ix in range((b - 1) * BLOCK, min(b * BLOCK, n)):
        ground.B[e + ix] = step * rates[first + ix]


@njit(_nrt=False)
def _stir(ground, runs):
    """Mark the blocks in which a potential still changes, and those next to them."""
    B, wake, quiet = ground.B, ground.wake, np.float32(ground.run.quiet * ground.run.step)
    for r in range(runs.size[0]):
        start = runs.start[r]
        if not stirred(B, start, ADAPTED, quiet):
            continue
        s = np.int64(start)
        iz, iy, b = s // SLAB, s % SLAB // WIDTH, (s % WIDTH - LEFT) // BLOCK + 1
        wake[iz, iy, b] = True
        wake[iz - 1, iy, b] = wake[iz + 1, iy, b] = True
        wake[iz, iy - 1, b] = wake[iz, iy + 1, b] = True
        if abs(B[s] - B[s + ADAPTED]) > quiet:
            wake[iz, iy, b - 1] = True
        if abs(B[s + BLOCK - 1] - B[s + BLOCK - 1 + ADAPTED]) > quiet:
            wake[iz, iy, b + 1] = True


@njit(_nrt=False)
def _list(ground, runs):
    """List the blocks that are marked, get the new ones ready, and take the marks away."""
    n, wake, known = ground.n, ground.wake, ground.known
    low, count, watched = np.float32(0.1 * ground.run.threshold), 0, 0
    for iz in range(1, n + 1):
        runs.slabs[iz - 1] = count
        for iy in range(1, n + 1):
            for b in range(1, wake.shape[2] - 1):
                if not wake[iz, iy, b]:
                    continue
                wake[iz, iy, b] = False
                if known[iz, iy, b] != AWAKE:
                    _rouse(iz, iy, b, ground)
                start = np.uint64(iz * SLAB + iy * WIDTH + (b - 1) * BLOCK + LEFT)
                runs.start[count] = start
                count += 1
                if crossed(ground.B, start, ARRIVED, low):
                    runs.watch[watched] = start
                    watched += 1
    runs.slabs[n], runs.size[0], runs.size[1] = count, count, watched


@njit(_nrt=False)
def _next_door(B, joints, leap, n, m, k):
    """Arrival of the earliest neighbour of cell m at place k that passes the front on.

    -1 without such a neighbour; -2 if the rule jumps between the cell and all of them.
    """
    best = np.float32(-1.0)
    for d in range(6):
        e = k + DOORS[d]
        c = B[e + ARRIVED]
        if B[e] > 0.0 and c >= 0.0 and (best < 0.0 or c < best):
            if is_step(joints, leap, m, m + (-n * n, -n, -1, 1, n, n * n)[d]):
                best = c
            elif best < 0.0:
                best = np.float32(-2.0)
    return np.float64(best)


@njit(_nrt=False)
def _arrivals(ground, runs, tau, batch):
    """Find and record the cells that crossed the threshold since the last look: how many."""
    B, n, threshold, count = ground.B, ground.n, np.float32(ground.run.threshold), 0
    joints, leap = ground.found.nodes.joints, ground.found.nodes.leap
    for w in range(runs.size[1]):
        if not crossed(B, runs.watch[w], ARRIVED, threshold):
            continue
        first = np.int64(runs.watch[w])
        for k in range(first, first + BLOCK):
            if B[k] < threshold or B[k + ARRIVED] >= 0.0 or count == MOST:
                continue
            m = cell_of(k, n)
            before = _next_door(B, joints, leap, n, m, k)
            if before < 0.0:
                if before == -2.0:  # it was stirred by cells from which no step leads to it
                    insulate(B, k)
                continue
            batch.cells[count], batch.since[count] = m, before
            batch.when[count] = when_crossed(B, k, ADAPTED, tau, before, ground.run)
            count += 1
    # Written down only now, so that no cell passes on what has not been judged yet.
    for i in range(count):
        B[entry_of(batch.cells[i], n) + ARRIVED] = batch.when[i]
    return count


@njit(_nrt=False)
def _mark(ground, k):
    """Mark the block of the cell at place k and those next to it."""
    wake, iz, iy, b = ground.wake, k // SLAB, k % SLAB // WIDTH, (k % WIDTH - LEFT) // BLOCK + 1
    wake[iz, iy, b] = True
    wake[iz - 1, iy, b] = wake[iz + 1, iy, b] = True
    wake[iz, iy - 1, b] = wake[iz, iy + 1, b] = True
    wake[iz, iy, b - 1] = wake[iz, iy, b + 1] = True


@njit(_nrt=False)
def _set_out(scene, ball, away, radius, ground, terms, batch, judged, desk):
    """Excite the cells within a radius of the hand as far as they are free, and wake those around.

    The first of them that has a posture is the hand's own.  If few cells are free, as next to the
    ends of the joints' ranges, cells beyond the radius are excited as well.

    Returns
    -------
    cell, body : int
        First contact, -1 without one.
    time : float
        Its time [s].
    start : float
        Start of the wave [tau].  The hand is then a cell beyond the ball, because the ball's sharp
        edge is faster than a front at first.
    """
    n, B, home, slowness, start = ground.n, ground.B, -1, 0.0, 0.0
    joints, leap = ground.found.nodes.joints, ground.found.nodes.leap
    contact, contact_body, first, excited, edge = -1, -1, -1.0, 0, 1e300
    for i in range(ball.size):
        m = ball[i]
        k = entry_of(m, n)
        iz, iy, b = k // SLAB, k % SLAB // WIDTH, (k % WIDTH - LEFT) // BLOCK + 1
        if ground.known[iz, iy, b] != AWAKE:
            _rouse(iz, iy, b, ground)
        if ground.found.nodes.joints[m, 0] >= NOWHERE:
            continue
        _mark(ground, k)
        if away[i] > radius and excited >= ground.fewest:
            edge = min(edge, away[i])
            if away[i] > edge + SPREAD:
                break
            continue
        if home < 0:
            home, slowness = m, ground.run.slowness * ground.run.step / np.float64(B[k + SHARE])
            B[k], B[k + ADAPTED], B[k + SHARE], B[k + ARRIVED] = CLAMPED, CLAMPED, 0.0, 0.0
            judged.via[m] = -1
            continue
        when, before = away[i] * slowness, _next_door(B, joints, leap, n, m, k)
        if before < 0.0 or when > terms.end:
            continue  # behind cells that are not free
        start = max(start, when)
        batch.cells[0], batch.since[0], batch.when[0] = m, before, when
        B[k], B[k + ADAPTED], B[k + 2 * FIELD], B[k + ARRIVED] = UP_R, UP_R, UP_Z, when
        cell, body, t = judge_cells(scene, ground, terms, batch, 1, when, judged, desk)
        if cell >= 0 and (contact < 0 or t < first):
            contact, contact_body, first = cell, body, t
        freeze(ground, batch, 1, judged.state)
        excited += judged.state[m] == FREE
    return contact, contact_body, first, start + slowness


@njit
def propagate_in_space(scene, ball, away, radius, ground, terms, judged, runs, batch):
    """Run the wave until contact, end or horizon; the buffer must be at rest.

    Parameters
    ----------
    ball, away : (m,) ndarray
        Cells that are excited or awake at the start, by their distances from the hand [cells].
    radius : float
        Of those that are excited, if there are enough [cells].
    terms : Terms
        Times are mental.
    judged : Judged
        Filled.

    Returns
    -------
    cell, body : int
        First contact, -1 if there is none.
    time : float
        When [s].
    steps : int
        Euler steps made.
    """
    desk, d, eps = desk_of(scene), np.float32(ground.run.diffusion), np.float32(ground.run.epsilon)
    pairs, looks = rhythm(ground.run)
    contact, body, time, start = _set_out(
        scene, ball, away, radius, ground, terms, batch, judged, desk
    )
    _list(ground, runs)
    look, tau, slabs = 0, start, runs.slabs[: ground.n + 1]
    while tau < terms.end and runs.size[0] > 0 and (contact < 0 or terms.explore):
        steps(ground.B, runs.start, slabs, pairs, d, eps)
        look += 1
        tau = start + look * 2 * pairs * ground.run.step
        count = _arrivals(ground, runs, tau, batch)
        if count > 0:
            now = min(tau, terms.end)
            cell, target, t = judge_cells(scene, ground, terms, batch, count, now, judged, desk)
            if cell >= 0 and contact < 0:
                contact, body, time = cell, target, t
            freeze(ground, batch, count, judged.state)
        if look % looks == 0:
            _stir(ground, runs)
            _list(ground, runs)
    return contact, body, time, 2 * pairs * look
