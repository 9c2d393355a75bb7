"""Signed distances of points and segments to shapes, in the frame of the body.

Shapes of the plane are prisms along z without ends, so that one code serves plane and space.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from gcm_learn.referee import surfaces
from gcm_learn.referee.rotations import Array
from gcm_learn.referee.segments import point_apart, segments_apart

Shape = dict[str, Any]
GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)
SECTIONS = 40
"""Of a golden section search: to 5e-9 of a segment."""


class Solid(NamedTuple):
    """Functions that a kind of shape has."""

    points: Callable[[Shape, Array], Array]
    """Signed distances (k,) of points (k, 3), negative inside."""
    segments: Callable[[Shape, Array, Array], Array]
    """Least signed distances (k,) of segments between points (k, 3)."""
    ball: Callable[[Shape], float]
    """Radius of the ball about the centre that holds the shape."""
    ready: Callable[[Shape], Shape] = lambda shape: shape
    """The shape as the other functions take it."""
    centred: bool = True
    """True if the centre of the body is in the shape."""


def point_gaps(shape: Shape, points: Array) -> Array:
    """Return signed distances (k,) of points (k, 3) to a shape, negative inside."""
    return SOLIDS[shape["kind"]].points(shape, points)


def segment_gaps(shape: Shape, a: Array, b: Array) -> Array:
    """Return the least signed distances (k,) of segments from a to b (k, 3) to a shape."""
    return SOLIDS[shape["kind"]].segments(shape, a, b)


def ball_of(shape: Shape) -> float:
    """Return the radius of the ball about the centre that holds a shape."""
    return SOLIDS[shape["kind"]].ball(shape)


def ready(shape: Shape) -> Shape:
    """Return a shape in the form that the functions of this module need."""
    return SOLIDS[shape["kind"]].ready(shape)


def is_centred(shape: Shape) -> bool:
    """Tell if the centre of the body is in a shape."""
    return SOLIDS[shape["kind"]].centred


def golden_minimum(function: Callable[[Array], Array], count: int) -> Array:
    """Return minima (count,) over [0, 1] of convex functions, evaluated at places (count,)."""
    low, high = np.zeros(count), np.ones(count)
    best = np.minimum(function(low), function(high))
    s, u = high - GOLDEN, low + GOLDEN
    fs, fu = function(s), function(u)
    for _ in range(SECTIONS):
        best = np.minimum(best, np.minimum(fs, fu))
        left = fs <= fu
        low, high = np.where(left, low, s), np.where(left, u, high)
        fresh = np.where(left, high - GOLDEN * (high - low), low + GOLDEN * (high - low))
        found = function(fresh)
        s, u = np.where(left, fresh, u), np.where(left, s, fresh)
        fs, fu = np.where(left, found, fu), np.where(left, fs, found)
    return np.minimum(best, np.minimum(fs, fu))


# --- solids ----------------------------------------------------------------------------------


def _outside(beyond: Array) -> Array:
    """Return signed distances (k,) to a product of intervals, given the excess (k, parts)."""
    outside = np.sqrt((np.maximum(beyond, 0.0) ** 2).sum(axis=1))
    return outside + np.minimum(beyond.max(axis=1), 0.0)


def _box_points(shape: Shape, p: Array) -> Array:
    return _outside(np.abs(p) - np.array(shape["half_extents"], dtype=float))


def _cylinder_points(shape: Shape, p: Array) -> Array:
    beyond = [np.hypot(p[:, 0], p[:, 1]) - shape["radius"], np.abs(p[:, 2]) - shape["half_length"]]
    return _outside(np.stack(beyond, axis=1))


def _by_sections(points: Callable[[Shape, Array], Array]) -> Callable[..., Array]:
    """Make a distance of segments from that of points by golden sections, as it is convex."""

    def segments(shape: Shape, a: Array, b: Array) -> Array:
        return golden_minimum(lambda s: points(shape, a + s[:, None] * (b - a)), len(a))

    return segments


def _box_segments(shape: Shape, a: Array, b: Array) -> Array:
    """Return distances of segments to a box: their slope is linear between the box's six planes."""
    half, d = np.array(shape["half_extents"], dtype=float), b - a
    with np.errstate(all="ignore"):
        cuts = np.concatenate([(half - a) / d, (-half - a) / d], axis=1)
    cuts = np.clip(np.where(np.isfinite(cuts), cuts, 0.0), 0.0, 1.0)
    ends = np.broadcast_to([0.0, 1.0], (len(a), 2))
    s = np.sort(np.concatenate([ends, cuts], axis=1), axis=1)
    places = a[:, None] + s[:, :, None] * d[:, None]
    slope = ((places - np.clip(places, -half, half)) * d[:, None]).sum(axis=2)
    k, rows = np.clip((slope <= 0.0).sum(axis=1) - 1, 0, 6), np.arange(len(a))
    first, last = slope[rows, k], slope[rows, k + 1]
    rises = last > first
    share = np.where(rises, -first / np.where(rises, last - first, 1.0), first <= 0.0)
    best = s[rows, k] + np.clip(share, 0.0, 1.0) * (s[rows, k + 1] - s[rows, k])
    gap = _box_points(shape, a + best[:, None] * d)
    deep = np.flatnonzero(gap <= 1e-12)
    if len(deep):
        gap[deep] = _by_sections(_box_points)(shape, a[deep], b[deep])
    return gap


def _axis(shape: Shape) -> tuple[Array, Array]:
    half = np.array([0.0, 0.0, shape.get("half_length", 0.0)])
    return -half, half


def _round_points(shape: Shape, p: Array) -> Array:
    return point_apart(p, *_axis(shape)) - shape["radius"]


def _round_segments(shape: Shape, a: Array, b: Array) -> Array:
    low, high = (np.broadcast_to(end, a.shape) for end in _axis(shape))
    return segments_apart(a, b, low, high) - shape["radius"]


# --- shapes of the plane ---------------------------------------------------------------------

_FLAT = np.array([1.0, 1.0, 0.0])


def _disc_points(shape: Shape, p: Array) -> Array:
    return np.hypot(p[:, 0], p[:, 1]) - shape["radius"]


def _disc_segments(shape: Shape, a: Array, b: Array) -> Array:
    return point_apart(np.zeros(3), a * _FLAT, b * _FLAT) - shape["radius"]


def _corners(shape: Shape) -> tuple[Array, Array]:
    """Return both ends (m, 3) of a polygon's edges."""
    corners = np.array([[x, y, 0.0] for x, y in shape["vertices"]], dtype=float)
    return np.roll(corners, 1, axis=0), corners


def _turned(a: Array, b: Array, c: Array) -> Array:
    """Return twice the areas of triangles a, b, c of the plane."""
    u, v = b - a, c - a
    return u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]


def inside(shape: Shape, p: Array) -> Array:
    """Tell (k,) which points (k, 3) a polygon winds round, by the sum of angles."""
    first, last = _corners(shape)
    u, v = first[:, None] - p, last[:, None] - p
    cross = u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]
    angles = np.arctan2(cross, u[..., 0] * v[..., 0] + u[..., 1] * v[..., 1])
    return np.rint(angles.sum(axis=0) / (2.0 * np.pi)) != 0


def _polygon_points(shape: Shape, p: Array) -> Array:
    p = p * _FLAT
    first, last = _corners(shape)
    edge = point_apart(p, first[:, None], last[:, None]).min(axis=0)
    return np.where(inside(shape, p), -edge, edge)


def _polygon_segments(shape: Shape, a: Array, b: Array) -> Array:
    """Return distances to a filled polygon; inside, the depth in the middle of each crossing."""
    a, b = a * _FLAT, b * _FLAT
    first, last = (corner[:, None] for corner in _corners(shape))
    wide = np.broadcast_shapes(first.shape, a.shape)
    gap = segments_apart(*(np.broadcast_to(x, wide) for x in (a, b, first, last))).min(axis=0)
    near = np.flatnonzero((gap < 1e-9) | inside(shape, a))
    for k in near:
        gap[k] = min(gap[k], _depth(shape, a[k], b[k], first[:, 0], last[:, 0]))
    return gap


def _depth(shape: Shape, a: Array, b: Array, first: Array, last: Array) -> float:
    """Return the least signed distance in the middles between a segment's crossings of edges."""
    along, edge = _turned(first, last, a), _turned(first, last, b)
    with np.errstate(all="ignore"):
        cuts = along / (along - edge)
    cuts = np.sort(np.concatenate([[0.0, 1.0], cuts[(cuts > 0.0) & (cuts < 1.0)]]))
    s = np.concatenate([cuts, 0.5 * (cuts[1:] + cuts[:-1])])
    return float(_polygon_points(shape, a + s[:, None] * (b - a)).min())


_SURFACE = Solid(
    surfaces.points, surfaces.segments, lambda shape: shape["ball"], surfaces.ready, centred=False
)
SOLIDS = {
    "sphere": Solid(_round_points, _round_segments, lambda shape: shape["radius"]),
    "capsule": Solid(
        _round_points, _round_segments, lambda shape: shape["radius"] + shape["half_length"]
    ),
    "box": Solid(_box_points, _box_segments, lambda shape: math.hypot(*shape["half_extents"])),
    "cylinder": Solid(
        _cylinder_points,
        _by_sections(_cylinder_points),
        lambda shape: math.hypot(shape["radius"], shape["half_length"]),
    ),
    "disc": Solid(_disc_points, _disc_segments, lambda shape: shape["radius"]),
    "polygon": Solid(
        _polygon_points,
        _polygon_segments,
        lambda s: max(math.hypot(*v) for v in s["vertices"]),
        centred=False,
    ),
    **dict.fromkeys(("cloud", "mesh"), _SURFACE),
}
"""Functions by kind of shape."""
