"""Moves as cubics in the joints, over a share s in [0, 1] of the move.

A row of coefficients (a, b, c, d) for each joint: ``q(s) = a + b s + c s^2 + d s^3``.
"""

from __future__ import annotations

from gcm_learn.compiled import njit


@njit(_nrt=False)
def line(q, p, curve):
    """Write the straight move from joints q to p (n,) into `curve` (n, 4)."""
    for j in range(curve.shape[0]):
        curve[j, 0], curve[j, 1], curve[j, 2], curve[j, 3] = q[j], p[j] - q[j], 0.0, 0.0


@njit(_nrt=False)
def hermite(q, v, p, w, span, curve):
    """Write the cubic from q with rates v to p with rates w (n,) in `span` [s] into `curve`."""
    for j in range(curve.shape[0]):
        a, b, way = v[j] * span, w[j] * span, p[j] - q[j]
        curve[j, 0], curve[j, 1] = q[j], a
        curve[j, 2], curve[j, 3] = 3.0 * way - 2.0 * a - b, a + b - 2.0 * way


@njit(_nrt=False)
def on_curve(curve, s, q):
    """Write the joints at share s of a move into q (n,)."""
    for j in range(curve.shape[0]):
        q[j] = curve[j, 0] + s * (curve[j, 1] + s * (curve[j, 2] + s * curve[j, 3]))


@njit(_nrt=False)
def part(curve, since, until, out):
    """Write the part of a move from share `since` to share `until` to `out` (n, 4), as a move."""
    width = until - since
    for j in range(curve.shape[0]):
        b, c, d = curve[j, 1], curve[j, 2], curve[j, 3]
        out[j, 0] = curve[j, 0] + since * (b + since * (c + since * d))
        out[j, 1] = width * (b + since * (2.0 * c + since * 3.0 * d))
        out[j, 2] = width * width * (c + 3.0 * since * d)
        out[j, 3] = width * width * width * d


@njit(_nrt=False, forceinline=True)
def rate_of(curve, j, s):
    """Rate of joint j at share s of a move, per share."""
    return curve[j, 1] + s * (2.0 * curve[j, 2] + s * 3.0 * curve[j, 3])


@njit(_nrt=False, forceinline=True)
def turn_of(curve, j, s, half):
    """Bound the turn of joint j between share s of a move and share s - half or s + half."""
    rate = abs(rate_of(curve, j, s))
    bend = abs(2.0 * curve[j, 2] + 6.0 * s * curve[j, 3])
    return half * (rate + half * (bend + half * 3.0 * abs(curve[j, 3])))
