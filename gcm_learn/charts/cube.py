"""A cube of cells over the hand's places in space, in the frame of the arm's base."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from gcm_learn.arms import rotation_of
from gcm_learn.charts.chart import SMALLEST_LATTICE, Chart
from gcm_learn.errors import LatticeError
from gcm_learn.scene import Scene

LARGEST_POSTURE_LATTICE = 80


@dataclass(frozen=True)
class Cube(Chart):
    """A lattice of n x n x n cells over the ball of hand positions.

    The frame is that of the arm's base, with lengths in the arm's unit.  Arrays over the cells are
    indexed ``[iz, iy, ix]``.
    """

    half_diagonal: ClassVar[float] = 0.87
    arm: Any
    n: int = 80
    """Cells along a side."""

    @property
    def postures(self) -> int:
        """Postures in a cell."""
        return 1

    @abstractmethod
    def nodes_for(self, scene: Scene) -> Any:
        """Return the nodes for a front, as kernels read them."""

    @abstractmethod
    def start(self, scene: Scene) -> tuple[np.ndarray, np.ndarray]:
        """Return nodes around the hand (k,), and when the arm is there (k,) [s]."""

    def found_in(self, nodes: Any) -> np.ndarray | None:
        """Return the postures (nodes, dof) that a front found; None if a rule has them."""
        return None

    def __post_init__(self) -> None:
        """Check the size."""
        if not SMALLEST_LATTICE <= self.n <= LARGEST_POSTURE_LATTICE:
            raise LatticeError(
                f"lattice size {self.n} is outside "
                f"{SMALLEST_LATTICE}..{LARGEST_POSTURE_LATTICE} in space"
            )

    @property
    def shape(self) -> tuple[int, ...]:
        """(n, n, n)."""
        return (self.n,) * 3

    @property
    def reach(self) -> float:
        """Radius of the ball, half a side of the lattice."""
        return float(self.arm.reach)

    @property
    def centres(self) -> np.ndarray:
        """Coordinates (n,) of the cells' centres along an axis."""
        return (np.arange(self.n) - 0.5 * (self.n - 1)) * self.spacing

    @property
    def hands(self) -> np.ndarray:
        """Centre (nodes, 3) of every cell: x, y, z."""
        z, y, x = np.meshgrid(*(self.centres,) * 3, indexing="ij")
        return np.stack([x, y, z], axis=-1).reshape(-1, 3)

    def in_world(self, points: np.ndarray) -> np.ndarray:
        """Points (..., 3) of the lattice's frame, in the world."""
        base = self.arm.base
        return np.asarray(points) @ rotation_of(base.rotation).T + np.array(base.origin)

    def in_base(self, points: np.ndarray) -> np.ndarray:
        """Points (..., 3) of the world, in the lattice's frame."""
        base = self.arm.base
        return (np.asarray(points) - np.array(base.origin)) @ rotation_of(base.rotation)

    def nodes_near(self, hand: np.ndarray, around: float) -> np.ndarray:
        """Return the cells (k,) whose centres are nearer than `around` cells along every axis."""
        near = [np.flatnonzero(np.abs(self.centres - c) < around * self.spacing) for c in hand]
        index = np.stack(np.meshgrid(*near[::-1], indexing="ij"), axis=-1).reshape(-1, 3)
        cells: np.ndarray = index @ np.array([self.n**2, self.n, 1])
        return cells
