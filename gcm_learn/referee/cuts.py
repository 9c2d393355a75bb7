"""Distances within the plane of an arm, to the cut of a solid with that plane."""

from __future__ import annotations

import numpy as np

from gcm_learn.referee.bodies import Body
from gcm_learn.referee.rotations import Array
from gcm_learn.referee.shapes import golden_minimum

CHORDS = 33
ROUNDS = 14
"""In each of them chords are taken 16 times as closely around the best."""


def deepest(
    body: Body, time: float, origin: Array, axes: Array, hand: Array, grasp: float
) -> float:
    """Return the least signed distance to a solid within `grasp` of the hand (2,), in the plane.

    It is at most 0 exactly if the cut comes within `grasp`.  Distances to convex solids are convex,
    and so is the minimum over a chord of the disc as a function of the chord.
    """
    low, high, best = -grasp, grasp, np.inf
    for _ in range(ROUNDS):
        x = np.linspace(low, high, CHORDS)
        half = np.sqrt(np.maximum(grasp**2 - x**2, 0.0))

        def depth(share: Array, x: Array = x, half: Array = half) -> Array:
            points = hand + np.stack([x, (2.0 * share - 1.0) * half], axis=1)
            return body.gaps(time, origin + points @ axes)

        least = golden_minimum(depth, CHORDS)
        k = int(least.argmin())
        best = min(best, float(least[k]))
        if best <= 0.0 or high - low < 1e-12:
            break
        low, high = x[max(k - 1, 0)], x[min(k + 1, CHORDS - 1)]
    return best
