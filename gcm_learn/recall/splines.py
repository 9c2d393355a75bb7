"""Random movements in place of memories: what does verification catch on its own?

A spline's hand starts where the query's does. Its direction and its share of the ring follow
quadratic Bezier curves from there, whose middle control point and end are drawn: directions evenly
within HALF_TURN of the first, shares within RIMS, the time of the end within TIMES; one in WAITERS
waits half way until half of that time. Ends are then bent to the target like those of memories, so
what is random is the way there.
"""

from __future__ import annotations

import numpy as np

from gcm_learn import seeding
from gcm_learn.recall.kernels import ANGLE, EARLIEST, KNOTS, RING, TIME

HALF_TURN = 1.8  # largest change of the hand's direction [rad]
RIMS = (0.15, 0.98)  # shares of the ring
TIMES = (0.2, 1.0)  # of the end [horizons]
WAITERS = 4  # one in so many waits on its way


def random_traces(
    seed: int, index: int, count: int, start: float, horizon: float
) -> tuple[np.ndarray, np.ndarray]:
    """Random movements in the form of traces.

    Parameters
    ----------
    seed, index : int
        Decide all that is random.
    count : int
    start : float
        Share of the ring where the hand is at t = 0.
    horizon : float
        [s]

    Returns
    -------
    traces, goals : (count, KNOTS, 4), (count, 2) ndarray of float32
    """
    rng = seeding.rng(seed, index)
    s = np.linspace(0.0, 1.0, KNOTS)[None]
    angles = rng.uniform(-HALF_TURN, HALF_TURN, (2, count, 1))
    rings = rng.uniform(*RIMS, (2, count, 1))
    ends = horizon * rng.uniform(*TIMES, (count, 1))
    waits = rng.integers(WAITERS, size=(count, 1)) == 0
    traces = np.zeros((count, KNOTS, 4), np.float32)
    traces[:, :, ANGLE] = 2.0 * s * (1.0 - s) * angles[0] + s * s * angles[1]
    way = (1.0 - s) ** 2 * start + 2.0 * s * (1.0 - s) * rings[0] + s * s * rings[1]
    traces[:, :, RING] = way
    traces[:, :, TIME] = s * ends
    half = KNOTS // 2
    traces[:, half, EARLIEST] = np.where(waits, 0.5 * ends, 0.0)[:, 0]
    goals = traces[:, -1, [ANGLE, RING]]
    return traces, np.ascontiguousarray(goals)
