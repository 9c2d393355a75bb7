"""Kernels of the oracle: a reachable set on a lattice, step by step through time.

Two roundings of the same recurrence, R(t + dt) = dilate(R(t), v dt) minus what is occupied:

*outer*: a cell is free as long as any part of it may be free, and lengths are underestimated, so
what this set cannot reach nothing can reach;
*inner*: the hand moves straight from centre to centre and rests there, and every move and rest is
checked without sampling, so what this set reaches can be reached.

Arrivals are real numbers within their step: the lattice rounds places, not times.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from gcm_learn.arm.clearance import least_distance
from gcm_learn.arm.occupancy import first_touch
from gcm_learn.situation.kernels import (
    HAND,
    PART,
    REACH,
    TOP_SPEED,
    arm_distance,
    drift,
    poses_at,
    segment_point2,
)

RIM = 2  # cells around the lattice that are never entered, so that moves need no bounds
START = 16  # the source beside the 16 neighbours: the hand at t = 0, which is no cell's centre
MOST_SURE = 63  # obstacles that the outer set heeds: the bits of a word; more only hinder
FINEST = 1e-3  # resolution of touches within a step [steps]
_COARSE = 1e9  # resolution of clearances whose sign is all that matters

# 16 moves, by which lengths are at most STRETCH times too long: sqrt(1 + (sqrt(5) - 2)^2).
MOVE_I = np.array([1, -1, 0, 0, 1, 1, -1, -1, 2, 2, -2, -2, 1, 1, -1, -1])
MOVE_J = np.array([0, 0, 1, -1, 1, -1, 1, -1, 1, -1, 1, -1, 2, -2, 2, -2])
STRETCH = 1.0275
# The two cells between which a move passes (itself for the four that pass none).
PASS_I = np.stack([np.sign(MOVE_I) * (abs(MOVE_I) >= abs(MOVE_J)), np.sign(MOVE_I)], axis=1)
PASS_J = np.stack([np.sign(MOVE_J) * (abs(MOVE_J) > abs(MOVE_I)), np.sign(MOVE_J)], axis=1)
PASS_I[4:8], PASS_J[4:8] = [[1, 0], [1, 0], [-1, 0], [-1, 0]], [[0, 1], [0, -1], [0, 1], [0, -1]]


class Grid(NamedTuple):
    """A lattice with a rim, flattened row by row: cell k has the corners k, k + 1, k + width, ..."""

    width: int
    limb: np.ndarray  # (m, 4): hand x, y and elbow x, y at the cells' centres
    corner: np.ndarray  # (m, 4): the same at their lower left corners, within the ring
    cells: np.ndarray  # (c,) int: those that the hand can be in
    corners: np.ndarray  # (k,) int: those of these cells


class Front(NamedTuple):
    """A reachable set and how it came about."""

    alive: np.ndarray  # (m,) bool: in the set now
    blocked: np.ndarray  # (m,) bool: occupied in this step
    before: np.ndarray  # (m,) bool: in the one before
    arrival: np.ndarray  # (m,): when it last came into the set [s]
    until: np.ndarray  # (m,): and how long the hand could stay
    hoped: np.ndarray  # (m,): not to be looked at before [s]
    latest: np.ndarray  # (m,) int: its node, -1 before the first
    away: np.ndarray  # (m,): least time from the hand at t = 0 [s]
    near: np.ndarray  # (m,): the same, infinite where no move leads from there
    cost: np.ndarray  # (1 or m, 16): least time of the moves into a cell [s]
    cell: np.ndarray  # (n,) int: of the nodes, in order of acceptance
    came: np.ndarray  # (n,): arrival
    left: np.ndarray  # (n,): when the hand left the node before
    parent: np.ndarray  # (n,) int: that node, -1 for the start
    count: np.ndarray  # (1,) int: number of nodes


@njit(cache=True)
def surely_blocked(bodies, grid, t, reached, thickness, look, touched, poses, away, blocked):
    """Mark the cells at all corners of which the limb touches the same obstacle at time t.

    Parameters
    ----------
    reached : float
        Cells whose `away` is later cannot matter yet [s].
    look : (m, b) ndarray
        When a corner has to be looked at again for an obstacle [s].
    touched : (m,) uint64 ndarray
        Obstacles that are touched at a corner, one bit each.
    """
    poses_at(bodies, t, poses)
    for b in range(min(bodies.rows.shape[0], MOST_SURE)):
        if bodies.rows[b, PART] == HAND:
            continue
        bit = np.uint64(1) << np.uint64(b)
        speed = bodies.rows[b, TOP_SPEED]
        for a in range(grid.corners.size):
            k = grid.corners[a]
            if away[k] > reached or look[k, b] > t:
                continue
            hx, hy, ex, ey = grid.corner[k, 0], grid.corner[k, 1], grid.corner[k, 2], grid.corner[k, 3]
            room = arm_distance(bodies, poses, b, hx, hy, ex, ey) - thickness
            touched[k] &= ~bit
            if room <= 0.0:
                touched[k] |= bit
            wait = max(room, 0.0) / speed if speed > 0.0 else 1e300
            look[k, b] = t + wait
    w = grid.width
    for a in range(grid.cells.size):
        k = grid.cells[a]
        blocked[k] = (touched[k] & touched[k + 1] & touched[k + w] & touched[k + w + 1]) != 0


@njit(cache=True)
def ever_blocked(bodies, grid, t0, t1, reached, gap, look, poses, scratch, away, blocked):
    """Mark the cells at whose centre the limb touches an obstacle at any instant of [t0, t1].

    The parameters are those of `surely_blocked`; `gap` is the distance that counts as touching.
    """
    poses_at(bodies, t1, poses)
    blocked[:] = False
    shortest = FINEST * (t1 - t0)
    for b in range(bodies.rows.shape[0]):
        if bodies.rows[b, PART] == HAND:
            continue
        speed = bodies.rows[b, TOP_SPEED]
        moved = drift(bodies, b, t0, t1)
        for a in range(grid.cells.size):
            k = grid.cells[a]
            if away[k] > reached or blocked[k] or look[k, b] >= t1:
                continue
            hx, hy, ex, ey = grid.limb[k, 0], grid.limb[k, 1], grid.limb[k, 2], grid.limb[k, 3]
            room = arm_distance(bodies, poses, b, hx, hy, ex, ey) - gap
            if room > moved:
                look[k, b] = t1 + room / speed if speed > 0.0 else 1e300
            elif room <= 0.0:
                blocked[k] = True
            else:
                t = first_touch(bodies, b, hx, hy, ex, ey, gap, t0, t1, shortest, scratch)
                blocked[k] = t >= 0.0


@njit(cache=True)
def leave(grid, front, until, again):
    """Take the occupied cells out of the set; the hand could stay `until`, look again `again`."""
    for a in range(grid.cells.size):
        k = grid.cells[a]
        if front.alive[k] and front.blocked[k]:
            front.alive[k] = False
            front.until[k] = until
            front.hoped[k] = again


@njit(cache=True)
def accept(bodies, grid, front, t0, t1, rho, side, hole, floor, start, exact, waiting):
    """Take those cells into the set at which the hand arrives in (t0, t1].

    Parameters
    ----------
    hole : float
        Radius around the shoulder that straight moves must not cut.
    floor : float
        Distance that moves must keep.
    start : (3,) ndarray
        Hand x, y at t = 0 and until when it can stay there [s].
    exact : bool
        Inner set: moves are checked; else the outer set, in which they only must not pass between
        cells that are both occupied.
    waiting : bool
        Whether the hand may leave a cell later than it came.

    Returns
    -------
    int
        Number of cells taken in.
    """
    time, hand = np.empty(2), np.empty((2, 2))
    fresh = 0
    for a in range(grid.cells.size):
        k = grid.cells[a]
        if front.alive[k] or front.hoped[k] > t1:
            continue
        if front.blocked[k] and (exact or front.before[k]):
            continue
        tried = 0
        while True:
            d, when = earliest(grid, front, k, t0, t1, start[2], tried, exact, waiting)
            if d < 0:
                break
            cost = front.near[k] if d == START else move_time(front, k, d)
            if exact:
                time[0], time[1] = when - cost, when
                q = source_of(grid, k, d)
                hand[0, 0] = start[0] if d == START else grid.limb[q, 0]
                hand[0, 1] = start[1] if d == START else grid.limb[q, 1]
                hand[1, 0], hand[1, 1] = grid.limb[k, 0], grid.limb[k, 1]
                if not clear(bodies, time, hand, rho, side, hole, floor):
                    tried |= 1 << d
                    continue
            settle(grid, front, k, d, when, cost)
            fresh += 1
            break
    return fresh


@njit(cache=True)
def earliest(grid, front, k, t0, t1, start_until, tried, exact, waiting):
    """Find the source, not yet tried, from which cell k is reached first in (t0, t1]: (d, when)."""
    best, when = -1, t1
    for d in range(17):
        if tried >> d & 1:
            continue
        if d == START:
            came, until, cost = 0.0, start_until, front.near[k]
        else:
            q = source_of(grid, k, d)
            if front.latest[q] < 0:
                continue
            came, until, cost = front.arrival[q], front.until[q], move_time(front, k, d)
        t = came + cost
        if t <= t0:
            if not waiting:
                continue
            t = t0
        if t > when or t - cost > until or (t == when and best >= 0):
            continue
        if not exact and d != START and barred(grid, front, k, d):
            continue
        best, when = d, t
    return best, when


@njit(cache=True, inline="always")
def source_of(grid, k, d):
    """Cell from which move d leads into cell k."""
    return k - MOVE_I[d % 16] * grid.width - MOVE_J[d % 16]


@njit(cache=True, inline="always")
def move_time(front, k, d):
    """Least time of move d into cell k [s]."""
    return front.cost[k if front.cost.shape[0] > 1 else 0, d]


@njit(cache=True)
def barred(grid, front, k, d):
    """Tell whether both cells between which move d into cell k passes are occupied throughout."""
    if d < 4:
        return False
    q = source_of(grid, k, d)
    for p in range(2):
        m = q + PASS_I[d, p] * grid.width + PASS_J[d, p]
        if not (front.blocked[m] and front.before[m]):
            return False
    return True


@njit(cache=True)
def clear(bodies, time, hand, rho, side, hole, floor):
    """Tell whether the limb keeps its distance while the hand goes straight."""
    if hole > 0.0:
        nearest = segment_point2(0.0, 0.0, hand[0, 0], hand[0, 1], hand[1, 0], hand[1, 1])
        if nearest < hole * hole:
            return False
    return least_distance(bodies, time, hand, rho, side, floor, _COARSE)[0] > floor


@njit(cache=True)
def settle(grid, front, k, d, when, cost):
    """Take cell k, reached by move d at `when`, into the set."""
    n = front.count[0]
    front.cell[n], front.came[n], front.left[n] = k, when, when - cost
    front.parent[n] = -1 if d == START else front.latest[source_of(grid, k, d)]
    front.count[0] = n + 1
    front.alive[k], front.arrival[k], front.until[k], front.latest[k] = True, when, 1e300, n
    for e in range(16):
        q = k + MOVE_I[e] * grid.width + MOVE_J[e]
        front.hoped[q] = min(front.hoped[q], when + move_time(front, q, e))


@njit(cache=True)
def meetings(bodies, grid, front, t0, t1, gap, fresh, poses, scratch, cells, times):
    """Find the cells of the set in which the hand meets a target in [t0, t1].

    Parameters
    ----------
    gap : float
        Distance from the centre at which a target is met.
    fresh : bool
        Look only at cells that came into the set in this step.
    cells, times : (m,) ndarray
        Filled.

    Returns
    -------
    int
        Number of cells.
    """
    count = 0
    poses_at(bodies, t1, poses)
    shortest = FINEST * (t1 - t0)
    for b in range(bodies.rows.shape[0]):
        if bodies.rows[b, PART] != HAND:
            continue
        far = (bodies.rows[b, REACH] + gap + drift(bodies, b, t0, t1)) ** 2
        for a in range(grid.cells.size):
            k = grid.cells[a]
            if not front.alive[k] or (fresh and front.arrival[k] < t0):
                continue
            x, y = grid.limb[k, 0], grid.limb[k, 1]
            if (x - poses[b, 0]) ** 2 + (y - poses[b, 1]) ** 2 + poses[b, 2] ** 2 > far:
                continue
            since = max(t0, front.arrival[k])
            t = first_touch(bodies, b, x, y, x, y, gap, since, t1, shortest, scratch)
            if t >= 0.0 and count < cells.size:
                cells[count], times[count] = k, t
                count += 1
    return count
