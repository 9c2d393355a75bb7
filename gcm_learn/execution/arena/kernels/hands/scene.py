"""Planar situations of a world, and buffers for kernels."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.arms import PlanarLimb
from gcm_learn.compiled import njit
from gcm_learn.execution.arena.kernels.hands.nearness import MOMENT_COLUMNS
from gcm_learn.execution.arena.kernels.world import bodies_in
from gcm_learn.scene import Limits, Scene

# Columns of a world's limbs and limits.
FAR, HORIZON = PlanarLimb._fields.index("far"), Limits._fields.index("horizon")
START = slice(PlanarLimb._fields.index("x"), None)  # the hand at t = 0

MOMENTS = 6  # most moments that are compared at once


class Workspace(NamedTuple):
    """Buffers that are shared by arms stepped one after the other."""

    time: np.ndarray  # (2,): of the hand's step [s]
    hand: np.ndarray  # (2, 2): its two ends
    poses: np.ndarray  # (n, 12): n is the most bodies that a situation has
    moments: np.ndarray  # (MOMENTS, MOMENT_COLUMNS): see `nearness`
    gaps: np.ndarray  # (n, 3): see `observation`


@njit
def workspace_for(world, state, first, last):
    """Return buffers for arms first to last - 1."""
    most = 1
    for e in range(first, last):
        s = state.place[e]
        most = max(most, world.first[s + 1] - world.first[s])
    moments, gaps = np.empty((MOMENTS, MOMENT_COLUMNS)), np.empty((most, 3))
    return Workspace(np.empty(2), np.empty((2, 2)), np.zeros((most, 12)), moments, gaps)


@njit
def scene_of(world, s):
    """Return situation s in the form of all kernels."""
    a, b = world.limbs, world.limits
    limb = PlanarLimb(a[s, 0], a[s, 1], a[s, 2], a[s, 3], a[s, 4], a[s, 5], a[s, 6])
    limits = Limits(b[s, 0], b[s, 1], b[s, 2], b[s, 3], b[s, 4])
    return Scene(bodies_in(world, s), limb, limits)
