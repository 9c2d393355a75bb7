"""Bumps that push a path aside: their shape, and in which order they are tried."""

from __future__ import annotations

import numpy as np

from gcm_learn.compiled import njit

WIDTHS = (1.0, 0.3)  # of bumps [shares of the path]
SIDES = 2  # of an obstacle
PUSHED = SIDES * len(WIDTHS)  # changes that are pushes, the first of a round


@njit
def bump(share, top, wide):
    """Return the height of a bump at a share of the path.

    It is 1 at its top, and 0 at a distance of `wide` and at both ends. An end that is its top is 1.
    """
    s = 1.0
    if share != top:
        s = 1.0 - abs(share - top) / min(wide, top if share < top else 1.0 - top)
    return np.sin(0.5 * np.pi * min(max(s, 0.0), 1.0)) ** 2
