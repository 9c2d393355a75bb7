"""The yardstick: bounds on the earliest catch of any movement, waiting allowed, whole limb.

The reachable set of the hand is followed through space and time on a lattice,
R(t + dt) = dilate(R(t), v dt) minus what is occupied, once rounded outwards and once rounded
inwards (`oracle_kernels`).  The outer set's first meeting with a target bounds every catch from
below.  The inner set's is the end of a movement, which is tightened and verified like every plan
and bounds the earliest catch from above.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from gcm_learn.arm.kinematics import SIDE, elbow_position
from gcm_learn.arm.lattice import Lattice
from gcm_learn.arm.occupancy import first_touch
from gcm_learn.planners import oracle_kernels as kernels
from gcm_learn.planners.completion import (
    HOLE_MARGIN,
    Attempt,
    Problem,
    checked,
    finish,
    straight_catch,
)
from gcm_learn.planners.fronts import marching
from gcm_learn.planners.interception import first_interception
from gcm_learn.planners.oracle_kernels import Front, Grid
from gcm_learn.planners.plan import Plan
from gcm_learn.planners.straight import StraightPlanner
from gcm_learn.planners.timing import segment_times, straight_way
from gcm_learn.planners.verification import SAFETY, start_clearance
from gcm_learn.situation import Situation
from gcm_learn.situation.bodies import pack
from gcm_learn.situation.kernels import LIMB, PART
from gcm_learn.situation.situation import Arm

SIZES = (60, 120, 240)
TIGHT = 0.02
STEP = 0.97
MOST_STEPS = 3000
FEWEST_STEPS = 100
TRIES = 30
A_STEP = 6
NEVER = 1e300


@dataclass(frozen=True)
class Bounds:
    """What is known of the earliest catch of a situation [s]."""

    lower: float
    upper: float
    plan: Plan | None
    n: int

    @property
    def gap(self) -> float:
        return self.upper - self.lower


class ReachableSet:
    """The set of places where the hand can be, step by step."""

    def __init__(self, problem: Problem, n: int, exact: bool, waiting: bool = True) -> None:
        arm = problem.situation.arm
        self.problem, self.exact, self.waiting = problem, exact, waiting
        self.n, self.h = n, 2.0 * arm.reach / n
        self.grid = _grid(n, arm.upper_arm, arm.elbow, exact)
        self.cost = _costs(arm, n, exact)
        self.front = _front(arm, self.grid, self.cost, self.h, exact)
        self.floor = arm.thickness + (
            min(SAFETY, 0.5 * start_clearance(problem.situation, problem.bodies)) if exact else 0.0
        )
        self.start = np.array([*arm.hand, self._start_until()])
        dt = STEP * float(self.cost.min())
        horizon = problem.situation.horizon
        self.steps = int(min(max(math.ceil(horizon / dt), FEWEST_STEPS), MOST_STEPS))

    def _start_until(self) -> float:
        problem, arm = self.problem, self.problem.situation.arm
        limb = (*arm.hand, *elbow_position(arm.hand, arm.upper_arm, arm.elbow))
        scratch = np.zeros((len(problem.situation.bodies), 12))
        first = NEVER
        for b in np.flatnonzero(problem.bodies.rows[:, PART] == LIMB):
            t = first_touch(
                problem.bodies, b, *limb, self.floor, 0.0, problem.situation.horizon,
                1e-5 * problem.situation.horizon, scratch,
            )
            if t >= 0.0:
                first = min(first, t)
        return first

    def meetings(self, gap: float) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Cells and times of meetings with targets, by steps."""
        problem, grid = self.problem, self.grid
        situation, arm, bodies = problem.situation, problem.situation.arm, problem.bodies
        size, count = grid.limb.shape[0], len(situation.bodies)
        poses, scratch = np.zeros((count, 12)), np.zeros((count, 12))
        look, touched = np.full((size, count), -1.0), np.zeros(size, dtype=np.uint64)
        cells, times = np.empty(4 * size, dtype=np.int64), np.empty(4 * size)
        ahead = 4.0 * float(self.cost.max())
        ts = np.linspace(0.0, situation.horizon, self.steps + 1)
        front = self.front
        if not self.exact:
            kernels.surely_blocked(
                bodies, grid, 0.0, ahead, arm.thickness, look, touched, poses, front.away,
                front.blocked,
            )
        for t0, t1 in zip(ts[:-1], ts[1:]):
            front.before[:] = front.blocked
            if self.exact:
                kernels.ever_blocked(
                    bodies, grid, t0, t1, t1 + ahead, self.floor, look, poses, scratch, front.away,
                    front.blocked,
                )
                if self.waiting:
                    kernels.leave(grid, front, t0, t1)
            else:
                kernels.surely_blocked(
                    bodies, grid, t1, t1 + ahead, arm.thickness, look, touched, poses, front.away,
                    front.blocked,
                )
            front = self._room(front)
            kernels.accept(
                bodies, grid, front, t0, t1, arm.upper_arm, SIDE[arm.elbow],
                arm.inner_reach + HOLE_MARGIN if arm.inner_reach > 0 else 0.0, self.floor, self.start, self.exact, self.waiting,
            )
            found = kernels.meetings(
                bodies, grid, front, t0, t1, gap, not self.waiting, poses, scratch, cells, times
            )
            self.front = front
            if found:
                order = np.argsort(times[:found], kind="stable")
                yield cells[:found][order], times[:found][order]
            if not self.exact:
                kernels.leave(grid, front, t1, t1)

    def _room(self, front: Front) -> Front:
        if front.count[0] + self.grid.cells.size <= front.cell.size:
            return front
        def more(a): return np.concatenate([a, np.zeros_like(a)])
        return front._replace(cell=more(front.cell), came=more(front.came), left=more(front.left), parent=more(front.parent))

    def way(self, cell: int) -> tuple[np.ndarray, np.ndarray]:
        """Time and hand from the start to a cell, with waits."""
        front, grid = self.front, self.grid
        chain = []
        node = int(front.latest[cell])
        while node >= 0:
            chain.append(node)
            node = int(front.parent[node])
        chain.reverse()
        time, hand = [0.0], [np.array(self.problem.situation.arm.hand)]
        for node in chain:
            time += [front.left[node], front.came[node]]
            hand += [hand[-1], grid.limb[front.cell[node], :2]]
        return np.array(time), np.array(hand)


@lru_cache(maxsize=16)
def _grid(n, rho, elbow, exact):
    lattice = Lattice(n, rho, elbow)
    h = lattice.spacing
    w = n + 2 * kernels.RIM
    centres = (np.arange(w) - kernels.RIM + 0.5) * h - (rho + 1.0)
    x, y = np.meshgrid(centres, centres)
    hand = np.stack([x.ravel(), y.ravel()], axis=-1)
    corner = hand - 0.5 * h
    radius = np.hypot(*hand.T)
    inner, outer = abs(rho - 1.0), rho + 1.0
    if exact:
        inside = (radius <= outer) & (radius > inner + (HOLE_MARGIN if inner > 0 else 0.0))
    else:
        half = h * math.sqrt(0.5)
        inside = (radius <= outer + half) & (radius >= inner - half)
    r = np.hypot(*corner.T)
    scale = np.clip(r, max(inner, 1e-9), outer) / np.maximum(r, 1e-9)
    corner = corner * scale[:, None]
    yy, xx = np.divmod(np.arange(w * w), w)
    inside &= (yy >= 2) & (yy < w - 2) & (xx >= 2) & (xx < w - 2)
    cells = np.flatnonzero(inside)
    corners = np.unique(np.concatenate([cells, cells + 1, cells + w, cells + w + 1]))
    limb = np.concatenate([hand, elbow_position(hand, rho, elbow)], axis=1)
    corner = np.concatenate([corner, elbow_position(corner, rho, elbow)], axis=1)
    return Grid(w, limb, corner, cells, corners)


def _costs(arm: Arm, n: int, exact: bool) -> np.ndarray:
    h = 2.0 * arm.reach / n
    lengths = h * np.hypot(kernels.MOVE_I, kernels.MOVE_J)
    if not exact:
        return (lengths / (kernels.STRETCH * arm.max_hand_speed))[None]
    return (lengths / (arm.max_hand_speed*(1-1e-8)))[None]


def _front(arm: Arm, grid: Grid, cost, h: float, exact: bool) -> Front:
    size = grid.limb.shape[0]
    offset = np.abs(grid.limb[:, :2] - arm.hand)
    if not exact:
        offset = np.maximum(offset - 0.5 * h, 0.0)
    away = np.hypot(*offset.T) / (arm.max_hand_speed*(1-1e-8 if exact else 1))
    near = np.where(away * arm.max_hand_speed <= 2.5 * h, away, np.inf)
    outside = np.ones(size, bool)
    outside[grid.cells] = False
    near[outside] = np.inf
    nodes = 2 * grid.cells.size
    f = lambda v, t=float: np.full(size, v, dtype=t)
    return Front(
        f(False, bool), f(False, bool), f(False, bool), f(np.inf), f(-1.0), near.copy(), f(-1, np.int64),
        away, near, cost, np.zeros(nodes, np.int64), np.zeros(nodes), np.zeros(nodes), np.zeros(nodes, np.int64), np.zeros(1, np.int64),
    )
