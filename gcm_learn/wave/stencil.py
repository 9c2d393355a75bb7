"""The stencil of Eq. 10: Euler steps over runs of cells, at the speed of the machine's vectors.

All fields of a lattice live in one float32 buffer as planes at constant offsets.  So the compiler
knows them to be disjoint and vectorises without run-time checks.  A few widths have a stencil each,
so that the offsets are constants.

The cell (iy, ix) is entry ``(iy + 1) * W + ix + LEFT`` of a plane; the rest is padding and stays 0.
The planes: potential (two time levels), recovery, q * step, live neighbours, arrival.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from gcm_learn.compiled import njit

BLOCK = 16  # cells of a row that are switched on and off together: one wide vector register
LEFT = 8
PLANES = 6


class StencilLayout(NamedTuple):
    """Layout of the buffer of a lattice of n x n cells."""

    n: int
    width: int  # W, row to row
    plane: int  # plane to plane
    blocks: int  # blocks in a row

    @property
    def length(self) -> int:
        """Floats in the whole buffer."""
        return PLANES * self.plane + BLOCK


WIDTHS = (96, 176, 336)  # rows of lattices up to 80, 160 and 320 cells: one set of kernels each


def layout(n: int) -> StencilLayout:
    """Lay out the planes of an n x n lattice, n at most LARGEST_LATTICE."""
    width = next(w for w in WIDTHS if n + BLOCK <= w)
    return StencilLayout(n, width, _plane(width), -(-n // BLOCK))


def room(n: int) -> np.ndarray:
    """Make the buffer of an n x n lattice, with blocks that begin on cache lines.

    Blocks that straddle two cache lines are a tenth slower.
    """
    length = layout(n).length
    spare = np.empty(length + BLOCK, dtype=np.float32)
    first = -(spare.ctypes.data // spare.itemsize + LEFT) % BLOCK
    return spare[first : first + length]


def _plane(width: int) -> int:
    """Floats from plane to plane."""
    # An odd number of cache lines between planes keeps them out of each other's cache sets.
    return (width - BLOCK + 2) * width + BLOCK


def _stencil(width: int, points: int) -> Callable:
    """Make the kernel that advances runs of cells by two Euler steps of Eq. 10."""
    W, ONE, plane = np.uint64(width), np.uint64(1), _plane(width)
    A, Z, Q, L = (np.uint64(k * plane) for k in (1, 2, 3, 4))
    nine = points == 9
    f4 = np.float32
    seventh, two, four, seven, sixth = f4(1 / 7), f4(2), f4(4), f4(7), f4(1 / 6)

    @njit
    def two_steps(B, lo, hi, runs, d, eps):
        """Advance B[lo:hi] of every run twice: plane 0 -> plane 1 -> plane 0.

        d is the diffusion constant, eps the recovery rate times the step (float32).
        """
        for run in range(runs):
            for k in range(lo[run], hi[run]):
                r, z = B[k], B[k + Z]
                f = (((four - r) * r - two) * r - two) * seventh
                near = B[k - W] + B[k + W] + B[k - ONE] + B[k + ONE]
                if nine:
                    far = B[k - W - ONE] + B[k - W + ONE] + B[k + W - ONE] + B[k + W + ONE]
                    near = (four * near + far) * sixth
                B[k + A] = r + B[k + Q] * (f - z + d * (near - B[k + L] * r))
                B[k + Z] = z + eps * (r - seven * z - two)
        for run in range(runs):
            for k in range(lo[run] + A, hi[run] + A):
                r, z = B[k], B[k + (Z - A)]
                f = (((four - r) * r - two) * r - two) * seventh
                near = B[k - W] + B[k + W] + B[k - ONE] + B[k + ONE]
                if nine:
                    far = B[k - W - ONE] + B[k - W + ONE] + B[k + W - ONE] + B[k + W + ONE]
                    near = (four * near + far) * sixth
                B[k - A] = r + B[k + (Q - A)] * (f - z + d * (near - B[k + (L - A)] * r))
                B[k + (Z - A)] = z + eps * (r - seven * z - two)

    return two_steps


_five_96, _nine_96 = _stencil(96, 5), _stencil(96, 9)
_five_176, _nine_176 = _stencil(176, 5), _stencil(176, 9)
_five_336, _nine_336 = _stencil(336, 5), _stencil(336, 9)


@njit
def two_steps(B, lo, hi, runs, d, eps, width, points):
    """Advance runs of cells by two Euler steps on a lattice of one of the WIDTHS."""
    if width == 96:
        if points == 5:
            _five_96(B, lo, hi, runs, d, eps)
        else:
            _nine_96(B, lo, hi, runs, d, eps)
    elif width == 176:
        if points == 5:
            _five_176(B, lo, hi, runs, d, eps)
        else:
            _nine_176(B, lo, hi, runs, d, eps)
    elif points == 5:
        _five_336(B, lo, hi, runs, d, eps)
    else:
        _nine_336(B, lo, hi, runs, d, eps)
