"""What a cognitive map looks like to an encoder: its fields about the shoulder, on few cells.

Three fields on a polar lattice that begins in the direction of the hand: when the front arrived,
whether it did, and where it was stopped for good (the effective obstacles). A cell that was not
reached has no arrival: its number is 0 and the second field says so, in place of a time that means
"never". The contact follows: direction, share of the ring and time of the catch.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.maps import CognitiveMap, build_map
from gcm_learn.situation import Situation
from gcm_learn.situation.canonical import canonical
from gcm_learn.wave import MarchingParams

CELLS = 40  # along a side of the maps that are made here
DIRECTIONS, RINGS = 32, 10
FIELDS = 3
CONTACT = 5
COUNT = FIELDS * DIRECTIONS * RINGS + CONTACT


def picture_of(situation: Situation, made: CognitiveMap | None = None) -> np.ndarray:
    """Features (COUNT,) float32 of a situation's map.

    Parameters
    ----------
    situation : Situation
        In any frame if no map is given, else the canonical one that the map belongs to.
    made : CognitiveMap, optional
        By default one is marched on CELLS x CELLS cells.
    """
    turned = canonical(situation)[0] if made is None else situation
    chart = build_map(turned, MarchingParams(n=CELLS)) if made is None else made
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
    if chart.contact is not None:
        x, y = chart.contact.position
        r = np.hypot(x, y)
        share = (r - arm.inner_reach) / (arm.reach - arm.inner_reach)
        out[-CONTACT:] = (1.0, x / r, y / r, 2.0 * share - 1.0, chart.contact.time * speed / 3.0)
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
