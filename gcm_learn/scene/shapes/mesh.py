"""Meshes: surfaces of triangles without an inside; the sizes are 0, count and depth of the tree."""

from __future__ import annotations

import numpy as np

from gcm_learn.arms.link_gaps import segments_apart2
from gcm_learn.compiled import njit
from gcm_learn.scene.bodies import MESH
from gcm_learn.scene.shapes.region import ShapeEntry
from gcm_learn.scene.shapes.tree import depth_of, kept, nearest, tree_of
from gcm_learn.situation import Mesh

LEAF = 2
_ROWS = 5  # of a triangle in the tree: nine numbers and a free one


@kept
def _tree(mesh: Mesh) -> np.ndarray:
    """Return the tree of a mesh."""
    corners = mesh.corners
    middle = 0.5 * (corners.min(axis=1) + corners.max(axis=1))
    radii = np.linalg.norm(corners - middle[:, None], axis=2).max(axis=1)
    parts = np.c_[corners.reshape(-1, 9), np.zeros(len(corners))]
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
    within = _dot(_cross(u, w), n) >= 0.0 and _dot(_cross(w, v), n) >= 0.0
    return within and _dot(_cross(_minus(v, u), _minus(w, u)), n) >= 0.0


@njit(_nrt=False, forceinline=True)
def _edges(v, row):
    """Corner of a triangle and the two edges (3) that begin there."""
    corner = v[row, 0], v[row, 1], v[row + 1, 0]
    second, third = (
        (v[row + 1, 1], v[row + 2, 0], v[row + 2, 1]),
        (v[row + 3, 0], v[row + 3, 1], v[row + 4, 0]),
    )
    return corner, _minus(second, corner), _minus(third, corner)


@njit(_nrt=False)
def _off_triangle(bodies, b, row, p, q):
    """Distance of the segment p-q to a triangle: by its edges, its plane, or 0 where it crosses."""
    corner, u, v = _edges(bodies.vertices, row)
    p, d = _minus(p, corner), _minus(q, p)
    q = _minus(q, corner)
    back = -p[0], -p[1], -p[2]
    best = min(segments_apart2(u, d, back), segments_apart2(v, d, back))
    best = min(best, segments_apart2(_minus(v, u), d, _minus(u, p)))
    n = _cross(u, v)
    size2 = _dot(n, n)
    if size2 > 0.0:
        above, below = _dot(n, p), _dot(n, q)
        if _above(p, u, v, n):
            best = min(best, above * above / size2)
        if _above(q, u, v, n):
            best = min(best, below * below / size2)
        if above * below < 0.0:
            s = above / (above - below)
            if _above((p[0] + s * d[0], p[1] + s * d[1], p[2] + s * d[2]), u, v, n):
                return 0.0
    return np.sqrt(max(best, 0.0))


@njit(_nrt=False)
def gap(bodies, b, x, y, z):
    """Distance of a point."""
    return nearest(_off_triangle, _ROWS, bodies, b, (x, y, z), (x, y, z), 0.0, 1e300)[0]


@njit(_nrt=False)
def gap_of_bone(bodies, b, p, q, enough):
    """Distance of the segment p-q, 0 when they meet."""
    return nearest(_off_triangle, _ROWS, bodies, b, p, q, 0.0, enough)[0]


@njit(_nrt=False)
def part_near(bodies, b, p, q):
    """Row of the triangle that is nearest to the segment p-q."""
    return nearest(_off_triangle, _ROWS, bodies, b, p, q, 0.0, 1e300)[1]


@njit(_nrt=False)
def from_nearest(bodies, b, part, x, y, z):
    """Vector (3) from the nearest point of a triangle to a point."""
    corner, u, v = _edges(bodies.vertices, part)
    w = _minus((x, y, z), corner)
    n = _cross(u, v)
    size2 = _dot(n, n)
    if size2 > 0.0 and _above(w, u, v, n):
        up = _dot(n, w) / size2
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
    """Longest axis (3): none, as nothing is known of how triangles are spread."""
    return 0.0, 0.0, 0.0
