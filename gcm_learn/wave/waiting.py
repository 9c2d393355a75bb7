"""Front door of the wave that may wait: Eq. 10 with obstacles that inhibit while they are there."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from gcm_learn.handspace import Lattice
from gcm_learn.scene import Scene
from gcm_learn.wave import excitation, inhibition, stencil
from gcm_learn.wave.front import Front
from gcm_learn.wave.limits import contact_distance, fastest, postures
from gcm_learn.wave.params import WaveParams
from gcm_learn.wave.solver import (
    STATES_PER_CELL,
    free_scene,
    front_speed,
    ground_of,
    kappa_of,
    propagate,
    start_disc,
)


def propagate_layers(
    scene: Scene,
    lattice: Lattice,
    params: WaveParams,
    *,
    ignore: float = 0.0,
    widening: np.ndarray | None = None,
) -> Front:
    """Run the wave of Eq. 10 until a target is met or the horizon; the hand may wait.

    A cell is excited as long as the hand can be there: obstacles inhibit it while they are there.

    Parameters
    ----------
    params : WaveParams
        `frozen` tells what an inhibited cell does to its neighbours: "insulating" cuts its
        couplings, "held" leaves it to be seen, clamped at rest.

    The others are as for `propagate`.

    Returns
    -------
    Front
    """
    n = lattice.n
    slowness = 1.0 / front_speed(params).fastest
    ground, book = ground_of(scene, lattice, params, stencil.room(n), slowness), _book(n)
    world = _world(scene, lattice, params, ignore, widening)
    state, body, time = excitation.propagate_layers(
        *start_disc(scene, lattice, params), ground, world, book, _batch(n)
    )
    count = int(book.tally[inhibition.TOTAL])
    arrival = book.spans[:count, inhibition.ARRIVAL]
    # Cells reached between the same two looks stand in the order of the lattice.
    order = np.argsort(arrival, kind="stable")
    rank = np.append(np.argsort(order), -1)  # the last entry is that of "none", -1
    nodes, met = book.states[order, excitation.CELL].astype(np.int64), np.zeros((n, n), dtype=bool)
    if state >= 0:
        met.flat[nodes[rank[state]]] = True
    return Front(
        chart=lattice,
        waits=True,
        nodes=nodes,
        via=rank[book.states[order, excitation.VIA]],
        arrival=arrival[order],
        end=book.spans[order, inhibition.END],
        refused=book.refused.reshape(n, n),
        met=met,
        met_state=int(rank[state]),
        met_body=body,
        met_time=time,
        steps=count,
    )


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
    scene = free_scene(lattice, hand, 70 * lattice.spacing)
    tau = propagate(scene, lattice, free).first / kappa_of(scene, lattice, free)
    x, y = np.meshgrid(lattice.centres, lattice.centres)
    away = np.hypot(x - hand[0], y - hand[1]) / lattice.spacing
    order = np.argsort(tau[tau >= 0.0], kind="stable")
    tau, away = tau[tau >= 0.0][order], np.maximum.accumulate(away[tau >= 0.0][order])
    record = np.flatnonzero(np.diff(away, prepend=-1.0) > 0.0)
    return np.interp(np.arange(0.0, tau[-1], inhibition.TICK), tau[record], away[record])


def _world(
    scene: Scene, lattice: Lattice, params: WaveParams, ignore: float, widening: np.ndarray | None
) -> inhibition.World:
    kappa = kappa_of(scene, lattice, params)
    return inhibition.World(
        postures=postures(scene, lattice, params.margin, widening),
        clock=free_clock(params) * (lattice.spacing / fastest(scene)),
        kappa=kappa,
        shortest=kappa * params.step,
        grasp=contact_distance(scene, lattice, params),
        ignore=ignore,
        end=scene.limits.horizon,
        explore=params.until == "horizon",
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
