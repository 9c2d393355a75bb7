"""Clearances of a limb at postures and times."""

from __future__ import annotations

import numpy as np

from gcm_learn.collision.postures import desk_of, gap_at
from gcm_learn.compiled import njit


@njit
def clearances(scene, joints, times):
    """Return clearances (k,) of the limb at postures (k, n) and times (k,) [s].

    They are signed distances to obstacles, or of the limb to itself where that is less.
    """
    desk, found = desk_of(scene), np.empty(times.size)
    for k in range(times.size):
        found[k] = gap_at(scene, joints[k], times[k], desk)
    return found
