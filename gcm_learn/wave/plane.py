"""Planar lattice for marching: padded by one cell all round, lengths in cells.

Times are in crossings: the time that the front needs for one cell.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.compiled import njit

# A cell of the padded lattice; CLOSED: frozen or nearer than the arm can reach, BEYOND: farther.
UNKNOWN, ACCEPTED, CLOSED, BEYOND = 0, 1, 2, 3
PER_CELL = 1.5  # buckets per crossing: neighbours along a ray are 0.7 crossings apart or more
BUCKETS = 256  # circular, a power of two; one step never spans more
SLOWEST = 165.0  # crossings that a step may take when joints limit the speed: see BUCKETS
ROOT2 = float(np.sqrt(2.0))
STEP_I = np.array([-1, -1, -1, 0, 0, 1, 1, 1])
STEP_J = np.array([-1, 0, 1, -1, 1, -1, 0, 1])


class PlaneLattice(NamedTuple):
    """A planar lattice and the hand in it."""

    n: int
    hand_i: float  # hand in coordinates of the padded lattice; cell (iy, ix) is at (iy, ix) + 1
    hand_j: float
    outside: np.ndarray  # ((n + 2)^2,) uint8: UNKNOWN where the hand can be, BEYOND farther out
    turns: np.ndarray  # (n * n + 1, 2): joint angles in every cell, then the hand's, as times at
    #                    the joints' full speeds; (0, 2) if the joints are not limited
    circle: float  # the shoulder's full turn in the same unit


@njit(_nrt=False, forceinline=True)
def row_of(k, W):
    """K // W by a multiplication: a division by a variable costs more than the rest of a cell."""
    return int((k + 0.5) * (1.0 / W))


@njit(_nrt=False, forceinline=True)
def bare(k, n):
    """Index without padding of cell k of the padded lattice."""
    return k - 2 * row_of(k, n + 2) - n - 1


@njit(_nrt=False, forceinline=True)
def step_time(plane, m, a, b, share, length):
    """Time of a straight step of `length` cells to cell m.

    It starts between the cells a and b (both without padding), a `share` of the way to b.  That
    takes as long as the hand, or the joint that has farthest to turn.
    """
    turns, circle = plane.turns, plane.circle
    shoulder = turns[m, 0] - turns[a, 0]
    shoulder = abs(shoulder - circle * np.round(shoulder / circle))
    elbow = abs(turns[m, 1] - turns[a, 1])
    if share > 0.0:
        other = turns[m, 0] - turns[b, 0]
        other = abs(other - circle * np.round(other / circle))
        shoulder += share * (other - shoulder)
        elbow += share * (abs(turns[m, 1] - turns[b, 1]) - elbow)
    return min(max(length, shoulder, elbow), SLOWEST)


@njit
def closed_rim(n, spacing, reach, inside):
    """Status ((n + 2)^2,) of a padded lattice before marching: UNKNOWN where the hand can be.

    The disc of the reach is convex: a ray between two of its cells never leaves it. So what is
    farther out is BEYOND, and CLOSED only what is not `inside` (n * n,) the ring elsewhere.
    """
    status = np.full((n + 2) * (n + 2), CLOSED, dtype=np.uint8)
    for i in range(n + 2):
        for j in range(n + 2):
            x, y = (j - 0.5) * spacing - reach, (i - 0.5) * spacing - reach
            if x * x + y * y > reach * reach:
                status[i * (n + 2) + j] = BEYOND
            elif 0 < i <= n and 0 < j <= n and inside[(i - 1) * n + j - 1]:
                status[i * (n + 2) + j] = UNKNOWN
    return status
