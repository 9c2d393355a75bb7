"""Distances of segments to clouds and meshes, part by part among blocks that may hold the nearest.

Parts are arrays (n, c, 3): one corner of a point, three of a triangle.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from gcm_learn.referee.rotations import Array
from gcm_learn.referee.segments import point_apart, segments_apart

BLOCK = 32
"""Parts of a block at most."""
AT_ONCE = 1 << 20
"""Distances that are computed in one step."""


def ready(shape: dict[str, Any]) -> dict[str, Any]:
    """Return a cloud or mesh with its parts in blocks, and a ball around each block."""
    if shape["kind"] == "cloud":
        parts = np.array(shape["points"], dtype=float)[:, None]
    else:
        parts = np.array(shape["vertices"], dtype=float)[np.array(shape["triangles"])]
    blocks = np.array([np.resize(b, BLOCK) for b in _divided(np.arange(len(parts)), parts)])
    corners = parts[blocks].reshape(len(blocks), -1, 3)
    centres = corners.mean(axis=1)
    radii = np.linalg.norm(corners - centres[:, None], axis=2).max(axis=1)
    far = float(np.linalg.norm(parts, axis=2).max()) + shape.get("radius", 0.0)
    return {
        "kind": shape["kind"], "radius": shape.get("radius", 0.0), "parts": parts[blocks],
        "centres": centres, "radii": radii * (1.0 + 1e-9), "ball": far,
    }  # fmt: skip


def _divided(which: Array, parts: Array) -> Iterator[Array]:
    """Yield the parts of blocks, divided where they spread most."""
    if len(which) <= BLOCK:
        yield which
        return
    places = parts[which, 0]
    order = np.argsort(places[:, np.ptp(places, axis=0).argmax()])
    for half in np.array_split(which[order], 2):
        yield from _divided(half, parts)


def points(shape: dict[str, Any], p: Array) -> Array:
    """Return distances (k,) of points (k, 3), which are negative within balls."""
    return segments(shape, p, p)


def segments(shape: dict[str, Any], a: Array, b: Array) -> Array:
    """Return least distances (k,) of segments from a to b (k, 3)."""
    part = _to_points if shape["kind"] == "cloud" else _to_triangles
    step = max(1, AT_ONCE // len(shape["centres"]))
    cuts = range(0, len(a), step)
    found = [_nearest(shape, a[k : k + step], b[k : k + step], part) for k in cuts]
    return np.concatenate([np.zeros(0), *found]) - shape["radius"]


def _nearest(
    shape: dict[str, Any], a: Array, b: Array, part: Callable[[Array, Array, Array], Array]
) -> Array:
    """Return least distances (k,) to parts: of the nearest blocks, then of all that matter."""
    low = point_apart(shape["centres"], a[:, None], b[:, None]) - shape["radii"]
    rows, first = np.arange(len(a)), low.argmin(axis=1)
    best = _least(shape["parts"], rows, first, a, b, part)
    low[rows, first] = np.inf
    row, block = np.nonzero(low <= best[:, None])
    np.minimum.at(best, row, _least(shape["parts"], row, block, a, b, part))
    return best


def _least(
    parts: Array, row: Array, block: Array, a: Array, b: Array,
    part: Callable[[Array, Array, Array], Array],
) -> Array:  # fmt: skip
    """Return least distances (m,) of segments of some rows to a block each."""
    step, found = AT_ONCE // (16 * BLOCK), [np.zeros(0)]
    for k in range(0, len(row), step):
        i, corners = row[k : k + step], parts[block[k : k + step]]
        found.append(part(corners, a[i, None], b[i, None]).min(axis=1))
    return np.concatenate(found)


def _to_points(corners: Array, a: Array, b: Array) -> Array:
    return point_apart(corners[..., 0, :], a, b)


def _to_triangles(corners: Array, a: Array, b: Array) -> Array:
    """Return distances (m, parts): to edges, to planes above triangles, or 0 for a crossing."""
    a, b = (np.broadcast_to(end, corners[..., 0, :].shape) for end in (a, b))
    edges = [segments_apart(a, b, corners[..., k - 1, :], corners[..., k, :]) for k in range(3)]
    best = np.min(edges, axis=0)
    origin, u, v = corners[..., 0, :], *(corners[..., k, :] - corners[..., 0, :] for k in (1, 2))
    normal = np.cross(u, v)
    area = np.linalg.norm(normal, axis=-1)
    normal = normal / np.where(area > 0.0, area, 1.0)[..., None]
    longest = np.max([np.linalg.norm(side, axis=-1) for side in (u, v, v - u)], axis=0)
    thin = area / np.where(longest > 0.0, longest, 1.0)  # nothing is farther from all edges
    edge = best
    heights = [((end - origin) * normal).sum(axis=-1) for end in (a, b)]
    for end, height in zip((a, b), heights, strict=True):
        over = (edge <= np.abs(height) + thin) & _within(end - origin, u, v)
        best = np.where(over, np.minimum(best, np.abs(height)), best)
    up, down = heights
    crosses = (edge <= thin) & (up * down < 0.0)
    share = np.where(crosses, up / np.where(crosses, up - down, 1.0), 0.0)
    return np.where(crosses & _within(a + share[..., None] * (b - a) - origin, u, v), 0.0, best)


def _within(w: Array, u: Array, v: Array) -> Array:
    """Tell which w are above the triangles of 0, u and v, by the coordinates of their feet."""
    uu, uv, vv = (u * u).sum(axis=-1), (u * v).sum(axis=-1), (v * v).sum(axis=-1)
    wu, wv = (w * u).sum(axis=-1), (w * v).sum(axis=-1)
    below = uu * vv - uv * uv
    flat = below <= 0.0
    below = np.where(flat, 1.0, below)
    first, second = (vv * wu - uv * wv) / below, (uu * wv - uv * wu) / below
    return ~flat & (first >= 0.0) & (second >= 0.0) & (first + second <= 1.0)
