"""Nodes of a front in space, the steps between them, and records of marching over them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.charts import Nodes
from gcm_learn.collision.postures import Desk
from gcm_learn.compiled import njit
from gcm_learn.scene import Scene
from gcm_learn.wave.kernels import Terms

OPEN, ACCEPTED, FROZEN, MET = 0, 1, 2, 3  # what became of a node
NEIGHBOURS = 26
START = 255  # code of nodes that are reached from the arm's posture at t = 0
BUCKETS = 1024
NEVER = np.float32(1e30)


class Pace(NamedTuple):
    """Times of steps."""

    slowness: np.ndarray  # (dof,) float32 of the joints [s/rad]
    offsets: np.ndarray  # (26, 3): of neighbours along z, y and x [cells]
    ahead: np.ndarray  # (26,): of their nodes
    hops: np.ndarray  # (26,): how far they are
    buckets: float  # float32: in a second; a step takes at least as long as a bucket


class NodeArrivals(NamedTuple):
    """Arrivals at the nodes and their state."""

    arrival: np.ndarray  # (nodes,) float32: earliest so far [s]
    state: np.ndarray  # (nodes,) uint8
    via: np.ndarray  # (nodes,) uint8: step by which the front comes


class Ask(NamedTuple):
    """Scene, lattice and terms of one march in space, with working arrays."""

    scene: Scene
    nodes: Nodes
    pace: Pace
    terms: Terms
    desk: Desk
    widening: np.ndarray  # (nodes,) or none: margin beyond `margin`
    margin: float  # of the limb, in halves of what it moves on a step
    near: np.ndarray  # (dof,): joints
    far: np.ndarray  # (dof,)


@njit(_nrt=False)
def hand_of_node(nodes, node):
    """Hand (three numbers) at the centre of a cell, in the frame of the base."""
    n, row = nodes.n, node // nodes.n
    middle = 0.5 * (n - 1)
    return (
        (node - row * n - middle) * nodes.spacing,
        (row % n - middle) * nodes.spacing,
        (row // n - middle) * nodes.spacing,
    )


@njit(_nrt=False)
def neighbour(nodes, pace, node, code):
    """Node that a step with some code leads to, -1 if that is outside the lattice."""
    n = nodes.n
    row = node // n
    z = row // n
    x, y, z = (
        node - row * n + pace.offsets[code, 2], row - z * n + pace.offsets[code, 1],
        z + pace.offsets[code, 0],
    )  # fmt: skip
    if x < 0 or y < 0 or z < 0 or x >= n or y >= n or z >= n:
        return -1
    return (z * n + y) * n + x


@njit(_nrt=False)
def before(nodes, pace, node, code):
    """Node that a step with some code comes from; -1 for the arm's posture at t = 0."""
    return -1 if code == START else neighbour(nodes, pace, node, NEIGHBOURS - 1 - code)


@njit(_nrt=False)
def home_of(nodes, pace, node, code):
    """Node that a step already made comes from: `before` without the check of the border."""
    return -1 if code == START else node - pace.ahead[code]
