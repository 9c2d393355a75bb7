"""Features of the maps of situations, for encoders that embed memories by maps."""

from __future__ import annotations

import numpy as np

from gcm_learn.arms import SpatialArm
from gcm_learn.charts import PostureLattice
from gcm_learn.maps import CognitiveMap, build_map
from gcm_learn.situation import Situation, canonical
from gcm_learn.wave import MarchingParams

CELLS = 40  # along a side of the maps of the plane
DIRECTIONS, RINGS = 32, 10
COARSE, POSTURES, SIDE = 24, 4, 12  # cells along a side in space, postures, blocks along a side
FIELDS = 3
WAY = 3.0  # of the hand, for which a planar arrival is 1 [forearm lengths]


def planar_map_features(situation: Situation) -> np.ndarray:
    """Return features (965,) float32 of the map of a planar situation in any frame.

    Fields on a polar lattice: arrival, cells with an arrival, effective obstacles. Then the
    contact: found, its direction, its distance, its time.
    """
    turned, _ = canonical(situation)
    chart = build_map(turned, MarchingParams(n=CELLS))
    arm = turned.arm
    rows, columns = _cells(chart.lattice.centres, arm.inner_reach, arm.reach)
    speed = arm.max_hand_speed / WAY
    fields = _fields(chart)[:, rows, columns]
    fields[0] *= speed
    contact = np.zeros(5)
    if chart.interception is not None:
        (x, y), when = chart.interception.position, chart.interception.time
        r = np.hypot(x, y)
        share = (r - arm.inner_reach) / (arm.reach - arm.inner_reach)
        contact[:] = 1.0, x / r, y / r, 2.0 * share - 1.0, when * speed
    return np.concatenate([fields.ravel(), contact]).astype(np.float32)


def spatial_map_features(situation: Situation[SpatialArm]) -> np.ndarray:
    """Return features (5189,) float32 of a coarse map of a spatial arm's situation in any frame.

    The same fields on blocks of two cells a side of hand-space, means over their cells: the first
    arrival in any posture [horizons], cells with an arrival, effective obstacles in any posture.
    Then the contact: found, its place, its time. The front has no margin: a key promises nothing.
    """
    turned, _ = canonical(situation)
    params = MarchingParams(n=COARSE, margin=0.0)
    made = build_map(turned, params, chart=PostureLattice(turned.arm, COARSE, POSTURES))
    arrival, there, walls = _fields(made)
    first = np.where(there > 0.0, arrival, np.inf).min(axis=-1) / turned.horizon
    cells = np.stack([first, there.max(axis=-1), walls.max(axis=-1)])
    cells[0, cells[1] == 0.0] = 0.0
    block = COARSE // SIDE
    blocks = cells.reshape(FIELDS, SIDE, block, SIDE, block, SIDE, block).mean(axis=(2, 4, 6))
    contact = np.zeros(5)
    if made.interception is not None:
        place = np.array(made.interception.position) / turned.arm.reach
        contact[:] = 1.0, *place, made.interception.time / turned.horizon
    return np.concatenate([blocks.ravel(), contact]).astype(np.float32)


def _fields(made: CognitiveMap) -> np.ndarray:
    """Return arrival, nodes with an arrival, and effective obstacles (FIELDS, ...) of a map."""
    there = ~np.ma.getmaskarray(made.arrival)
    return np.stack([made.arrival.filled(0.0), there, made.effective_obstacles], dtype=float)


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
