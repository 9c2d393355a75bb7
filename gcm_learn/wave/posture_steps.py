"""Nodes of a front in space, the steps between them, and records of marching over them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from gcm_learn.collision.postures import Desk
from gcm_learn.compiled import njit
from gcm_learn.scene import Scene
from gcm_learn.wave.kernels import Terms

OPEN, ACCEPTED, FROZEN, MET = 0, 1, 2, 3  # what became of a node
NEIGHBOURS = 26
RING = NEIGHBOURS  # code of a step to the next posture, and to the one before it
START = 255  # code of nodes that are reached from the arm's posture at t = 0
BUCKETS = 1024
NEVER, LOST = np.float32(1e30), np.float32(-1.0)


class Pace(NamedTuple):
    """Times of steps."""

    slowness: np.ndarray  # (dof,) float32 of the joints [s/rad]
    offsets: np.ndarray  # (26, 3): of neighbours along z, y and x [cells]
    ahead: np.ndarray  # (26,): of their nodes
    hops: np.ndarray  # (28,): how far they are
    hand: np.ndarray  # (28,) float32: how long the hand takes at least [s]
    buckets: float  # float32: in a second; a step takes at least as long as a bucket
    leap: float  # float32: angle by which no joint turns in a step within a cell [rad]


class Field(NamedTuple):
    """Arrivals at the nodes and their state."""

    arrival: np.ndarray  # (nodes,) float32: earliest so far [s]
    state: np.ndarray  # (nodes,) uint8
    via: np.ndarray  # (nodes,) uint8: step by which the front comes
    room: np.ndarray  # (nodes,) float32: distance that obstacles have at least then, bones only


class Ask(NamedTuple):
    """A scene, a lattice and the terms of marching over it."""

    scene: Scene
    nodes: Any  # `Nodes` or `PulledNodes`
    pace: Pace
    terms: Terms
    desk: Desk
    widening: np.ndarray  # (nodes,) or none: margin beyond `margin`
    margin: float  # of the limb, in halves of what it moves on a step
    quick: float  # top speed of obstacles [lengths/s]
    near: np.ndarray  # (dof,): joints
    far: np.ndarray  # (dof,)


class PulledAsk(Ask):
    """The same over cells whose postures a front finds; the type chooses the kernels."""

    __slots__ = ()


@njit(_nrt=False)
def neighbour(nodes, pace, node, code):
    """Node that a step with some code leads to, -1 if that is outside the lattice."""
    n, K = nodes.n, nodes.rule.postures
    cell = node // K
    if code >= RING:
        k = node - cell * K + (1 if code == RING else K - 1)
        return cell * K + (k if k < K else k - K)
    row = cell // n
    z = row // n
    x, y, z = (
        cell - row * n + pace.offsets[code, 2], row - z * n + pace.offsets[code, 1],
        z + pace.offsets[code, 0],
    )  # fmt: skip
    if x < 0 or y < 0 or z < 0 or x >= n or y >= n or z >= n:
        return -1
    return ((z * n + y) * n + x) * K + node - cell * K


@njit(_nrt=False)
def before(nodes, pace, node, code):
    """Node that a step with some code comes from; -1 for the arm's posture at t = 0."""
    if code == START:
        return -1
    back = NEIGHBOURS - 1 - code if code < RING else RING + RING + 1 - code
    return neighbour(nodes, pace, node, back)


@njit(_nrt=False)
def home_of(nodes, pace, node, code):
    """`before` of a step that was made, so that it is in the lattice."""
    return node - pace.ahead[code] if code < RING else before(nodes, pace, node, code)
