"""The 7-point stencil of Eq. 10 in space, over blocks of cells that are awake.

It is laid out as in the plane (`wave.stencil`): all fields of a lattice in one float32 buffer, at
constant offsets.  The cell (iz, iy, ix) is entry ``(iz + 1) * SLAB + (iy + 1) * WIDTH + ix + LEFT``
of a field.  The rest is padding and stays 0.  The fields: potential (two time levels), recovery,
q * step, live neighbours, arrival.

In cells with q below 1 the recovery is slowed with the potential, so that a front is slower in
proportion.  Slowing the potential alone (Eq. 10 to the letter) would cost it another third at
q = 0.1, and stop it at q = 0.02.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.compiled import njit
from gcm_learn.wave.stencil import BLOCK, LEFT, PLANES, aligned

LARGEST = 80  # cells along a side: the offsets are constants
ROWS = LARGEST + 2
WIDTH = LARGEST + BLOCK
SLAB = ROWS * WIDTH
FIELD = ROWS * SLAB + BLOCK  # an odd number of cache lines, see `wave.stencil`


def cell_clearances() -> np.ndarray:
    """Make a buffer for any lattice in space."""
    return aligned(PLANES * FIELD + BLOCK)


def field(buffer: np.ndarray, k: int, n: int) -> np.ndarray:
    """The cells (n, n, n) of a field, as a view."""
    whole = buffer[k * FIELD : k * FIELD + ROWS * SLAB].reshape(ROWS, ROWS, WIDTH)
    return whole[1 : n + 1, 1 : n + 1, LEFT : LEFT + n]


_W, _S, _ONE, _SIZE = np.uint64(WIDTH), np.uint64(SLAB), np.uint64(1), np.uint64(BLOCK)
_A, _Z, _Q, _L = (np.uint64(k * FIELD) for k in (1, 2, 3, 4))
_SEVENTH, _TWO, _FOUR, _SEVEN = (np.float32(x) for x in (1.0 / 7.0, 2.0, 4.0, 7.0))


@njit(_nrt=False)
def _there(B, start, first, last, d, eps):
    """Step some blocks from the first time level to the second; the recovery stays in its place.

    A block is as long as the compiler may know: its loop has no remainder.
    """
    for i in range(first, last):
        for k in range(start[i], start[i] + _SIZE):
            r, z, q = B[k], B[k + _Z], B[k + _Q]
            f = (((_FOUR - r) * r - _TWO) * r - _TWO) * _SEVENTH
            near = B[k - _S] + B[k - _W] + B[k - _ONE] + B[k + _ONE] + B[k + _W] + B[k + _S]
            B[k + _A] = r + q * (f - z + d * (near - B[k + _L] * r))
            B[k + _Z] = z + q * eps * (r - _SEVEN * z - _TWO)


@njit(_nrt=False)
def _back(B, start, first, last, d, eps):
    """Step some blocks from the second time level to the first."""
    for i in range(first, last):
        for k in range(start[i] + _A, start[i] + (_A + _SIZE)):
            r, z, q = B[k], B[k + (_Z - _A)], B[k + (_Q - _A)]
            f = (((_FOUR - r) * r - _TWO) * r - _TWO) * _SEVENTH
            near = B[k - _S] + B[k - _W] + B[k - _ONE] + B[k + _ONE] + B[k + _W] + B[k + _S]
            B[k - _A] = r + q * (f - z + d * (near - B[k + (_L - _A)] * r))
            B[k + (_Z - _A)] = z + q * eps * (r - _SEVEN * z - _TWO)


@njit(_nrt=False)
def steps(B, start, slabs, pairs, d, eps):
    """Advance blocks by pairs of Euler steps, from the first time level and back to it.

    Every step follows the one before a slab behind, so that what it reads is still at hand.

    Parameters
    ----------
    start : (m,) ndarray of uint64
        First entries of the blocks, in order.
    slabs : (n + 1,) ndarray
        ``start[slabs[iz] : slabs[iz + 1]]`` are those of a slab.
    pairs : int
    d, eps : float32
        Diffusion constant, and rate of the recovery.
    """
    n = slabs.size - 1
    for front in range(n + 2 * pairs - 1):
        for step in range(max(front - n + 1, 0), min(2 * pairs, front + 1)):
            first, last = slabs[front - step], slabs[front - step + 1]
            if step % 2 == 0:
                _there(B, start, first, last, d, eps)
            else:
                _back(B, start, first, last, d, eps)
