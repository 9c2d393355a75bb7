"""Planning with waits by the wave of Eq. 10: what obstacles have left is excited again."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from gcm_learn.arms import joints_of
from gcm_learn.compiled import njit
from gcm_learn.planners.completion import Problem
from gcm_learn.planners.feedback import Exploration, Feedback
from gcm_learn.planners.fronts import FrontPlanner, wave_levels
from gcm_learn.planners.layered_front import explored, spread
from gcm_learn.scene import Scene
from gcm_learn.wave import Front, WaveParams

EARLY = 0.75  # a cell may be passed so long before the front is at its centre [crossings]
OUTRUN = 0.05  # share of a path's time by which a front may outrun the hand (concave ones do)
CLOSE = 0.5  # distance of the points at which a straight piece is asked [cells]


def layered_wave(params: WaveParams | None = None) -> FrontPlanner:
    """The paper's wave when the hand may wait; the straight line first, as in `layered`.

    The Laplacian has nine points, because its front is less early along the diagonals than that of
    five points (erratum 9). A front that is early there and late elsewhere costs catches.
    """
    params = WaveParams(laplacian=9) if params is None else params
    return FrontPlanner("layered-wave", wave_levels(params, _explore), direct=True)


def _explore(problem: Problem, params: WaveParams, feedback: Feedback) -> Exploration:
    """Layered map and paths back through its states."""
    front = spread(problem, params, feedback)
    if front.met_state >= 0:
        front = straightened(front, problem.scene)
    return explored(problem, front, params)


def straightened(front: Front, scene: Scene) -> Front:
    """Return the front with fewer bends on the path to the first contact.

    A front of the wave knows from which neighbour it came to a cell, so its paths run along the
    lattice.  Here states on the path are left out where the straight line is safe as well.
    """
    lattice, via = front.chart, np.array(front.via)
    n = lattice.n
    reached = Reached(
        front.cells,
        front.arrival,
        front.end,
        np.full((n, n), -1),
        np.empty(via.size, dtype=np.int64),
        lattice.centres,
    )
    _straighten(via, front.met_state, reached, scene.limb, scene.limits)
    return replace(front, via=via)


class Reached(NamedTuple):
    """The states of a front, listed by cell."""

    cells: np.ndarray  # (m, 2): iy, ix
    arrival: np.ndarray  # [s]
    end: np.ndarray
    last: np.ndarray  # (n, n): last state of a cell, -1 if none
    before: np.ndarray  # (m,): state of the same cell before
    centres: np.ndarray  # (n,): of cells along an axis


@njit
def _safe_at(reached, i, j, t, early):
    """Tell whether a cell is in one of its safe intervals, and reached, at time t [s]."""
    s = reached.last[i, j]
    while s >= 0:
        if reached.arrival[s] - early <= t:
            return t <= reached.end[s]
        s = reached.before[s]
    return False


@njit
def _under_way(path, limb, limits):
    """Least times (m,) at the points of a path (m, 2), from its start [s]."""
    time = np.zeros(path.shape[0])
    for p in range(1, time.size):
        dx, dy = path[p, 0] - path[p - 1, 0], path[p, 1] - path[p - 1, 1]
        time[p] = np.sqrt(dx * dx + dy * dy) / limits.speed
    if np.isfinite(limits.shoulder) or np.isfinite(limits.elbow):
        joints = joints_of(path, limb.rho, limb.side)
        for p in range(1, time.size):
            time[p] = max(time[p], abs(joints[p, 0] - joints[p - 1, 0]) / limits.shoulder)
            time[p] = max(time[p], abs(joints[p, 1] - joints[p - 1, 1]) / limits.elbow)
    return np.cumsum(time)


@njit
def _place(reached, s):
    """Centre (2,) of the cell of a state."""
    return np.array([reached.centres[reached.cells[s, 1]], reached.centres[reached.cells[s, 0]]])


@njit
def _is_straight(a, b, reached, limb, limits):
    """Tell whether the hand can go straight from state a (-1: from where it starts) to state b.

    It leaves as late as it can, at full speed, and must be in reached cells while they are safe.
    """
    centres = reached.centres
    h = centres[1] - centres[0]
    start, goal = np.array([limb.x, limb.y]), _place(reached, b)
    since, until = 0.0, reached.end[0]  # the first state is the hand's own cell
    if a >= 0:
        start = _place(reached, a)
        since, until = reached.arrival[a], reached.end[a]
    length = np.sqrt((goal[0] - start[0]) ** 2 + (goal[1] - start[1]) ** 2)
    path = np.empty((int(length / (CLOSE * h)) + 2, 2))
    for p in range(path.shape[0]):
        share = p / (path.shape[0] - 1.0)
        path[p] = start + share * (goal - start)
    time = _under_way(path, limb, limits)
    leave = reached.arrival[b] - time[-1]
    if leave < since - OUTRUN * time[-1] - 1e-9 or leave > until:
        return False
    for p in range(1, path.shape[0] - 1):
        i = int((path[p, 1] - centres[0]) / h + 0.5)
        j = int((path[p, 0] - centres[0]) / h + 0.5)
        if not _safe_at(reached, i, j, leave + time[p], EARLY * h / limits.speed):
            return False
    return True


@njit
def _straighten(via, met, reached, limb, limits):
    """Change `via` so that the path to state `met` has few bends."""
    cells, last = reached.cells, reached.last
    for s in range(via.size):
        reached.before[s] = last[cells[s, 0], cells[s, 1]]
        last[cells[s, 0], cells[s, 1]] = s
    count, s = 0, met
    while s >= 0:
        count, s = count + 1, via[s]
    chain = np.full(count + 1, -1)  # from where the hand starts to where the target is met
    s = met
    for k in range(count, 0, -1):
        chain[k], s = s, via[s]
    k = count
    while k > 0:
        first = 0
        while first < k - 1 and not _is_straight(chain[first], chain[k], reached, limb, limits):
            first += 1
        via[chain[k]] = chain[first]
        k = first
