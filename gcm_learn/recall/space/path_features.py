"""What an encoder is told of a memory of a spatial arm: its movement, in the joints of a left arm.

The straight way from start to end is told apart from what the movement adds to it, since an
adaptation moves both ends.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.recall.space.kernels import EARLIEST, KNOTS, TIME
from gcm_learn.recall.space.waypoints import GOAL

SAMPLES = 12  # equal shares of the movement's length
PER_SAMPLE, PER_KNOT = 9, 3
COUNT = SAMPLES * PER_SAMPLE + KNOTS * PER_KNOT + 16 + GOAL
_SMALL = 1e-6  # added to the length of a piece [rad]


def path_features_in_space(knots: np.ndarray, goals: np.ndarray) -> np.ndarray:
    """Features (n, COUNT) float32 of remembered movements.

    Parameters
    ----------
    knots, goals : (n, KNOTS, COLUMNS), (n, GOAL) ndarray
        As of `SpatialWaypoints`.
    """
    n = len(knots)
    if n == 0:
        return np.zeros((0, COUNT), np.float32)
    joints, time = knots[:, :, :4].astype(float), knots[:, :, TIME].astype(float)
    pieces = np.abs(np.diff(joints, axis=1)).max(axis=2) + _SMALL
    share = np.concatenate([np.zeros((n, 1)), np.cumsum(pieces, axis=1)], axis=1)
    length = share[:, -1]
    share /= length[:, None]
    at = np.arange(1, SAMPLES + 1) / SAMPLES
    rows = np.arange(n)[:, None]
    k = np.clip((share[:, :, None] < at).sum(axis=1) - 1, 0, KNOTS - 2)
    s = (at - share[rows, k]) / (share[rows, k + 1] - share[rows, k])
    there = joints[rows, k] + s[..., None] * (joints[rows, k + 1] - joints[rows, k])
    when = time[rows, k] + s * (time[rows, k + 1] - time[rows, k])
    first, last = joints[:, 0], joints[:, -1]
    line = first[:, None] + at[:, None] * (last - first)[:, None]
    waits = knots[:, :, EARLIEST]
    parts = [
        np.concatenate([there, there - line, when[..., None]], axis=2).reshape(n, -1),
        np.stack([time, waits, waits > 0.0], axis=2).reshape(n, -1),
        first,
        last,
        last - first,
        np.stack([length, time[:, -1], waits.max(axis=1), pieces.max(axis=1)], axis=1),
        goals,
    ]
    return np.concatenate(parts, axis=1).astype(np.float32)
