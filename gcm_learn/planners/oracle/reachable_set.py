"""The set of places where the hand can be, followed through time on a lattice."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from gcm_learn.arms import Arm, elbow_position, joint_angles
from gcm_learn.charts import SMALLEST_LATTICE, Lattice
from gcm_learn.collision import first_touch
from gcm_learn.planners.completion import Problem, hole_of
from gcm_learn.planners.oracle import kernels
from gcm_learn.planners.oracle.kernels import Grid, ReachedSet, Regime, SetBuffers
from gcm_learn.planners.oracle.moves import MOVES, PAST, RIM, STRETCH
from gcm_learn.scene import LIMB, PART

STEP = 0.97  # of the shortest move: nothing comes into the set and goes on within one step
FEWEST_STEPS, MOST_STEPS = 100, 3000  # in a horizon
START_CELLS = (0.75, 3.2)  # outer, inner: cells that near to the start are entered from there
USEFUL_INSTANTS = 50
LEG_INSTANTS = 4.0  # resolution of interceptions by legs, which planning makes exact [instants]
JOINT_SLACK = 1.05  # joint speeds vary along a move; timing and verification have the last word
TIDY = 1.0 - 1e-8  # of the hand's speed, against rounding


class Meeting(NamedTuple):
    """A target met."""

    time: float
    """[s]"""
    leave: float
    """Instant at which an inner set's hand leaves the cell for it, by a straight leg [s]."""
    cell: int


class ReachableSet:
    """Outer or inner reachable set of the hand in a situation (see `oracle_kernels`).

    Parameters
    ----------
    problem : Problem
    n : int
        Cells along a side of the lattice; fewer are taken if the horizon is too long for them.
    exact : bool
        Inner set instead of the outer one.
    waiting : bool
        Whether the hand may wait; if not, a cell is left when it is reached and not again.
    after, before : float
        Catches before the one or from the other on need not be looked for [s].
    """

    def __init__(
        self,
        problem: Problem,
        n: int,
        *,
        exact: bool,
        waiting: bool = True,
        after: float = 0.0,
        before: float = math.inf,
    ) -> None:
        arm, bodies = problem.situation.arm, problem.bodies
        self.problem = problem
        self.end = min(problem.situation.horizon, before)
        most = MOST_STEPS * STEP * 2.0 * arm.reach / (STRETCH * arm.max_hand_speed * self.end)
        self.n = max(min(n, int(most)), SMALLEST_LATTICE)
        h = 2.0 * arm.reach / self.n
        self.dt = min(STEP * h / (STRETCH * arm.max_hand_speed), self.end / FEWEST_STEPS)
        self.dt = max(self.dt, self.end / MOST_STEPS)
        grid = _grid(Lattice(self.n, arm.upper_arm, arm.elbow), exact)
        self.regime = _regime(problem, h, exact, waiting, after)
        useful = kernels.useful_until(
            bodies, grid, self.end, arm.max_hand_speed, self.regime.meet, USEFUL_INSTANTS
        )
        self.front = _front(arm, grid, h, exact, useful)
        self.grid = _part(grid, self.front.away <= useful + 1e-9)
        size, count = len(grid.centre), len(bodies.rows)
        self.work = SetBuffers(
            look=np.full((size, count), -1.0),
            touched=np.zeros(size, dtype=np.uint64),
            poses=np.zeros((count, 12)),
            others=np.zeros((count, 12)),
            cells=np.zeros(count * size, dtype=np.int64),
            times=np.zeros(count * size),
            leaves=np.zeros(count * size),
        )
        if not exact:
            kernels.surely_blocked(self.regime, self.grid, self.front, self.work, 0.0)
            self.front.past[0] = self.front.blocked

    @property
    def sound(self) -> bool:
        """True if time steps are at most as long as the shortest move, as an outer set needs."""
        return self.dt <= self.front.cost.min()

    def meetings(self) -> Iterator[list[Meeting]]:
        """Follow the set by steps; yield each step's meetings with targets, in order of time."""
        for s in range(1, math.ceil(self.end / self.dt) + 1):
            self._make_room()
            work = self.work
            found = kernels.step(self.regime, self.grid, self.front, work, s, self.dt, self.end)
            if found:
                columns = (work.times[:found], work.leaves[:found], work.cells[:found])
                yield sorted(
                    Meeting(*row) for row in zip(*(c.tolist() for c in columns), strict=True)
                )

    def _make_room(self) -> None:
        """Make sure that a step cannot run out of nodes."""
        front = self.front
        if front.total[0] + len(self.grid.cells) > len(front.cell):
            longer = {
                name: np.concatenate([getattr(front, name), np.zeros_like(getattr(front, name))])
                for name in ("cell", "came", "left", "parent")
            }
            self.front = front._replace(**longer)

    def path_to(self, cell: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Way of the hand to a cell of the set.

        Returns
        -------
        came, left : (k,) ndarray
            When the hand comes to every stop and leaves it [s]; it starts at the first.
        hand : (k, 2) ndarray
            The stops.
        """
        front, nodes = self.front, []
        node = int(front.latest[cell])
        while node >= 0:
            nodes.append(node)
            node = int(front.parent[node])
        nodes.reverse()
        came = np.concatenate([[0.0], front.came[nodes]])
        left = np.concatenate([front.left[nodes], came[-1:]])
        hand = np.vstack([self.problem.situation.arm.hand, self.grid.centre[front.cell[nodes], :2]])
        return came, left, hand


@lru_cache(maxsize=16)
def _grid(lattice: Lattice, exact: bool) -> Grid:
    """Make the lattice with its rim; cells count by centre (exact) or any part within the ring."""
    h, rho, rim = lattice.spacing, lattice.upper_arm, RIM
    inner, outer = abs(rho - 1.0), rho + 1.0
    width = lattice.n + 2 * rim
    axis = (np.arange(width) - rim + 0.5) * h - outer
    centre = np.stack([a.ravel() for a in np.meshgrid(axis, axis)], axis=-1)
    radius = np.hypot(*centre.T)
    slack = 0.0 if exact else h * math.sqrt(0.5)
    inside = (radius <= outer + slack) & (radius >= inner - slack)
    inside &= (np.abs(centre) < outer).all(axis=1)
    corner = centre - 0.5 * h
    radius = np.maximum(np.hypot(*corner.T), 1e-12)
    corner *= (np.clip(radius, inner, outer) / radius)[:, None]
    centre, corner = (
        np.hstack([hand, elbow_position(hand, rho, lattice.elbow)]) for hand in (centre, corner)
    )
    return _part(Grid(width, centre, corner, np.empty(0, int), np.empty(0, int)), inside)


def _part(grid: Grid, wanted: np.ndarray) -> Grid:
    """Return the grid with only the cells that are `wanted` (m,)."""
    if len(grid.cells):
        wanted = wanted & np.isin(np.arange(len(wanted)), grid.cells)
    w, corners = grid.width, wanted.copy()
    for offset in (1, w, w + 1):
        corners[offset:] |= wanted[:-offset]
    return grid._replace(cells=np.flatnonzero(wanted), corners=np.flatnonzero(corners))


def _regime(problem: Problem, h: float, exact: bool, waiting: bool, after: float) -> Regime:
    """Return the rounding and the rules of a set; an outer set keeps the limits only."""
    arm, rules = problem.situation.arm, problem.rules
    meet = rules.catch + 2.0 * h if exact else arm.grasp + h * math.sqrt(0.5)
    rules = rules._replace(
        touch=rules.touch if exact else arm.thickness,
        speed=arm.max_hand_speed * TIDY,
        instant=LEG_INSTANTS * rules.instant,
    )
    return Regime(
        scene=problem.scene,
        rules=rules,
        exact=exact,
        waiting=waiting,
        hole=hole_of(arm),
        meet=meet,
        after=after,
        start_until=_start_until(problem, rules.touch),
        margin=4.0 * h / arm.max_hand_speed,
    )


def _start_until(problem: Problem, touch: float) -> float:
    """Return the time until which the hand can stay at its start [s]."""
    arm, horizon = problem.situation.arm, problem.situation.horizon
    limb = (*arm.hand, *elbow_position(arm.hand, arm.upper_arm, arm.elbow))
    poses = np.zeros((len(problem.bodies.rows), 12))
    until = math.inf
    for b in np.flatnonzero(problem.bodies.rows[:, PART] == LIMB):
        t = first_touch(problem.bodies, b, *limb, touch, 0.0, horizon, 1e-5 * horizon, poses)
        until = t if 0.0 <= t < until else until
    return until


def _front(arm: Arm, grid: Grid, h: float, exact: bool, useful: np.ndarray) -> ReachedSet:
    """The set before the first step: empty, with the cells around the hand listed."""
    size = len(grid.centre)
    offset = np.abs(grid.centre[:, :2] - arm.hand)
    if not exact:  # the nearest point of each cell
        offset = np.maximum(offset - 0.5 * h, 0.0)
    distance = np.hypot(*offset.T)
    counts = np.zeros(size, dtype=bool)
    counts[grid.cells] = True
    cost = _costs(arm, grid, h, exact)
    away = distance / (arm.max_hand_speed * (TIDY if exact else 1.0))
    # The hand starts slower where joints limit it: as the dearest move into the cell, per length.
    dear = (cost / cost.min(axis=0)).max(axis=1) if len(cost) > 1 else 1.0
    near = np.where(counts & (distance <= START_CELLS[exact] * h), away * dear, np.inf)
    nodes = len(grid.cells) + 64
    return ReachedSet(
        alive=np.zeros(size, dtype=bool),
        blocked=np.zeros(size, dtype=bool),
        past=np.zeros((1 if exact else PAST, size), dtype=bool),
        arrival=np.full(size, np.inf),
        until=np.full(size, -1.0),
        earliest=near.copy(),
        useful=useful,
        latest=np.full(size, -1, dtype=np.int64),
        away=away,
        near=near,
        cost=cost,
        cell=np.zeros(nodes, dtype=np.int64),
        came=np.zeros(nodes),
        left=np.zeros(nodes),
        parent=np.zeros(nodes, dtype=np.int64),
        total=np.zeros(1, dtype=np.int64),
    )


def _costs(arm: Arm, grid: Grid, h: float, exact: bool) -> np.ndarray:
    """Least times (1 or m, COUNT) of the moves into a cell [s]; the outer set knows no joints."""
    length = h * np.hypot(*MOVES.T)
    if not exact:
        return length[None] / (STRETCH * arm.max_hand_speed)
    least = length[None] / (arm.max_hand_speed * TIDY)
    if arm.max_joint_speed is None:
        return least
    joints = joint_angles(grid.centre[:, :2], arm.upper_arm, arm.elbow)
    source = np.arange(len(joints))[:, None] - MOVES @ (grid.width, 1)
    turn = joints[:, None] - joints[np.clip(source, 0, len(joints) - 1)]
    turn = np.abs((turn + np.pi) % (2.0 * np.pi) - np.pi)
    return np.maximum(least, JOINT_SLACK * (turn / arm.max_joint_speed).max(axis=2))
