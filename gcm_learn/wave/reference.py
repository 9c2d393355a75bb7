"""The wave of Eq. 10 once more, slow and plain: the oracle of the tests.

`wave.kernels` is fast because it is float32, because it steps only the blocks of cells near the
front, and because it searches a span of time by conservative advancement.  Each of these could go
wrong without being seen.  Here the whole lattice is stepped in float64, every step is searched
for arrivals, and the limb is tested at many instants, with its own elbow and its own distance to
discs.  Tests hold the kernel against this; the benchmark says how much faster the kernel is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gcm_learn.collision.distance import arm_distance
from gcm_learn.handspace.lattice import Lattice, hand_space
from gcm_learn.scene import bodies as k
from gcm_learn.scene.bodies import Bodies
from gcm_learn.scene.limb import SIDE
from gcm_learn.wave.kernels import CONTACT, FREE, FROZEN
from gcm_learn.wave.params import EXCITED, HAND_POTENTIAL, REST, WaveParams
from gcm_learn.wave.solver import (
    CONTACT_RADIUS,
    Front,
    front_speed,
    hand_cell,
    kappa_of,
    rates_of,
)
from gcm_learn.wave.task import Task

LOOK = 1.2  # the front is looked at about this often [tau]
FINENESS = 0.05  # from one instant of a search to the next, a body moves this many cells at most
EDGES = ((0, 1), (0, -1), (1, 0), (-1, 0))
CORNERS = ((1, 1), (1, -1), (-1, 1), (-1, -1))

Couplings = list[tuple[tuple[int, int], np.ndarray]]


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


def propagate_reference(task: Task, params: WaveParams) -> Front:
    """Run the wave of Eq. 10 from the hand until contact or the horizon.

    Parameters
    ----------
    task : Task
        Its lattice must have ``params.n`` cells a side.
    params : WaveParams

    Returns
    -------
    Front
        As from `wave.propagate`, with arrivals in float64.
    """
    kappa = kappa_of(task, params)
    wave = _Wave.excited(task, params)
    start, end = wave.tau, task.horizon / kappa
    steps_a_look = 2 * max(1, int(0.5 * LOOK / params.step + 1e-9))
    steps = 0
    contact: tuple[float, int, int] | None = None
    while wave.tau < end and (contact is None or params.until == "horizon"):
        for _ in range(steps_a_look):
            wave.advance()
            steps += 1
            wave.tau = start + steps * params.step
        contacts = wave.look(min(wave.tau, end), kappa)
        if contact is None and contacts:
            contact = min(contacts)
    time, cell, body = (-1.0, -1, -1) if contact is None else contact
    return Front(wave.arrival * kappa, wave.state, cell, body, time * kappa, steps)


@dataclass
class _Wave:
    """The lattice while it is being stepped; all arrays are (n, n)."""

    task: Task
    params: WaveParams
    tau: float
    r: np.ndarray
    z: np.ndarray
    q: np.ndarray
    live: np.ndarray
    coupled: Couplings
    arrival: np.ndarray  # [tau], negative where the front has not been
    crossing: np.ndarray  # last upward crossing of the threshold [tau]
    state: np.ndarray
    limb: np.ndarray  # (n, n, 4): hand x, y and elbow x, y
    gap: np.ndarray  # distance at which an obstacle occupies a cell

    @classmethod
    def excited(cls, task: Task, params: WaveParams) -> _Wave:
        """A lattice at rest but for the hand's neuron and the disc around it."""
        n, space = params.n, hand_space(task.lattice)
        live = space.inside.reshape(n, n).copy()
        limb = _limbs(task.lattice)
        rest = REST if params.start == "rest" else (0.0, 0.0)
        r, z = np.full((n, n), rest[0]), np.full((n, n), rest[1])
        q, arrival = live * rates_of(task).reshape(n, n), np.full((n, n), -1.0)
        tau = 0.0
        if params.start_radius > 0.0:
            away = np.hypot(*(limb[..., :2] - task.hand).T).T / task.lattice.spacing
            disc = live & (away <= params.start_radius)
            slowness = 1.0 / front_speed(params).fastest
            r[disc], z[disc], arrival[disc] = *EXCITED, away[disc] * slowness
            tau = params.start_radius * slowness
        hand = hand_cell(task.lattice, task.hand)
        r[hand], q[hand], arrival[hand] = HAND_POTENTIAL, 0.0, 0.0
        coupled = couplings(live, params.laplacian)
        gap = task.gaps(params.margin).reshape(n, n)
        state = np.full((n, n), FREE, dtype=np.uint8)
        never = np.full((n, n), -1.0)
        return cls(task, params, tau, r, z, q, live, coupled, arrival, never, state, limb, gap)

    def advance(self) -> None:
        """Step the whole lattice once and note where the threshold was crossed."""
        before, level = self.r, self.params.threshold
        self.r, self.z = euler_step(before, self.z, self.q, self.coupled, self.params)
        up = (before < level) & (self.r >= level)
        share = (level - before[up]) / (self.r[up] - before[up])
        self.crossing[up] = self.tau + share * self.params.step

    def look(self, now: float, kappa: float) -> list[tuple[float, int, int]]:
        """Record arrivals and apply Eq. 11 to them; returns contacts (time, cell, body)."""
        new = self.live & (self.arrival < 0.0) & (self.r >= self.params.threshold)
        since = {(int(y), int(x)): self._next_door((int(y), int(x))) for y, x in np.argwhere(new)}
        cells = [cell for cell, time in since.items() if time >= 0.0]
        for cell in cells:
            self.arrival[cell] = max(self.crossing[cell], since[cell])
        contacts = []
        for cell in cells:
            span = (since[cell] * kappa, now * kappa)
            if self._occupied(cell, span):
                self._take_out(cell, FROZEN)
                continue
            time, body = self._met(cell, span)
            if body >= 0 and time >= self.task.ignore:
                self._take_out(cell, CONTACT)
                index = cell[0] * self.params.n + cell[1]
                contacts.append((max(time / kappa, float(self.arrival[cell])), index, body))
        if self.params.frozen == "insulating" and cells:
            self.coupled = couplings(self.live, self.params.laplacian)
        return contacts

    def _next_door(self, cell: tuple[int, int]) -> float:
        """Earliest arrival at an edge neighbour that passes the front on [tau], -1 if none."""
        n, times = self.params.n, []
        for i, j in EDGES:
            y, x = cell[0] + i, cell[1] + j
            if 0 <= y < n and 0 <= x < n and self.live[y, x] and self.arrival[y, x] >= 0.0:
                times.append(float(self.arrival[y, x]))
        return min(times, default=-1.0)

    def _take_out(self, cell: tuple[int, int], state: int) -> None:
        self.state[cell] = state
        self.q[cell] = 0.0
        if self.params.frozen == "insulating":
            self.live[cell] = False

    def _occupied(self, cell: tuple[int, int], span: tuple[float, float]) -> bool:
        """Whether an obstacle touches the cell's limb at any instant of a span [s]."""
        bodies, limb = self.task.bodies, self.limb[cell]
        obstacles = np.flatnonzero(bodies.rows[:, k.PART] != k.HAND).tolist()
        step = FINENESS * self.task.lattice.spacing
        return any(
            (distances(bodies, b, limb, instants(bodies, b, span, step)) <= self.gap[cell]).any()
            for b in obstacles
        )

    def _met(self, cell: tuple[int, int], span: tuple[float, float]) -> tuple[float, int]:
        """First target near the hand in a span [s]: (time, body), body -1 if none."""
        bodies, limb = self.task.bodies, self.limb[cell]
        h, first = self.task.lattice.spacing, (span[1], -1)
        for b in np.flatnonzero(bodies.rows[:, k.PART] == k.HAND).tolist():
            times = instants(bodies, b, span, FINENESS * h)
            reach = max(self.task.grasp + self.params.slack * h, CONTACT_RADIUS * h)
            near = distances(bodies, b, limb, times) <= reach
            if near.any() and (first[1] < 0 or times[near][0] < first[0]):
                first = (float(times[near][0]), b)
        return first


def _limbs(lattice: Lattice) -> np.ndarray:
    """Hand and elbow of every cell, (n, n, 4), by erratum 7."""
    x, y = np.meshgrid(lattice.centres, lattice.centres)
    rho, radius = lattice.upper_arm, np.hypot(x, y)
    a = np.clip((radius**2 + rho**2 - 1.0) / (2.0 * rho * radius), -1.0, 1.0)
    b = SIDE[lattice.elbow] * np.sqrt(1.0 - a**2)
    ux, uy = x / radius, y / radius
    return np.stack([x, y, rho * (a * ux + b * uy), rho * (a * uy - b * ux)], axis=-1)


def instants(bodies: Bodies, b: int, span: tuple[float, float], step: float) -> np.ndarray:
    """Times that cover a span [s] so densely that body b moves at most `step` between two."""
    way = bodies.rows[b, k.TOP_SPEED] * (span[1] - span[0])
    return np.linspace(*span, int(np.ceil(way / step)) + 1 if way > 0.0 else 1)


def distances(bodies: Bodies, b: int, limb: np.ndarray, times: np.ndarray) -> np.ndarray:
    """Distance of body b to the part of a limb that it can touch, at each of some times.

    Parameters
    ----------
    limb : (4,) ndarray
        Hand x, y and elbow x, y.
    times : (m,) ndarray
        [s]

    Returns
    -------
    (m,) ndarray
    """
    row = bodies.rows[b]
    if row[k.KIND] != k.DISC:
        return np.array([_kernel_distance(bodies, b, limb, t) for t in times])
    t = times[:, None]
    velocity, acceleration = row[k.VELOCITY :][:2], row[k.ACCELERATION :][:2]
    centre = row[k.POSITION :][:2] + velocity * t + 0.5 * acceleration * t**2
    hand, elbow = limb[:2], limb[2:]
    away = np.linalg.norm(centre - hand, axis=-1)
    if row[k.PART] != k.HAND:
        away = np.minimum(
            _from_segment(centre, elbow, hand), _from_segment(centre, 0 * elbow, elbow)
        )
    return np.maximum(away - row[k.SIZE], 0.0)


def _from_segment(points: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Distances of points (m, 2) to the segment a-b."""
    share = np.clip((points - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
    return np.linalg.norm(points - a - share[:, None] * (b - a), axis=-1)


def _kernel_distance(bodies: Bodies, b: int, limb: np.ndarray, t: float) -> float:
    """As `distances`, for bodies that are no discs."""
    poses = np.zeros((bodies.rows.shape[0], 12))
    k.pose_at(bodies, b, t, poses)
    return float(arm_distance(bodies, poses, b, *limb))
