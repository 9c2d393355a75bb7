"""Features of situations and of remembered paths.

Validity of a memory depends on its knots and its goal, and on nothing else of the situation that it
comes from. Knots lie at corners and waits, so a single one says little; the path is also sampled at
equal shares of its length. Of a joint movement the straight line from start to end is kept apart
from the rest, since an adaptation moves both ends.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from gcm_learn.compiled import njit
from gcm_learn.recall.joint_moves import EARLIEST, KNOTS as JOINT_KNOTS, TIME
from gcm_learn.recall.waypoints import GOAL

TOUCH = 1.5  # number of a limb that touches; just free of it is 1, free by far is 0
STEPS = 170  # of a cell's number between 0 and 1, where features are stored in bytes


class Features(NamedTuple):
    """Clearance features of one situation."""

    context: np.ndarray
    """(context,) float32: the target's track, then numbers of the arm."""
    cells: np.ndarray
    """(obstacles, cells) float32: 0 is free by far, 1 just free, TOUCH touches. Obstacles that the
    limb can nowhere come near are left out: they change nothing."""


class FeatureBatch(NamedTuple):
    """Clearance features of many situations."""

    context: np.ndarray
    """(n, context) float32"""
    cells: np.ndarray
    """(m, cells) uint8: of all their obstacles [1 / STEPS]."""
    whose: np.ndarray
    """(m,) int64: situation of each obstacle."""


def batched(features: Sequence[Features]) -> FeatureBatch:
    """Join the features of situations, at least one, with cells as bytes."""
    cells = [np.rint(one.cells * STEPS).astype(np.uint8) for one in features]
    whose = np.repeat(np.arange(len(features)), [len(c) for c in cells])
    whole = np.concatenate(cells)
    return FeatureBatch(np.array([one.context for one in features]), whole, whose)


SAMPLES = 16  # equal shares of a hand path's length
PER_KNOT, PER_SAMPLE, WHOLE = 8, 5, 7
HUB = 0.1  # added to shares of the ring for lengths, so that a hand at the shoulder moves
PARTS = 12  # equal shares of a joint movement's length
PER_JOINT_KNOT, ENTIRE = 3, 4
_SMALL = 1e-6  # added to the length of a piece [rad]


def count(knots: int) -> int:
    """Features of a path with so many knots."""
    return PER_KNOT * knots + PER_SAMPLE * SAMPLES + WHOLE


def joint_count(joints: int) -> int:
    """Features of a movement of so many joints."""
    per_part = 2 * joints + 1
    return PARTS * per_part + JOINT_KNOTS * PER_JOINT_KNOT + 3 * joints + ENTIRE + GOAL


def hand_path_features(knots: np.ndarray, goals: np.ndarray) -> np.ndarray:
    """Features (n, count(k)) float32 of remembered paths.

    Parameters
    ----------
    knots : (n, k, 4) ndarray
        Rows (direction of the hand [rad], share of the ring, time [s], earliest [s] or 0).
    goals : (n, 2) ndarray
        Direction and share of the target's centre.
    """
    out = np.zeros((len(knots), count(knots.shape[1])), dtype=np.float32)
    _fill(knots.astype(np.float64), goals.astype(np.float64), out)
    return out


@njit
def _fill(knots, goals, out):
    """Fill in the features of all paths."""
    n, size = knots.shape[0], knots.shape[1]
    cum = np.zeros(size)
    for m in range(n):
        at, latest = 0, 0.0
        for k in range(size):
            a, ring, t, earliest = (
                knots[m, k, 0], knots[m, k, 1], knots[m, k, 2], knots[m, k, 3],
            )  # fmt: skip
            latest = max(latest, earliest)
            at = _place(a, ring, t, m, at, out)
            out[m, at] = 1.0 if earliest > 0.0 else 0.0
            out[m, at + 1], out[m, at + 2] = earliest, latest
            at += 3
            if k > 0:
                turn, width = a - knots[m, k - 1, 0], ring - knots[m, k - 1, 1]
                mean = 2.0 * (0.5 * (ring + knots[m, k - 1, 1]) + HUB)
                cum[k] = cum[k - 1] + np.sqrt((2.0 * width) ** 2 + (mean * turn) ** 2)
        whole = cum[size - 1]
        k = 0
        for j in range(SAMPLES):
            want = whole * (j + 0.5) / SAMPLES
            while k < size - 2 and cum[k + 1] < want:
                k += 1
            span = cum[k + 1] - cum[k]
            s = min(max((want - cum[k]) / span, 0.0), 1.0) if span > 1e-12 else 1.0
            a = knots[m, k, 0] + s * (knots[m, k + 1, 0] - knots[m, k, 0])
            ring = knots[m, k, 1] + s * (knots[m, k + 1, 1] - knots[m, k, 1])
            t = knots[m, k, 2] + s * (knots[m, k + 1, 2] - knots[m, k, 2])
            at = _place(a, ring, t, m, at, out)
        at = _place(goals[m, 0], goals[m, 1], knots[m, size - 1, 2], m, at, out)
        out[m, at], out[m, at + 1] = 0.5 * whole, latest


@njit
def _place(a, ring, t, m, at, out):
    """Fill in place and time of the hand from column `at` on; return the next free column."""
    out[m, at], out[m, at + 1] = np.cos(a), np.sin(a)
    out[m, at + 2] = a / np.pi
    out[m, at + 3] = 2.0 * ring - 1.0
    out[m, at + 4] = 2.0 * t - 1.0
    return at + 5


def joint_path_features(knots: np.ndarray, goals: np.ndarray) -> np.ndarray:
    """Features (n, joint_count(m)) float32 of remembered movements of m joints.

    Parameters
    ----------
    knots, goals : (n, JOINT_KNOTS, m + 2), (n, GOAL) ndarray
        As of `Waypoints`.
    """
    n = len(knots)
    if n == 0:
        return np.zeros((0, joint_count(knots.shape[2] - 2)), np.float32)
    joints, time = knots[:, :, :TIME].astype(float), knots[:, :, TIME].astype(float)
    pieces = np.abs(np.diff(joints, axis=1)).max(axis=2) + _SMALL
    share = np.concatenate([np.zeros((n, 1)), np.cumsum(pieces, axis=1)], axis=1)
    length = share[:, -1]
    share /= length[:, None]
    at = np.arange(1, PARTS + 1) / PARTS
    rows = np.arange(n)[:, None]
    k = np.clip((share[:, :, None] < at).sum(axis=1) - 1, 0, JOINT_KNOTS - 2)
    s = (at - share[rows, k]) / (share[rows, k + 1] - share[rows, k])
    there = joints[rows, k] + s[..., None] * (joints[rows, k + 1] - joints[rows, k])
    when = time[rows, k] + s * (time[rows, k + 1] - time[rows, k])
    first, last = joints[:, 0], joints[:, -1]
    line = first[:, None] + at[:, None] * (last - first)[:, None]
    waits = knots[:, :, EARLIEST]
    parts = [
        np.concatenate([there, there - line, when[..., None]], axis=2).reshape(n, -1),
        np.stack([time, waits, waits > 0.0], axis=2).reshape(n, -1),
        first,
        last,
        last - first,
        np.stack([length, time[:, -1], waits.max(axis=1), pieces.max(axis=1)], axis=1),
        goals,
    ]
    return np.concatenate(parts, axis=1).astype(np.float32)


ALONE = 0.4  # share of a batch: situations of it again, with one of their obstacles alone


class Sizes(NamedTuple):
    """Sizes of a batch of labels."""

    situations: int = 512
    any: int = 160
    """Memories of a batch about any memories."""
    top: int = 40
    """First memories of a batch about the best."""
    wide: int = 16
    """Memories drawn from the best that follow."""

    @property
    def alone(self) -> int:
        """Number of situations with a single obstacle."""
        return int(ALONE * self.situations)

    @property
    def others(self) -> int:
        """Number of situations with all of their obstacles."""
        return self.situations - self.alone

    def hard(self, found: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """Choose the first of the best memories (n, k) and some that follow (n, top + wide)."""
        top = min(self.top, found.shape[1])
        rest = found.shape[1] - top
        wide = min(self.wide, rest)
        after = top + np.argsort(rng.random((len(found), rest)), axis=1)[:, :wide]
        rows = np.hstack([found[:, :top], np.take_along_axis(found, after, axis=1)])
        return np.ascontiguousarray(rows, dtype=np.int64)
