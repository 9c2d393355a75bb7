"""Features of situations and of their maps."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from gcm_learn.maps import build_map
from gcm_learn.situation import Situation, canonical
from gcm_learn.wave import MarchingParams

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


CELLS = 40  # along a side of the maps that are made here
DIRECTIONS, RINGS = 32, 10
FIELDS = 3
CONTACT = 5
COUNT = FIELDS * DIRECTIONS * RINGS + CONTACT


def map_features(situation: Situation) -> np.ndarray:
    """Features (COUNT,) float32 of the map of a situation in any frame."""
    turned, _ = canonical(situation)
    chart = build_map(turned, MarchingParams(n=CELLS))
    arm = turned.arm
    out = np.zeros(COUNT, dtype=np.float32)
    rows, columns = _cells(chart.lattice.centres, arm.inner_reach, arm.reach)
    arrival = chart.arrival[rows, columns]
    there = ~np.ma.getmaskarray(arrival)
    speed = arm.max_hand_speed
    fields = out[: FIELDS * DIRECTIONS * RINGS].reshape(FIELDS, RINGS, DIRECTIONS)
    fields[0] = np.where(there, arrival.filled(0.0) * speed / 3.0, 0.0)
    fields[1] = there
    fields[2] = chart.effective_obstacles[rows, columns]
    if chart.interception is not None:
        (x, y), when = chart.interception.position, chart.interception.time
        r = np.hypot(x, y)
        share = (r - arm.inner_reach) / (arm.reach - arm.inner_reach)
        out[-CONTACT:] = (1.0, x / r, y / r, 2.0 * share - 1.0, when * speed / 3.0)
    return out


def _cells(centres: np.ndarray, near: float, far: float) -> tuple[np.ndarray, np.ndarray]:
    """Rows and columns (RINGS, DIRECTIONS) of the lattice's cells that the polar ones lie in."""
    r = near + (np.arange(RINGS)[:, None] + 0.5) / RINGS * (far - near)
    a = 2.0 * np.pi * np.arange(DIRECTIONS)[None] / DIRECTIONS
    step = centres[1] - centres[0]
    last = len(centres) - 1
    rows = np.clip(np.rint((r * np.sin(a) - centres[0]) / step), 0, last).astype(int)
    columns = np.clip(np.rint((r * np.cos(a) - centres[0]) / step), 0, last).astype(int)
    return rows, columns


def map_picture(situation: Situation) -> np.ndarray:
    """Map of a situation in its canonical frame, as numbers (2 CELLS CELLS,) float32.

    Arrival as a share of the horizon, or 1 without arrival, and the effective obstacles.
    """
    turned, _ = canonical(situation)
    made = build_map(turned, MarchingParams(n=CELLS))
    arrival = np.minimum(made.arrival.filled(np.inf) / situation.horizon, 1.0)
    return np.concatenate([arrival.ravel(), made.effective_obstacles.ravel()]).astype(np.float32)
