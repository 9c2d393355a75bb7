"""Steps between the nodes of a lattice in space, all of them: what marching is held against."""

from __future__ import annotations

import itertools
from typing import NamedTuple

import numpy as np

from gcm_learn.arms.spatial_limb import limbs_at
from gcm_learn.charts import ring_leap
from gcm_learn.motion import fastest_hand


class Steps(NamedTuple):
    """Neighbours of all nodes, and how long the hand or the slowest joint takes to them."""

    first: np.ndarray  # (nodes + 1,): the steps from node k are first[k] : first[k + 1]
    to: np.ndarray  # (m,): neighbour
    time: np.ndarray  # (m,): [s]


def steps_of(chart, scene):
    """Steps to the 26 neighbours of a cell with the same posture, and to two postures beside it.

    A step takes as long as the hand, or the joint that has farthest to turn; none is shorter than
    the hand at its fastest takes to the next cell.
    """
    index = np.arange(chart.size).reshape((chart.n,) * 3 + (chart.postures,))
    pairs = np.concatenate([
        without_leaps(chart, across(index), chart.nodes.leap),
        without_leaps(chart, around(index), ring_leap(chart.postures)),
    ])  # fmt: skip
    joints, hands = chart.joints.astype(float), chart.hands
    turn = np.abs(joints[pairs[:, 1]] - joints[pairs[:, 0]]) / scene.limits.joint_speed
    away = np.linalg.norm(hands[pairs[:, 1]] - hands[pairs[:, 0]], axis=1)
    hand = np.maximum(away, chart.spacing) / fastest_hand(scene)
    order = np.argsort(pairs[:, 0], kind="stable")
    first = np.searchsorted(pairs[order, 0], np.arange(chart.size + 1))
    return Steps(first, pairs[order, 1], np.maximum(turn.max(axis=1), hand)[order])


def across(index):
    """Pairs (m, 2) of nodes of the same posture, in cells next to each other."""
    pairs = []
    for d in itertools.product((-1, 0, 1), repeat=3):
        if any(d):
            here = tuple(slice(max(-i, 0), len(index) - max(i, 0)) for i in d)
            there = tuple(slice(max(i, 0), len(index) - max(-i, 0)) for i in d)
            pairs.append(np.stack([index[here].ravel(), index[there].ravel()], axis=-1))
    return np.concatenate(pairs)


def around(index):
    """Pairs (m, 2) of nodes whose postures are next to each other in one cell."""
    postures = index.shape[-1]
    sides = () if postures == 1 else (1,) if postures == 2 else (1, -1)
    pairs = [np.stack([index, np.roll(index, side, axis=-1)], -1) for side in sides]
    return np.concatenate([np.empty((0, 2), np.int64), *(p.reshape(-1, 2) for p in pairs)])


def without_leaps(chart, pairs, leap):
    """Pairs (m, 2) of nodes that are there and between which no joint turns farther than `leap`."""
    pairs = pairs[chart.inside[pairs].all(axis=1)]
    joints = chart.nodes.joints
    return pairs[np.abs(joints[pairs[:, 1]] - joints[pairs[:, 0]]).max(axis=1) <= leap]


def limbs_of(chart):
    """Shoulder, elbow and hand (nodes, 3, 3); without a posture the elbow is the hand."""
    both = np.empty((chart.size, 6))
    limbs_at(chart.limb, chart.joints.astype(float), both)
    out = np.repeat(chart.hands[:, None], 3, axis=1)
    out[:, 0] = 0.0
    out[:, 1] = np.where(chart.inside[:, None], both[:, :3], chart.hands)
    return out
