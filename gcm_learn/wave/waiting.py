"""The wave that may wait: Eq. 10 with obstacles that inhibit while they are there."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from gcm_learn.charts import Lattice
from gcm_learn.scene import Scene
from gcm_learn.wave import excitation, inhibition, stencil
from gcm_learn.wave.front import Front, all_arrivals, ranks
from gcm_learn.wave.limits import contact_distance, fastest_in_plane, postures
from gcm_learn.wave.params import WaveParams
from gcm_learn.wave.solver import (
    STATES_PER_CELL,
    free_scene,
    front_speed,
    ground_of,
    kappa_in_plane,
    propagate_in_plane,
    start_disc,
)


def propagate_layers_in_plane(
    scene: Scene,
    lattice: Lattice,
    params: WaveParams,
    *,
    ignore: float = 0.0,
    widening: np.ndarray | None = None,
) -> Front:
    """Run `wave.propagate_layers` over a lattice of the plane."""
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
    rank = ranks(order, count)
    return all_arrivals(
        lattice,
        book.states[order, excitation.CELL].astype(np.int64),
        rank[book.states[order, excitation.VIA]],
        arrival[order],
        book.spans[order, inhibition.END],
        book.refused,
        (int(rank[state]), body, time),
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
    tau = propagate_in_plane(scene, lattice, free).first / kappa_in_plane(scene, lattice, free)
    x, y = np.meshgrid(lattice.centres, lattice.centres)
    away = np.hypot(x - hand[0], y - hand[1]) / lattice.spacing
    order = np.argsort(tau[tau >= 0.0], kind="stable")
    tau, away = tau[tau >= 0.0][order], np.maximum.accumulate(away[tau >= 0.0][order])
    record = np.flatnonzero(np.diff(away, prepend=-1.0) > 0.0)
    return np.interp(np.arange(0.0, tau[-1], inhibition.TICK), tau[record], away[record])


def _world(
    scene: Scene, lattice: Lattice, params: WaveParams, ignore: float, widening: np.ndarray | None
) -> inhibition.World:
    kappa = kappa_in_plane(scene, lattice, params)
    return inhibition.World(
        postures=postures(scene, lattice, params.margin, widening),
        clock=free_clock(params) * (lattice.spacing / fastest_in_plane(scene)),
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
