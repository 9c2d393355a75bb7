"""Boxes along the axes of the body; their sizes are half of the edge lengths."""

from __future__ import annotations

import numpy as np

from gcm_learn.compiled import njit
from gcm_learn.scene.bodies import BOX, SIZE
from gcm_learn.scene.shapes.region import ShapeEntry, placed

ENTRY = ShapeEntry(BOX, lambda shape: shape.half_extents)


@njit(_nrt=False, forceinline=True)
def gap(bodies, b, x, y, z):
    """Signed distance of a point, negative inside."""
    rows = bodies.rows
    u, v, w = abs(x) - rows[b, SIZE], abs(y) - rows[b, SIZE + 1], abs(z) - rows[b, SIZE + 2]
    inside = min(max(u, v, w), 0.0)
    u, v, w = max(u, 0.0), max(v, 0.0), max(w, 0.0)
    return np.sqrt(u * u + v * v + w * w) + inside


@njit(_nrt=False, forceinline=True)
def gap_of_bone(bodies, b, p, q):
    """Distance of the segment p-q, 0 when they meet."""
    rows = bodies.rows
    return _off_box(p, q, (rows[b, SIZE], rows[b, SIZE + 1], rows[b, SIZE + 2]))


@njit(_nrt=False)
def excess(p, half):
    """Signed distance of p beyond the interval [-half, half]; 0 within."""
    return p - half if p > half else (p + half if p < -half else 0.0)


@njit(_nrt=False)
def _off_box(p, q, size):
    """Distance of segment p-q to a box, both in the box's frame.

    The squared distance is convex and piecewise quadratic along the segment, so its derivative is
    piecewise linear: bisect over the breakpoints, then one linear solve is exact.
    """
    d = (q[0] - p[0], q[1] - p[1], q[2] - p[2])
    lo, hi = 0.0, 1.0
    g_lo = 0.0
    g_hi = 0.0
    for k in range(3):
        g_lo += d[k] * excess(p[k], size[k])
        g_hi += d[k] * excess(q[k], size[k])
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
                        g += d[j] * excess(p[j] + m * d[j], size[j])
                    if g < 0.0:
                        lo, g_lo = m, g
                    else:
                        hi, g_hi = m, g
        s = lo - g_lo * (hi - lo) / (g_hi - g_lo)
    total = 0.0
    for k in range(3):
        e = excess(p[k] + s * d[k], size[k])
        total += e * e
    return np.sqrt(total)


@njit(_nrt=False)
def from_nearest(bodies, b, x, y, z):
    """Vector (3) from the nearest point to a point; 0 from inside."""
    rows = bodies.rows
    return (
        x - min(max(x, -rows[b, SIZE]), rows[b, SIZE]),
        y - min(max(y, -rows[b, SIZE + 1]), rows[b, SIZE + 1]),
        z - min(max(z, -rows[b, SIZE + 2]), rows[b, SIZE + 2]),
    )


@njit(_nrt=False)
def inner_radius(bodies, b):
    """Radius of the largest ball about the centre inside."""
    return min(bodies.rows[b, SIZE], bodies.rows[b, SIZE + 1], bodies.rows[b, SIZE + 2])


@njit(_nrt=False)
def long_axis(bodies, b):
    """Longest axis (3), half as long as the longest edge."""
    x, y, z = bodies.rows[b, SIZE], bodies.rows[b, SIZE + 1], bodies.rows[b, SIZE + 2]
    if z > x and z > y:
        return 0.0, 0.0, z
    return (0.0, y, 0.0) if y > x else (x, 0.0, 0.0)


@njit(_nrt=False)
def cut(bodies, poses, b, made):
    """Cut a box with the plane z = 0: clip a square that holds the cut by six half-spaces."""
    rows, corners, spare = bodies.rows, made.corners, made.spare
    x, y, z = rows[b, SIZE], rows[b, SIZE + 1], rows[b, SIZE + 2]
    bound = 2.0 * np.sqrt(x**2 + y**2 + z**2)
    corners[0, 0], corners[0, 1] = -bound, -bound
    corners[1, 0], corners[1, 1] = bound, -bound
    corners[2, 0], corners[2, 1] = bound, bound
    corners[3, 0], corners[3, 1] = -bound, bound
    count = 4
    for axis in range(3):
        gx, gy = poses[b, 3 + axis], poses[b, 6 + axis]
        half, offset = rows[b, SIZE + axis], poses[b, 9 + axis] * poses[b, 2]
        count = _clip(corners, count, spare, gx, gy, half + offset)
        count = _clip(spare, count, corners, -gx, -gy, half - offset)
    return 0, placed(corners, count, poses[b, 0], poses[b, 1])


@njit(_nrt=False)
def _clip(polygon, corners, kept, gx, gy, limit):
    """Part of a convex polygon where gx x + gy y <= limit (Sutherland and Hodgman).

    Written into `kept`; returns the number of its corners.
    """
    count = 0
    for k in range(corners):
        a = k - 1 if k > 0 else corners - 1
        ax, ay, bx, by = polygon[a, 0], polygon[a, 1], polygon[k, 0], polygon[k, 1]
        over_a = gx * ax + gy * ay - limit
        over_b = gx * bx + gy * by - limit
        if (over_a > 0.0) != (over_b > 0.0):
            share = over_a / (over_a - over_b)
            kept[count, 0], kept[count, 1] = ax + share * (bx - ax), ay + share * (by - ay)
            count += 1
        if over_b <= 0.0:
            kept[count, 0], kept[count, 1] = bx, by
            count += 1
    return count
