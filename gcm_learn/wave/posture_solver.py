"""The wave of Eq. 10 over hand-space in space.

The paper expects no more than larger computations there.  Three things are different:

- One neuron starts no wave.  The hand's, clamped to 5, excites its six neighbours and no others.  A
  ball smaller than 4 cells shrinks: a front is slower the more it is curved, and in space it is
  curved twice.  So a ball around the hand is excited at the start, as far as it is free.
- For the same reason fronts come late: at a radius of 20 cells by about a fifth.
- The joints are mostly what limits a hand in space.  A wave's speed knows no
  direction, so a cell is as quick as the hand is on average over the six steps from it (q of
  Eq. 10).  The difference is lost: a path is timed by the joints' limits once more.
"""

from __future__ import annotations

import math
import threading
from functools import lru_cache

import numpy as np

from gcm_learn.arms import hand_speed
from gcm_learn.charts import Cube, PostureLattice
from gcm_learn.errors import LatticeError
from gcm_learn.scene import Scene
from gcm_learn.wave import posture_ground, posture_judging
from gcm_learn.wave import posture_kernels as kernels
from gcm_learn.wave import posture_stencil as stencil
from gcm_learn.wave.front import Front, first_arrivals
from gcm_learn.wave.kernels import CONTACT, FROZEN
from gcm_learn.wave.limits import run_of, terms_of
from gcm_learn.wave.params import REST, WaveParams, check_stability

START_BALL = (
    5.1  # radius of the smallest ball that is excited at the start; no cell is on it [cells]
)
FEWEST = 300  # cells that are excited at the start, if so many are free within two such radii
QUIET = 3e-3  # potential change [1/tau] below which a block of cells counts as settled
SLOWEST_RATE = 0.02  # of a cell: the wave should not stop altogether
QUICK = 0.9  # share of hands that are no faster than the front is where it is fastest
SAMPLES = 12  # of hands along an axis, from which that is known
_workspace = threading.local()


def kappa_in_space(scene: Scene, lattice: PostureLattice, params: WaveParams) -> float:
    """Run `wave.kappa_of` for cells in space.

    Fronts come late while they are small.  So this holds for the whole way from the hand to cells
    half a lattice away.  The front is late before, and may be early by a tenth beyond.
    """
    speed = mean_speed(params, 0.5 * lattice.n)
    return speed * lattice.spacing / quickest(scene, lattice)


def kappa_of_hand(scene: Scene, lattice: Cube, params: WaveParams) -> float:
    """Run `wave.kappa_of` for cells whose postures only a front finds.

    The wave is as fast as the hand at t = 0 while a single joint turns at full speed: the joint
    that moves the hand most.
    """
    arm, alone = lattice.arm, np.diag(scene.limits.joint_speed)
    quick = min(max(hand_speed(arm, arm.joints, rates) for rates in alone), scene.limits.speed)
    return mean_speed(params, 0.5 * lattice.n) * lattice.spacing / max(quick, 1e-9)


def mean_speed(params: WaveParams, radius: float) -> float:
    """Speed with which a free front gets to a radius [cells], its start included [cells per tau].

    A sphere's surface moves at c - 2 d / R, c being the speed of a plane front.  The mean follows
    from the time of its growth from the ball at the start.
    """
    c = front_speed_in_space(params)
    lag = 2.0 * params.diffusion / c
    ball = max(params.start_radius, START_BALL, lag + 1.0)
    if radius <= ball + 1.0:
        return c
    growth = radius - ball + lag * math.log((radius - lag) / (ball - lag))
    return radius / ((ball + 1.0 + growth) / c)


def quickest(scene: Scene, lattice: PostureLattice) -> float:
    """Speed of the front where it is fastest [lengths/s].

    It is the hand's limit, or a quantile if joints limit hands more: nine tenths of the hands stay
    below it on average over directions.  The front is that fast at the others.
    """
    return min(scene.limits.speed, _quickest(lattice))


@lru_cache(maxsize=64)
def _quickest(lattice: PostureLattice) -> float:
    along = (np.arange(SAMPLES) + 0.5) / SAMPLES * 2.0 - 1.0
    grid = np.stack(np.meshgrid(along, along, along), axis=-1).reshape(-1, 3)
    hands = lattice.reach * grid[np.linalg.norm(grid, axis=1) < 1.0]
    speed = np.array(lattice.arm.max_joint_speed)
    found = kernels.speeds_at(lattice.nodes.rule, speed, lattice.spacing, hands)
    found = found[found > 0.0]
    if found.size == 0:  # joints with hardly any range: no sample is a hand
        return float(lattice.reach * speed.max())
    return float(np.quantile(found, QUICK))


@lru_cache(maxsize=32)
def front_speed_in_space(params: WaveParams) -> float:
    """Largest speed of a plane front in any direction [cells per tau].

    Along an axis, a face's and the cube's diagonal, a plane front is one on a chain of neurons.
    The chain has 1, 2 and 3 times the diffusion, and neighbours 1, 1 / sqrt 2 and 1 / sqrt 3 cells
    apart.
    """
    check_stability(params, 7)
    return max(_chain_speed(params, k) / math.sqrt(k) for k in (1, 2, 3))


def _chain_speed(params: WaveParams, times: int) -> float:
    """Speed on a chain with so many times the diffusion [neurons per tau]."""
    r, z = np.zeros(48), np.full(48, REST[1])
    r[:3], z[:3] = 3.0, 1.0 / 7.0
    passed: dict[int, float] = {}
    tau = 0.0
    while 40 not in passed and tau < 48 / 0.01:
        near = np.concatenate([r[:1], r[:-1]]) + np.concatenate([r[1:], r[-1:]]) - 2.0 * r
        change = (((4.0 - r) * r - 2.0) * r - 2.0) / 7.0 - z + params.diffusion * times * near
        before, r, z = (
            r,
            r + params.step * change,
            z + params.step * params.epsilon * (r - 7.0 * z - 2.0),
        )
        for k in (15, 40):
            if before[k] < 1.0 <= r[k]:
                passed[k] = tau + params.step * (1.0 - before[k]) / (r[k] - before[k])
        tau += params.step
    return 25.0 / (passed[40] - passed[15])


def propagate_in_space(
    scene: Scene,
    lattice: PostureLattice,
    params: WaveParams,
    *,
    ignore: float = 0.0,
    widening: np.ndarray | None = None,
) -> Front:
    """Run `wave.propagate` over cells in space, of one posture each.

    The discrete Laplacian has 7 points, whatever the parameters say of the plane's.
    """
    if lattice.postures != 1:
        raise LatticeError(f"a wave in space needs one posture in a cell, not {lattice.postures}")
    n, kappa = lattice.n, kappa_in_space(scene, lattice, params)
    terms = terms_of(scene, lattice, params, kappa, ignore, quickest(scene, lattice))
    ground = _ground(scene, lattice, params)
    radius = max(params.start_radius, START_BALL)
    ball, away = _start_ball(scene, lattice, 2.0 * radius + kernels.SPREAD)
    wide = np.zeros(0) if widening is None else widening
    state, via = np.zeros(n**3, dtype=np.uint8), np.full(n**3, -1, dtype=np.int32)
    room = np.full(n**3, posture_ground.UNKNOWN)
    judged = posture_ground.Judged(state, via, room, wide, params.margin)
    cell, body, time, steps = kernels.propagate_in_space(
        scene, ball, away, radius, ground, terms, judged, *_rooms()
    )
    arrival = stencil.field(ground.B, 5, n)
    arrival = np.where(arrival >= 0.0, arrival * kappa, -1.0).astype(np.float32)
    return first_arrivals(
        lattice,
        arrival.ravel(),
        state == FROZEN,
        state == CONTACT,
        (cell, body, time),
        horizon=scene.limits.horizon,
        steps=steps,
        via=via,
    )


def _start_ball(
    scene: Scene, lattice: PostureLattice, radius: float
) -> tuple[np.ndarray, np.ndarray]:
    """Cells (m,) within a radius of the hand, and their distances (m,) from it [cells]."""
    hand = np.array(posture_judging.hand_at_start(scene.limb))
    low = np.maximum(np.floor(hand / lattice.spacing + 0.5 * lattice.n - radius - 0.5), 0)
    high = np.minimum(low + 2 * math.ceil(radius) + 2, lattice.n).astype(int)
    x, y, z = (np.arange(a, b) for a, b in zip(low.astype(int), high, strict=True))
    iz, iy, ix = (i.ravel() for i in np.meshgrid(z, y, x, indexing="ij"))
    places = (np.stack([ix, iy, iz], axis=-1) + 0.5 - 0.5 * lattice.n) * lattice.spacing
    away = np.linalg.norm(places - hand, axis=1) / lattice.spacing
    near = np.flatnonzero(away <= radius)
    near = near[np.argsort(away[near], kind="stable")]
    return ((iz * lattice.n + iy) * lattice.n + ix)[near], away[near]


def _ground(
    scene: Scene, lattice: PostureLattice, params: WaveParams
) -> posture_ground.SpaceGround:
    """The lattice at rest, in arrays that a thread uses again and again."""
    n, shape = lattice.n, _blocks(lattice.n)
    space = _workspace.__dict__
    if "buffer" not in space:
        space["buffer"] = stencil.cell_clearances()
    buffer, speed = space["buffer"], quickest(scene, lattice)
    rest = REST if params.start == "rest" else (0.0, 0.0)
    buffer[:] = 0.0
    for k, value in enumerate((rest[0], rest[0], rest[1], 0.0, 6.0, -1.0)):
        stencil.field(buffer, k, n)[:] = value
    live = stencil.field(buffer, 4, n)
    for axis in range(3):
        for end in (0, n - 1):
            live[(slice(None),) * axis + (end,)] -= 1.0
    return posture_ground.SpaceGround(
        B=buffer,
        n=n,
        joint_speed=scene.limits.joint_speed,
        speed=speed,
        found=_found(lattice, speed, tuple(scene.limits.joint_speed)),
        known=np.zeros(shape, np.uint8),
        wake=np.zeros(shape, np.bool_),
        slowest=SLOWEST_RATE,
        fewest=FEWEST,
        run=run_of(params, QUIET, 1.0 / mean_speed(params, 0.5 * n)),
    )


def _blocks(n: int) -> tuple[int, int, int]:
    """Shape of arrays over blocks of cells, with a rim."""
    return n + 2, n + 2, -(-n // stencil.BLOCK) + 2


@lru_cache(maxsize=2)
def _found(
    lattice: PostureLattice, speed: float, joint_speed: tuple[float, ...]
) -> posture_ground.Found:
    """Make the findings about a lattice, of joints and a front that are so fast."""
    cells, blocks = lattice.n**3, _blocks(lattice.n)
    return posture_ground.Found(
        nodes=lattice.nodes,
        elbows=np.empty((cells, 3), np.float32),
        rates=np.empty(cells, np.float32),
        asked=np.zeros(blocks, np.uint8),
        rated=np.zeros(blocks, np.bool_),
    )


def _rooms() -> tuple[posture_ground.Runs, posture_ground.SpaceBatch]:
    """Make lists of blocks and of cells."""
    space = _workspace.__dict__
    if "rooms" not in space:
        blocks = stencil.LARGEST**2 * (stencil.LARGEST // stencil.BLOCK)
        start, watch = np.zeros(blocks, np.uint64), np.zeros(blocks, np.uint64)
        most = posture_ground.MOST
        space["rooms"] = (
            posture_ground.Runs(
                start, watch, np.zeros(stencil.LARGEST + 1, np.int64), np.zeros(2, np.int64)
            ),
            posture_ground.SpaceBatch(np.empty(most, np.int64), np.empty(most), np.empty(most)),
        )
    return space["rooms"]
