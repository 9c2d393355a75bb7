"""Charts: where a front can be, as nodes with neighbours, whatever the space and the arm.

A front runs over the nodes of a chart.  A node stands for a posture of the arm: a cell of
hand-space in the plane, where the elbow's side fixes the posture; a cell in space and one of
several swivels of the elbow; or a cell of joint space.  What a front, a map and a planner need to
know of it is here; what is particular to one kind of hand-space stays in its chart.
"""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol, runtime_checkable

import numpy as np

from gcm_learn.scene import Scene


class Steps(NamedTuple):
    """Which nodes are next to which, and how long the hand or the slowest joint takes."""

    first: np.ndarray  # (nodes + 1,): the steps from node k are first[k] : first[k + 1]
    to: np.ndarray  # (m,): neighbour
    time: np.ndarray  # (m,): [s]


@runtime_checkable
class Chart(Protocol):
    """Nodes in which a front can be; arrays over them are flat, or in the chart's shape."""

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape in which arrays over the nodes are drawn and stored."""

    @property
    def spacing(self) -> float:
        """Distance of neighbouring hands [forearm lengths]."""

    @property
    def hands(self) -> np.ndarray:
        """Hand (nodes, d) at every node [forearm lengths]."""

    @property
    def inside(self) -> np.ndarray:
        """Nodes (nodes,) bool at which the arm can be."""

    @property
    def limbs(self) -> np.ndarray:
        """Joints (nodes, j, 3) of the limb at every node, from shoulder to hand."""

    @property
    def strides(self) -> np.ndarray:
        """How far (nodes,) points of the limb move at most on half a step to a neighbour."""

    def steps(self, limits: Any) -> Steps:
        """Neighbours of every node and the times to get there, by a scene's limits."""

    def start(self, scene: Scene) -> tuple[np.ndarray, np.ndarray]:
        """Nodes (k,) that are reached straight from where the arm is at t = 0, and when (k,) [s].

        They are close by: only the nodes themselves are asked for obstacles.
        """

    def lower_bound(self, place: np.ndarray, near: float, limits: Any) -> np.ndarray:
        """Least time (nodes,) from every node until the hand is `near` a place (3,) [s]."""


def steps_of(pairs: np.ndarray, times: np.ndarray, count: int) -> Steps:
    """Sort steps from node to node (m, 2) and their times (m,) [s] by where they begin."""
    order = np.argsort(pairs[:, 0], kind="stable")
    first = np.searchsorted(pairs[order, 0], np.arange(count + 1))
    return Steps(first, pairs[order, 1], times[order])
