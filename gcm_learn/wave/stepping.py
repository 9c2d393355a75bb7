"""The lattice of Eq. 10 stepped in plain numpy: what both reference waves are made of.

The whole of it is stepped in float64, and limbs are tested at many instants, with their own elbows
and their own distance to discs.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.arms import SIDE
from gcm_learn.charts import Lattice, hand_space
from gcm_learn.collision import arm_distance
from gcm_learn.scene import (
    ACCELERATION,
    BALL,
    HAND,
    PART,
    POSITION,
    SIZE,
    SWING,
    TOP_SPEED,
    VELOCITY,
    Bodies,
    Scene,
    pose_at,
)
from gcm_learn.wave.limits import contact_distance, gaps
from gcm_learn.wave.params import REST, WaveParams
from gcm_learn.wave.solver import front_speed, kappa_in_plane, rates_of, start_disc

FINENESS = 0.05  # from one instant of a search to the next, a body moves this many cells at most
EDGES = ((0, 1), (0, -1), (1, 0), (-1, 0))
CORNERS = ((1, 1), (1, -1), (-1, 1), (-1, -1))

Couplings = list[tuple[tuple[int, int], np.ndarray]]
Cell = tuple[int, int]


def reaction(r: np.ndarray, z: np.ndarray, epsilon: float) -> tuple[np.ndarray, np.ndarray]:
    """Right-hand sides of Eq. 10 without diffusion: (dr/dtau, dz/dtau)."""
    return (((4.0 - r) * r - 2.0) * r - 2.0) / 7.0 - z, epsilon * (r - 7.0 * z - 2.0)


def couplings(live: np.ndarray, points: int) -> Couplings:
    """List which neighbours every cell exchanges with, and how strongly.

    Parameters
    ----------
    live : (n, m) bool ndarray
        Cells that exchange with their neighbours; nothing flows into others or over the border.
    points : {5, 9}
        9 weighs the four edge neighbours by 4/6 and the four corner neighbours by 1/6.

    Returns
    -------
    list of ((int, int), (n, m) ndarray)
        Offset of a neighbour (rows, columns) and its weight in every cell.
    """
    edge = 1.0 if points == 5 else 4.0 / 6.0
    weights = [(offset, edge) for offset in EDGES]
    if points == 9:
        weights += [(offset, 1.0 / 6.0) for offset in CORNERS]
    return [(offset, weight * (live & _neighbour(live, offset))) for offset, weight in weights]


def euler_step(
    r: np.ndarray,
    z: np.ndarray,
    q: np.ndarray,
    coupled: Couplings,
    params: WaveParams,
    diffusion: float | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Advance Eq. 10 by one explicit Euler step.

    Parameters
    ----------
    r, z : (n, m) ndarray
        Potential and recovery variable.
    q : (n, m) ndarray
        1 where the potential may change, else 0 (Eq. 11).
    coupled : list
        From `couplings`.
    params : WaveParams
        Epsilon, step and diffusion are used.
    diffusion : float, optional
        Takes the place of the one in `params`, which refuse what lets the wave fail.

    Returns
    -------
    r, z : (n, m) ndarray
    """
    d = params.diffusion if diffusion is None else diffusion
    dr, dz = reaction(r, z, params.epsilon)
    flow = np.zeros_like(r)
    for offset, weight in coupled:
        flow += weight * (_neighbour(r, offset) - r)
    return r + params.step * q * (dr + d * flow), z + params.step * dz


def _neighbour(a: np.ndarray, offset: tuple[int, int]) -> np.ndarray:
    """Every cell's neighbour at an offset; 0 beyond the border."""
    (i, j), (n, m) = offset, a.shape
    return np.pad(a, 1)[1 + i : 1 + i + n, 1 + j : 1 + j + m]


class Stepped:
    """The lattice while it is being stepped; arrays are (n, n), mental times in tau."""

    def __init__(self, scene: Scene, lattice: Lattice, params: WaveParams) -> None:
        n, shape = params.n, lattice.shape
        self.scene, self.lattice, self.params = scene, lattice, params
        self.kappa = kappa_in_plane(scene, lattice, params)
        self.tau, self.steps = 0.0, 0
        self.inside, self.limb = hand_space(lattice).inside.reshape(n, n), _limbs(lattice)
        stride = hand_space(lattice).stride
        self.gap = gaps(scene, stride, params.margin, None).reshape(n, n)
        rest = REST if params.start == "rest" else (0.0, 0.0)
        self.r, self.z = np.full(shape, rest[0]), np.full(shape, rest[1])
        self.rate = self.inside * rates_of(scene, lattice).reshape(n, n)
        self.q = self.rate.copy()
        self.coupled = couplings(self.inside, params.laplacian)
        self.arrival, self.crossing = np.full(shape, -1.0), np.full(shape, -1.0)
        parts = scene.bodies.rows[:, PART]
        self.targets = np.flatnonzero(parts == HAND).tolist()
        self.obstacles = np.flatnonzero(parts != HAND).tolist()
        self.reach = contact_distance(scene, lattice, params)

    @property
    def insulates(self) -> bool:
        """Return whether cells that are frozen or inhibited are cut out."""
        return self.params.frozen == "insulating"

    def disc(self) -> list[tuple[Cell, float]]:
        """Cells that are excited at the start, and when; the hand's comes first."""
        cells, away = start_disc(self.scene, self.lattice, self.params)
        if self.params.start_radius == 0.0:
            return [(self._cell(cells[0]), 0.0)]
        slowness = 1.0 / front_speed(self.params).fastest
        self.tau = self.params.start_radius * slowness
        return [(self._cell(c), a * slowness) for c, a in zip(cells, away, strict=True)]

    def _cell(self, index: int) -> Cell:
        return int(index) // self.params.n, int(index) % self.params.n

    def advance(self) -> None:
        """Step the whole lattice once and note where the threshold was crossed."""
        before, level = self.r, self.params.threshold
        self.r, self.z = euler_step(before, self.z, self.q, self.coupled, self.params)
        up = (before < level) & (self.r >= level)
        share = (level - before[up]) / (self.r[up] - before[up])
        self.crossing[up] = self.tau + share * self.params.step
        self.steps += 1

    def passes_on(self, cell: Cell) -> bool:
        """Return whether a cell has been reached and passes the front on."""
        raise NotImplementedError

    def next_door(self, cell: Cell) -> float:
        """Earliest arrival at an edge neighbour that passes the front on [tau], -1 if none."""
        near = [(cell[0] + i, cell[1] + j) for i, j in EDGES]
        times = [float(self.arrival[c]) for c in near if self.within(c) and self.passes_on(c)]
        return min(times, default=-1.0)

    def within(self, cell: Cell) -> bool:
        """Return whether a cell is on the lattice."""
        return min(cell) >= 0 and max(cell) < self.params.n

    def instants(self, b: int, span: tuple[float, float]) -> np.ndarray:
        """Times that cover a span [s] so densely that body b does not go far between two."""
        way = self.scene.bodies.rows[b, TOP_SPEED] * (span[1] - span[0])
        step = FINENESS * self.lattice.spacing
        return np.linspace(*span, int(np.ceil(way / step)) + 1 if way > 0.0 else 1)

    def near(self, b: int, cells: np.ndarray, times: np.ndarray) -> np.ndarray:
        """Mark (c, m) at which times (m,) body b is at the limbs, or a target at the hands."""
        limbs, target = self.limb[tuple(cells.T)], b in self.targets
        gap = np.full(len(cells), self.reach) if target else self.gap[tuple(cells.T)]
        return distances(self.scene.bodies, b, limbs, times) <= gap[:, None]


def _limbs(lattice: Lattice) -> np.ndarray:
    """Hand and elbow of every cell, (n, n, 4), by erratum 7."""
    x, y = np.meshgrid(lattice.centres, lattice.centres)
    rho, radius = lattice.upper_arm, np.hypot(x, y)
    a = np.clip((radius**2 + rho**2 - 1.0) / (2.0 * rho * radius), -1.0, 1.0)
    b = SIDE[lattice.elbow] * np.sqrt(1.0 - a**2)
    ux, uy = x / radius, y / radius
    return np.stack([x, y, rho * (a * ux + b * uy), rho * (a * uy - b * ux)], axis=-1)


def distances(bodies: Bodies, b: int, limbs: np.ndarray, times: np.ndarray) -> np.ndarray:
    """Distances of body b to what it can touch of limbs, at each of some times.

    Parameters
    ----------
    limbs : (c, 4) ndarray
        Hand x, y and elbow x, y.
    times : (m,) ndarray
        [s]

    Returns
    -------
    (c, m) ndarray
    """
    row = bodies.rows[b]
    if row[BALL] == 0.0 or row[SWING] >= 0.0:
        return np.array([[_kernel_distance(bodies, b, limb, t) for t in times] for limb in limbs])
    t = times[:, None]
    centre = row[POSITION:][:3] + row[VELOCITY:][:3] * t
    centre = centre + 0.5 * row[ACCELERATION:][:3] * t**2
    centre, height = centre[:, :2], centre[:, 2]
    hand, elbow = limbs[:, None, :2], limbs[:, None, 2:]
    if row[PART] == HAND:
        away = np.linalg.norm(centre - hand, axis=-1)
    else:
        upper_arm = _from_segments(centre, 0.0 * elbow, elbow)
        away = np.minimum(_from_segments(centre, elbow, hand), upper_arm)
    return np.maximum(np.hypot(away, height) - row[SIZE], 0.0)


def _from_segments(points: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Distances (c, m) of points (m, 2) to segments from a to b (c, 1, 2)."""
    along = b - a
    share = ((points - a) * along).sum(-1) / (along * along).sum(-1)
    nearest = a + np.clip(share, 0.0, 1.0)[..., None] * along
    return np.linalg.norm(points - nearest, axis=-1)


def _kernel_distance(bodies: Bodies, b: int, limb: np.ndarray, t: float) -> float:
    """As `distances`, for bodies of any shape and law."""
    poses = np.zeros((bodies.rows.shape[0], 12))
    pose_at(bodies, b, t, poses)
    return float(arm_distance(bodies, poses, b, *limb))
