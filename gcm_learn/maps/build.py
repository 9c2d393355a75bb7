"""From a situation to its cognitive map, by either engine."""

from __future__ import annotations

import numpy as np

from gcm_learn.handspace.lattice import Lattice
from gcm_learn.maps.cognitive_map import CognitiveMap, Contact
from gcm_learn.scene.bodies import Bodies
from gcm_learn.scene.packing import pack_bodies
from gcm_learn.situation import Situation
from gcm_learn.wave import (
    LayeredFront,
    MarchingParams,
    Task,
    WaveParams,
    kappa_of,
    march,
    propagate,
)
from gcm_learn.wave.kernels import CONTACT, FROZEN


def build_map(
    situation: Situation,
    params: WaveParams | MarchingParams | None = None,
    *,
    bodies: Bodies | None = None,
    ignore: float = 0.0,
    widening: np.ndarray | None = None,
) -> CognitiveMap:
    """Let a front spread from the hand and keep what it met (Eqs. 10-12).

    Parameters
    ----------
    situation : Situation
    params : WaveParams or MarchingParams, optional
        The kind chooses the engine; the published wave by default.
    bodies : Bodies, optional
        The situation packed, if the caller has it at hand.
    ignore : float
        Contacts before this time do not stop the front [s].
    widening : (n * n,) ndarray, optional
        Margin of every cell beyond that of `params`, in the same unit.

    Returns
    -------
    CognitiveMap
        Whether the target was met is its `contact`.
    """
    params = WaveParams() if params is None else params
    task = task_of(situation, params, bodies, ignore, widening)
    wave = isinstance(params, WaveParams)
    front = propagate(task, params) if isinstance(params, WaveParams) else march(task, params)
    frozen = front.state == FROZEN
    contact = None
    if front.contact_cell >= 0:
        cell = divmod(front.contact_cell, params.n)
        contact = _contact(situation, task.lattice, cell, front.contact_time, front.contact_body)
    return CognitiveMap(
        lattice=task.lattice,
        hand=task.hand,
        arrival=np.ma.MaskedArray(front.arrival, mask=frozen | (front.arrival < 0.0)),
        effective_obstacles=frozen,
        effective_target=front.state == CONTACT,
        contact=contact,
        kappa=kappa_of(task, params if isinstance(params, WaveParams) else WaveParams(n=params.n)),
        engine="wave" if wave else "marching",
    )


def task_of(
    situation: Situation,
    params: WaveParams | MarchingParams,
    bodies: Bodies | None = None,
    ignore: float = 0.0,
    widening: np.ndarray | None = None,
) -> Task:
    """What a front has to explore in a situation; the arguments are those of `build_map`."""
    arm = situation.arm
    return Task(
        bodies=pack_bodies(situation) if bodies is None else bodies,
        lattice=Lattice(params.n, arm.upper_arm, arm.elbow),
        hand=arm.hand,
        speed=arm.max_hand_speed,
        horizon=situation.horizon,
        thickness=arm.thickness,
        grasp=arm.grasp,
        ignore=ignore,
        joint_speed=arm.max_joint_speed,
        widening=widening,
    )


def layered_map(situation: Situation, task: Task, front: LayeredFront) -> CognitiveMap:
    """The map of a front that waits: one sheet of arrivals for every safe interval of a cell.

    Parameters
    ----------
    situation : Situation
    task, front : Task, LayeredFront
        What was explored, and what came of it.

    Returns
    -------
    CognitiveMap
        Its effective obstacles are the cells in which an obstacle was when a front came; unlike
        those of a first-arrival map they may have arrivals, later ones.
    """
    n = task.lattice.n
    iy, ix = front.cells.T
    order, sheet = _sheets_of(iy * n + ix, front.arrival, front.end)
    arrival = np.full((sheet.max(initial=0) + 1, n, n), -1.0)
    arrival[sheet, iy[order], ix[order]] = front.arrival[order]
    sheets = np.ma.MaskedArray(arrival, mask=arrival < 0.0)
    target, contact = np.zeros((n, n), dtype=bool), None
    if front.met_state >= 0:
        cell = (int(iy[front.met_state]), int(ix[front.met_state]))
        target[cell] = True
        contact = _contact(situation, task.lattice, cell, front.met_time, front.met_body)
    return CognitiveMap(
        lattice=task.lattice,
        hand=task.hand,
        arrival=sheets[0],
        effective_obstacles=front.refused,
        effective_target=target,
        contact=contact,
        kappa=kappa_of(task, WaveParams(n=n)),
        engine="layered",
        later=sheets[1:] if len(sheets) > 1 else None,
    )


def _sheets_of(
    cell: np.ndarray, arrival: np.ndarray, end: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Count the safe intervals of every cell.

    A front may come to a cell twice in one interval, over a neighbour and from where it waited;
    the earlier one counts.

    Parameters
    ----------
    cell, arrival, end : (m,) ndarray
        Of the states: flat index; when the hand can be there, and until when [s].

    Returns
    -------
    order : (k,) ndarray
        The states that are the first in their interval, cell by cell in order of arrival.
    sheet : (k,) ndarray
        How many intervals of their cell come before.
    """
    order = np.lexsort((arrival, cell))
    another = np.ones(len(order), dtype=bool)
    same = cell[order][1:] == cell[order][:-1]
    another[1:] = ~same | (arrival[order][1:] > end[order][:-1])
    order = order[another]
    sheet = np.arange(len(order)) - np.searchsorted(cell[order], cell[order])
    return order, sheet


def _contact(
    situation: Situation, lattice: Lattice, cell: tuple[int, int], time: float, body: int
) -> Contact:
    x, y = float(lattice.centres[cell[1]]), float(lattice.centres[cell[0]])
    return Contact(cell=cell, position=(x, y), time=time, body=situation.bodies[body].name)
