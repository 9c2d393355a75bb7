"""Meshes: surfaces of triangles without an inside; the sizes are 0, count and depth of the tree."""

from __future__ import annotations

import numpy as np

from gcm_learn.arms.link_gaps import segments_apart2
from gcm_learn.compiled import njit
from gcm_learn.scene.bodies import MESH
from gcm_learn.scene.shapes.region import ShapeEntry
from gcm_learn.scene.shapes.tree import above, depth_of, kept, nearest, tree_of
from gcm_learn.situation import Mesh

LEAF = 2
SLIVER = 1e-7
"""Share of height and length of a triangle below which its plane is lost in rounding."""
_ROWS = 7  # of a triangle in the tree: a corner, two edges, unit normal, lowest height, a free one


@kept
def _tree(mesh: Mesh) -> np.ndarray:
    """Return the tree of a mesh."""
    corners = mesh.corners
    middle = 0.5 * (corners.min(axis=1) + corners.max(axis=1))
    radii = np.linalg.norm(corners - middle[:, None], axis=2).max(axis=1)
    u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normal = np.cross(u, v)
    area = np.linalg.norm(normal, axis=1)
    longest = np.linalg.norm([u, v, v - u], axis=2).max(axis=0)
    flat = area <= SLIVER * longest**2
    thin = np.where(flat, 0.0, area / np.where(flat, 1.0, longest))
    normal = np.where(flat, 0.0, normal.T / np.where(flat, 1.0, area)).T
    parts = np.c_[corners[:, 0], u, v, normal, thin, np.zeros(len(u))]
    return tree_of(parts, middle, radii, LEAF)


def _sizes(mesh: Mesh) -> tuple[float, float, float]:
    return 0.0, len(mesh.triangles), depth_of(len(mesh.triangles), LEAF)


ENTRY = ShapeEntry(MESH, _sizes, vertices=_tree)


@njit(_nrt=False, forceinline=True)
def _minus(p, q):
    return p[0] - q[0], p[1] - q[1], p[2] - q[2]


@njit(_nrt=False, forceinline=True)
def _dot(p, q):
    return p[0] * q[0] + p[1] * q[1] + p[2] * q[2]


@njit(_nrt=False, forceinline=True)
def _cross(p, q):
    return p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]


@njit(_nrt=False, forceinline=True)
def _above(w, u, v, n):
    """Return whether the normal n through the point w meets the triangle of 0, u and v."""
    if n[0] == n[1] == n[2] == 0.0:  # it has no area
        return False
    within = _dot(_cross(u, w), n) >= 0.0 and _dot(_cross(w, v), n) >= 0.0
    return within and _dot(_cross(_minus(v, u), _minus(w, u)), n) >= 0.0


@njit(_nrt=False, forceinline=True)
def _edges(v, row):
    """Corner, the two edges that begin there, and the unit normal of a triangle (3 each)."""
    return (
        (v[row, 0], v[row, 1], v[row + 1, 0]),
        (v[row + 1, 1], v[row + 2, 0], v[row + 2, 1]),
        (v[row + 3, 0], v[row + 3, 1], v[row + 4, 0]),
        (v[row + 4, 1], v[row + 5, 0], v[row + 5, 1]),
    )


@njit(_nrt=False)
def _apart2(t, row, p, d, inverse, far):
    """Squared distance of the triangle in a row to the segment from p to p + d; 0 if they cross."""
    corner, u, v, n = _edges(t, row)
    p = _minus(p, corner)
    q = p[0] + d[0], p[1] + d[1], p[2] + d[2]
    high, low = _dot(n, p), _dot(n, q)
    if high * low > 0.0 and min(abs(high), abs(low)) > far:
        return 1e300
    back = -p[0], -p[1], -p[2]
    best = min(segments_apart2(u, d, back), segments_apart2(v, d, back))
    best = min(best, segments_apart2(_minus(v, u), d, _minus(u, p)))
    # No point of a triangle is farther than its lowest height from an edge. Where rounding says so,
    # as of triangles that are tiny and far, only edges count.
    thin = t[row + 6, 0]
    if high * low < 0.0 and best <= thin * thin:
        s = high / (high - low)
        if _above((p[0] + s * d[0], p[1] + s * d[1], p[2] + s * d[2]), u, v, n):
            return 0.0
    edge, high, low = best, abs(high), abs(low)
    if high * high < best and edge <= (high + thin) ** 2 and _above(p, u, v, n):
        best = high * high
    if low * low < best and edge <= (low + thin) ** 2 and _above(q, u, v, n):
        best = low * low
    return max(best, 0.0)


@njit(_nrt=False)
def _nearest(bodies, b, p, q, near, far):
    """Distance of the nearest triangle to the segment p-q, and the triangle's row."""
    return nearest(_apart2, _ROWS, bodies, b, p, q, 0.0, near, far)


@njit(_nrt=False)
def gap(bodies, b, x, y, z):
    """Distance of a point."""
    return _nearest(bodies, b, (x, y, z), (x, y, z), 1e300, 1e300)[0]


@njit(_nrt=False)
def gap_of_bone(bodies, b, p, q, near, far):
    """Distance of the segment p-q, 0 when they meet; see `choice.gap_of_bone`."""
    return _nearest(bodies, b, p, q, above(near), above(far))[0]


@njit(_nrt=False)
def part_near(bodies, b, p, q):
    """Row of the triangle that is nearest to the segment p-q."""
    return _nearest(bodies, b, p, q, 1e300, 1e300)[1]


@njit(_nrt=False)
def from_nearest(bodies, b, part, x, y, z):
    """Vector (3) from the nearest point of a triangle to a point."""
    corner, u, v, n = _edges(bodies.vertices, part)
    w = _minus((x, y, z), corner)
    if _above(w, u, v, n):
        up = _dot(n, w)
        return up * n[0], up * n[1], up * n[2]
    first, second = _off_edge(w, u), _off_edge(w, v)
    third = _off_edge(_minus(w, u), _minus(v, u))
    if _dot(second, second) < _dot(first, first):
        first = second
    return third if _dot(third, third) < _dot(first, first) else first


@njit(_nrt=False, forceinline=True)
def _off_edge(w, d):
    """Vector (3) from the nearest point of the segment from 0 to d to the point w."""
    length2 = _dot(d, d)
    s = min(max(_dot(w, d) / length2, 0.0), 1.0) if length2 > 0.0 else 0.0
    return w[0] - s * d[0], w[1] - s * d[1], w[2] - s * d[2]


@njit(_nrt=False)
def long_axis(bodies, b):
    """Longest axis (3): zero, which means unknown."""
    return 0.0, 0.0, 0.0
