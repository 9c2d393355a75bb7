"""Data of the goal-directed search: nodes, labels, a queue. Times in seconds."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.collision.occupancy import Postures
from gcm_learn.collision.sweep import Sweep
from gcm_learn.compiled import njit
from gcm_learn.motion.rules import Rules
from gcm_learn.scene import Scene

PIECES = 64  # of a leg, whose sweeps are found out once


class SearchCells(NamedTuple):
    """The cells of a lattice, and the start as one more node."""

    scene: Scene
    rules: Rules
    postures: Postures  # limbs of all nodes
    n: int
    inside: np.ndarray  # (n * n,) bool
    spacing: float  # [forearm lengths]
    hole: float  # distance that legs keep from the shoulder
    sweep: Sweep  # room to ask for a leg
    sweeps: np.ndarray  # (PIECES,): and for what its pieces sweep
    budget: np.ndarray  # (1,): distances along legs that may still be computed
    first: np.ndarray  # (n * n + 1,) int: a node's first label, -1 before it is asked for
    size: np.ndarray  # (n * n + 1,) int: of its labels
    soonest: np.ndarray  # (n * n + 1,): when it is queued to be asked for


class Labels(NamedTuple):
    """Nodes in their safe intervals; tentative arrivals (`tent`) have not been verified."""

    node: np.ndarray  # (m,) int
    since: np.ndarray  # (m,): the interval
    until: np.ndarray
    arrival: np.ndarray  # (m,): verified, NEVER before
    via: np.ndarray  # (m,) int: label that the hand comes from, -1 for none
    tent: np.ndarray  # (m,)
    by: np.ndarray  # (m,) int
    tries: np.ndarray  # (m,) int: of `tent`; 0 for a leg past the label that offers it


class Queue(NamedTuple):
    """Binary heap of limited size; entries that do not fit are dropped."""

    key: np.ndarray  # (m,)
    time: np.ndarray  # (m,): arrival that an entry stands for
    label: np.ndarray  # (m,) int: -1 - node if the node is to be asked for first
    size: np.ndarray  # (1,) int


class Aim(NamedTuple):
    """Aim of a search."""

    ways: np.ndarray  # (spans, targets, 4): centre, and how far off the hand meets the target
    step: float  # of time that is a span [s]
    bound: float


class Hunt(NamedTuple):
    """A search under way."""

    aim: Aim
    queue: Queue
    total: np.ndarray  # (1,) int: labels of nodes that were asked for; 0 before it begins

    @property
    def goes_on(self) -> bool:
        """True until nothing is left to be taken up."""
        return bool(self.total[0] == 0 or self.queue.size[0] > 0)


class SearchEnd(NamedTuple):
    """End of a search."""

    time: float  # NEVER if there is none
    label: int
    leave: float  # when the hand leaves the label for the target
    x: float
    y: float
    body: int


@njit(_nrt=False)
def push(queue, key, time, label):
    """Queue an entry."""
    k = queue.size[0]
    if k == queue.key.size:
        return
    queue.size[0] = k + 1
    while k > 0 and queue.key[(k - 1) // 2] > key:
        up = (k - 1) // 2
        queue.key[k], queue.time[k], queue.label[k] = queue.key[up], queue.time[up], queue.label[up]
        k = up
    queue.key[k], queue.time[k], queue.label[k] = key, time, label


@njit(_nrt=False)
def pop(queue):
    """Remove the entry with the smallest key; return the time and label of the entry."""
    time, label = queue.time[0], queue.label[0]
    last = queue.size[0] = queue.size[0] - 1
    key, k = queue.key[last], 0
    while 2 * k + 1 < last:
        down = 2 * k + 1
        if down + 1 < last and queue.key[down + 1] < queue.key[down]:
            down += 1
        if queue.key[down] >= key:
            break
        queue.key[k], queue.label[k] = queue.key[down], queue.label[down]
        queue.time[k] = queue.time[down]
        k = down
    queue.key[k], queue.time[k], queue.label[k] = key, queue.time[last], queue.label[last]
    return time, label
