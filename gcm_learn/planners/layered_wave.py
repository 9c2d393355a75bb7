"""Planning with waits by the wave of Eq. 10: obstacles inhibit, and the excited region flows back."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numba import njit

from gcm_learn.maps import CognitiveMap, layered_map, task_of
from gcm_learn.planners.completion import Problem
from gcm_learn.planners.fronts import FrontPlanner, Way, finer
from gcm_learn.planners.fronts import HALF_DIAGONAL
from gcm_learn.planners.layered import way_to
from gcm_learn.wave import LayeredFront, Task, WaveParams
from gcm_learn.wave.waiting import propagate_layers

EARLY = 0.75  # a point of a cell may be passed so long before the front is at its centre [crossings]
CLOSE = 0.5  # distance of the points at which a straight piece is asked [cells]


def layered_wave(params: WaveParams | None = None) -> FrontPlanner[WaveParams]:
    """The paper's wave in which the hand may wait; the straight line first, as in `layered`."""
    params = WaveParams(start_radius=4.0) if params is None else params
    bare = replace(params, margin=0.0, slack=HALF_DIAGONAL)
    rungs = (params, bare, finer(params), finer(bare))
    return FrontPlanner("layered-wave", rungs, _explore, direct=True)


def _explore(
    problem: Problem, params: WaveParams, ignore: float
) -> tuple[CognitiveMap, Way | None]:
    """Layered map and the way back through its states."""
    task = task_of(problem.situation, params, problem.bodies, ignore)
    front = propagate_layers(task, params)
    way = way_to(straightened(front, task), task) if front.met_state >= 0 else None
    return layered_map(problem.situation, task, front), way


def straightened(front: LayeredFront, task: Task) -> LayeredFront:
    """The same front with fewer bends on the way to where the target is met.

    A front of the wave knows from which neighbour it came to a cell, so its ways run along the
    lattice.  Here states on the way are left out where the straight line is safe as well.
    """
    lattice = task.lattice
    hand = (np.array(task.hand) + lattice.upper_arm + 1.0) / lattice.spacing - 0.5
    via = front.via.copy()
    _straighten(
        via,
        front.cells,
        front.arrival,
        front.end,
        front.met_state,
        hand,
        lattice.spacing / task.speed,
        lattice.n,
    )
    return replace(front, via=via)


@njit(cache=True)
def _safe_at(i, j, t, early, cells, arrival, end, last, before):
    """Tell whether a cell is in one of its safe intervals, and reached, at time t [s]."""
    s = last[i, j]
    while s >= 0:
        if arrival[s] - early <= t:
            return t <= end[s]
        s = before[s]
    return False


@njit(cache=True)
def _is_straight(a, b, hand, crossing, cells, arrival, end, last, before):
    """Tell whether the hand can go straight from state a (-1: from where it starts) to state b.

    It leaves as late as it can, at full speed, and must be in reached cells while they are safe.
    """
    x1, y1 = float(cells[b, 1]), float(cells[b, 0])
    if a < 0:
        x0, y0, since, until = hand[0], hand[1], 0.0, 1e300
    else:
        x0, y0, since, until = float(cells[a, 1]), float(cells[a, 0]), arrival[a], end[a]
    length = np.sqrt((x1 - x0) ** 2 + (y1 - y0) ** 2)
    leave = arrival[b] - length * crossing
    if leave < since - 1e-9 or leave > until:
        return False
    pieces = int(length / CLOSE) + 1
    for p in range(1, pieces):
        share = p / pieces
        i, j = int(np.round(y0 + share * (y1 - y0))), int(np.round(x0 + share * (x1 - x0)))
        t = leave + share * length * crossing
        if not _safe_at(i, j, t, EARLY * crossing, cells, arrival, end, last, before):
            return False
    return True


@njit(cache=True)
def _straighten(via, cells, arrival, end, met, hand, crossing, n):
    """Change `via` so that the way to state `met` has few bends; positions in cells."""
    last, before = np.full((n, n), -1), np.empty(via.size, dtype=np.int64)
    for s in range(via.size):
        before[s] = last[cells[s, 0], cells[s, 1]]
        last[cells[s, 0], cells[s, 1]] = s
    count, s = 0, met
    while s >= 0:
        count, s = count + 1, via[s]
    chain = np.full(count + 1, -1)
    s = met
    for k in range(count, 0, -1):
        chain[k], s = s, via[s]
    k = count
    while k > 0:
        first = 0
        while first < k - 1 and not _is_straight(
            chain[first], chain[k], hand, crossing, cells, arrival, end, last, before
        ):
            first += 1
        via[chain[k]] = chain[first]
        k = first
