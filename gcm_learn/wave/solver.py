"""The wave of Eq. 10 over hand-space in the plane."""

from __future__ import annotations

import math
import threading
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from gcm_learn.arms import PlanarLimb
from gcm_learn.charts import Lattice, cell_joints, hand_space
from gcm_learn.scene import Limits, Scene, no_bodies
from gcm_learn.wave import kernels, stencil
from gcm_learn.wave.front import Front, first_arrivals
from gcm_learn.wave.limits import fastest_in_plane, hand_of, postures, run_of, terms_of
from gcm_learn.wave.params import REST, WaveParams

QUIET = 1e-5  # potential change [1/tau] below which a block of cells counts as settled
SLOWEST_RATE = 0.02  # of a cell whose front is slow: the wave should not stop altogether
_workspace = threading.local()


def kappa_in_plane(scene: Scene, lattice: Lattice, params: WaveParams) -> float:
    """Return seconds per unit of mental time, see `wave.kappa_of`."""
    return front_speed(params).fastest * lattice.spacing / fastest_in_plane(scene)


def propagate_in_plane(
    scene: Scene,
    lattice: Lattice,
    params: WaveParams,
    *,
    ignore: float = 0.0,
    widening: np.ndarray | None = None,
) -> Front:
    """Run the wave of Eq. 10 from the hand until contact, the end of hand-space or the horizon."""
    kappa = kappa_in_plane(scene, lattice, params)
    return _propagate(scene, lattice, params, kappa, ignore, widening)


def _propagate(
    scene: Scene,
    lattice: Lattice,
    params: WaveParams,
    kappa: float,
    ignore: float = 0.0,
    widening: np.ndarray | None = None,
) -> Front:
    """Run the wave with a given kappa; also used to measure the front's speed."""
    n, shape = lattice.n, stencil.layout(lattice.n)
    slowness = 1.0 / front_speed(params).fastest if params.start_radius > 0.0 else 0.0
    buffers = _workspace.__dict__.setdefault("buffers", {})
    if n not in buffers:
        buffers[n] = stencil.room(n)
    buffer = buffers[n]
    ground = ground_of(scene, lattice, params, buffer, slowness)
    kernels.excite(ground, *start_disc(scene, lattice, params))
    terms = terms_of(scene, lattice, params, kappa, ignore, fastest_in_plane(scene))
    around = postures(scene, lattice, params.margin, widening)
    state = np.zeros(n * n, dtype=np.uint8)
    cell, body, time, steps = kernels.propagate(ground, terms, around, state)
    plane = buffer[5 * shape.plane : 5 * shape.plane + (n + 2) * shape.width]
    arrival = plane.reshape(n + 2, shape.width)[1:-1, stencil.LEFT : stencil.LEFT + n]
    inside = hand_space(lattice).inside.reshape(n, n)
    arrival = np.where(inside, arrival, np.float32(-1.0)) * kappa
    return first_arrivals(
        lattice,
        arrival.ravel(),
        state == kernels.FROZEN,
        state == kernels.CONTACT,
        (cell, body, time * kappa),
        horizon=scene.limits.horizon,
        steps=steps,
    )


def hand_cell(lattice: Lattice, hand: tuple[float, float]) -> tuple[int, int]:
    """Index (iy, ix) of the hand's cell; if it is outside the ring, of the nearest cell inside.

    A clamped neuron outside the ring has too few neighbours to start a wave.
    """
    iy, ix = lattice.cell_of(hand)
    cells = hand_space(lattice)
    if cells.inside[iy * lattice.n + ix]:
        return iy, ix
    away = np.linalg.norm(cells.limb[:, :2] - hand, axis=1)
    nearest = int(np.argmin(np.where(cells.inside, away, np.inf)))
    return nearest // lattice.n, nearest % lattice.n


def start_disc(scene: Scene, lattice: Lattice, params: WaveParams) -> tuple[np.ndarray, np.ndarray]:
    """Cells (m,) that are excited at the start and their distances (m,) from the hand [cells].

    The hand's cell comes first, at no distance, whatever the radius.
    """
    hand, space = hand_of(scene), hand_space(lattice)
    iy, ix = hand_cell(lattice, hand)
    if params.start_radius <= 0.0:
        return np.array([iy * lattice.n + ix]), np.zeros(1)
    away = np.hypot(*(space.limb[:, :2] - hand).T) / lattice.spacing
    away[iy * lattice.n + ix] = 0.0
    cells = np.flatnonzero(space.inside & (away <= params.start_radius))
    cells = cells[np.argsort(away[cells], kind="stable")]
    return cells, away[cells]


def ground_of(
    scene: Scene, lattice: Lattice, params: WaveParams, buffer: np.ndarray, slowness: float
) -> kernels.WaveLattice:
    """Bind the lattice at rest in a buffer; `slowness` is the fastest front's [tau per cell]."""
    n, shape = lattice.n, stencil.layout(lattice.n)
    ground = kernels.WaveLattice(
        B=buffer,
        n=n,
        W=shape.width,
        plane=shape.plane,
        rate=rates_of(scene, lattice),
        active=np.ones((n + 2, shape.blocks), dtype=np.bool_),
        points=params.laplacian,
        start=params.start_radius * slowness,
        run=run_of(params, QUIET, slowness),
    )
    rest = REST if params.start == "rest" else (0.0, 0.0)
    kernels.prepare(ground, hand_space(lattice).inside, *rest)
    return ground


def rates_of(scene: Scene, lattice: Lattice) -> np.ndarray:
    """Rate (n * n,) of every cell's dynamics: q of Eq. 10 as a share of full speed.

    A wave's speed does not depend on direction.  If joints limit the hand, the front is as fast
    as the hand is on average over directions; the plan's timing then keeps the limits exactly.
    """
    limits = scene.limits
    if math.isinf(limits.shoulder) and math.isinf(limits.elbow):
        return np.ones(lattice.n**2)
    return _joint_limited_rates(lattice, fastest_in_plane(scene), limits.shoulder, limits.elbow)


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
    front = _propagate(free_scene(lattice, hand, 70 / 0.03), lattice, free, kappa=1.0)
    arrival = np.where(front.first > 0, front.first, np.nan)
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


def free_scene(lattice: Lattice, hand: tuple[float, float], horizon: float) -> Scene:
    """Make a scene without bodies, with a hand speed of one forearm length a second."""
    rho = lattice.upper_arm
    limb = PlanarLimb(rho, 1.0, abs(rho - 1.0), rho + 1.0, 0.0, *hand)
    return Scene(no_bodies(), limb, Limits(1.0, math.inf, math.inf, 0.0, horizon))
