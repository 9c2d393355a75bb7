"""Moves of the oracle's hand on its lattice: directions, cells that are passed, and times."""

from __future__ import annotations

from itertools import product

import numpy as np

from gcm_learn.collision.distance import segment_point2
from gcm_learn.collision.sweep import least_distance
from gcm_learn.compiled import njit
from gcm_learn.motion.interception import first_interception

ANY = 1e9  # resolution of a clearance of which only the sign matters

STRETCH = 1.0131  # lengths by these moves are too long by at most sqrt(1 + (sqrt(10) - 3)^2)
RIM = 3  # cells around the lattice that are never entered, so that moves need no bounds
PAST = 16  # samples of time that are remembered: more than the longest move takes

# Moves in an octant [cells], each with two pairs of cells between which it passes; a pair of
# itself (0, 0) is none.
_NONE, _HALF = ((0, 0), (0, 0)), ((1, 0), (1, 1))
_OCTANT = {
    (1, 0): (_NONE, _NONE),
    (1, 1): (((1, 0), (0, 1)), _NONE),
    (2, 1): (_HALF, _NONE),
    (3, 1): (_HALF, ((2, 0), (2, 1))),
    (3, 2): (_HALF, ((2, 1), (2, 2))),
}


def _moves() -> tuple[np.ndarray, np.ndarray]:
    """All 32 moves (32, 2) and their pairs (32, 2, 2, 2): mirror images of the octant's."""
    moves: dict[tuple[int, ...], np.ndarray] = {}
    for a, b in product((1, -1), repeat=2):
        for mirror in (np.array([[a, 0], [0, b]]), np.array([[0, a], [b, 0]])):
            for move, pairs in _OCTANT.items():
                moves[tuple(mirror @ move)] = np.array(pairs) @ mirror.T
    return np.array(list(moves)), np.array(list(moves.values()))


MOVES, BETWEEN = _moves()
COUNT = len(MOVES)
# How far along a move passes between a pair: at the foot of the pair's middle.
SHARES = (BETWEEN.mean(axis=2) * MOVES[:, None]).sum(axis=2) / (MOVES**2).sum(axis=1)[:, None]
START = COUNT  # the source besides the neighbours: the hand at t = 0, which is no cell's centre


@njit
def earliest(regime, grid, front, k, t0, t1, s, dt, tried):
    """Find the source, not yet tried, from which cell k is reached first in (t0, t1]: (d, when)."""
    best, first = -1, t1
    for d in range(COUNT + 1):
        if tried >> d & 1:
            continue
        if d == START:
            came, until, cost = 0.0, regime.start_until, front.near[k]
        else:
            q = source_of(grid, k, d)
            if front.latest[q] < 0:
                continue
            came, until, cost = front.arrival[q], front.until[q], move_time(front, k, d)
        when = max(came + cost, front.away[k])
        if when <= t0:
            if not regime.waiting:
                continue
            when = t0
        if when > first or (when == first and best >= 0) or when - cost > until:
            continue
        if not regime.exact and d != START and barred(grid, front, k, d, when - cost, cost, s, dt):
            continue
        best, first = d, when
    return best, first


@njit(inline="always")
def source_of(grid, k, d):
    """Cell from which move d leads into cell k."""
    return k - MOVES[d, 0] * grid.width - MOVES[d, 1]


@njit(inline="always")
def move_time(front, k, d):
    """Least time of move d into cell k [s]."""
    return front.cost[k if front.cost.shape[0] > 1 else 0, d]


@njit
def barred(grid, front, k, d, leave, cost, s, dt):
    """Tell whether move d into cell k, begun at `leave`, leads through surely occupied cells.

    At every sample of time on its way the hand is in one of the cells around the straight path.  It
    passes between cells of which one is free at the sample before or after.
    """
    q = source_of(grid, k, d)
    for m in range(s - 1, max(s - PAST, -1), -1):
        share = (m * dt - leave) / cost
        if share <= 0.0:
            break
        if share < 1.0 and surrounded(grid, front, q, share * MOVES[d, 0], share * MOVES[d, 1], m):
            return True
    for p in range(2):
        if BETWEEN[d, p, 0, 0] == 0 and BETWEEN[d, p, 0, 1] == 0:
            continue
        m = min(max(int((leave + SHARES[d, p] * cost) / dt), s - PAST + 1, 0), s - 1)
        solid = True
        for c in range(2):
            j = q + BETWEEN[d, p, c, 0] * grid.width + BETWEEN[d, p, c, 1]
            solid = solid and front.past[m % PAST, j] and front.past[(m + 1) % PAST, j]
        if solid:
            return True
    return False


@njit
def surrounded(grid, front, q, i, j, m):
    """Tell whether all cells around the point (i, j) from cell q were occupied at sample m."""
    i0, j0 = int(np.floor(i + 1e-6)), int(np.floor(j + 1e-6))
    i1, j1 = int(np.ceil(i - 1e-6)), int(np.ceil(j - 1e-6))
    for a in range(i0, i1 + 1):
        for b in range(j0, j1 + 1):
            if not front.past[m % PAST, q + a * grid.width + b]:
                return False
    return True


@njit
def clear(regime, time, hand):
    """Tell whether the limb stays clear while the hand goes straight (2, 2) in time (2,)."""
    if regime.hole > 0.0:
        nearest = segment_point2(0.0, 0.0, hand[0, 0], hand[0, 1], hand[1, 0], hand[1, 1])
        if nearest < regime.hole * regime.hole:
            return False
    floor = regime.rules.touch
    return least_distance(regime.scene, time, hand, floor, ANY)[0] > floor


@njit
def leg_from(regime, x, y, leave, since, end):
    """Return when a clear straight leg that leaves (x, y) at `leave` catches a target, or -1.

    Catches between `since` and `end` are looked for, joints left aside [s].
    """
    t, _, px, py = first_interception(regime.scene, regime.rules, x, y, leave, since, end)
    if t < 0.0:
        return -1.0
    leg = np.array([[x, y], [px, py]])
    return t if clear(regime, np.array([leave, t]), leg) else -1.0


@njit
def pull(regime, came, left, hand):
    """Pull a path tight: for every stop the earliest arrival by straight legs from stops before.

    Parameters
    ----------
    came, left : (n,) ndarray
        When the hand comes to the stops and leaves them [s].
    hand : (n, 2) ndarray
        The stops; the path between them is known to be clear.

    Returns
    -------
    arrival, departure : (n,) ndarray
        At the stop, and from the stop before [s].
    before : (n,) int64 ndarray
        That stop; -1 where the path as it was is best.
    """
    n = came.size
    arrival, departure = came.copy(), came.copy()
    before = np.full(n, -1)
    time, leg = np.empty(2), np.empty((2, 2))
    for j in range(1, n):
        for i in range(j):
            length = np.sqrt((hand[j, 0] - hand[i, 0]) ** 2 + (hand[j, 1] - hand[i, 1]) ** 2)
            when = arrival[i] + length / regime.rules.speed
            if when >= arrival[j] - 1e-9:
                continue
            time[0], time[1] = arrival[i], when
            leg[0, 0], leg[0, 1], leg[1, 0], leg[1, 1] = (
                hand[i, 0],
                hand[i, 1],
                hand[j, 0],
                hand[j, 1],
            )
            if clear(regime, time, leg):
                arrival[j], departure[j], before[j] = when, arrival[i], i
    return arrival, departure, before
