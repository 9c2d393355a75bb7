"""The lattice over hand-space in the plane: the chart whose nodes are cells."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np

from gcm_learn.arms.planar_limb import SIDE, elbow_of, joints_of
from gcm_learn.compiled import njit
from gcm_learn.errors import LatticeError
from gcm_learn.handspace.chart import Steps, steps_of
from gcm_learn.scene import Limits, Scene

SMALLEST_LATTICE, LARGEST_LATTICE = 16, 320
START_RADIUS = 2.0  # cells this near to the hand are reached straight from it


@dataclass(frozen=True)
class Lattice:
    """A square lattice of n x n cells over the disc of radius upper_arm + 1 (Eq. 10's Lambda).

    Arrays over it are indexed ``[iy, ix]``, so ``imshow(a, origin="lower", extent=lattice.extent)``
    draws them in place.
    """

    n: int = 80
    """Cells along a side; 80 in the paper."""
    upper_arm: float = 1.0
    """Length of the upper arm, rho [forearm lengths]."""
    elbow: str = "right"
    """Side of the elbow, looking from shoulder to hand."""

    def __post_init__(self) -> None:
        if not SMALLEST_LATTICE <= self.n <= LARGEST_LATTICE:
            raise LatticeError(
                f"lattice size {self.n} is outside {SMALLEST_LATTICE}..{LARGEST_LATTICE}"
            )
        if self.elbow not in SIDE:
            raise LatticeError(f"elbow must be 'right' or 'left', got {self.elbow!r}")

    @property
    def spacing(self) -> float:
        """Side h of a cell [forearm lengths]."""
        return 2.0 * (self.upper_arm + 1.0) / self.n

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """Left, right, bottom, top edge, as matplotlib's ``extent``."""
        reach = self.upper_arm + 1.0
        return (-reach, reach, -reach, reach)

    @cached_property
    def centres(self) -> np.ndarray:
        """Coordinates (n,) of the cells' centres along an axis."""
        return (np.arange(self.n) + 0.5) * self.spacing - (self.upper_arm + 1.0)

    def cell_of(self, x: float, y: float) -> tuple[int, int]:
        """Index (iy, ix) of the cell that holds a point, clipped to the lattice."""
        reach, h = self.upper_arm + 1.0, self.spacing
        ix = min(max(int((x + reach) / h), 0), self.n - 1)
        iy = min(max(int((y + reach) / h), 0), self.n - 1)
        return iy, ix

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.n, self.n

    @property
    def hands(self) -> np.ndarray:
        """Centres (n * n, 2) of the cells."""
        return hand_space(self).limb[:, :2]

    @property
    def inside(self) -> np.ndarray:
        """Cells (n * n,) bool that the hand can be in."""
        return hand_space(self).inside

    @property
    def strides(self) -> np.ndarray:
        """How far (n * n,) points of the limb move when the hand goes half way to the next cell."""
        return hand_space(self).stride

    @property
    def limbs(self) -> np.ndarray:
        """Shoulder, elbow and hand (n * n, 3, 3) in every cell."""
        limb = hand_space(self).limb
        out = np.zeros((len(limb), 3, 3))
        out[:, 1, :2], out[:, 2, :2] = limb[:, 2:], limb[:, :2]
        return out

    def steps(self, limits: Limits) -> Steps:
        """The eight neighbours; a step takes as long as the hand, or the slowest joint."""
        cells = np.arange(self.n**2).reshape(self.shape)
        pairs = []
        for i, j in ((0, 1), (1, 0), (1, 1), (1, -1)):
            here = cells[: self.n - i, max(-j, 0) : self.n - max(j, 0)]
            there = cells[i:, max(j, 0) : self.n + min(j, 0)]
            pairs += [np.stack([here, there], -1), np.stack([there, here], -1)]
        found = np.concatenate([pair.reshape(-1, 2) for pair in pairs])
        found = found[self.inside[found].all(axis=1)]
        joints = cell_joints(self)
        times = self._times(self.hands[found], joints[found], limits)
        return steps_of(found, times, self.n**2)

    def start(self, scene: Scene) -> tuple[np.ndarray, np.ndarray]:
        """Cells within START_RADIUS of the hand, and when it is there [s]."""
        limb = scene.limb
        hand = np.array([[limb.x, limb.y]])
        away = np.hypot(*(self.hands - hand).T) / self.spacing
        cells = np.flatnonzero(self.inside & (away <= START_RADIUS))
        joints = joints_of(hand, limb.rho, limb.side)
        ends = [np.stack(np.broadcast_arrays(a, b[cells]), axis=1)
                for a, b in ((hand, self.hands), (joints, cell_joints(self)))]  # fmt: skip
        return cells, self._times(ends[0], ends[1], scene.limits)

    def lower_bound(self, place: np.ndarray, near: float, limits: Limits) -> np.ndarray:
        """Least time (n * n,) from every cell until the hand is `near` a place (3,) [s]."""
        away = np.hypot(np.hypot(*(self.hands - place[:2]).T), place[2])
        return np.maximum(away - near, 0.0) / limits.speed

    @staticmethod
    def _times(hands: np.ndarray, joints: np.ndarray, limits: Limits) -> np.ndarray:
        """Times (m,) between pairs of hands (m, 2, 2) with their joint angles (m, 2, 2) [s]."""
        turn = np.abs(joints[:, 1] - joints[:, 0])
        turn[:, 0] = np.abs((turn[:, 0] + np.pi) % (2.0 * np.pi) - np.pi)
        hand = np.hypot(*(hands[:, 1] - hands[:, 0]).T) / limits.speed
        return np.maximum(hand, (turn / (limits.shoulder, limits.elbow)).max(axis=1))


class HandSpace(NamedTuple):
    """Per-cell geometry of a lattice, flattened cell by cell (m = n * n)."""

    limb: np.ndarray  # (m, 4): hand x, y and elbow x, y
    stride: np.ndarray  # (m,): no point of the limb moves further when the hand goes half way to
    #                     a neighbouring cell
    inside: np.ndarray  # (m,) bool: the hand can be there


@lru_cache(maxsize=16)
def hand_space(lattice: Lattice) -> HandSpace:
    """Per-cell geometry of a lattice; computed once and shared, so treat it as read-only."""
    limb, stride, inside = _geometry(lattice.centres, lattice.upper_arm, SIDE[lattice.elbow])
    for array in (limb, stride, inside):
        array.setflags(write=False)
    return HandSpace(limb, stride, inside)


@lru_cache(maxsize=16)
def cell_joints(lattice: Lattice) -> np.ndarray:
    """Joint angles (n * n, 2) of the arm with its hand in every cell [rad]; shared, read-only."""
    x, y, ex, ey = hand_space(lattice).limb.T
    fx, fy = x - ex, y - ey
    bend = np.arctan2(ex * fy - ey * fx, ex * fx + ey * fy)
    joints = np.stack([np.arctan2(ey, ex), bend], axis=-1)
    joints.setflags(write=False)
    return joints


@njit
def _geometry(centres, rho, side):
    """Limb, stride and inside of `HandSpace`.

    Every arm that was not met before needs them, so it is a quarter of the lattice that is
    computed: turned by a right angle, hand and elbow are those of another cell.
    """
    n = centres.size
    limb, stride = np.empty((n * n, 4)), np.empty(n * n)
    inside = np.empty(n * n, dtype=np.bool_)
    half, quarter = (rho + 1.0) / n, (n + 1) // 2  # an odd lattice has its middle row in two
    below = np.empty((quarter, 2))  # elbow with the hand half way to the cell below
    for j in range(quarter):
        below[j, 0], below[j, 1] = elbow_of(centres[j], centres[0] - half, rho, side)
    for i in range(quarter):
        left = elbow_of(centres[0] - half, centres[i], rho, side)
        for j in range(quarter):
            x, y = centres[j], centres[i]
            ex, ey = elbow_of(x, y, rho, side)
            right = elbow_of(x + half, y, rho, side)
            above = elbow_of(x, y + half, rho, side)
            far2 = half * half
            for mx, my in (left, right, above, (below[j, 0], below[j, 1])):
                far2 = max(far2, (mx - ex) ** 2 + (my - ey) ** 2)
            longest = np.sqrt(far2)
            left, below[j, 0], below[j, 1] = right, above[0], above[1]
            radius = np.sqrt(x * x + y * y)
            # At the shoulder itself (rho = 1) the arm would spin at unbounded speed (erratum 5).
            ring = abs(rho - 1.0) <= radius <= rho + 1.0 and radius > half
            a, b = i, j
            for _ in range(4):
                cell = a * n + b
                limb[cell, 0], limb[cell, 1] = centres[b], centres[a]
                limb[cell, 2], limb[cell, 3] = ex, ey
                stride[cell], inside[cell] = longest, ring
                a, b, ex, ey = b, n - 1 - a, -ey, ex
    return limb, stride, inside
