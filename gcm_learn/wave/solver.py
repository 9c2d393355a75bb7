"""Front door of the wave: run Eq. 10 over the hand-space of a situation."""

from __future__ import annotations

import math
import threading
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Literal

import numpy as np

from gcm_learn.handspace.lattice import HandSpace, Lattice, cell_joints, hand_space
from gcm_learn.scene.bodies import COLUMNS, Bodies
from gcm_learn.wave import kernels, layered, marching, stencil
from gcm_learn.wave.params import REST, WaveParams
from gcm_learn.wave.task import Task

QUIET = 1e-5  # potential change [1/tau] below which a block of cells counts as settled
CONTACT_RADIUS = 0.71  # at least half a cell's diagonal, or a small target slips between centres
SLOWEST_RATE = 0.02  # of a cell whose front is slow: the wave should not stop altogether
STATES_PER_CELL = 4  # room for sheets; most cells need one
_workspace = threading.local()


@dataclass(frozen=True)
class Front:
    """What a front left behind on an n x n lattice."""

    arrival: np.ndarray
    """(n, n) float [s]; negative where the front never came. Frozen cells have one."""
    state: np.ndarray
    """(n, n) uint8: FREE, FROZEN or CONTACT of `wave.kernels`."""
    contact_cell: int
    """Flat index of the first contact, -1 if none."""
    contact_body: int
    """Index of the target met first, -1 if none."""
    contact_time: float
    """Time of the first contact [s], negative if none."""
    steps: int
    """Euler steps (wave) or accepted cells (marching) that it took."""


def kappa_of(task: Task, params: WaveParams) -> float:
    """Seconds per unit of mental time, such that the front nowhere outruns the hand.

    At the paper's setting (80 cells over 4 forearm lengths, d = 0.2) and 3.4 forearm lengths a
    second this is the paper's kappa = 1/400 s.
    """
    return front_speed(params).fastest * task.lattice.spacing / task.fastest


def propagate(task: Task, params: WaveParams) -> Front:
    """Run the wave of Eq. 10 from the hand until contact, the end of the ring or the horizon.

    Parameters
    ----------
    task : Task
        Its lattice must have ``params.n`` cells a side.
    params : WaveParams

    Returns
    -------
    Front
    """
    kappa = kappa_of(task, params)
    return _propagate(task, params, kappa)


def _propagate(task: Task, params: WaveParams, kappa: float) -> Front:
    """`propagate` with a given kappa, which the measurement of the front's speed needs."""
    lattice, space = task.lattice, hand_space(task.lattice)
    n, shape = lattice.n, stencil.layout(lattice.n)
    slowness = 1.0 / front_speed(params).fastest if params.start_radius > 0.0 else 0.0
    buffer = _start(space, task, params, slowness)
    state = np.zeros(n * n, dtype=np.uint8)
    cell, body, time, steps = kernels.propagate(
        buffer,
        *shape,
        params.laplacian,
        space.limb,
        task.gaps(params.margin),
        task.bodies,
        _constants(params, task, kappa),
        params.frozen == "held",
        params.until == "horizon",
        params.start_radius * slowness,
        task.horizon / kappa,
        task.ignore / kappa,
        state,
    )
    plane = buffer[5 * shape.plane : 5 * shape.plane + (n + 2) * shape.width]
    arrival = plane.reshape(n + 2, shape.width)[1:-1, stencil.LEFT : stencil.LEFT + n]
    arrival = np.where(space.inside.reshape(n, n), arrival, np.float32(-1.0)) * kappa
    return Front(arrival, state.reshape(n, n), cell, body, time * kappa, steps)


@dataclass(frozen=True)
class MarchingParams:
    """Numbers that fix causal marching."""

    n: int = 80
    """Cells along a side of the lattice."""
    margin: float = 1.0
    """Widening of obstacles, as for the wave."""
    lookback: float = 1.0
    """Since when a cell must have been free: 1 covers the whole time since the front was next door
    (erratum 14), 0 the instant of its arrival only."""
    slack: float = 0.0
    """How far beyond the grasp a target still makes a contact, as for the wave [cells]."""
    until: Literal["contact", "horizon"] = "contact"
    """Stop at the first contact with a target or explore to the horizon."""


def march(task: Task, params: MarchingParams) -> Front:
    """Map arrivals of a front at hand speed by causal marching; the meaning is the wave's.

    Parameters
    ----------
    task : Task
        Its lattice must have ``params.n`` cells a side.
    params : MarchingParams

    Returns
    -------
    Front
    """
    lattice, space = task.lattice, hand_space(task.lattice)
    n, h = lattice.n, lattice.spacing
    crossing = h / task.fastest
    state = np.zeros(n * n, dtype=np.uint8)
    arrival, cell, body, time, accepted = marching.march(
        n,
        (task.hand[1] + lattice.upper_arm + 1.0) / h - 0.5,
        (task.hand[0] + lattice.upper_arm + 1.0) / h - 0.5,
        space.limb,
        _closed_rim(lattice),
        task.gaps(params.margin),
        *task.turns(),
        task.bodies,
        _marching_constants(task, params),
        params.lookback,
        params.until == "horizon",
        task.horizon / crossing,
        task.ignore / crossing,
        state,
    )
    return Front(
        arrival.reshape(n, n) * crossing, state.reshape(n, n), cell, body, time * crossing, accepted
    )


@dataclass(frozen=True)
class LayeredFront:
    """What a front reached when the hand may wait: states, i.e. cells in one safe interval each."""

    cells: np.ndarray
    """(m, 2) int: iy, ix; in order of arrival."""
    via: np.ndarray
    """(m,) int: state from which the hand comes straight, -1 for the hand's start."""
    arrival: np.ndarray
    """(m,) float: earliest arrival [s]."""
    end: np.ndarray
    """(m,) float: when the safe interval ends, the horizon at most [s]."""
    met_state: int
    """State in which a target is met first, -1 if none."""
    met_body: int
    """Index of that target, -1 if none."""
    met_time: float
    """When [s]; the horizon if none."""
    refused: np.ndarray
    """(n, n) bool: where an obstacle was when a front came."""


def march_layers(task: Task, params: MarchingParams) -> LayeredFront:
    """March over cells and safe intervals until a target is met; waiting is free.

    Parameters
    ----------
    task : Task
        Its lattice must have ``params.n`` cells a side.
    params : MarchingParams
        Until contact only states from which a target may still be met are kept, and nothing after
        the contact; until the horizon all are.

    Returns
    -------
    LayeredFront
    """
    lattice, space = task.lattice, hand_space(task.lattice)
    n, h = lattice.n, lattice.spacing
    crossing = h / task.fastest
    states = np.empty((STATES_PER_CELL * n * n, 3), dtype=np.int32)
    spans = np.empty((STATES_PER_CELL * n * n, 2))
    refused = np.zeros(n * n, dtype=np.bool_)
    count, state, body, time = layered.march_layers(
        n,
        (task.hand[1] + lattice.upper_arm + 1.0) / h - 0.5,
        (task.hand[0] + lattice.upper_arm + 1.0) / h - 0.5,
        space.limb,
        _closed_rim(lattice),
        task.gaps(params.margin),
        *task.turns(),
        task.bodies,
        _marching_constants(task, params),
        params.lookback,
        params.until == "horizon",
        task.fastest,
        task.horizon / crossing,
        task.ignore / crossing,
        states,
        spans,
        refused,
    )
    place = states[:count, layered.CELL]
    return LayeredFront(
        cells=np.stack([place // (n + 2) - 1, place % (n + 2) - 1], axis=-1),
        via=states[:count, layered.VIA].astype(np.int64),
        arrival=spans[:count, layered.ARRIVAL] * crossing,
        end=spans[:count, layered.END] * crossing,
        met_state=state,
        met_body=body,
        met_time=time * crossing,
        refused=refused.reshape(n, n),
    )


def _contact_distance(task: Task, params: WaveParams | MarchingParams) -> float:
    """Distance of a cell's centre and a target at which they are in contact."""
    h = task.lattice.spacing
    return max(task.grasp + params.slack * h, CONTACT_RADIUS * h)


def _marching_constants(task: Task, params: MarchingParams) -> np.ndarray:
    """Float constants of both kinds of marching; times are in crossings."""
    c = np.zeros(kernels.CONSTANTS)
    c[kernels.KAPPA] = task.lattice.spacing / task.fastest
    c[kernels.GRASP] = _contact_distance(task, params)
    c[kernels.SHORTEST] = 0.03 * c[kernels.KAPPA]
    return c


@lru_cache(maxsize=16)
def _closed_rim(lattice: Lattice) -> np.ndarray:
    """Padded status of a lattice before marching: open where the hand can be."""
    inside = hand_space(lattice).inside
    return marching.closed_rim(lattice.n, lattice.spacing, lattice.upper_arm + 1.0, inside)


def hand_cell(lattice: Lattice, hand: tuple[float, float]) -> tuple[int, int]:
    """Index (iy, ix) of the hand's cell; at a rim, of the nearest one that is in the ring.

    A clamped neuron outside the ring has too few neighbours to start a wave.
    """
    iy, ix = lattice.cell_of(*hand)
    space = hand_space(lattice)
    if space.inside[iy * lattice.n + ix]:
        return iy, ix
    away = np.linalg.norm(space.limb[:, :2] - hand, axis=1)
    nearest = int(np.argmin(np.where(space.inside, away, np.inf)))
    return nearest // lattice.n, nearest % lattice.n


def _start(space: HandSpace, task: Task, params: WaveParams, slowness: float) -> np.ndarray:
    """Prepare and excite this thread's buffer."""
    lattice, hand = task.lattice, task.hand
    n, shape = lattice.n, stencil.layout(lattice.n)
    buffers = _workspace.__dict__.setdefault("buffers", {})
    buffer = buffers.setdefault(n, np.empty(shape.length, dtype=np.float32))
    rest = REST if params.start == "rest" else (0.0, 0.0)
    kernels.prepare(
        buffer,
        n,
        shape.width,
        shape.plane,
        params.laplacian,
        space.inside,
        rates_of(task),
        params.step,
        *rest,
    )
    iy, ix = hand_cell(lattice, hand)
    kernels.excite(
        buffer,
        n,
        shape.width,
        shape.plane,
        iy * n + ix,
        hand[0],
        hand[1],
        lattice.spacing,
        params.start_radius if params.start_radius > 0 else -1.0,
        slowness,
        space.limb,
        space.inside,
    )
    return buffer


def rates_of(task: Task) -> np.ndarray:
    """Rate (n * n,) of every cell's dynamics: q of Eq. 10 as a share of full speed.

    A wave's speed does not depend on direction.  Where joints limit the hand, the front is as fast
    as the hand is on average over directions; the plan's timing then keeps the limits exactly.
    """
    if task.joint_speed is None:
        return np.ones(task.lattice.n**2)
    return _joint_limited_rates(task.lattice, task.fastest, *task.joint_speed)


@lru_cache(maxsize=16)
def _joint_limited_rates(
    lattice: Lattice, speed: float, shoulder: float, elbow: float
) -> np.ndarray:
    """Mean speed of the hand over the steps from a cell (n * n,), as a share of `speed`."""
    n, h = lattice.n, lattice.spacing
    joints = np.pad(cell_joints(lattice).reshape(n, n, 2), ((1, 1), (1, 1), (0, 0)), mode="edge")
    share = np.zeros((n, n))
    steps = [(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if i or j]
    for i, j in steps:
        turn = joints[1 + i : n + 1 + i, 1 + j : n + 1 + j] - joints[1:-1, 1:-1]
        turn = np.abs((turn + np.pi) % (2.0 * np.pi) - np.pi)
        least = (turn / (shoulder, elbow)).max(axis=2)
        hand = h * math.hypot(i, j) / speed
        share += hand / np.clip(least, hand, 1.0 / SLOWEST_RATE * hand)
    return (share / len(steps)).ravel()


def _constants(params: WaveParams, task: Task, kappa: float) -> np.ndarray:
    c = np.zeros(kernels.CONSTANTS)
    c[kernels.STEP] = params.step
    c[kernels.DIFFUSION] = params.diffusion
    c[kernels.EPSILON] = params.epsilon
    c[kernels.THRESHOLD] = params.threshold
    c[kernels.KAPPA] = kappa
    c[kernels.GRASP] = _contact_distance(task, params)
    c[kernels.QUIET] = QUIET
    c[kernels.SHORTEST] = kappa * params.step
    return c


@dataclass(frozen=True)
class FrontSpeed:
    """Speed of a free circular front [cells per tau]."""

    axis: float
    """Along the lattice's axes."""
    diagonal: float
    """Along its diagonals."""
    fastest: float
    """Largest speed in any direction."""

    @property
    def anisotropy(self) -> float:
        """Spread of the speed over directions, relative to the fastest."""
        return 1.0 - min(self.axis, self.diagonal) / self.fastest


@lru_cache(maxsize=32)
def front_speed(params: WaveParams) -> FrontSpeed:
    """Measure the front's speed by a free wave from the centre of a 160 x 160 lattice.

    Slopes are taken between radii of 25 and 70 cells, where curvature has faded (erratum 9).
    """
    free = replace(params, n=160, start_radius=0.0, until="horizon", margin=0.0, slack=0.0)
    if params != free:
        return front_speed(free)
    lattice, mid = Lattice(n=free.n), free.n // 2
    hand = (0.5 * lattice.spacing, 0.5 * lattice.spacing)
    task = Task(no_bodies(), lattice, hand, speed=1.0, horizon=70 / 0.03)
    front = _propagate(task, free, kappa=1.0)
    arrival = np.where(front.arrival > 0, front.arrival, np.nan)
    near, far = 25.0, 70.0
    speeds = []
    for angle in np.linspace(0.0, np.pi / 4, 10):
        times = []
        for radius in (near, far):
            x, y = mid + radius * np.cos(angle), mid + radius * np.sin(angle)
            i, j = int(y), int(x)
            u, v = x - j, y - i
            block = arrival[i : i + 2, j : j + 2]
            times.append(
                (1 - v) * ((1 - u) * block[0, 0] + u * block[0, 1])
                + v * ((1 - u) * block[1, 0] + u * block[1, 1])
            )
        speeds.append((far - near) / (times[1] - times[0]))
    return FrontSpeed(axis=float(speeds[0]), diagonal=float(speeds[-1]), fastest=float(max(speeds)))


def no_bodies() -> Bodies:
    """An empty world."""
    return Bodies(np.zeros((0, COLUMNS)), np.zeros((0, 2)), np.zeros((0, 2, 2)), 1.0)
