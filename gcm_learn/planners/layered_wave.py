"""Planning with waits by the wave of Eq. 10: what obstacles have left is excited again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gcm_learn.compiled import njit
from gcm_learn.maps import task_of
from gcm_learn.planners.completion import Problem
from gcm_learn.planners.feedback import Exploration, Lessons
from gcm_learn.planners.fronts import FrontPlanner, wave_rungs
from gcm_learn.planners.layered import explored
from gcm_learn.scene.limb import SIDE, joints_of
from gcm_learn.wave import LayeredFront, Task, WaveParams, propagate_layers

EARLY = 0.75  # a cell may be passed so long before the front is at its centre [crossings]
OUTRUN = 0.05  # share of a way's time by which a front may outrun the hand (concave ones do)
CLOSE = 0.5  # distance of the points at which a straight piece is asked [cells]


def layered_wave(params: WaveParams | None = None) -> FrontPlanner:
    """The paper's wave when the hand may wait; the straight line first, as in `layered`.

    The Laplacian is the one of nine points: of the two that the paper may mean the one whose front
    is less early along the diagonals (erratum 9), which costs catches when it is late elsewhere.
    """
    params = WaveParams(laplacian=9) if params is None else params
    return FrontPlanner("layered-wave", wave_rungs(params, _explore), direct=True)


def _explore(problem: Problem, params: WaveParams, lessons: Lessons) -> Exploration:
    """Layered map and ways back through its states."""
    task = lessons.applied(task_of(problem.situation, params, problem.bodies))
    front = propagate_layers(task, params)
    return explored(problem, task, straightened(front, task) if front.met_state >= 0 else front)


def straightened(front: LayeredFront, task: Task) -> LayeredFront:
    """The same front with fewer bends on the way to where the target is met.

    A front of the wave knows from which neighbour it came to a cell, so its ways run along the
    lattice.  Here states on the way are left out where the straight line is safe as well.
    """
    lattice, via = task.lattice, front.via.copy()
    _straighten(
        via,
        front.cells,
        front.arrival,
        front.end,
        front.met_state,
        np.array(task.hand),
        np.array([task.speed, *(task.joint_speed or (0.0, 0.0))]),
        lattice.centres,
        lattice.upper_arm,
        SIDE[lattice.elbow],
    )
    return replace(front, via=via)


@njit
def _safe_at(i, j, t, early, arrival, end, last, before):
    """Tell whether a cell is in one of its safe intervals, and reached, at time t [s]."""
    s = last[i, j]
    while s >= 0:
        if arrival[s] - early <= t:
            return t <= end[s]
        s = before[s]
    return False


@njit
def _under_way(way, limits, rho, side):
    """Least times (m,) at the points of a way (m, 2), from its start [s]."""
    time = np.zeros(way.shape[0])
    for p in range(1, time.size):
        dx, dy = way[p, 0] - way[p - 1, 0], way[p, 1] - way[p - 1, 1]
        time[p] = np.sqrt(dx * dx + dy * dy) / limits[0]
    if limits[1] > 0.0:
        joints = joints_of(way, rho, side)
        for p in range(1, time.size):
            for k in range(2):
                time[p] = max(time[p], abs(joints[p, k] - joints[p - 1, k]) / limits[1 + k])
    return np.cumsum(time)


@njit
def _is_straight(a, b, cells, arrival, end, last, before, hand, limits, centres, rho, side):
    """Tell whether the hand can go straight from state a (-1: from where it starts) to state b.

    It leaves as late as it can, at full speed, and must be in reached cells while they are safe.
    """
    h = centres[1] - centres[0]
    start, goal = hand, np.array([centres[cells[b, 1]], centres[cells[b, 0]]])
    since, until = 0.0, end[0]  # the first state is the hand's own cell
    if a >= 0:
        start = np.array([centres[cells[a, 1]], centres[cells[a, 0]]])
        since, until = arrival[a], end[a]
    length = np.sqrt((goal[0] - start[0]) ** 2 + (goal[1] - start[1]) ** 2)
    way = np.empty((int(length / (CLOSE * h)) + 2, 2))
    for p in range(way.shape[0]):
        share = p / (way.shape[0] - 1.0)
        way[p] = start + share * (goal - start)
    time = _under_way(way, limits, rho, side)
    leave = arrival[b] - time[-1]
    if leave < since - OUTRUN * time[-1] - 1e-9 or leave > until:
        return False
    for p in range(1, way.shape[0] - 1):
        i = int((way[p, 1] - centres[0]) / h + 0.5)
        j = int((way[p, 0] - centres[0]) / h + 0.5)
        if not _safe_at(i, j, leave + time[p], EARLY * h / limits[0], arrival, end, last, before):
            return False
    return True


@njit
def _straighten(via, cells, arrival, end, met, hand, limits, centres, rho, side):
    """Change `via` so that the way to state `met` has few bends.

    `limits` are the speed of the hand and of the joints, these 0 if they are not limited.
    """
    n = centres.size
    last, before = np.full((n, n), -1), np.empty(via.size, dtype=np.int64)
    for s in range(via.size):
        before[s] = last[cells[s, 0], cells[s, 1]]
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
        while first < k - 1 and not _is_straight(
            chain[first], chain[k], cells, arrival, end, last, before, hand, limits, centres, rho,
            side,
        ):  # fmt: skip
            first += 1
        via[chain[k]] = chain[first]
        k = first
