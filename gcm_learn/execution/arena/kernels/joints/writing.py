"""Numbers of an observation, cut at `EXTREME`."""

from __future__ import annotations

from gcm_learn.compiled import njit
from gcm_learn.execution.arena.kernels.world import EXTREME


@njit(_nrt=False, forceinline=True)
def put(row, k, value):
    """Write a number."""
    row[k] = min(max(value, -EXTREME), EXTREME)


@njit(_nrt=False, forceinline=True)
def put_vector(row, k, x, y, z, unit):
    """Write the vector (x, y, z) in a unit."""
    put(row, k, x / unit)
    put(row, k + 1, y / unit)
    put(row, k + 2, z / unit)
