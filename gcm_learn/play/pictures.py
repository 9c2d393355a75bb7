"""Pictures of hand-space for the page: one byte or one bit a cell, in base64."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np

from gcm_learn.charts import Lattice, occupied_cells
from gcm_learn.maps import CognitiveMap
from gcm_learn.situation import Situation

SIZE = 120  # cells a side of extended obstacles
LEVELS = 250  # of arrival times, from 0 to the last one
OBSTACLE, TARGET, NEVER = 253, 254, 255  # instead of an arrival


def map_picture(cognitive_map: CognitiveMap) -> dict[str, Any]:
    """Return a map as a picture.

    Returns
    -------
    dict
        `size` (cells a side), `last` (the time of level `LEVELS` [s]) and `cells`: a byte for each
        cell, row by row from below. A byte is a level of arrival, or one of the marks above it.
    """
    arrival = cognitive_map.arrival.filled(np.inf)
    reached = np.isfinite(arrival)
    last = float(arrival[reached].max(initial=0.0)) or 1.0
    cells = np.full(arrival.shape, NEVER, dtype=np.uint8)
    cells[reached] = np.rint(LEVELS / last * arrival[reached])
    cells[cognitive_map.effective_obstacles & ~reached] = OBSTACLE
    cells[cognitive_map.effective_target & ~reached] = TARGET
    return {"size": len(cells), "last": last, "cells": _text(cells)}


def extended_pictures(situation: Situation, instants: list[float]) -> list[dict[str, Any]]:
    """Return the hand positions that obstacles forbid, one picture for each instant.

    Returns
    -------
    list of dict
        `time` [s], `size` and `cells`: a bit for each cell, row by row from below, the first cell
        in the highest bit.
    """
    lattice = Lattice(SIZE, situation.arm.upper_arm, situation.arm.elbow)
    return [
        {
            "time": t,
            "size": SIZE,
            "cells": _text(np.packbits(occupied_cells(situation, lattice, t))),
        }
        for t in instants
    ]


def _text(cells: np.ndarray) -> str:
    return base64.b64encode(cells.tobytes()).decode("ascii")
