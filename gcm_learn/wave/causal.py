"""Causal marching over the charts, with waits and without."""

from __future__ import annotations

import itertools
from functools import lru_cache

import numpy as np

from gcm_learn.charts import HandLattice, Lattice, hand_space
from gcm_learn.collision import WORK, desk_of
from gcm_learn.motion import fastest_hand
from gcm_learn.scene import Scene
from gcm_learn.wave import (
    agendas,
    layered,
    marching,
    posture_marching as space,
    posture_steps as steps,
)
from gcm_learn.wave.front import Front, all_arrivals, first_arrivals
from gcm_learn.wave.kernels import CONTACT, FROZEN
from gcm_learn.wave.limits import fastest_in_plane, hand_of, postures, terms_of, turns_of
from gcm_learn.wave.params import MarchingParams
from gcm_learn.wave.plane import PlaneLattice, closed_rim

SHORTEST = 0.03  # resolution of times in space, in steps of the hand
STATES_PER_CELL = 4  # capacity for sheets; most cells need one


def march_in_plane(
    scene: Scene,
    lattice: Lattice,
    params: MarchingParams,
    *,
    ignore: float = 0.0,
    widening: np.ndarray | None = None,
) -> Front:
    """Map arrivals at hand speed over a lattice of the plane."""
    speed = fastest_in_plane(scene)
    crossing = lattice.spacing / speed
    state = np.zeros(lattice.size, dtype=np.uint8)
    arrival, cell, body, time, accepted = marching.march(
        _plane(scene, lattice),
        terms_of(scene, lattice, params, crossing, ignore, speed),
        postures(scene, lattice, params.margin, widening),
        state,
    )
    return first_arrivals(
        lattice,
        arrival * crossing,
        state == FROZEN,
        state == CONTACT,
        (cell, body, time * crossing),
        horizon=scene.limits.horizon,
        steps=accepted,
    )


def march_layers_in_plane(
    scene: Scene,
    lattice: Lattice,
    params: MarchingParams,
    *,
    ignore: float = 0.0,
    widening: np.ndarray | None = None,
) -> Front:
    """March over cells and safe intervals of the plane; the hand may wait."""
    n, speed = lattice.n, fastest_in_plane(scene)
    crossing = lattice.spacing / speed
    room, nowhere = STATES_PER_CELL * n * n, np.full((n + 2) ** 2, -1, dtype=np.int32)
    sheets = agendas.Sheets(np.empty((room, 3), dtype=np.int32), np.empty((room, 2)), nowhere)
    refused = np.zeros(n * n, dtype=np.bool_)
    count, state, body, time = layered.march_layers(
        _plane(scene, lattice),
        terms_of(scene, lattice, params, crossing, ignore, speed),
        postures(scene, lattice, params.margin, widening),
        sheets,
        refused,
    )
    place = sheets.states[:count, agendas.CELL].astype(np.int64)
    return all_arrivals(
        lattice,
        (place // (n + 2) - 1) * n + place % (n + 2) - 1,
        sheets.states[:count, agendas.VIA].astype(np.int64),
        sheets.spans[:count, agendas.ARRIVAL] * crossing,
        sheets.spans[:count, agendas.END] * crossing,
        refused,
        (state, body, time * crossing),
    )


def march_in_space(
    scene: Scene,
    chart: HandLattice,
    params: MarchingParams,
    *,
    ignore: float = 0.0,
    widening: np.ndarray | None = None,
) -> Front:
    """Map arrivals over cells in space; the front keeps the postures that it finds."""
    ask, count = _ask(scene, chart, params, ignore, widening), chart.size
    field = steps.NodeArrivals(
        np.full(count, steps.NEVER), np.zeros(count, np.uint8), np.zeros(count, np.uint8)
    )
    node, body, time, accepted = space.march(ask, chart.start(), field)
    via = np.empty(count, np.int32)
    space.finish(ask, field, via)
    return first_arrivals(
        chart,
        field.arrival,
        field.state == steps.FROZEN,
        field.state == steps.MET,
        (node, body, time),
        horizon=scene.limits.horizon,
        steps=accepted,
        via=via,
        joints=chart.found_in(ask.nodes),
    )


def _ask(
    scene: Scene,
    chart: HandLattice,
    params: MarchingParams,
    ignore: float,
    widening: np.ndarray | None,
) -> steps.Ask:
    """Bind a scene and a lattice for marching in space."""
    dof = len(scene.limb.start)
    fast, desk = float(fastest_hand(scene)), desk_of(scene)
    desk.budget[0] = WORK
    return steps.Ask(
        scene,
        chart.nodes_for(scene),
        _pace(scene, chart, fast),
        terms_of(scene, chart, params, 1.0, ignore, fast)._replace(
            shortest=SHORTEST * chart.spacing / fast
        ),
        desk,
        np.empty(0) if widening is None else widening,
        params.margin,
        np.empty(dof),
        np.empty(dof),
    )


def _pace(scene: Scene, chart: HandLattice, fast: float) -> steps.Pace:
    """Bind the times of steps, with a hand that is nowhere faster than `fast`."""
    offsets = np.array([d for d in itertools.product((-1, 0, 1), repeat=3) if any(d)])
    return steps.Pace(
        (1.0 / scene.limits.joint_speed).astype(np.float32),
        offsets,
        offsets @ np.array([chart.n**2, chart.n, 1]),
        np.linalg.norm(offsets, axis=1) * chart.spacing,
        np.float32(fast / chart.spacing),  # type: ignore[arg-type]
    )


def _plane(scene: Scene, lattice: Lattice) -> PlaneLattice:
    """Bind a lattice and the hand in it for marching."""
    x, y = ((c + lattice.upper_arm + 1.0) / lattice.spacing - 0.5 for c in hand_of(scene))
    hand = y + 1.0, x + 1.0
    return PlaneLattice(lattice.n, *hand, _closed_rim(lattice), *turns_of(scene, lattice))


@lru_cache(maxsize=16)
def _closed_rim(lattice: Lattice) -> np.ndarray:
    """Padded status of a lattice before marching: open where the hand can be."""
    inside = hand_space(lattice).inside
    return closed_rim(lattice.n, lattice.spacing, lattice.reach, inside)
