"""Distances of a segment to solids, in the solid's own frame.

Points are tuples of three numbers.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.compiled import njit


@njit(_nrt=False)
def _excess(p, half):
    """How far p lies beyond [-half, half], with its sign."""
    return p - half if p > half else (p + half if p < -half else 0.0)


@njit(_nrt=False)
def segment_box(p, q, size):
    """Distance of segment p-q to a box, both in the box's frame.

    The squared distance is convex and piecewise quadratic along the segment, so its derivative is
    piecewise linear: bisect over the breakpoints, then one linear solve is exact.
    """
    d = (q[0] - p[0], q[1] - p[1], q[2] - p[2])
    lo, hi = 0.0, 1.0
    g_lo = 0.0
    g_hi = 0.0
    for k in range(3):
        g_lo += d[k] * _excess(p[k], size[k])
        g_hi += d[k] * _excess(q[k], size[k])
    if g_lo >= 0.0:
        s = 0.0
    elif g_hi <= 0.0:
        s = 1.0
    else:
        for k in range(3):
            if d[k] == 0.0:
                continue
            for side in (-1.0, 1.0):
                m = (side * size[k] - p[k]) / d[k]
                if lo < m < hi:
                    g = 0.0
                    for j in range(3):
                        g += d[j] * _excess(p[j] + m * d[j], size[j])
                    if g < 0.0:
                        lo, g_lo = m, g
                    else:
                        hi, g_hi = m, g
        s = lo - g_lo * (hi - lo) / (g_hi - g_lo)
    total = 0.0
    for k in range(3):
        e = _excess(p[k] + s * d[k], size[k])
        total += e * e
    return np.sqrt(total)


@njit(_nrt=False)
def segment_axis(p, q, half_length):
    """Distance of segment p-q to the segment of the z axis between -half_length and half_length."""
    dx, dy, dz = q[0] - p[0], q[1] - p[1], q[2] - p[2]
    a = dx * dx + dy * dy + dz * dz
    flat = dx * dx + dy * dy
    s = 0.0
    if flat > 1e-18 * a and a > 0.0:
        # Nearest points of the two lines; the z coordinate is clamped, then s follows from it.
        s = min(max(-(p[0] * dx + p[1] * dy) / flat, 0.0), 1.0)
    z = min(max(p[2] + s * dz, -half_length), half_length)
    if a > 0.0:
        s = min(max(-(p[0] * dx + p[1] * dy + (p[2] - z) * dz) / a, 0.0), 1.0)
    z = min(max(p[2] + s * dz, -half_length), half_length)
    x, y, w = p[0] + s * dx, p[1] + s * dy, p[2] + s * dz - z
    return np.sqrt(x * x + y * y + w * w)


@njit(_nrt=False)
def _cylinder_slope(p, d, s, radius, half_length):
    """Half the derivative of the squared distance to a cylinder at p + s d."""
    x, y, z = p[0] + s * d[0], p[1] + s * d[1], p[2] + s * d[2]
    rad = np.sqrt(x * x + y * y)
    g = d[2] * _excess(z, half_length)
    if rad > radius:
        g += (rad - radius) * (x * d[0] + y * d[1]) / rad
    return g


@njit(_nrt=False)
def segment_cylinder(p, q, radius, half_length):
    """Distance of segment p-q to a cylinder: the root of the slope of a convex function.

    Regula falsi with the Illinois rule, and bisection every third step, so that the bracket always
    shrinks; a slope of exactly 0 ends it, also inside, where the distance is flat at 0.
    """
    d = (q[0] - p[0], q[1] - p[1], q[2] - p[2])
    lo, hi = 0.0, 1.0
    g_lo = _cylinder_slope(p, d, lo, radius, half_length)
    g_hi = _cylinder_slope(p, d, hi, radius, half_length)
    if g_lo >= 0.0:
        hi = lo
    elif g_hi <= 0.0:
        lo = hi
    turn = 0
    while hi - lo > 1e-9:
        turn += 1
        m = 0.5 * (lo + hi) if turn % 3 == 0 else lo - g_lo * (hi - lo) / (g_hi - g_lo)
        g = _cylinder_slope(p, d, m, radius, half_length)
        if g == 0.0 or m <= lo or m >= hi:
            lo = hi = m
        elif g < 0.0:
            lo, g_lo, g_hi = m, g, 0.5 * g_hi
        else:
            hi, g_hi, g_lo = m, g, 0.5 * g_lo
    s = 0.5 * (lo + hi)
    x, y, z = p[0] + s * d[0], p[1] + s * d[1], p[2] + s * d[2]
    e = max(np.sqrt(x * x + y * y) - radius, 0.0)
    w = _excess(z, half_length)
    return np.sqrt(e * e + w * w)
