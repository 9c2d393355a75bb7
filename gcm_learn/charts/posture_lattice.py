"""The lattice over hand-space in space: the chart whose nodes are cells and postures in them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import ClassVar, NamedTuple

import numpy as np

from gcm_learn.arms import SPATIAL, Kind, SpatialArm
from gcm_learn.arms.limbs import dof
from gcm_learn.arms.spatial_limb import SpatialLimb, limb_at, spatial_limb_of
from gcm_learn.charts.cube import Cube
from gcm_learn.charts.postures import Rule, leap_of, posture_of, rule_of
from gcm_learn.compiled import njit
from gcm_learn.errors import LatticeError
from gcm_learn.scene import Scene

MOST_POSTURES = 16
NOWHERE = 1e9  # joints of a node that has no posture
UNSEEN, THERE, MISSING = 0, 1, 2  # what is known of a node's posture


class Nodes(NamedTuple):
    """The nodes of a lattice in space as kernels read them; postures are found at their first use.

    Node ``((iz * n + iy) * n + ix) * K + k`` is the k-th posture of a cell.
    """

    rule: Rule
    n: int  # cells along a side
    spacing: float  # of cells
    leap: float  # a step in which no joint turns farther is one [rad]
    joints: np.ndarray  # (nodes, dof) float32 [rad], NOWHERE where there is none
    known: np.ndarray  # (nodes,) uint8: UNSEEN, THERE or MISSING
    scratch: np.ndarray  # (dof,)


@njit(_nrt=False)
def hand_of_node(nodes, node):
    """Hand (three numbers) at a node, in the frame of the base."""
    n, cell = nodes.n, node // nodes.rule.postures
    row = cell // n
    middle = 0.5 * (n - 1)
    return (
        (cell - row * n - middle) * nodes.spacing,
        (row % n - middle) * nodes.spacing,
        (row // n - middle) * nodes.spacing,
    )


@njit(_nrt=False)
def is_there(nodes, node):
    """Return whether a node has a posture, which is then in ``nodes.joints``."""
    if nodes.known[node] == UNSEEN:
        x, y, z = hand_of_node(nodes, node)
        found = posture_of(nodes.rule, node % nodes.rule.postures, x, y, z, nodes.scratch)
        for j in range(dof(nodes.rule.limb)):
            nodes.joints[node, j] = nodes.scratch[j] if found else NOWHERE
        nodes.known[node] = THERE if found else MISSING
    return nodes.known[node] == THERE


@njit(_nrt=False)
def look_at_all(nodes):
    """Find all postures."""
    for node in range(nodes.known.size):
        is_there(nodes, node)


@dataclass(frozen=True)
class PostureLattice(Cube):
    """A lattice of n x n x n cells over the ball of hand positions, and K postures in each.

    Arrays over it are indexed ``[iz, iy, ix]``, and ``[iz, iy, ix, k]`` with several postures.

    The module `postures` has the rule by which a hand has its postures. `inside` and `joints` find
    the postures of all nodes. Fronts find the postures of the nodes that they reach.
    """

    kind: ClassVar[Kind] = SPATIAL
    arm: SpatialArm
    postures: int = 1
    """Postures K in a cell: swivels of the elbow in a ring."""

    def __post_init__(self) -> None:
        """Check the sizes."""
        super().__post_init__()
        if not 1 <= self.postures <= MOST_POSTURES:
            raise LatticeError(f"{self.postures} postures are outside 1..{MOST_POSTURES}")

    @property
    def shape(self) -> tuple[int, ...]:
        """(n, n, n), with several postures (n, n, n, K)."""
        return (self.n,) * 3 + ((self.postures,) if self.postures > 1 else ())

    @cached_property
    def limb(self) -> SpatialLimb:
        """The arm as kernels read it."""
        return spatial_limb_of(self.arm)

    @cached_property
    def nodes(self) -> Nodes:
        """The nodes as kernels read them; postures that were found once are kept."""
        rule, shape = rule_of(self.limb, self.postures), (self.size, len(self.arm.joints))
        joints, known = np.empty(shape, np.float32), np.zeros(self.size, np.uint8)
        leap = leap_of(self.limb, self.spacing)
        return Nodes(rule, self.n, self.spacing, leap, joints, known, np.empty(shape[1]))

    @property
    def hands(self) -> np.ndarray:
        """Centre (nodes, 3) of every node's cell: x, y, z."""
        cells = super().hands
        return cells if self.postures == 1 else np.repeat(cells, self.postures, axis=0)

    @property
    def hand(self) -> tuple[float, float, float]:
        """Hand at t = 0."""
        _, _, _, x, y, z = limb_at(self.limb, self.limb.start)
        return float(x), float(y), float(z)

    def hand_at(self, node: int) -> tuple[float, float, float]:
        """Centre of one node's cell: x, y, z."""
        x, y, z = hand_of_node(self.nodes, node)
        return float(x), float(y), float(z)

    @property
    def inside(self) -> np.ndarray:
        """Nodes (nodes,) bool that have a posture."""
        look_at_all(self.nodes)
        return np.asarray(self.nodes.known == THERE)

    @property
    def joints(self) -> np.ndarray:
        """Joints (nodes, dof) float32 of every node; NOWHERE if it has no posture [rad]."""
        look_at_all(self.nodes)
        return self.nodes.joints

    def joints_at(self, nodes: np.ndarray) -> np.ndarray:
        """Joints (m, dof) of some nodes to full precision; NOWHERE if there is no posture [rad]."""
        out = np.empty((len(nodes), len(self.arm.joints)))
        for row, node in zip(out, nodes, strict=True):
            place = hand_of_node(self.nodes, node)
            if not posture_of(self.nodes.rule, node % self.postures, *place, row):
                row[:] = NOWHERE
        return out

    def nodes_for(self, scene: Scene) -> Nodes:
        """Return the nodes for a front: those that all fronts share."""
        return self.nodes

    def start(self, scene: Scene) -> tuple[np.ndarray, np.ndarray]:
        """First postures of the cells around the hand (k,), and when the arm is there (k,) [s]."""
        limb = scene.limb
        hand = np.array(self.hand)
        for around in (1.0, 2.0):
            nodes = self.nodes_near(hand, around) * self.postures
            joints = self.joints_at(nodes)
            turn = np.abs(joints - limb.start)
            good = turn.max(axis=1) <= self.nodes.leap
            if good.any():
                break
        places = np.array([hand_of_node(self.nodes, node) for node in nodes[good]]).reshape(-1, 3)
        away = np.linalg.norm(places - hand, axis=1) / scene.limits.speed
        turns = (turn[good] / scene.limits.joint_speed).max(axis=1, initial=0.0)
        return nodes[good], np.maximum(turns, away)


def ring_leap(postures: int) -> float:
    """Angle by which no joint turns from one posture in a cell to the next [rad]."""
    return min(4.0 * np.pi / postures, 0.9 * np.pi)


@lru_cache(maxsize=2)
def posture_lattice_of(arm: SpatialArm, n: int, postures: int = 1) -> PostureLattice:
    """The lattice of an arm's hand-space; the last two lattices keep their postures."""
    return PostureLattice(arm, n, postures)
