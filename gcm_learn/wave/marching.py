"""Causal marching: the map of a front of constant speed, cell by cell in order of arrival.

The meaning is that of the wave (a cell is accepted only if its limb is free when the front gets
there), at the speed of a Dijkstra search.  Distances are measured in cells and times in crossings
(the time the front needs for one cell) while marching.

Every accepted cell remembers the *source* from which its front runs straight: the hand, or a cell
where the front last had to bend round something frozen.  A neighbour inherits the source when the
ray from it to the source passes between two accepted cells of that source, and its arrival is then
the Euclidean distance: exact in free space and in the shadow of each corner.  Otherwise the front
bends, and the cell that passes it on becomes a source itself.  Any-angle path planning inherits
parents in the same way (Daniel, Nash, Koenig and Felner, Theta*, JAIR 39, 2010).
"""

from __future__ import annotations

import numpy as np

from gcm_learn.compiled import njit
from gcm_learn.scene.bodies import poses_at
from gcm_learn.wave.kernels import FREE, KAPPA, judge

# A cell of the padded lattice; CLOSED: frozen or nearer than the arm can reach, BEYOND: farther.
UNKNOWN, ACCEPTED, CLOSED, BEYOND = 0, 1, 2, 3
PER_CELL = 1.5  # buckets per crossing: neighbours along a ray are 0.7 crossings apart or more
BUCKETS = 256  # circular, a power of two; one step never spans more
SLOWEST = 165.0  # crossings that a step may take when joints limit the speed: see BUCKETS
HAND_SOURCE = 0  # a cell of the rim, which is never a source itself
START_RADIUS = 2.0  # cells this near to the hand are reached straight from it
HALF_DIAGONAL = 0.7072  # of a cell; the hand is in a cell whose centre is this near
ROOT2 = float(np.sqrt(2.0))
STEP_I = np.array([-1, -1, -1, 0, 0, 1, 1, 1])
STEP_J = np.array([-1, 0, 1, -1, 1, -1, 0, 1])


def _members() -> np.ndarray:
    """List the set bits of every byte (256, 8) and, in a ninth column, count them."""
    table = np.zeros((256, 9), dtype=np.int64)
    for byte in range(256):
        bits = [d for d in range(8) if byte >> d & 1]
        table[byte, : len(bits)] = bits
        table[byte, 8] = len(bits)
    return table


MEMBERS = _members()


@njit(forceinline=True)
def row_of(k, W):
    """K // W by a multiplication: a division by a variable costs more than the rest of a cell."""
    return int((k + 0.5) * (1.0 / W))


@njit(forceinline=True)
def away_from(source, i, j, W, hand_i, hand_j):
    """Vector (di, dj) from cell (i, j) to a source."""
    if source == HAND_SOURCE:
        return hand_i - i, hand_j - j
    row = row_of(source, W)
    return float(row - i), float(source - row * W - j)


@njit(forceinline=True)
def step_time(turns, circle, m, a, b, share, length):
    """Time of a straight step of `length` cells to cell m [crossings].

    It starts between the cells a and b (both without padding), a `share` of the way to b.  That
    takes as long as the hand, or the joint that has farthest to turn.
    """
    shoulder = turns[m, 0] - turns[a, 0]
    shoulder = abs(shoulder - circle * np.round(shoulder / circle))
    elbow = abs(turns[m, 1] - turns[a, 1])
    if share > 0.0:
        other = turns[m, 0] - turns[b, 0]
        other = abs(other - circle * np.round(other / circle))
        shoulder += share * (other - shoulder)
        elbow += share * (abs(turns[m, 1] - turns[b, 1]) - elbow)
    return min(max(length, shoulder, elbow), SLOWEST)


@njit(forceinline=True)
def bare(k, n):
    """Index without padding of cell k of the padded lattice."""
    return k - 2 * row_of(k, n + 2) - n - 1


@njit(forceinline=True)
def bend(k, q, di, dj, n, turns, circle, tent, status):
    """When the front of cell k is in its neighbour q = k + (di, dj), going round a cell.

    Returns the time and the cell that it goes round: this one, or one beside it; (0, -1) if q is
    reached across a corner only, where nothing squeezes through.
    """
    W = n + 2
    limited = turns.shape[0] > 0
    if di != 0 and dj != 0:
        if status[k + di * W] != ACCEPTED and status[k + dj] != ACCEPTED:
            return 0.0, -1
        step = ROOT2
        if limited:
            step = step_time(turns, circle, bare(q, n), bare(k, n), 0, 0.0, step)
        return tent[k] + step, k
    step = 1.0
    if limited:
        step = step_time(turns, circle, bare(q, n), bare(k, n), 0, 0.0, step)
    time, source = tent[k] + step, k
    side = W if di == 0 else 1
    for e in (k - side, k + side):
        if status[e] != ACCEPTED:
            continue
        step = ROOT2
        if limited:
            step = step_time(turns, circle, bare(q, n), bare(e, n), 0, 0.0, step)
        if tent[e] + step < time:
            time, source = tent[e] + step, e
    return time, source


@njit(forceinline=True)
def expand(  # noqa: C901  one decision; a call in this loop costs more than it clears up
    places, found, count, state, n, hand_i, hand_j, turns, circle, tent, origin, status, queue,
    counts, bucket,
):  # fmt: skip
    """Offer the fronts of newly accepted cells to their neighbours.

    The ray from a neighbour q towards the source leaves through the edge between an axis (`major`)
    and a corner neighbour.  If both have been reached, one of them from here, q is reached straight
    from the source; where they belong to two sources, the later arrival is taken: on the shadow
    line of a corner both agree, and beyond it the nearer source is hidden.  Until then, and
    wherever one of them is closed, the front bends round this cell, which is then the source.

    Parameters
    ----------
    places, found : (count,) int64 ndarray
        Indices of the cells in the padded lattice and without padding; those that `state` calls
        frozen are passed over.
    hand_i, hand_j : float
        Hand in coordinates of the padded lattice.
    turns : (n * n + 1, 2) or (0, 2) ndarray
        Joint angles in every cell, then the hand's, as times at the joints' full speeds
        [crossings]; none if the joints are not limited.
    circle : float
        The shoulder's full turn in the same unit.
    origin : ((n + 2)^2,) int32 ndarray
        Source of every cell: the index of a cell, or HAND_SOURCE.
    counts : (1 + BUCKETS,) int64 ndarray
        Number of queue entries, then the first entry of every bucket.
    bucket : int
        The bucket being worked on; nothing is put into an earlier one.
    """
    W = n + 2
    limited = turns.shape[0] > 0
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
            dy, dx = away_from(home, ci + di, cj + dj, W, hand_i, hand_j)
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
                    dy, dx = away_from(rival, ci + di, cj + dj, W, hand_i, hand_j)
                    later = np.sqrt(dx * dx + dy * dy)
                    if rival != HAND_SOURCE:
                        later += tent[rival]
                    if later > time:
                        time, source = later, rival
                if limited and near:
                    time = step_time(turns, circle, bare(q, n), n * n, 0, 0.0, time)
                elif limited:
                    slope = min(ax, ay) / max(ax, ay, 1e-9)
                    share = slope if k == major else 1.0 - slope
                    share *= status[other] == ACCEPTED
                    length = np.sqrt(1.0 + slope * slope)
                    time = tent[k] + share * (tent[other] - tent[k])
                    time += step_time(
                        turns, circle, bare(q, n), found[a], bare(other, n), share, length
                    )
            else:
                time, source = bend(k, q, di, dj, n, turns, circle, tent, status)
                if source < 0:
                    continue
            # A straight ray wins a tie: rays of a bend would run beside the true ones.
            if time >= tent[q] + (1e-9 if source == home else -1e-9):
                continue
            tent[q] = time
            origin[q] = source
            slot = 1 + (max(int(time * PER_CELL), bucket) & (BUCKETS - 1))
            queue[counts[0], 0] = q
            queue[counts[0], 1] = counts[slot]
            counts[slot] = counts[0]
            counts[0] += 1


@njit
def closed_rim(n, spacing, reach, inside):
    """Status ((n + 2)^2,) of a padded lattice before marching: UNKNOWN where the hand can be.

    The disc of the reach is convex: a ray between two of its cells never leaves it. So what is
    farther out is BEYOND, and CLOSED only what is not `inside` (n * n,) the ring elsewhere.
    """
    status = np.full((n + 2) * (n + 2), CLOSED, dtype=np.uint8)
    for i in range(n + 2):
        for j in range(n + 2):
            x, y = (j - 0.5) * spacing - reach, (i - 0.5) * spacing - reach
            if x * x + y * y > reach * reach:
                status[i * (n + 2) + j] = BEYOND
            elif 0 < i <= n and 0 < j <= n and inside[(i - 1) * n + j - 1]:
                status[i * (n + 2) + j] = UNKNOWN
    return status


@njit
def seed(n, W, hand_i, hand_j, turns, circle, tent, origin, status, queue, counts):
    """Put the hand's cell, or the nearest where the hand can be, into the queue.

    The hand may be in several cells at once, on their borders.
    """
    reach = int(START_RADIUS) + 1
    nearest = START_RADIUS
    for turn in range(2):
        for i in range(max(int(hand_i) - reach, 1), min(int(hand_i) + reach + 2, n + 1)):
            for j in range(max(int(hand_j) - reach, 1), min(int(hand_j) + reach + 2, n + 1)):
                k = i * W + j
                away = np.sqrt((i - hand_i) ** 2 + (j - hand_j) ** 2)
                if status[k] != UNKNOWN or away > max(nearest, HALF_DIAGONAL):
                    continue
                nearest = min(nearest, away)
                if turn == 1:
                    if turns.shape[0] > 0:
                        away = step_time(turns, circle, bare(k, n), n * n, 0, 0.0, away)
                    tent[k] = away
                    origin[k] = HAND_SOURCE
                    slot = 1 + int(away * PER_CELL)
                    queue[counts[0], 0], queue[counts[0], 1] = k, counts[slot]
                    counts[slot] = counts[0]
                    counts[0] += 1


@njit(forceinline=True)
def pop(slot, n, tent, status, queue, counts, end, lookback, places, found, since, when):
    """Accept the cells waiting in a bucket; returns how many."""
    count = 0
    W = n + 2
    entry = counts[1 + slot]
    counts[1 + slot] = -1
    while entry >= 0:
        k = queue[entry, 0]
        entry = queue[entry, 1]
        # Entries made stale by an earlier arrival find their cell closed or accepted.
        if status[k] == UNKNOWN and tent[k] <= end:
            status[k] = ACCEPTED
            places[count] = k
            # (i - 1) n + (j - 1) with k = i W + j and W = n + 2
            found[count] = k - 2 * row_of(k, W) - n - 1
            before = tent[k] if tent[k] > START_RADIUS else 0.0
            for e in (k - 1, k + 1, k - W, k + W):
                if status[e] == ACCEPTED and tent[e] < before:
                    before = tent[e]
            since[count] = tent[k] - lookback * (tent[k] - before)
            when[count] = tent[k]
            count += 1
    return count


@njit(forceinline=True)
def close(places, found, when, count, state, status, arrival):
    """Write down the arrivals of accepted cells and close the frozen ones."""
    for f in range(count):
        arrival[found[f]] = when[f]
        if state[found[f]] != FREE:
            status[places[f]] = CLOSED


@njit
def march(
    n, hand_i, hand_j, limb, outside, gap, turns, circle, bodies, c, lookback, explore, end, ignore,
    state,
):  # fmt: skip
    """March the front over the lattice.

    Parameters
    ----------
    hand_i, hand_j : float
        Hand in lattice coordinates; the centre of cell (iy, ix) is (iy, ix).
    outside : ((n + 2) * (n + 2),) uint8 ndarray
        UNKNOWN where the hand can be, BEYOND farther out and CLOSED elsewhere; the rim is not
        UNKNOWN.
    gap : (n * n,) ndarray
        Distance at which an obstacle occupies a cell.
    turns, circle
        As for `expand`.
    c : (CONSTANTS,) ndarray
        As for the wave; KAPPA is the seconds per crossing.
    lookback : float
        Share of the time since the front was next door that a cell must have been free.
    explore : bool
        Go on after the first contact.
    end, ignore : float
        Horizon; contacts before `ignore` do not count [crossings].
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
    W = n + 2
    status = outside.copy()
    tent = np.full(W * W, 1e300)
    origin = np.full(W * W, -1, dtype=np.int32)
    queue = np.empty((9 * n * n, 2), dtype=np.int32)
    counts = np.full(1 + BUCKETS, -1, dtype=np.int64)
    found, places = np.empty(n * n, dtype=np.int64), np.empty(n * n, dtype=np.int64)
    blocked = np.empty(n * n, dtype=np.bool_)
    since, when, met_time = np.empty(n * n), np.empty(n * n), np.empty(n * n)
    met_body = np.empty(n * n, dtype=np.int64)
    poses = np.zeros((bodies.rows.shape[0], 12))
    scratch = np.zeros_like(poses)
    arrival = np.full(n * n, -1.0)
    counts[0] = 0
    hand_i, hand_j = hand_i + 1.0, hand_j + 1.0
    seed(n, W, hand_i, hand_j, turns, circle, tent, origin, status, queue, counts)
    contact, body, time = -1, -1, -1.0
    bucket, empty, accepted = 0, 0, 0
    while empty < BUCKETS and bucket <= end * PER_CELL and (contact < 0 or explore):
        empty += 1
        now = min((bucket + 1.0) / PER_CELL, end)
        posed = False
        while counts[1 + bucket % BUCKETS] >= 0:
            empty = 0
            count = pop(
                bucket % BUCKETS, n, tent, status, queue, counts, end, lookback,
                places, found, since, when,
            )  # fmt: skip
            if count == 0:
                continue
            if not posed:
                poses_at(bodies, now * c[KAPPA], poses)
                posed = True
            cell, target, t = judge(
                found, since, when, count, limb, gap, bodies, poses, c, now, ignore, state,
                blocked, met_body, met_time, scratch,
            )  # fmt: skip
            if cell >= 0 and (contact < 0 or t < time):
                contact, body, time = cell, target, t
            close(places, found, when, count, state, status, arrival)
            expand(
                places, found, count, state, n, hand_i, hand_j, turns, circle, tent, origin, status,
                queue, counts, bucket,
            )  # fmt: skip
            accepted += count
        bucket += 1
    return arrival, contact, body, time, accepted
