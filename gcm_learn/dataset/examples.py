"""A map as training reads it: whole numbers as stored, and the picture made of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from gcm_learn.dataset.schema import UNREACHED

CHANNELS = ("reached", "arrival", "obstacle")


@dataclass(frozen=True, slots=True)
class Example:
    """The map of a record, without what it takes to plan on it."""

    index: int
    """Of the record's item."""
    arrival: np.ndarray
    """(n, n) uint16: steps of `quantum` seconds, 65535 where there is no arrival."""
    obstacles: np.ndarray
    """(n * n / 8,) uint8: bits of the effective obstacles, row by row."""
    quantum: float
    """[s]"""
    horizon: float
    """[s]"""
    labels: Mapping[str, Any]
    """The columns that were asked for."""

    def image(self) -> np.ndarray:
        """The map as a picture (3, n, n) float32 of CHANNELS; arrivals are shares of the horizon.

        Arrivals are 0 where there is none, so that every number is within [0, 1].
        """
        n = self.arrival.shape[0]
        out = np.empty((len(CHANNELS), n, n), dtype=np.float32)
        np.less(self.arrival, UNREACHED, out=out[0])
        np.multiply(self.arrival, np.float32(self.quantum / self.horizon), out=out[1])
        out[1] *= out[0]
        out[2] = np.unpackbits(self.obstacles, count=n * n).reshape(n, n)
        return out
