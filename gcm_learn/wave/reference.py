"""Slow and plain wave of Eq. 10, the reference for tests of the kernels.

The kernels are float32, step only the blocks of cells near the front, and search a span of time by
conservative advancement.  Each of these could go wrong without being seen.  Here the whole lattice
is stepped in float64, and every step is searched for arrivals.  Limbs are tested at many instants,
with their own elbows and their own distance to discs.
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
from gcm_learn.wave.front import Front, first_arrivals
from gcm_learn.wave.kernels import CONTACT, FREE, FROZEN
from gcm_learn.wave.limits import contact_distance, gaps
from gcm_learn.wave.params import EXCITED, HAND_POTENTIAL, REST, WaveParams
from gcm_learn.wave.solver import front_speed, kappa_in_plane, rates_of, start_disc

LOOK = 1.2  # the front is checked about this often [tau]
FINENESS = 0.05  # from one instant of a search to the next, a body moves this many cells at most
EDGES = ((0, 1), (0, -1), (1, 0), (-1, 0))
CORNERS = ((1, 1), (1, -1), (-1, 1), (-1, -1))

Couplings = list[tuple[tuple[int, int], np.ndarray]]
Cell = tuple[int, int]


def propagate_reference(scene: Scene, lattice: Lattice, params: WaveParams) -> Front:
    """Run the wave of Eq. 10 from the hand until contact or the horizon.

    Parameters
    ----------
    scene : Scene
    lattice : Lattice
        Of ``params.n`` cells a side.
    params : WaveParams

    Returns
    -------
    Front
        As from `solver.propagate_in_plane`, with arrivals in float64.
    """
    wave = _Wave(scene, lattice, params)
    start = wave.tau
    while wave.goes_on():
        for _ in range(2 * max(1, int(0.5 * LOOK / params.step + 1e-9))):
            wave.advance()
            wave.tau = start + wave.steps * params.step
        wave.look()
    return wave.front()


def reaction(r: np.ndarray, z: np.ndarray, epsilon: float) -> tuple[np.ndarray, np.ndarray]:
    """Right-hand sides of Eq. 10 without diffusion: (dr/dtau, dz/dtau)."""
    return (((4.0 - r) * r - 2.0) * r - 2.0) / 7.0 - z, epsilon * (r - 7.0 * z - 2.0)


def couplings(live: np.ndarray, points: int) -> Couplings:
    """List the offsets of the neighbours that cells exchange with, and the weights.

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
        Used in place of that in `params`, which refuse values at which the wave fails.

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


class _Wave:
    """State of the lattice during a run; arrays are (n, n), mental times in tau."""

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
        self.q = self.inside * rates_of(scene, lattice).reshape(n, n)
        self.coupled = couplings(self.inside, params.laplacian)
        self.arrival, self.crossing = np.full(shape, -1.0), np.full(shape, -1.0)
        parts = scene.bodies.rows[:, PART]
        self.targets = np.flatnonzero(parts == HAND).tolist()
        self.obstacles = np.flatnonzero(parts != HAND).tolist()
        self.reach = contact_distance(scene, lattice, params)
        self.live = self.inside.copy()
        self.state = np.full(lattice.shape, FREE, dtype=np.uint8)
        self.contact: tuple[float, int, int] | None = None  # when [tau], cell, body
        for i, (cell, when) in enumerate(self.disc()):
            self.r[cell], self.z[cell] = EXCITED if i > 0 else (HAND_POTENTIAL, self.z[cell])
            self.q[cell], self.arrival[cell] = self.q[cell] * (i > 0), when

    @property
    def insulates(self) -> bool:
        """Return whether frozen cells are cut out."""
        return self.params.frozen == "insulating"

    def disc(self) -> list[tuple[Cell, float]]:
        """List the cells excited at the start and their times; the hand's cell comes first."""
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

    def goes_on(self) -> bool:
        """Return whether anything is left to do."""
        late = self.tau >= self.scene.limits.horizon / self.kappa
        return not late and (self.contact is None or self.params.until == "horizon")

    def passes_on(self, cell: Cell) -> bool:
        """Return whether a cell has been reached and passes the front on."""
        return bool(self.live[cell] and self.arrival[cell] >= 0.0)

    def look(self) -> None:
        """Record arrivals and apply Eq. 11 to them."""
        now = min(self.tau, self.scene.limits.horizon / self.kappa)
        new = self.live & (self.arrival < 0.0) & (self.r >= self.params.threshold)
        doors = {(i, j): self.next_door((i, j)) for i, j in np.argwhere(new).tolist()}
        since = {cell: time for cell, time in doors.items() if time >= 0.0}
        for cell, time in since.items():
            self.arrival[cell] = max(self.crossing[cell], time)
        contacts = []
        for cell, before in since.items():
            span, here = (before * self.kappa, now * self.kappa), np.array([cell])
            if any(self.near(b, here, self.instants(b, span)).any() for b in self.obstacles):
                self._take_out(cell, FROZEN)
                continue
            time, body = self._met(here, span)
            if body >= 0:
                self._take_out(cell, CONTACT)
                index = cell[0] * self.params.n + cell[1]
                contacts.append((max(time / self.kappa, float(self.arrival[cell])), index, body))
        if self.contact is None and contacts:
            self.contact = min(contacts)
        if self.insulates and since:
            self.coupled = couplings(self.live, self.params.laplacian)

    def _take_out(self, cell: Cell, state: int) -> None:
        self.state[cell], self.q[cell] = state, 0.0
        self.live[cell] = not self.insulates

    def _met(self, cell: np.ndarray, span: tuple[float, float]) -> tuple[float, int]:
        """First target near the hand in a span [s]: (time, body), body -1 if none."""
        first = (span[1], -1)
        for b in self.targets:
            times = self.instants(b, span)
            near = self.near(b, cell, times)[0]
            if near.any() and (first[1] < 0 or times[near][0] < first[0]):
                first = (float(times[near][0]), b)
        return first

    def front(self) -> Front:
        """Return the reached states."""
        time, cell, body = (-1.0, -1, -1) if self.contact is None else self.contact
        arrival = (self.arrival * self.kappa).ravel()
        met = (cell, body, time * self.kappa)
        state = self.state.ravel()
        return first_arrivals(
            self.lattice,
            arrival,
            state == FROZEN,
            state == CONTACT,
            met,
            horizon=self.scene.limits.horizon,
            steps=self.steps,
        )


def _limbs(lattice: Lattice) -> np.ndarray:
    """Hand and elbow of every cell, (n, n, 4), by erratum 7."""
    x, y = np.meshgrid(lattice.centres, lattice.centres)
    rho, radius = lattice.upper_arm, np.hypot(x, y)
    a = np.clip((radius**2 + rho**2 - 1.0) / (2.0 * rho * radius), -1.0, 1.0)
    b = SIDE[lattice.elbow] * np.sqrt(1.0 - a**2)
    ux, uy = x / radius, y / radius
    return np.stack([x, y, rho * (a * ux + b * uy), rho * (a * uy - b * ux)], axis=-1)


def distances(bodies: Bodies, b: int, limbs: np.ndarray, times: np.ndarray) -> np.ndarray:
    """Distances of body b to hands (if it is a target) or limbs (if an obstacle), at all `times`.

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
