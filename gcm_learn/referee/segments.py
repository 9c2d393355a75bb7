"""Distances between points and segments."""

from __future__ import annotations

import numpy as np

from gcm_learn.referee.rotations import Array


def point_apart(p: Array, a: Array, b: Array) -> Array:
    """Return distances (...) of points p to segments from a to b (..., 3)."""
    d = b - a
    length2 = (d * d).sum(axis=-1)
    s = ((p - a) * d).sum(axis=-1) / np.where(length2 > 0.0, length2, 1.0)
    return np.linalg.norm(p - a - np.clip(s, 0.0, 1.0)[..., None] * d, axis=-1)


def segments_apart(a: Array, b: Array, c: Array, d: Array) -> Array:
    """Return distances (k,) of segments from a to b and from c to d (k, 3).

    The least is at an end of either, or where both lines are nearest if that is within both.
    """
    ends = [point_apart(a, c, d), point_apart(b, c, d), point_apart(c, a, b), point_apart(d, a, b)]
    best = np.min(ends, axis=0)
    u, v, w = b - a, d - c, a - c
    uu, vv, uv = (u * u).sum(axis=-1), (v * v).sum(axis=-1), (u * v).sum(axis=-1)
    below = uu * vv - uv * uv
    crossing = below > 1e-12 * uu * vv
    below = np.where(crossing, below, 1.0)
    uw, vw = (u * w).sum(axis=-1), (v * w).sum(axis=-1)
    s, t = (uv * vw - vv * uw) / below, (uu * vw - uv * uw) / below
    within = crossing & (s >= 0.0) & (s <= 1.0) & (t >= 0.0) & (t <= 1.0)
    apart = np.linalg.norm(w + s[..., None] * u - t[..., None] * v, axis=-1)
    return np.where(within, np.minimum(apart, best), best)
