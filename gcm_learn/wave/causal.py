"""Front doors of causal marching, with waits and without."""

from __future__ import annotations

import itertools
from functools import lru_cache

import numpy as np

from gcm_learn.collision import desk_of
from gcm_learn.handspace import Chart, Lattice, SpaceLattice, hand_space, ring_leap
from gcm_learn.scene import Scene
from gcm_learn.wave import agenda, layered, layered_in_space, marching
from gcm_learn.wave import marching_in_space as space
from gcm_learn.wave.front import Front, first_arrivals
from gcm_learn.wave.kernels import CONTACT, FROZEN
from gcm_learn.wave.limits import fastest, hand_of, postures, terms_of, turns_of
from gcm_learn.wave.params import MarchingParams
from gcm_learn.wave.plane import Plane, closed_rim
from gcm_learn.wave.solver import STATES_PER_CELL

SHORTEST = 0.03  # resolution of safe intervals in space, in steps of the hand


def march(
    scene: Scene,
    chart: Chart,
    params: MarchingParams,
    *,
    ignore: float = 0.0,
    widening: np.ndarray | None = None,
) -> Front:
    """Map arrivals of a front at hand speed by causal marching; the meaning is the wave's.

    Parameters
    ----------
    scene : Scene
    chart : Chart
        A lattice must have ``params.n`` cells a side. In space the limb must be free on every step,
        so that there is no lookback, and the margin counts in halves of what a step moves it.
    params : MarchingParams
    ignore : float
        Contacts before this time do not count [s].
    widening : (nodes,) ndarray, optional
        Margin of every node beyond that of the parameters, in the same unit.

    Returns
    -------
    Front
        Of one sheet.
    """
    if isinstance(chart, SpaceLattice):
        return _march_in_space(scene, chart, params, ignore, widening)
    crossing = chart.spacing / fastest(scene)
    state = np.zeros(chart.n * chart.n, dtype=np.uint8)
    arrival, cell, body, time, accepted = marching.march(
        _plane(scene, chart),
        terms_of(scene, chart, params, crossing, ignore),
        postures(scene, chart, params.margin, widening),
        state,
    )
    return first_arrivals(
        chart,
        arrival * crossing,
        state == FROZEN,
        state == CONTACT,
        (cell, body, time * crossing),
        horizon=scene.limits.horizon,
        steps=accepted,
    )


def march_layers(
    scene: Scene,
    chart: Chart,
    params: MarchingParams,
    *,
    ignore: float = 0.0,
    widening: np.ndarray | None = None,
) -> Front:
    """March over nodes and safe intervals until a target is met; the hand may wait.

    Parameters
    ----------
    params : MarchingParams
        Until contact only states from which a target may still be met are kept, and nothing after
        the contact; until the horizon all are.

    The others and what is returned are as for `march`.
    """
    if isinstance(chart, SpaceLattice):
        return _march_layers_in_space(scene, chart, params, ignore, widening)
    n, crossing = chart.n, chart.spacing / fastest(scene)
    room, nowhere = STATES_PER_CELL * n * n, np.full((n + 2) ** 2, -1, dtype=np.int32)
    sheets = agenda.Sheets(np.empty((room, 3), dtype=np.int32), np.empty((room, 2)), nowhere)
    refused, met = np.zeros((n, n), dtype=np.bool_), np.zeros((n, n), dtype=np.bool_)
    count, state, body, time = layered.march_layers(
        _plane(scene, chart),
        terms_of(scene, chart, params, crossing, ignore),
        postures(scene, chart, params.margin, widening),
        sheets,
        refused.reshape(-1),
    )
    place = sheets.states[:count, agenda.CELL].astype(np.int64)
    nodes = (place // (n + 2) - 1) * n + place % (n + 2) - 1
    if state >= 0:
        met.flat[nodes[state]] = True
    return Front(
        chart=chart,
        waits=True,
        nodes=nodes,
        via=sheets.states[:count, agenda.VIA].astype(np.int64),
        arrival=sheets.spans[:count, agenda.ARRIVAL] * crossing,
        end=sheets.spans[:count, agenda.END] * crossing,
        refused=refused,
        met=met,
        met_state=state,
        met_body=body,
        met_time=time * crossing,
        steps=count,
    )


def _march_in_space(
    scene: Scene,
    chart: SpaceLattice,
    params: MarchingParams,
    ignore: float,
    widening: np.ndarray | None,
) -> Front:
    ask, count = _ask(scene, chart, params, ignore, widening), chart.size
    field = space.Field(
        np.full(count, space.NEVER),
        np.zeros(count, np.uint8),
        np.zeros(count, np.uint8),
        np.empty(count, np.float32),
    )
    node, body, time, accepted = space.march(ask, chart.start(scene), field)
    via = np.empty(count, np.int32)
    space.finish(ask, field, via)
    return first_arrivals(
        chart,
        field.arrival,
        field.state == space.FROZEN,
        field.state == space.MET,
        (node, body, time),
        horizon=scene.limits.horizon,
        steps=accepted,
        via=via,
    )


def _march_layers_in_space(
    scene: Scene,
    chart: SpaceLattice,
    params: MarchingParams,
    ignore: float,
    widening: np.ndarray | None,
) -> Front:
    ask, count = _ask(scene, chart, params, ignore, widening), chart.size
    table = layered_in_space.new_table(ask, count)
    contact, states = layered_in_space.march_layers(ask, chart.start(scene), table)
    (state, body), known = contact.which, int(states.size[0])
    reached = np.flatnonzero(states.tries[:known] == layered_in_space.ACCEPTED)
    reached = reached[np.argsort(states.arrival[reached], kind="stable")]
    rank = np.full(known + 1, -1)  # the last entry is that of "none", -1
    rank[reached] = np.arange(len(reached))
    nodes, met = states.node[reached].astype(np.int64), np.zeros(count, dtype=np.bool_)
    if state >= 0:
        met[states.node[state]] = True
    return Front(
        chart=chart,
        waits=True,
        nodes=nodes,
        via=rank[states.via[reached]],
        arrival=states.arrival[reached],
        end=states.span[reached, 1],
        refused=table.refused.reshape(chart.shape),
        met=met.reshape(chart.shape),
        met_state=int(rank[state]),
        met_body=int(body),
        met_time=float(contact.when[0]),
        steps=len(reached),
    )


def _ask(
    scene: Scene,
    chart: SpaceLattice,
    params: MarchingParams,
    ignore: float,
    widening: np.ndarray | None,
) -> space.Ask:
    """Bind a scene and a lattice for marching in space."""
    fast = fastest(scene)
    return space.Ask(
        scene,
        chart.nodes,
        _pace(scene, chart, fast),
        terms_of(scene, chart, params, 1.0, ignore)._replace(
            shortest=SHORTEST * chart.spacing / fast
        ),
        desk_of(scene),
        np.empty(0) if widening is None else widening,
        params.margin,
        space.fastest_obstacle(scene),
        np.empty(4),
        np.empty(4),
    )


def _pace(scene: Scene, chart: SpaceLattice, fast: float) -> space.Pace:
    """Bind the times of steps, with a hand that is nowhere faster than `fast`."""
    offsets = np.array([d for d in itertools.product((-1, 0, 1), repeat=3) if any(d)])
    hops = np.append(np.linalg.norm(offsets, axis=1), [0.0, 0.0]) * chart.spacing
    ahead = offsets @ np.array([chart.n**2, chart.n, 1]) * chart.postures
    hand = np.maximum(hops, chart.spacing) / fast
    return space.Pace(
        (1.0 / scene.limits.joint_speed).astype(np.float32),
        offsets,
        ahead,
        hops,
        hand.astype(np.float32),
        np.float32(fast / chart.spacing),  # type: ignore[arg-type]
        np.float32(ring_leap(chart.postures)),  # type: ignore[arg-type]
    )


def _plane(scene: Scene, lattice: Lattice) -> Plane:
    """The lattice as kernels read it."""
    x, y = ((c + lattice.upper_arm + 1.0) / lattice.spacing - 0.5 for c in hand_of(scene))
    hand = y + 1.0, x + 1.0
    return Plane(lattice.n, *hand, _closed_rim(lattice), *turns_of(scene, lattice))


@lru_cache(maxsize=16)
def _closed_rim(lattice: Lattice) -> np.ndarray:
    """Padded status of a lattice before marching: open where the hand can be."""
    inside = hand_space(lattice).inside
    return closed_rim(lattice.n, lattice.spacing, lattice.upper_arm + 1.0, inside)
