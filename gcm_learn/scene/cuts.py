"""Where a solid meets the arm's plane: the cut with z = 0, in arm-plane coordinates.

A cut is a union of discs and one convex polygon, each of which may be missing:

========  =====================================================================================
sphere    a disc
box       the polygon in which the plane meets it, exact
cylinder  an ellipse, or the strip between two lines when the axis lies in the plane, less what
          lies beyond the end faces; a disc when the axis is the plane's normal
capsule   the cylinder's cut and a disc for each of the two end balls
========  =====================================================================================

Ellipse arcs are sampled: vertices lie on the true boundary, so the polygon lies inside the cut
and misses at most `ARC_ERROR` times the radius.
"""

from __future__ import annotations

import math

import numpy as np

from gcm_learn.compiled import njit
from gcm_learn.scene.bodies import BOX, CAPSULE, CYLINDER, SPHERE
from gcm_learn.situation import Box, Capsule, Cylinder, SolidShape, Sphere

ARC_ERROR = 1.9e-4
"""Largest distance of a sampled arc from the true one, in radii (2.6e-4 where 256 vertices are
too few: in whole ellipses more than 50 times longer than wide)."""

EMPTY_DISTANCE = 1e300
"""Distance to a cut that is empty."""

_MOST_NODES = 126  # inner vertices on each half of an ellipse; with the ends, 256 in all
_PARALLEL = 1e-14  # axis in the plane: what the ellipse's curve adds is below rounding
_NORMAL = 1e-12  # axis along the normal: the ellipse is a circle to rounding


@njit
def cut(
    kind: int, size: np.ndarray, centre: np.ndarray, rotation: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Cut a solid with the plane z = 0.

    Parameters
    ----------
    kind : int
        SPHERE, BOX, CAPSULE or CYLINDER of `gcm_learn.scene.bodies`.
    size : (3,) ndarray
        (radius, 0, 0), half extents, or (radius, half length, 0).
    centre : (3,) ndarray
        Of the body, in arm-plane coordinates.
    rotation : (3, 3) ndarray
        Body frame to arm-plane frame; capsules and cylinders lie along the last column.

    Returns
    -------
    discs : (k, 3) ndarray
        x, y and radius; k <= 3. A plane that touches a ball gives radius 0.
    polygon : (m, 2) ndarray
        Convex, counter-clockwise; m = 0 when there is none, and 1 or 2 (or no area) when the
        plane only touches the solid.
    """
    if kind == SPHERE:
        return _ball_cut(size[0], centre), np.empty((0, 2))
    if kind == BOX:
        return np.empty((0, 3)), _box_cut(size, centre, rotation)
    if kind == CYLINDER:
        return _tube_cut(size[0], size[1], centre, rotation)
    if kind == CAPSULE:
        discs, polygon = _tube_cut(size[0], size[1], centre, rotation)
        end = size[1] * rotation[:, 2]
        first, last = _ball_cut(size[0], centre - end), _ball_cut(size[0], centre + end)
        return np.concatenate((discs, first, last)), polygon
    raise ValueError("kind must be SPHERE, BOX, CAPSULE or CYLINDER")


@njit
def _ball_cut(radius: float, centre: np.ndarray) -> np.ndarray:
    """Cut of a ball: (1, 3) disc, or (0, 3)."""
    height = abs(centre[2])
    if height > radius:
        return np.empty((0, 3))
    disc = np.empty((1, 3))
    disc[0, :2] = centre[:2]
    disc[0, 2] = np.sqrt((radius - height) * (radius + height))
    return disc


@njit
def _box_cut(half: np.ndarray, centre: np.ndarray, rotation: np.ndarray) -> np.ndarray:
    """Cut of a box: a square that surely holds it, clipped by the box's six half-spaces."""
    bound = 2.0 * np.sqrt(half[0] ** 2 + half[1] ** 2 + half[2] ** 2)
    polygon = np.array([[-bound, -bound], [bound, -bound], [bound, bound], [-bound, bound]])
    for axis in range(3):
        gx, gy = rotation[0, axis], rotation[1, axis]
        offset = rotation[2, axis] * centre[2]
        polygon = _clip(polygon, gx, gy, half[axis] + offset)
        polygon = _clip(polygon, -gx, -gy, half[axis] - offset)
    return _placed(polygon, centre)


@njit
def _clip(polygon: np.ndarray, gx: float, gy: float, limit: float) -> np.ndarray:
    """Part of a convex polygon where gx x + gy y <= limit (Sutherland and Hodgman)."""
    kept = np.empty((polygon.shape[0] + 2, 2))
    count = 0
    for k in range(polygon.shape[0]):
        a, b = polygon[k - 1], polygon[k]
        over_a = gx * a[0] + gy * a[1] - limit
        over_b = gx * b[0] + gy * b[1] - limit
        if (over_a > 0.0) != (over_b > 0.0):
            kept[count] = a + over_a / (over_a - over_b) * (b - a)
            count += 1
        if over_b <= 0.0:
            kept[count] = b
            count += 1
    return kept[:count]


@njit
def _tube_cut(
    radius: float, half: float, centre: np.ndarray, rotation: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Cut of a cylinder.

    Let u run along the axis' shadow on the plane and w across it, both from the point below the
    centre. With lean and rise the axis' components along u and z, a point of the plane lies
    ``lean u - rise z`` along the axis and ``hypot(w, rise u + lean z)`` off it.
    """
    ax, ay, rise = rotation[0, 2], rotation[1, 2], rotation[2, 2]
    if rise < 0.0:  # the cylinder looks the same from its other end
        ax, ay, rise = -ax, -ay, -rise
    lean = np.hypot(ax, ay)
    no_polygon = np.empty((0, 2))
    if lean <= _NORMAL:
        discs = np.empty((1, 3))
        discs[0] = centre[0], centre[1], radius
        return discs[: 1 if abs(centre[2]) <= half else 0], no_polygon
    low = (rise * centre[2] - half) / lean
    high = (rise * centre[2] + half) / lean
    shift = lean * centre[2]
    if rise > _PARALLEL:
        low = max(low, (-radius - shift) / rise)
        high = min(high, (radius - shift) / rise)
    elif abs(shift) > radius:
        return np.empty((0, 3)), no_polygon
    if low > high:
        return np.empty((0, 3)), no_polygon
    chain = _half_outline(radius, rise, shift, low, high)
    polygon = np.empty((2 * chain.shape[0], 2))
    last = polygon.shape[0] - 1
    for k in range(chain.shape[0]):
        u, w = chain[k]
        polygon[k] = (ax * u + ay * w) / lean, (ay * u - ax * w) / lean
        polygon[last - k] = (ax * u - ay * w) / lean, (ay * u + ax * w) / lean
    return np.empty((0, 3)), _placed(polygon, centre)


@njit
def _half_outline(radius: float, rise: float, shift: float, low: float, high: float) -> np.ndarray:
    """Vertices (u, w), u rising from `low` to `high`, on w^2 + (rise u + shift)^2 = radius^2."""
    ends = np.array([rise * low + shift, rise * high + shift])
    ends = np.minimum(np.maximum(ends / radius, -1.0), 1.0)
    nodes = _arc_nodes(np.arccos(-ends[0]), np.arccos(-ends[1]), rise)
    chain = np.empty((nodes.size + 2, 2))
    chain[0, 0] = low
    count = 1
    for angle in nodes:
        u = (-radius * np.cos(angle) - shift) / rise
        if chain[count - 1, 0] < u < high:
            chain[count, 0] = u
            count += 1
    chain[count, 0] = high
    for k in range(count + 1):
        # the two factors of radius^2 - (rise u + shift)^2; in this order of sums, a plane that all
        # but touches the cylinder does not roughen the outline
        climb = rise * chain[k, 0]
        below, above = (radius + shift) + climb, (radius - shift) - climb
        chain[k, 1] = np.sqrt(max(below, 0.0) * max(above, 0.0))
    return chain[: count + 1]


@njit
def _arc_nodes(start: float, stop: float, rise: float) -> np.ndarray:
    """Angles between `start` and `stop` in [0, pi] at which to put vertices on an ellipse.

    The half axes are 1 (angle pi/2) and 1/rise (angles 0 and pi). Nodes are laid from both ends
    towards the middle, where the ellipse bends least, and spread out if they are too many.
    """
    middle = 0.5 * np.pi
    step = np.sqrt(8.0 * ARC_ERROR)
    while True:
        rising = _march(start, min(stop, middle), rise, step)
        falling = _march(np.pi - stop, min(np.pi - start, middle), rise, step)
        centre = np.full(1 if start < middle < stop else 0, middle)
        nodes = np.concatenate((rising, centre, np.pi - falling[::-1]))
        if nodes.size <= _MOST_NODES:
            return nodes
        step *= 1.01


@njit
def _march(start: float, stop: float, rise: float, step: float) -> np.ndarray:
    """Angles after `start` and before `stop` <= pi/2, so that every chord misses as much.

    A chord over the angle d misses d^2 / (8 s) where s is the ellipse's speed per angle over
    its value at pi/2; s grows from `start` on, so the value at the chord's start is safe.
    """
    nodes = np.empty(2 * _MOST_NODES)
    count = 0
    angle = start
    while count < nodes.size:
        speed = np.hypot(np.sin(angle), rise * np.cos(angle))
        angle += step * np.sqrt(speed)
        if angle >= stop:
            break
        nodes[count] = angle
        count += 1
    return nodes[:count]


@njit
def _placed(polygon: np.ndarray, centre: np.ndarray) -> np.ndarray:
    """Shift a polygon by the centre and drop vertices that repeat the one before them."""
    kept = np.empty_like(polygon)
    count = 0
    for k in range(polygon.shape[0]):
        x, y = polygon[k, 0] + centre[0], polygon[k, 1] + centre[1]
        if count == 0 or x != kept[count - 1, 0] or y != kept[count - 1, 1]:
            kept[count] = x, y
            count += 1
    while count > 1 and kept[0, 0] == kept[count - 1, 0] and kept[0, 1] == kept[count - 1, 1]:
        count -= 1
    return kept[:count]


@njit
def point_polygon_distance(px: float, py: float, vertices: np.ndarray) -> float:
    """Signed distance of a point to a simple polygon, convex or not.

    Parameters
    ----------
    px, py : float
    vertices : (m, 2) ndarray
        In either direction; fewer than three (or no area) mean a segment or a point.

    Returns
    -------
    float
        Negative inside, `EMPTY_DISTANCE` when m = 0.
    """
    best = np.inf
    inside = False
    for k in range(vertices.shape[0]):
        ax, ay = vertices[k - 1, 0], vertices[k - 1, 1]
        dx, dy = vertices[k, 0] - ax, vertices[k, 1] - ay
        wx, wy = px - ax, py - ay
        # compared before any rounding: both edges at a corner must agree on which side it is
        if (ay > py) != (vertices[k, 1] > py) and wx < dx * (wy / dy):
            inside = not inside
        length2 = dx * dx + dy * dy
        if length2 > 0.0:
            share = min(max((wx * dx + wy * dy) / length2, 0.0), 1.0)
            wx -= share * dx
            wy -= share * dy
        best = min(best, np.hypot(wx, wy))
    if vertices.shape[0] == 0:
        return EMPTY_DISTANCE
    return -best if inside else best


@njit
def region_distance(px: float, py: float, discs: np.ndarray, polygon: np.ndarray) -> float:
    """Signed distance of a point to a cut.

    Parameters
    ----------
    px, py : float
    discs : (k, 3) ndarray
    polygon : (m, 2) ndarray
        As `cut` returns them.

    Returns
    -------
    float
        Exact outside; inside it is negative and its magnitude at most the distance to the
        boundary; `EMPTY_DISTANCE` when the cut is empty.
    """
    best = point_polygon_distance(px, py, polygon)
    for k in range(discs.shape[0]):
        best = min(best, np.hypot(px - discs[k, 0], py - discs[k, 1]) - discs[k, 2])
    return best


def cut_outline(
    shape: SolidShape, centre: np.ndarray, rotation: np.ndarray, n: int = 96
) -> np.ndarray:
    """Return the boundary of a solid's cut with z = 0, for figures.

    Parameters
    ----------
    shape : Sphere, Box, Capsule or Cylinder
    centre : (3,) array_like
        In arm-plane coordinates.
    rotation : (3, 3) array_like
        Body frame to arm-plane frame.
    n : int
        Points on every full circle.

    Returns
    -------
    (m, 2) ndarray
        Counter-clockwise, the first point not repeated; (0, 2) when the cut has no area.
    """
    kind, size = _kind_and_size(shape)
    centre, rotation = np.asarray(centre, dtype=float), np.asarray(rotation, dtype=float)
    discs, polygon = cut(kind, size, centre, np.ascontiguousarray(rotation))
    angles = np.arange(n) * (2.0 * math.pi / n)
    circle = np.column_stack((np.cos(angles), np.sin(angles)))
    pieces = [polygon, *(disc[:2] + disc[2] * circle for disc in discs)]
    return _convex_hull(np.concatenate(pieces))


def _kind_and_size(shape: SolidShape) -> tuple[int, np.ndarray]:
    """Return the kernel's name of a shape and its (3,) size."""
    if isinstance(shape, Sphere):
        return SPHERE, np.array([shape.radius, 0.0, 0.0])
    if isinstance(shape, Box):
        return BOX, np.array(shape.half_extents)
    if isinstance(shape, Capsule):
        return CAPSULE, np.array([shape.radius, shape.half_length, 0.0])
    if isinstance(shape, Cylinder):
        return CYLINDER, np.array([shape.radius, shape.half_length, 0.0])
    raise TypeError(f"only solids are cut (got {type(shape).__name__})")


def _convex_hull(points: np.ndarray) -> np.ndarray:
    """Return the corners of the convex hull, counter-clockwise (Andrew's monotone chain)."""
    ordered = [(x, y) for x, y in np.unique(points, axis=0).tolist()]
    hull: list[tuple[float, float]] = []
    for side in (ordered, ordered[::-1]):
        chain: list[tuple[float, float]] = []
        for x, y in side:
            while len(chain) > 1 and _turn(chain[-2], chain[-1], (x, y)) <= 0.0:
                chain.pop()
            chain.append((x, y))
        hull += chain[:-1]
    return np.array(hull if len(hull) > 2 else []).reshape(-1, 2)


def _turn(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> float:
    """Twice the area of the triangle a, b, c; positive when it runs counter-clockwise."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
