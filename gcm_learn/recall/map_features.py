"""Features of the cognitive map of a memory's situation.

Of a map, three fields are given on a polar lattice that begins in the direction of the hand. They
are the front's arrival, a mark of arrival, and the effective obstacles. A cell without an arrival
has a 0 in the first two fields. The interception follows: direction, share of the ring and time.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.maps import build_map
from gcm_learn.situation import Situation, canonical
from gcm_learn.wave import MarchingParams

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
