"""Features of situations."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

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
    """Join the features of many situations, at least one, in bytes."""
    cells = [np.rint(one.cells * STEPS).astype(np.uint8) for one in features]
    whose = np.repeat(np.arange(len(features)), [len(c) for c in cells])
    whole = np.concatenate(cells)
    return FeatureBatch(np.array([one.context for one in features]), whole, whose)
