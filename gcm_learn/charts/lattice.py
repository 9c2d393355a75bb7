"""Lattice over hand-space in the plane: a chart with one node per cell."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import ClassVar, NamedTuple

import numpy as np

from gcm_learn.arms import PLANAR, Kind
from gcm_learn.arms.planar_limb import SIDE, elbow_of
from gcm_learn.charts.chart import SMALLEST_LATTICE, Chart
from gcm_learn.compiled import njit
from gcm_learn.errors import LatticeError

LARGEST_LATTICE = 320
START_RADIUS = 2.0  # cells this near to the hand are reached straight from it


@dataclass(frozen=True)
class Lattice(Chart):
    """A square lattice of n x n cells over the disc of radius upper_arm + 1 (Eq. 10's Lambda).

    Arrays over it are indexed ``[iy, ix]``, so ``imshow(a, origin="lower", extent=lattice.extent)``
    draws them in place.
    """

    half_diagonal: ClassVar[float] = 0.71
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
    def kind(self) -> Kind:
        """PLANAR."""
        return PLANAR

    @property
    def reach(self) -> float:
        """Radius of the disc [forearm lengths]."""
        return self.upper_arm + 1.0

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """Left, right, bottom, top edge, as matplotlib's ``extent``."""
        return (-self.reach, self.reach, -self.reach, self.reach)

    @cached_property
    def centres(self) -> np.ndarray:
        """Coordinates (n,) of the cells' centres along an axis."""
        return (np.arange(self.n) + 0.5) * self.spacing - self.reach

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.n, self.n

    @property
    def hands(self) -> np.ndarray:
        """Centres (n * n, 2) of the cells."""
        return hand_space(self).limb[:, :2]

    def hand_at(self, node: int) -> tuple[float, float]:
        """Centre of one cell."""
        x, y = self.hands[node]
        return float(x), float(y)


class HandSpace(NamedTuple):
    """Per-cell geometry of a lattice, flattened cell by cell (m = n * n)."""

    limb: np.ndarray  # (m, 4): hand x, y and elbow x, y
    stride: np.ndarray  # (m,): no point of the limb moves further when the hand goes half way to
    #                     a neighbouring cell
    inside: np.ndarray  # (m,) bool: the hand can be there


@lru_cache(maxsize=16)
def hand_space(lattice: Lattice) -> HandSpace:
    """Return the geometry of a lattice's cells; computed once and shared, so read-only."""
    limb, stride, inside = _geometry(lattice.centres, lattice.upper_arm, SIDE[lattice.elbow])
    for array in (limb, stride, inside):
        array.setflags(write=False)
    return HandSpace(limb, stride, inside)


@lru_cache(maxsize=16)
def cell_joints(lattice: Lattice) -> np.ndarray:
    """Return joint angles (n * n, 2) with the hand in every cell [rad]; shared, read-only."""
    x, y, ex, ey = hand_space(lattice).limb.T
    fx, fy = x - ex, y - ey
    bend = np.arctan2(ex * fy - ey * fx, ex * fx + ey * fy)
    joints = np.stack([np.arctan2(ey, ex), bend], axis=-1)
    joints.setflags(write=False)
    return joints


@njit
def _geometry(centres, rho, side):
    """Limb, stride and inside of `HandSpace`.

    Every new arm needs this geometry. So a quarter of the lattice is computed: turned by a right
    angle, a cell's hand and elbow stand in another cell.
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
