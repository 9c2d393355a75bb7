"""Kernels of the oracle: a reachable set on a lattice, step by step through time.

One recurrence, R(t + dt) = dilate(R(t), v dt) minus what is occupied, with two roundings:

*outer*: a cell is blocked if the limb touches the same obstacle at all four of its corners, and
paths count as short as they can be.  No hand leaves this set.
*inner*: the hand goes straight from centre to centre and rests there.  Moves are checked without
sampling and rests to a fraction of a step.  A hand can reach all of this set.

The lattice rounds places only: arrivals are real numbers, and a step just holds those within it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.collision.distance import arm_distance
from gcm_learn.collision.occupancy import first_touch
from gcm_learn.compiled import njit
from gcm_learn.motion.rules import Rules
from gcm_learn.planners.oracle import moves
from gcm_learn.scene import Scene
from gcm_learn.scene.bodies import HAND, PART, REACH, TOP_SPEED, drift, poses_at

MOST_SURE = 63  # obstacles that the outer set heeds, the bits of a word; leaving out is optimistic
TRIES = 4  # moves into a cell that are checked in a step, best first
FINEST = 0.05  # resolution of touches within a step [steps]


class Grid(NamedTuple):
    """A lattice with a rim, row by row: the corners of cell k are k, k + 1, k + width, ..."""

    width: int
    centre: np.ndarray  # (m, 4): hand x, y and elbow x, y at the cells' centres
    corner: np.ndarray  # (m, 4): the same at their lower left corners, drawn into the ring
    cells: np.ndarray  # (c,) int: those that count
    corners: np.ndarray  # (k,) int: theirs


class Regime(NamedTuple):
    """Scene and rules of a reachable set, which make the set outer or inner."""

    scene: Scene
    rules: Rules  # of moves, and of straight legs to targets
    exact: bool  # inner
    waiting: bool  # whether the hand may leave a cell later than it came
    hole: float  # moves stay that far from the shoulder
    meet: float  # distance from a centre at which a target is met, or a leg to it is tried
    after: float  # when interceptions may begin [s]
    start_until: float  # until when the hand can stay where it starts [s]
    margin: float  # cells need no look that much before the hand can be there [s]


class ReachedSet(NamedTuple):
    """Reachable set, and the nodes by which the hand came to the cells."""

    alive: np.ndarray  # (m,) bool: in the set now
    blocked: np.ndarray  # (m,) bool: occupied in this step
    past: np.ndarray  # (PAST, m) bool: occupied at the last samples of time, in turns
    arrival: np.ndarray  # (m,): when the hand last came [s]
    until: np.ndarray  # (m,): until when it could stay [s]
    earliest: np.ndarray  # (m,): when there may be something to see, at the earliest [s]
    useful: np.ndarray  # (m,): when it is too late for a catch that matters [s]
    latest: np.ndarray  # (m,) int: the cell's last node, -1 before the first
    away: np.ndarray  # (m,): least time from the start [s]
    near: np.ndarray  # (m,): the same where the hand may go straight from there, else infinite
    cost: np.ndarray  # (1 or m, COUNT): least time of each move into a cell [s]
    cell: np.ndarray  # (n,) int: of every node, in order of acceptance
    came: np.ndarray  # (n,): when the hand came [s]
    left: np.ndarray  # (n,): when it left the node before [s]
    parent: np.ndarray  # (n,) int: that node, -1 for the start
    total: np.ndarray  # (1,) int: number of nodes


class SetBuffers(NamedTuple):
    """Room to work."""

    look: np.ndarray  # (m, b): when a cell or corner has to be checked for an obstacle [s]
    touched: np.ndarray  # (m,) uint64: obstacles that are touched at a corner, a bit each
    poses: np.ndarray  # (b, 12)
    others: np.ndarray  # (b, 12)
    cells: np.ndarray  # (k,) int: where a target is met
    times: np.ndarray  # (k,): when [s]
    leaves: np.ndarray  # (k,): and when the hand leaves the cell for it [s]


@njit
def step(regime, grid, front, work, s, dt, end):
    """Take the set through step s of length dt; returns how many meetings were found."""
    t0, t1 = (s - 1) * dt, min(s * dt, end)
    if regime.exact:
        ever_blocked(regime, grid, front, work, t0, t1)
        if regime.waiting:
            leave(grid, front, t0)
    else:
        surely_blocked(regime, grid, front, work, t1)
        front.past[s % moves.PAST] = front.blocked
    accept(regime, grid, front, t0, t1, s, dt)
    count = meetings(regime, grid, front, work, t0, t1, end)
    if not regime.exact:
        leave(grid, front, t1)
    return count


@njit
def surely_blocked(regime, grid, front, work, t):
    """Mark the cells at all corners of which the limb touches the same obstacle at time t."""
    bodies = regime.scene.bodies
    poses_at(bodies, t, work.poses)
    look, touched = work.look, work.touched
    for b in range(min(bodies.rows.shape[0], MOST_SURE)):
        if bodies.rows[b, PART] == HAND:
            continue
        bit = np.uint64(1) << np.uint64(b)
        speed = bodies.rows[b, TOP_SPEED]
        for a in range(grid.corners.size):
            k = grid.corners[a]
            if look[k, b] > t or front.away[k] > t + regime.margin:
                continue
            x, y, ex, ey = (
                grid.corner[k, 0], grid.corner[k, 1], grid.corner[k, 2], grid.corner[k, 3]
            )  # fmt: skip
            room = arm_distance(bodies, work.poses, b, x, y, ex, ey) - regime.rules.touch
            touched[k] &= ~bit
            if room <= 0.0:
                touched[k] |= bit
            look[k, b] = t + max(room, 0.0) / speed if speed > 0.0 else 1e300
    w = grid.width
    for a in range(grid.cells.size):
        k = grid.cells[a]
        front.blocked[k] = (touched[k] & touched[k + 1] & touched[k + w] & touched[k + w + 1]) != 0


@njit
def ever_blocked(regime, grid, front, work, t0, t1):
    """Mark the cells at whose centre the limb touches an obstacle at any instant of [t0, t1]."""
    bodies = regime.scene.bodies
    poses_at(bodies, t1, work.poses)
    front.blocked[:] = False
    shortest = FINEST * (t1 - t0)
    for b in range(bodies.rows.shape[0]):
        if bodies.rows[b, PART] == HAND:
            continue
        speed = bodies.rows[b, TOP_SPEED]
        moved = drift(bodies, b, t0, t1)
        for a in range(grid.cells.size):
            k = grid.cells[a]
            if work.look[k, b] >= t1 or front.blocked[k] or front.away[k] > t1 + regime.margin:
                continue
            x, y, ex, ey = (
                grid.centre[k, 0], grid.centre[k, 1], grid.centre[k, 2], grid.centre[k, 3]
            )  # fmt: skip
            room = arm_distance(bodies, work.poses, b, x, y, ex, ey) - regime.rules.touch
            if room > moved:
                work.look[k, b] = t1 + room / speed if speed > 0.0 else 1e300
            elif room <= 0.0:
                front.blocked[k] = True
            else:
                front.blocked[k] = 0.0 <= first_touch(
                    bodies, b, x, y, ex, ey, regime.rules.touch, t0, t1, shortest, work.others
                )


@njit
def leave(grid, front, until):
    """Take the occupied cells out of the set: the hand could stay `until`."""
    for a in range(grid.cells.size):
        k = grid.cells[a]
        if front.alive[k] and front.blocked[k]:
            front.alive[k] = False
            front.until[k] = until
            front.earliest[k] = until


@njit
def accept(regime, grid, front, t0, t1, s, dt):
    """Add the cells at which the hand arrives in (t0, t1] to the set."""
    time, hand = np.empty(2), np.empty((2, 2))
    for a in range(grid.cells.size):
        k = grid.cells[a]
        if front.alive[k] or front.earliest[k] > t1 or front.useful[k] < t0:
            continue
        if front.blocked[k] and (regime.exact or front.past[(s - 1) % moves.PAST, k]):
            if not regime.waiting:  # a first arrival that is refused is none: closed for ever
                front.useful[k] = -1.0
            continue
        tried = 0
        for _ in range(TRIES):
            d, when = moves.earliest(regime, grid, front, k, t0, t1, s, dt, tried)
            if d < 0 or when > front.useful[k]:
                break
            cost = front.near[k] if d == moves.START else moves.move_time(front, k, d)
            if regime.exact:
                time[0], time[1] = when - cost, when
                q = k if d == moves.START else moves.source_of(grid, k, d)
                hand[0, 0] = regime.scene.limb.x if d == moves.START else grid.centre[q, 0]
                hand[0, 1] = regime.scene.limb.y if d == moves.START else grid.centre[q, 1]
                hand[1, 0], hand[1, 1] = grid.centre[k, 0], grid.centre[k, 1]
                if not moves.clear(regime, time, hand):
                    tried |= 1 << d
                    continue
            settle(grid, front, k, d, when, cost)
            break


@njit
def settle(grid, front, k, d, when, cost):
    """Take cell k, reached by move d at `when`, into the set."""
    n = front.total[0]
    front.cell[n], front.came[n], front.left[n] = k, when, when - cost
    front.parent[n] = -1 if d == moves.START else front.latest[moves.source_of(grid, k, d)]
    front.total[0] = n + 1
    front.alive[k], front.arrival[k], front.until[k], front.latest[k] = True, when, 1e300, n
    for e in range(moves.COUNT):
        q = k + moves.MOVES[e, 0] * grid.width + moves.MOVES[e, 1]
        front.earliest[q] = min(front.earliest[q], when + moves.move_time(front, q, e))


@njit
def meetings(regime, grid, front, work, t0, t1, end):
    """Find the cells of the set in which the hand meets a target in [t0, t1], and list them.

    For the inner set that is a clear straight leg from the cell that catches before `end` [s].
    """
    bodies, count = regime.scene.bodies, 0
    poses_at(bodies, t1, work.poses)
    for b in range(bodies.rows.shape[0]):
        if bodies.rows[b, PART] != HAND:
            continue
        bx, by, bz = work.poses[b, 0], work.poses[b, 1], work.poses[b, 2]
        far = (bodies.rows[b, REACH] + regime.meet + drift(bodies, b, t0, t1)) ** 2
        for a in range(grid.cells.size):
            k = grid.cells[a]
            x, y = grid.centre[k, 0], grid.centre[k, 1]
            if not front.alive[k] or (x - bx) ** 2 + (y - by) ** 2 + bz * bz > far:
                continue
            if front.arrival[k] < t0 and not regime.waiting:
                continue
            since = max(t0, front.arrival[k])
            t = first_touch(
                bodies, b, x, y, x, y, regime.meet, since, t1, FINEST * (t1 - t0), work.others
            )
            if t >= 0.0 and regime.exact:
                last = min(t1 + 2.0 * regime.meet / regime.rules.speed, end)
                t = moves.leg_from(regime, x, y, since, max(since, regime.after), last)
            if t >= 0.0 and count < work.cells.size:
                work.cells[count], work.times[count], work.leaves[count] = k, t, since
                count += 1
    return count


@njit
def useful_until(bodies, grid, until, speed, gap, instants):
    """Last moments (m,) at which a hand at the cells may still meet a target before `until` [s].

    Parameters
    ----------
    gap : float
        Distance from the centre at which a target is met.
    instants : int
        Times at which the targets are sampled; their travel in between widens the gap.
    """
    poses = np.zeros((bodies.rows.shape[0], 12))
    last = np.full(grid.centre.shape[0], -1.0)
    for i in range(instants + 1):
        t = until * i / instants
        poses_at(bodies, t, poses)
        for b in range(bodies.rows.shape[0]):
            if bodies.rows[b, PART] != HAND:
                continue
            early, late = max(t - until / instants, 0.0), min(t + until / instants, until)
            near = gap + bodies.rows[b, REACH] + drift(bodies, b, early, late)
            for a in range(grid.cells.size):
                k = grid.cells[a]
                dx, dy = grid.centre[k, 0] - poses[b, 0], grid.centre[k, 1] - poses[b, 1]
                away = np.sqrt(dx * dx + dy * dy + poses[b, 2] ** 2) - near
                last[k] = max(last[k], late - max(away, 0.0) / speed)
    return last
