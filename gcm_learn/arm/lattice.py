"""The lattice over hand-space and what is known of every cell before any body moves."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np

from gcm_learn.arm.kinematics import SIDE, elbow_position, joints_of
from gcm_learn.errors import LatticeError

SMALLEST_LATTICE, LARGEST_LATTICE = 16, 320


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


class HandSpace(NamedTuple):
    """Per-cell geometry of a lattice, flattened cell by cell (m = n * n)."""

    limb: np.ndarray  # (m, 4): hand x, y and elbow x, y
    stride: np.ndarray  # (m,): no point of the limb moves further when the hand goes half way to
    #                     a neighbouring cell
    inside: np.ndarray  # (m,) bool: the hand can be there


@lru_cache(maxsize=16)
def hand_space(lattice: Lattice) -> HandSpace:
    """Per-cell geometry of a lattice; computed once and shared, so treat it as read-only."""
    x, y = np.meshgrid(lattice.centres, lattice.centres)
    hand = np.stack([x, y], axis=-1)
    elbow = elbow_position(hand, lattice.upper_arm, lattice.elbow)
    radius = np.hypot(x, y)
    inside = (radius <= lattice.upper_arm + 1.0) & (radius >= abs(lattice.upper_arm - 1.0))
    # At the shoulder itself (rho = 1) the arm would spin at unbounded speed (erratum 5).
    inside &= radius > 0.5 * lattice.spacing
    half = 0.5 * lattice.spacing
    stride = np.full(x.shape, half)
    for dx, dy in ((half, 0.0), (-half, 0.0), (0.0, half), (0.0, -half)):
        moved = elbow_position(hand + (dx, dy), lattice.upper_arm, lattice.elbow)
        stride = np.maximum(stride, np.linalg.norm(moved - elbow, axis=-1))
    limb = np.concatenate([hand, elbow], axis=-1).reshape(-1, 4)
    for array in (limb, stride, inside):
        array.setflags(write=False)
    return HandSpace(np.ascontiguousarray(limb), stride.ravel(), inside.ravel())


@lru_cache(maxsize=16)
def cell_joints(lattice: Lattice) -> np.ndarray:
    """Joint angles (n * n, 2) of the arm with its hand in every cell [rad]; shared, read-only."""
    hands = hand_space(lattice).limb[:, None, :2]  # paths of one point each: nothing to unwrap
    joints = np.concatenate(
        [joints_of(hand, lattice.upper_arm, SIDE[lattice.elbow]) for hand in hands]
    )
    joints.setflags(write=False)
    return joints
