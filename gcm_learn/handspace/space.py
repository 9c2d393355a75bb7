"""The lattice over hand-space in space, and the rule by which a hand has one posture there.

A hand in space leaves the elbow a circle.  The rule takes the swivel that the arm has at t = 0, or
the nearest one to it that the joints' ranges allow, on the branch of the inverse kinematics that
the arm is on, or where that has none on another.  So it gives the arm's own joints where the arm is
at t = 0.  It is continuous but for three places: the half-line on which swivels are undefined,
where the swivels that are allowed fall apart, and where the branch changes.  A step across these
takes the joints long, and fronts are told how long.

Coordinates are those of the arm's base: the shoulder at the origin, the base unturned.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np

from gcm_learn.compiled import njit
from gcm_learn.errors import LatticeError
from gcm_learn.handspace.chart import Steps, steps_of
from gcm_learn.handspace.lattice import SMALLEST_LATTICE, START_RADIUS
from gcm_learn.scene import Scene, SpatialLimb, SpatialLimits
from gcm_learn.scene.spatial_limb import inverse, limb_at, spatial_limb, swivel_of
from gcm_learn.situation import JOINTS, SpatialArm

LARGEST_IN_SPACE = 80
SWIVELS = 24  # tried where that of the start is not allowed
HALVINGS = 5  # of the gap between two of them
NOWHERE = 1e9  # joints of a hand that has no posture
ON_THE_EDGE = 1e-6  # share of a bone within which a branch has no sign


class Rule(NamedTuple):
    """One posture for every hand."""

    limb: SpatialLimb
    swivel: float  # of the start [rad]
    side: float  # branch of the start: signs, 0 where both branches meet
    bend: float
    branches: np.ndarray  # (4, 4): room for solutions


def rule_of(limb: SpatialLimb) -> Rule:
    """The rule that gives a limb's joints at t = 0 where its hand is then."""
    place = limb_at(limb, limb.start)
    side, bend = _branch(limb, limb.start)
    return Rule(limb, swivel_of(limb, *place), side, bend, np.empty((4, JOINTS)))


@njit(_nrt=False)
def _sign(x, unit):
    return 0.0 if abs(x) < ON_THE_EDGE * unit else np.copysign(1.0, x)


@njit(_nrt=False)
def _branch(limb, q):
    """Branch of the inverse kinematics that joints q (4,) are on, as two signs."""
    u, f = limb.upper, limb.fore
    side = np.cos(q[1]) * u[0] - np.sin(q[1]) * u[1]
    bend = np.sin(q[3]) * f[0] + np.cos(q[3]) * f[1]
    return _sign(side, limb.rho), _sign(bend, limb.length)


@njit(_nrt=False)
def _held(rule, x, y, z, swivel, q):
    """Whether the arm can hold the hand (x, y, z) with a swivel; q (4,) gets the joints.

    Returns
    -------
    int
        2 if it is on the rule's branch, 1 if it is on another one, 0 if it can not.
    """
    limb, found, held = rule.limb, rule.branches, 0
    for i in range(inverse(limb, x, y, z, swivel, limb.start, found)):
        side, bend = _branch(limb, found[i])
        own = side * rule.side >= 0.0 and bend * rule.bend >= 0.0
        if own or held == 0:
            for j in range(4):
                q[j] = found[i, j]
        if own:
            return 2
        held = 1
    return held


@njit(_nrt=False)
def posture_for(rule, x, y, z, q):
    """Write the rule's joints for the hand (x, y, z) into q (4,); False if it has none."""
    limb = rule.limb
    away = np.sqrt(x * x + y * y + z * z)
    if not abs(limb.rho - limb.length) < away < limb.rho + limb.length:
        return False
    if _held(rule, x, y, z, rule.swivel, q) == 2:
        return True
    step, other = 2.0 * np.pi / SWIVELS, 0.0
    found = False
    for k in range(1, SWIVELS + 1):
        off = step * (k // 2 + k % 2) * (1.0 if k % 2 else -1.0)
        held = _held(rule, x, y, z, rule.swivel + off, q)
        if held == 2:
            near, far = off - np.copysign(step, off), off
            for _ in range(HALVINGS):
                middle = 0.5 * (near + far)
                if _held(rule, x, y, z, rule.swivel + middle, q) == 2:
                    far = middle
                else:
                    near = middle
            return _held(rule, x, y, z, rule.swivel + far, q) == 2
        if held == 1 and not found:
            found, other = True, off
    return found and _held(rule, x, y, z, rule.swivel + other, q) > 0


@njit(_nrt=False)
def turning_time(speed, q, p):
    """Time in which joints whose speeds are `speed` (4,) turn from q to p (4,) [s]."""
    return max(
        max(abs(p[0] - q[0]) / speed[0], abs(p[1] - q[1]) / speed[1]),
        max(abs(p[2] - q[2]) / speed[2], abs(p[3] - q[3]) / speed[3]),
    )


@njit(_nrt=False)
def _postures(rule, n, spacing, joints, limbs):
    """Joints (n^3, 4), the first NOWHERE if there are none, and limbs (n^3, 3, 3) of all cells."""
    for m in range(n * n * n):
        x = (m % n + 0.5 - 0.5 * n) * spacing
        y = (m // n % n + 0.5 - 0.5 * n) * spacing
        z = (m // (n * n) + 0.5 - 0.5 * n) * spacing
        limbs[m, 2, 0], limbs[m, 2, 1], limbs[m, 2, 2] = x, y, z
        if posture_for(rule, x, y, z, joints[m]):
            limbs[m, 1, 0], limbs[m, 1, 1], limbs[m, 1, 2], _, _, _ = limb_at(rule.limb, joints[m])
        else:
            joints[m, 0] = NOWHERE


@dataclass(frozen=True)
class SpaceLattice:
    """A cubic lattice of n x n x n cells over the ball that an arm can reach.

    Arrays over it are indexed ``[iz, iy, ix]``; every cell has one posture.
    """

    arm: SpatialArm
    n: int = 80
    """Cells along a side."""

    def __post_init__(self) -> None:
        if not SMALLEST_LATTICE <= self.n <= LARGEST_IN_SPACE:
            raise LatticeError(
                f"lattice size {self.n} is outside {SMALLEST_LATTICE}..{LARGEST_IN_SPACE} in space"
            )

    @property
    def shape(self) -> tuple[int, int, int]:
        """Cells along z, y and x."""
        return self.n, self.n, self.n

    @property
    def spacing(self) -> float:
        """Side of a cell, in the arm's unit."""
        return 2.0 * self.arm.reach / self.n

    @property
    def centres(self) -> np.ndarray:
        """Coordinates (n,) of the cells' centres along an axis."""
        return (np.arange(self.n) + 0.5 - 0.5 * self.n) * self.spacing

    @property
    def hands(self) -> np.ndarray:
        """Centres (n^3, 3) of the cells: x, y, z."""
        return hands_of(self)

    @property
    def inside(self) -> np.ndarray:
        """Cells (n^3,) bool that have a posture."""
        return self._postures[0][:, 0] < NOWHERE

    @property
    def joints(self) -> np.ndarray:
        """Joints (n^3, 4) in every cell, the first NOWHERE where there is no posture [rad]."""
        return self._postures[0]

    @property
    def limbs(self) -> np.ndarray:
        """Shoulder, elbow and hand (n^3, 3, 3) in every cell."""
        return self._postures[1]

    @cached_property
    def strides(self) -> np.ndarray:
        """How far (n^3,) points of the limb move on half a step to a neighbour."""
        pairs = self._pairs
        elbows = self.limbs[:, 1]
        way = 0.5 * np.linalg.norm(elbows[pairs[:, 0]] - elbows[pairs[:, 1]], axis=1)
        out = np.full(self.n**3, 0.5 * self.spacing)
        np.maximum.at(out, pairs.ravel(), np.repeat(way, 2))
        return out

    def joints_at(self, nodes: np.ndarray) -> np.ndarray:
        """Joints (m, 4) in cells (m,), without those of all the others [rad]."""
        rule, out = rule_of(spatial_limb(self.arm)), np.full((len(nodes), JOINTS), NOWHERE)
        for q, hand in zip(out, self.hands[nodes], strict=True):
            posture_for(rule, *hand, q)
        return out

    def cell_of(self, hand: np.ndarray) -> tuple[int, ...]:
        """Index (iz, iy, ix) of the cell that holds a hand (3,), clipped to the lattice."""
        index = np.floor(np.asarray(hand)[::-1] / self.spacing + 0.5 * self.n).astype(int)
        return tuple(int(i) for i in np.clip(index, 0, self.n - 1))

    def steps(self, limits: SpatialLimits) -> Steps:
        """The six neighbours; a step takes as long as the hand, or the slowest joint."""
        both = np.concatenate([self._pairs, self._pairs[:, ::-1]])
        turn = np.abs(self.joints[both[:, 1]] - self.joints[both[:, 0]]) / limits.joint_speed
        times = np.maximum(turn.max(axis=1), self.spacing / limits.speed)
        return steps_of(both, times, self.n**3)

    def start(self, scene: Scene) -> tuple[np.ndarray, np.ndarray]:
        """Cells within START_RADIUS of the hand, and when it is there [s]."""
        away = np.linalg.norm(self.hands - limb_at(scene.limb, scene.limb.start)[3:], axis=1)
        cells = np.flatnonzero(self.inside & (away <= START_RADIUS * self.spacing))
        turn = np.abs(self.joints[cells] - scene.limb.start) / scene.limits.joint_speed
        return cells, np.maximum(turn.max(axis=1), away[cells] / scene.limits.speed)

    def lower_bound(self, place: np.ndarray, near: float, limits: SpatialLimits) -> np.ndarray:
        """Least time (n^3,) from every cell until the hand is `near` a place (3,) [s]."""
        rate, length = limits.joint_speed, float(np.hypot.reduce(self.arm.forearm))
        turning = np.hypot(rate[0], rate[1]) * self.arm.reach + np.hypot(rate[2], rate[3]) * length
        away = np.linalg.norm(self.hands - place, axis=1)
        return np.maximum(away - near, 0.0) / min(turning, limits.speed)

    @cached_property
    def _postures(self) -> tuple[np.ndarray, np.ndarray]:
        joints, limbs = np.empty((self.n**3, JOINTS)), np.zeros((self.n**3, 3, 3))
        _postures(rule_of(spatial_limb(self.arm)), self.n, self.spacing, joints, limbs)
        return joints, limbs

    @property
    def _pairs(self) -> np.ndarray:
        """Pairs (m, 2) of neighbouring cells that have postures."""
        cells = np.arange(self.n**3).reshape(self.shape)
        pairs = [
            np.stack([cells[:-1], cells[1:]], -1),
            np.stack([cells[:, :-1], cells[:, 1:]], -1),
            np.stack([cells[:, :, :-1], cells[:, :, 1:]], -1),
        ]
        found = np.concatenate([pair.reshape(-1, 2) for pair in pairs])
        return found[self.inside[found].all(axis=1)]


@lru_cache(maxsize=4)
def _hands(n: int, spacing: float) -> np.ndarray:
    along = (np.arange(n) + 0.5 - 0.5 * n) * spacing
    z, y, x = np.meshgrid(along, along, along, indexing="ij")
    out = np.stack([x.ravel(), y.ravel(), z.ravel()], axis=-1)
    out.setflags(write=False)
    return out


def hands_of(lattice: SpaceLattice) -> np.ndarray:
    """Centres (n^3, 3) of a lattice's cells; shared, read-only."""
    return _hands(lattice.n, lattice.spacing)
