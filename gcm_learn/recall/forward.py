"""The embedding of one situation, compiled: a recall has time for little else.

Rows of weights are added up for inputs that are not zero. Most cells of a look are, and half of all
rectified units.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.compiled import njit


@njit(fastmath={"reassoc", "contract"})
def _add_rows(values, weight, first, out):
    """Add values (n,) times the rows of a weight from `first` on to out (m,)."""
    for k in range(values.size):
        value = values[k]
        if value > 0.0 or value < 0.0:
            row = first + k
            for j in range(out.size):
                out[j] += value * weight[row, j]


@njit
def _rectify(values):
    for j in range(values.size):
        if values[j] < 0.0:
            values[j] = np.float32(0.0)


@njit
def embed_look(context, cells, arm_weights, arm_biases, body_weights, body_biases):
    """Embedding (dim,) float32 of a look.

    Parameters
    ----------
    context, cells : (c,), (b, n) ndarray of float32
        Of a `Look`.
    arm_weights, arm_biases, body_weights, body_biases : tuple of ndarray
        Of the towers `situation` and `body`; the body's inputs are context and cells.
    """
    first = arm_biases[0].copy()
    _add_rows(context, arm_weights[0], 0, first)
    _rectify(first)
    second = arm_biases[1].copy()
    _add_rows(first, arm_weights[1], 0, second)
    _rectify(second)
    out = arm_biases[2].copy()
    _add_rows(second, arm_weights[2], 0, out)
    if cells.shape[0] == 0:
        return out
    shared = body_biases[0].copy()
    _add_rows(context, body_weights[0], 0, shared)
    total = np.zeros(body_biases[1].size, dtype=np.float32)
    for b in range(cells.shape[0]):
        first = shared.copy()
        _add_rows(cells[b], body_weights[0], context.size, first)
        _rectify(first)
        second = body_biases[1].copy()
        _add_rows(first, body_weights[1], 0, second)
        _rectify(second)
        total += second
    _add_rows(total, body_weights[2], 0, out)
    return out + np.float32(cells.shape[0]) * body_biases[2]
