"""The lattice over the hand's places of a chain: cells whose postures a front finds on its way."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any, ClassVar, NamedTuple

import numpy as np

from gcm_learn.arms import CHAIN, Chain, Kind, hands_along
from gcm_learn.charts.cube import Cube
from gcm_learn.errors import LatticeError
from gcm_learn.scene import Scene


class OnePosture(NamedTuple):
    """A limb with one posture in a cell."""

    limb: Any
    postures: int  # 1


class PulledNodes(NamedTuple):
    """The cells as kernels read them; a front writes the posture by which it comes to a cell."""

    rule: OnePosture
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
class HandLattice(Cube):
    """A lattice of n x n x n cells over the ball of hand positions of a chain.

    There is no rule by which a place has its posture.  Each front keeps one posture for each cell:
    that of the cell it came from, pulled to this one by the least turn of the joints.
    """

    kind: ClassVar[Kind] = CHAIN
    arm: Chain

    @property
    def hand(self) -> tuple[float, float, float]:
        """Hand at t = 0."""
        x, y, z = self.in_base(hands_along(self.arm, self.arm.joints)[0][0])
        return float(x), float(y), float(z)

    def hand_at(self, node: int) -> tuple[float, float, float]:
        """Centre of one cell: x, y, z."""
        z, y, x = (self.centres[i] for i in np.unravel_index(node, self.shape))
        return float(x), float(y), float(z)

    def nodes_for(self, scene: Scene) -> PulledNodes:
        """Return the nodes for a front, without postures yet."""
        count, dof = self.size, self.arm.dof
        weights = np.asarray(scene.limits.joint_speed, dtype=float) ** 2
        return PulledNodes(
            OnePosture(scene.limb, 1),
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

    def found_in(self, nodes: PulledNodes) -> np.ndarray:
        """Return the postures (nodes, dof) that a front found; NaN where it never came."""
        return np.where((nodes.known > 0)[:, None], nodes.joints, np.nan)

    def start(self, scene: Scene) -> tuple[np.ndarray, np.ndarray]:
        """Cells about the hand (k,), and times (k,) before which it is not there [s]."""
        nodes = self.nodes_near(np.array(self.hand), 1.0)
        return nodes, np.zeros(len(nodes))


@lru_cache(maxsize=2)
def hand_lattice_of(arm: Chain, n: int, postures: int = 1) -> HandLattice:
    """Return the lattice of an arm's hand-space.

    Raises
    ------
    LatticeError
        If the number of postures is not 1.
    """
    if postures != 1:
        raise LatticeError(f"{postures} postures: a cell of a chain has 1")
    return HandLattice(arm, n)
