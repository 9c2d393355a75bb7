"""Front door of the wave that may wait: Eq. 10 with obstacles that inhibit while they are there."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from gcm_learn.handspace.lattice import HandSpace, Lattice, hand_space
from gcm_learn.wave import excitation, inhibition, kernels, stencil
from gcm_learn.wave.params import REST, WaveParams
from gcm_learn.wave.solver import (
    CONTACT_RADIUS,
    QUIET,
    STATES_PER_CELL,
    LayeredFront,
    front_speed,
    hand_cell,
    kappa_of,
    no_bodies,
    propagate,
    rates_of,
)
from gcm_learn.wave.task import Task


def propagate_layers(task: Task, params: WaveParams) -> LayeredFront:
    """Run the wave of Eq. 10 until a target is met or the horizon; the hand may wait.

    A cell is excited as long as the hand can be there: obstacles inhibit it while they are there.

    Parameters
    ----------
    task : Task
        Its lattice must have ``params.n`` cells a side.
    params : WaveParams
        `frozen` tells what an inhibited cell does to its neighbours: "insulating" cuts its
        couplings, "held" leaves it to be seen, clamped at rest.

    Returns
    -------
    LayeredFront
    """
    space, n = hand_space(task.lattice), task.lattice.n
    ground, book = _ground(task, params, space), _book(n)
    state, body, time = excitation.propagate_layers(
        *start_disc(task, params),
        ground,
        _world(task, params, space),
        book,
        _batch(n),
        np.float32(params.diffusion),
        np.float32(params.epsilon * params.step),
        np.float32(QUIET * params.step),
        params.until == "horizon",
    )
    count = int(book.tally[inhibition.TOTAL])
    arrival = book.spans[:count, inhibition.ARRIVAL]
    # Cells reached between the same two looks stand in the order of the lattice.
    order = np.argsort(arrival, kind="stable")
    rank = np.append(np.argsort(order), -1)  # the last entry is that of "none", -1
    cells = book.states[order, excitation.CELL]
    return LayeredFront(
        cells=np.stack([cells // n, cells % n], axis=-1).astype(np.int64),
        via=rank[book.states[order, excitation.VIA]],
        arrival=arrival[order],
        end=book.spans[order, inhibition.END],
        met_state=int(rank[state]),
        met_body=body,
        met_time=time,
        refused=book.refused.reshape(n, n),
    )


def start_disc(task: Task, params: WaveParams) -> tuple[np.ndarray, np.ndarray]:
    """Cells (m,) that are excited at the start and their distances (m,) from the hand [cells].

    The hand's cell comes first, at no distance, whatever the radius.
    """
    lattice, space = task.lattice, hand_space(task.lattice)
    iy, ix = hand_cell(lattice, task.hand)
    away = np.hypot(*(space.limb[:, :2] - task.hand).T) / lattice.spacing
    away[iy * lattice.n + ix] = 0.0
    reach = params.start_radius if params.start_radius > 0.0 else -1.0
    cells = np.flatnonzero(space.inside & ((away <= reach) | (away == 0.0)))
    cells = cells[np.argsort(away[cells], kind="stable")]
    return cells, away[cells]


@lru_cache(maxsize=32)
def free_clock(params: WaveParams) -> np.ndarray:
    """Crossings (m,) that the fastest part of a free front has made at every TICK of mental time.

    A wave that starts small is slow (erratum 9), by 26 tau for a single neuron; the hand is not.
    """
    free = replace(params, n=160, until="horizon", margin=0.0, slack=0.0)
    if params != free:
        return free_clock(free)
    lattice = Lattice(n=free.n)
    hand = (0.5 * lattice.spacing, 0.5 * lattice.spacing)
    task = Task(no_bodies(), lattice, hand, speed=1.0, horizon=70 * lattice.spacing)
    front = propagate(task, free)
    tau = front.arrival / kappa_of(task, free)
    x, y = np.meshgrid(lattice.centres, lattice.centres)
    away = np.hypot(x - hand[0], y - hand[1]) / lattice.spacing
    order = np.argsort(tau[tau >= 0.0], kind="stable")
    tau, away = tau[tau >= 0.0][order], np.maximum.accumulate(away[tau >= 0.0][order])
    record = np.flatnonzero(np.diff(away, prepend=-1.0) > 0.0)
    return np.interp(np.arange(0.0, tau[-1], inhibition.TICK), tau[record], away[record])


def _ground(task: Task, params: WaveParams, space: HandSpace) -> inhibition.Ground:
    n, shape = task.lattice.n, stencil.layout(task.lattice.n)
    buffer = np.empty(shape.length, dtype=np.float32)
    rate, rest = rates_of(task), REST if params.start == "rest" else (0.0, 0.0)
    kernels.prepare(
        buffer,
        n,
        shape.width,
        shape.plane,
        params.laplacian,
        space.inside,
        rate,
        params.step,
        *rest,
    )
    slowness = 1.0 / front_speed(params).fastest
    return inhibition.Ground(
        B=buffer,
        n=n,
        W=shape.width,
        plane=shape.plane,
        rate=rate,
        active=np.ones((n + 2, shape.blocks), dtype=np.bool_),
        points=params.laplacian,
        held=params.frozen == "held",
        step=params.step,
        lag=2 * max(1, int(0.6 / params.step + 1e-9)) * params.step,
        start=params.start_radius * slowness,
        slowness=slowness,
        threshold=params.threshold,
    )


def _world(task: Task, params: WaveParams, space: HandSpace) -> inhibition.World:
    kappa, h = kappa_of(task, params), task.lattice.spacing
    poses = np.zeros((task.bodies.rows.shape[0], 12))
    return inhibition.World(
        bodies=task.bodies,
        limb=space.limb,
        gap=task.gaps(params.margin),
        poses=poses,
        scratch=np.zeros_like(poses),
        clock=free_clock(params) * (h / task.fastest),
        kappa=kappa,
        shortest=kappa * params.step,
        grasp=max(task.grasp + params.slack * h, CONTACT_RADIUS * h),
        ignore=task.ignore,
        end=task.horizon,
    )


def _book(n: int) -> inhibition.Book:
    return inhibition.Book(
        latest=np.full(n * n, -1, dtype=np.int32),
        opened=np.zeros(n * n),
        heads=np.full(inhibition.SLOTS, -1, dtype=np.int32),
        following=np.empty(n * n, dtype=np.int32),
        dates=np.full(n * n, -1, dtype=np.int64),
        states=np.empty((STATES_PER_CELL * n * n, 2), dtype=np.int32),
        spans=np.empty((STATES_PER_CELL * n * n, 2)),
        refused=np.zeros(n * n, dtype=np.bool_),
        tally=np.zeros(3, dtype=np.int64),
    )


def _batch(n: int) -> inhibition.Batch:
    return inhibition.Batch(
        cells=np.empty(n * n, dtype=np.int64),
        via=np.empty(n * n, dtype=np.int64),
        since=np.empty(n * n),
        when=np.empty(n * n),
        until=np.empty(n * n),
        blocked=np.empty(n * n, dtype=np.bool_),
    )
