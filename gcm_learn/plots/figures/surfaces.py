"""Surfaces in arrays over space: where a field crosses a level (naive surface nets).

S. F. Gibson, Constrained elastic surface nets, MICCAI 1998. Every cube of eight
neighbours that the surface passes has a corner, in the middle of the crossings of its edges.
"""

from __future__ import annotations

import itertools

import numpy as np
from scipy.spatial import cKDTree

from gcm_learn.rendering import Shell, normals
from gcm_learn.situation import Cloud, Mesh, SpaceShape

CELLS = 24  # along a surface about a cloud or mesh
_CORNERS = np.array(list(itertools.product((0, 1), repeat=3)))
_EDGES = [
    (a, b)
    for a, b in itertools.combinations(range(8), 2)
    if np.abs(_CORNERS[a] - _CORNERS[b]).sum() == 1
]


def surface(field: np.ndarray, level: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Surface on which a field crosses a level.

    Parameters
    ----------
    field : (l, m, n) ndarray
        Finite.  Outside the array it is above the level, so that surfaces are closed.
    level : float

    Returns
    -------
    corners : (k, 4, 3) ndarray
        Of quadrilaterals, as indices of the field (fractions between its points), counter-clockwise
        when seen from where the field is above the level.
    normal : (k, 4, 3) ndarray
        Unit normals at the corners, towards there.
    """
    values = np.pad(field - level, 1, constant_values=1.0)
    inside = values < 0.0
    points, number = _points(values, inside)
    quads = np.concatenate([_quads(inside, number, axis) for axis in range(3)])
    corners = points[quads]
    flat = np.repeat(normals(corners)[:, None], 4, axis=1)
    sums = np.zeros_like(points)
    np.add.at(sums, quads, flat)
    sums /= np.maximum(np.linalg.norm(sums, axis=1, keepdims=True), 1e-12)
    return corners - 1.0, sums[quads]


def surface_about(shape: SpaceShape, distance: float, cells: int = CELLS) -> Shell | None:
    """Return one surface at a distance from a cloud or mesh; None if too near for the grid."""
    if not isinstance(shape, Cloud | Mesh):
        return None
    radius = shape.radius if isinstance(shape, Cloud) else 0.0
    corners = shape.points[:, None] if isinstance(shape, Cloud) else shape.corners
    low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
    wide = distance + radius
    cell = float((high - low + 2 * wide).max()) / cells
    if wide <= cell:
        return None
    tree = cKDTree(_filled(corners, cell))
    count = np.ceil((high - low + 2 * wide) / cell).astype(int) + 3
    grid = low - wide - cell + cell * np.moveaxis(np.indices(count), 0, -1)
    most = wide + 2.0 * cell  # what is farther away need not be known
    away = tree.query(grid, distance_upper_bound=most)[0]
    quads = grid[0, 0, 0] + cell * surface(np.minimum(away, most), wide)[0]
    outward = quads - tree.data[tree.query(quads)[1]]
    away = np.linalg.norm(outward, axis=-1, keepdims=True)
    return Shell(quads + (radius / away - 1.0) * outward, outward / away)


def _filled(corners: np.ndarray, apart: float) -> np.ndarray:
    """Return points (n, 3) of triangles (k, 3, 3), or of points (k, 1, 3), that are near others."""
    while (long := np.ptp(corners, axis=1).max(axis=1) > apart).any():
        a, b, c = corners[long].transpose(1, 0, 2)
        d, e, f = 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)
        parts = np.array([(a, d, f), (d, b, e), (f, e, c), (d, e, f)])
        corners = np.concatenate([corners[~long], *parts.transpose(0, 2, 1, 3)])
    return np.unique(corners.reshape(-1, 3), axis=0)


def _points(values: np.ndarray, inside: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Corners (k, 3) of the surface, and which of them is in a cube; -1 where none is."""
    shape = tuple(size - 1 for size in values.shape)
    parts = [
        inside[i : i + shape[0], j : j + shape[1], k : k + shape[2]]
        for i, j, k in _CORNERS.tolist()
    ]
    passed = np.logical_or.reduce(parts) & ~np.logical_and.reduce(parts)
    cubes = np.argwhere(passed)
    at = [values[tuple((cubes + corner).T)] for corner in _CORNERS]
    total, count = np.zeros((len(cubes), 3)), np.zeros((len(cubes), 1))
    for a, b in _EDGES:
        crosses = (at[a] < 0.0) != (at[b] < 0.0)
        share = at[a] / np.where(crosses, at[a] - at[b], 1.0)
        place = _CORNERS[a] + share[:, None] * (_CORNERS[b] - _CORNERS[a])
        total += np.where(crosses[:, None], place, 0.0)
        count += crosses[:, None]
    number = np.full(shape, -1)
    number[passed] = np.arange(len(cubes))
    return cubes + total / np.maximum(count, 1.0), number


def _quads(inside: np.ndarray, number: np.ndarray, axis: int) -> np.ndarray:
    """Quadrilaterals (m, 4) round the edges along an axis that the surface crosses."""
    u, v = (axis + 1) % 3, (axis + 2) % 3
    low = inside.take(range(inside.shape[axis] - 1), axis)
    high = inside.take(range(1, inside.shape[axis]), axis)
    start = np.argwhere(low != high)
    start = start[(start[:, u] > 0) & (start[:, v] > 0)]
    start = start[(start[:, u] < inside.shape[u] - 1) & (start[:, v] < inside.shape[v] - 1)]
    step_u, step_v = np.eye(3, dtype=int)[u], np.eye(3, dtype=int)[v]
    round_it = [number[tuple((start - du * step_u - dv * step_v).T)]
                for du, dv in ((1, 1), (0, 1), (0, 0), (1, 0))]  # fmt: skip
    quads = np.stack(round_it, axis=1)
    outward = low[tuple(start.T)]
    return np.where(outward[:, None], quads, quads[:, ::-1])


def softened(values: np.ndarray) -> np.ndarray:
    """A field (l, m, n), or marked cells, with a quarter of every step taken to either side."""
    field = values.astype(float)
    for axis in range(3):
        padded = np.pad(field, [(1, 1) if k == axis else (0, 0) for k in range(3)], "edge")
        size = field.shape[axis]
        before, here, after = (padded.take(range(k, k + size), axis) for k in range(3))
        field = 0.25 * before + 0.5 * here + 0.25 * after
    return field
