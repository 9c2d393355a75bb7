"""Simple polygons in the arm's plane, convex or not; a body's row has the range of its vertices."""

from __future__ import annotations

import numpy as np

from gcm_learn.compiled import njit
from gcm_learn.scene.bodies import FIRST, LAST, POLYGON
from gcm_learn.scene.shapes.region import ShapeEntry, polygon_distance

ENTRY = ShapeEntry(POLYGON, lambda _shape: (0.0, 0.0, 0.0), vertices=lambda shape: shape.vertices)


@njit(_nrt=False)
def segments_cross(ax, ay, bx, by, cx, cy, dx, dy):
    """Tell whether the plane segments a-b and c-d properly cross."""
    d1 = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    d2 = (bx - ax) * (dy - ay) - (by - ay) * (dx - ax)
    d3 = (dx - cx) * (ay - cy) - (dy - cy) * (ax - cx)
    d4 = (dx - cx) * (by - cy) - (dy - cy) * (bx - cx)
    return d1 * d2 < 0.0 and d3 * d4 < 0.0


@njit(_nrt=False, forceinline=True)
def _off_edge2(wx, wy, dx, dy, inverse):
    """Squared distance of w to the segment from the origin to d; `inverse` is 1 / |d|^2."""
    s = min(max((wx * dx + wy * dy) * inverse, 0.0), 1.0)
    wx, wy = wx - s * dx, wy - s * dy
    return wx * wx + wy * wy


@njit(_nrt=False)
def gap(bodies, b, x, y, z):
    """Signed distance of a point in the plane, negative inside."""
    rows = bodies.rows
    return polygon_distance(x, y, bodies.vertices, int(rows[b, FIRST]), int(rows[b, LAST]))


@njit(_nrt=False, forceinline=True)
def gap_of_bone(bodies, b, p, q):
    """Distance of the segment p-q in the plane, 0 when they meet."""
    ax, ay, _ = p
    bx, by, _ = q
    dx, dy = bx - ax, by - ay
    length2 = dx * dx + dy * dy
    inverse = 1.0 / length2 if length2 > 0.0 else 0.0
    first, last = int(bodies.rows[b, FIRST]), int(bodies.rows[b, LAST])
    best = 1e300
    inside = False
    px, py = bodies.vertices[last - 1, 0], bodies.vertices[last - 1, 1]
    for k in range(first, last):
        qx, qy = bodies.vertices[k, 0], bodies.vertices[k, 1]
        if segments_cross(ax, ay, bx, by, px, py, qx, qy):
            return 0.0
        ex, ey = qx - px, qy - py
        edge = 1.0 / (ex * ex + ey * ey)
        best = min(best, _off_edge2(px - ax, py - ay, dx, dy, inverse))
        best = min(best, _off_edge2(ax - px, ay - py, ex, ey, edge))
        best = min(best, _off_edge2(bx - px, by - py, ex, ey, edge))
        if (py > ay) != (qy > ay) and ax < ex * (ay - py) / ey + px:
            inside = not inside
        px, py = qx, qy
    return 0.0 if inside else np.sqrt(best)


@njit(_nrt=False)
def long_axis(bodies, b):
    """Axis (3) along which the corners spread most, as long as they spread more than across."""
    first, last = int(bodies.rows[b, FIRST]), int(bodies.rows[b, LAST])
    mx, my = 0.0, 0.0
    for k in range(first, last):
        mx += bodies.vertices[k, 0] / (last - first)
        my += bodies.vertices[k, 1] / (last - first)
    xx, xy, yy = 0.0, 0.0, 0.0
    for k in range(first, last):
        dx, dy = bodies.vertices[k, 0] - mx, bodies.vertices[k, 1] - my
        xx, xy, yy = xx + dx * dx, xy + dx * dy, yy + dy * dy
    spread = np.sqrt(np.sqrt((xx - yy) ** 2 + 4.0 * xy * xy) / (last - first))
    phi = 0.5 * np.arctan2(2.0 * xy, xx - yy)
    return spread * np.cos(phi), spread * np.sin(phi), 0.0
