"""Lattice over the hand's positions in space; a front finds the cells' postures on its way."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from gcm_learn.arms import Kind, hands_along, kind_of, rotation_of
from gcm_learn.charts.chart import SMALLEST_LATTICE, Chart
from gcm_learn.errors import LatticeError
from gcm_learn.scene import Scene

LARGEST_HAND_LATTICE = 80


class Nodes(NamedTuple):
    """Arrays over the cells, for kernels; a front writes the posture in which it reaches a cell."""

    limb: Any
    n: int  # cells along a side
    spacing: float  # of cells
    joints: np.ndarray  # (nodes, dof): postures [rad or lengths]
    hands: np.ndarray  # (nodes, 3): the hand there
    turns: np.ndarray  # (nodes, dof, 3): turn of the joints for a way of the hand
    known: np.ndarray  # (nodes,) int16: 1 + the step by which the posture was found, 0 if none
    refused: np.ndarray  # (nodes,) float32: when the first front froze there [s], -1 if none did
    weights: np.ndarray  # (dof,): squares of the joints' speeds
    held: np.ndarray  # (dof,): the same, 0 for joints that are held at an end of their range
    slopes: np.ndarray  # (3, dof): scratch
    turned: np.ndarray  # (dof, 3): scratch
    pulled: np.ndarray  # (dof,): scratch


@dataclass(frozen=True)
class HandLattice(Chart):
    """A lattice of n x n x n cells over the ball of hand positions of an arm in space.

    The frame is that of the arm's base, with lengths in the arm's unit.  Arrays over the cells are
    indexed ``[iz, iy, ix]``.

    There is no rule by which a place has its posture.  Each front keeps one posture for each cell:
    that of the cell it came from, pulled to this one by the least turn of the joints.
    """

    half_diagonal: ClassVar[float] = 0.87
    arm: Any
    n: int = 40
    """Cells along a side."""

    def __post_init__(self) -> None:
        """Check the size."""
        if not SMALLEST_LATTICE <= self.n <= LARGEST_HAND_LATTICE:
            raise LatticeError(
                f"lattice size {self.n} is outside "
                f"{SMALLEST_LATTICE}..{LARGEST_HAND_LATTICE} in space"
            )

    @property
    def kind(self) -> Kind:
        """Kind of the arm."""
        return kind_of(self.arm)

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

    @property
    def hand(self) -> tuple[float, float, float]:
        """Hand at t = 0."""
        x, y, z = self.in_base(hands_along(self.arm, self.arm.joints)[0][0])
        return float(x), float(y), float(z)

    def hand_at(self, node: int) -> tuple[float, float, float]:
        """Centre of one cell: x, y, z."""
        z, y, x = (self.centres[i] for i in np.unravel_index(node, self.shape))
        return float(x), float(y), float(z)

    def in_world(self, points: np.ndarray) -> np.ndarray:
        """Points (..., 3) of the lattice's frame, in the world."""
        base = self.arm.base
        return np.asarray(points) @ rotation_of(base.rotation).T + np.array(base.origin)

    def in_base(self, points: np.ndarray) -> np.ndarray:
        """Points (..., 3) of the world, in the lattice's frame."""
        base = self.arm.base
        return (np.asarray(points) - np.array(base.origin)) @ rotation_of(base.rotation)

    def nodes_for(self, scene: Scene) -> Nodes:
        """Return the nodes for a front, without postures yet."""
        count, dof = self.size, len(self.arm.joints)
        weights = np.asarray(scene.limits.joint_speed, dtype=float) ** 2
        return Nodes(
            scene.limb,
            self.n,
            self.spacing,
            np.empty((count, dof)),
            np.empty((count, 3)),
            np.empty((count, dof, 3)),
            np.zeros(count, np.int16),
            np.full(count, -1.0, np.float32),
            weights,
            np.empty(dof),
            np.empty((3, dof)),
            np.empty((dof, 3)),
            np.empty(dof),
        )

    def found_in(self, nodes: Nodes) -> np.ndarray:
        """Return the postures (nodes, dof) that a front found; NaN where it never came."""
        return np.where((nodes.known > 0)[:, None], nodes.joints, np.nan)

    def start(self) -> np.ndarray:
        """Return the cells (k,) about the hand at t = 0."""
        near = [np.flatnonzero(np.abs(self.centres - c) < self.spacing) for c in self.hand]
        index = np.stack(np.meshgrid(*near[::-1], indexing="ij"), axis=-1).reshape(-1, 3)
        cells: np.ndarray = index @ np.array([self.n**2, self.n, 1])
        return cells
