"""Shapes of bodies, in the body's own frame; lengths in forearm lengths."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, fields
from fractions import Fraction
from typing import Any, ClassVar

import numpy as np
from numba.extending import register_jitable

from gcm_learn.checks import positive, positive_vector, put, sequence, vector
from gcm_learn.compiled import njit
from gcm_learn.errors import SituationError
from gcm_learn.situation.surfaces import SURFACES, SurfaceShape

Point = tuple[float, float]

# A determinant of rounded products has the right sign beyond this share of their sum
# (Shewchuk 1997, "ccwerrboundA"); the second number covers products that underflow.
_ROUNDING = 3.3306690738754716e-16
_UNDERFLOW = 1e-290


@register_jitable
def _sure_orientation(ax: float, ay: float, bx: float, by: float, cx: float, cy: float) -> int:
    """Return `orientation` where rounding leaves no doubt, else 0."""
    left = (ax - cx) * (by - cy)
    right = (ay - cy) * (bx - cx)
    turn = left - right
    if abs(turn) > _ROUNDING * (abs(left) + abs(right)) + _UNDERFLOW:
        return 1 if turn > 0.0 else -1
    return 0


def orientation(a: Point, b: Point, c: Point) -> int:
    """Return 1 when a, b, c turn left, -1 when they turn right, 0 when they are in line."""
    return _sure_orientation(*a, *b, *c) or _exact_orientation(a, b, c)


def _exact_orientation(a: Point, b: Point, c: Point) -> int:
    """Return `orientation` in rational arithmetic."""
    if a[0] == b[0] == c[0] or a[1] == b[1] == c[1]:
        return 0
    ax, ay, bx, by, cx, cy = (Fraction(value) for value in (*a, *b, *c))
    turn = (ax - cx) * (by - cy) - (ay - cy) * (bx - cx)
    return (turn > 0) - (turn < 0)


def check_polygon(vertices: list[Point], field: str) -> None:
    """Refuse a polygon that is not simple and counter-clockwise.

    Parameters
    ----------
    vertices : list of (float, float)
        Finite corners; the last is joined to the first.
    field : str
        What errors call the list.
    """
    count = len(vertices)
    if count < 3:
        raise SituationError(field, f"must have at least 3 points (got {count})")
    if _surely_convex(vertices):  # most are: spare the questions for the others
        return
    for k in range(count):
        if vertices[k] == vertices[(k + 1) % count]:
            reason = f"point {(k + 1) % count} repeats point {k}: {vertices[k]}"
            raise SituationError(field, reason)
    if all(orientation(vertices[0], vertices[1], other) == 0 for other in vertices[2:]):
        raise SituationError(field, f"the {count} points lie in line and enclose no area")
    _check_spikes(vertices, field)
    _check_crossings(vertices, field)
    _check_direction(vertices, field)


def _surely_convex(vertices: list[Point]) -> bool:
    """Return whether a polygon surely turns left at every corner, and in all of them once round.

    Edges that turn left by less than half a turn each point to the right again, after having
    pointed to the left, once in every turn.
    """
    rounds = 0
    for k in range(len(vertices)):
        (ax, ay), (bx, by), (cx, cy) = vertices[k - 2], vertices[k - 1], vertices[k]
        if _sure_orientation(ax, ay, bx, by, cx, cy) <= 0:
            return False
        rounds += bx < ax and cx >= bx
    return rounds == 1


def _check_spikes(vertices: list[Point], field: str) -> None:
    """Refuse an edge that runs back along the edge before it."""
    for k in range(len(vertices)):
        before, corner, after = vertices[k - 2], vertices[k - 1], vertices[k]
        if orientation(before, corner, after) == 0 and not _between(before, corner, after):
            index = (k - 1) % len(vertices)
            raise SituationError(field, f"the edges at point {index} {corner} overlap")


def _between(a: Point, b: Point, c: Point) -> bool:
    """Return whether b lies between a and c, given that all are in line and differ from b."""
    return (a[0] - b[0] < 0) == (b[0] - c[0] < 0) and (a[1] - b[1] < 0) == (b[1] - c[1] < 0)


def _check_crossings(vertices: list[Point], field: str) -> None:
    """Refuse two edges that are not neighbours and share a point."""
    count = len(vertices)
    edges = np.array([(*vertices[k], *vertices[k + 1 - count]) for k in range(count)])
    order = np.argsort(np.minimum(edges[:, 0], edges[:, 2]), kind="stable")
    pair = _next_suspects(edges, order, 0, 0)
    while pair[0] < count:
        first, second = sorted(int(order[k]) for k in pair)
        if _meet(vertices, first, second):
            raise SituationError(field, f"edges {first} and {second} of {count} cross or touch")
        pair = _next_suspects(edges, order, *pair)


@njit
def _next_suspects(edges: np.ndarray, order: np.ndarray, i: int, j: int) -> tuple[int, int]:
    """Return the next places in `order` after (i, j), i < j, whose edges may touch.

    The order is by smaller x: as soon as one edge begins beyond an earlier one, so do all others.
    Returns (n, n) when there are no more.
    """
    count = order.size
    while i < count:
        ax, ay, bx, by = edges[order[i]]
        for k in range(max(i, j) + 1, count):
            cx, cy, dx, dy = edges[order[k]]
            if min(cx, dx) > max(ax, bx):
                break
            if min(cy, dy) > max(ay, by) or max(cy, dy) < min(ay, by):
                continue
            if abs(order[i] - order[k]) in (1, count - 1):
                continue
            sides = _sure_orientation(ax, ay, bx, by, cx, cy)
            sides *= _sure_orientation(ax, ay, bx, by, dx, dy)
            if sides > 0:
                continue
            sides = _sure_orientation(cx, cy, dx, dy, ax, ay)
            sides *= _sure_orientation(cx, cy, dx, dy, bx, by)
            if sides <= 0:
                return i, k
        i, j = i + 1, 0
    return count, count


def _meet(vertices: list[Point], first: int, second: int) -> bool:
    """Return whether two edges whose boxes overlap have a point in common."""
    a, b = vertices[first], vertices[first + 1]
    c, d = vertices[second], vertices[(second + 1) % len(vertices)]
    # in overlapping boxes, segments that are in line with each other overlap as well
    return (
        orientation(a, b, c) * orientation(a, b, d) <= 0
        and orientation(c, d, a) * orientation(c, d, b) <= 0
    )


def _check_direction(vertices: list[Point], field: str) -> None:
    """Refuse a clockwise simple polygon: there the lowest left corner turns right."""
    k = min(range(len(vertices)), key=vertices.__getitem__)
    corner = (vertices[k - 1], vertices[k], vertices[(k + 1) % len(vertices)])
    if orientation(*corner) < 0:
        raise SituationError(field, "the points run clockwise, not counter-clockwise")


@dataclass(frozen=True)
class Disc:
    """A filled circle around the body's origin.

    Parameters
    ----------
    radius : float
        Above zero.
    """

    radius: float

    kind: ClassVar[str] = "disc"

    def __post_init__(self) -> None:
        """Check the documented range."""
        put(self, "radius", positive(self.radius, "radius"))

    @property
    def bounding_radius(self) -> float:
        """Distance from the body's origin to its farthest point."""
        return self.radius


@dataclass(frozen=True)
class Polygon:
    """A filled simple polygon, convex or not. It has no crossings, contacts or spikes.

    Parameters
    ----------
    vertices : tuple of (float, float)
        At least three corners, counter-clockwise; the last is joined to the first.
    """

    vertices: tuple[tuple[float, float], ...]

    kind: ClassVar[str] = "polygon"

    def __post_init__(self) -> None:
        """Check that the vertices are a simple counter-clockwise polygon."""
        corners = []
        for k, corner in enumerate(sequence(self.vertices, "vertices", "points")):
            x, y = vector(corner, f"vertices[{k}]", 2)
            corners.append((x, y))
        check_polygon(corners, "vertices")
        put(self, "vertices", tuple(corners))

    @property
    def bounding_radius(self) -> float:
        """Distance from the body's origin to its farthest point."""
        return max(math.hypot(x, y) for x, y in self.vertices)


@dataclass(frozen=True)
class Sphere:
    """A ball around the body's origin.

    Parameters
    ----------
    radius : float
        Above zero.
    """

    radius: float

    kind: ClassVar[str] = "sphere"

    def __post_init__(self) -> None:
        """Check the documented range."""
        put(self, "radius", positive(self.radius, "radius"))

    @property
    def bounding_radius(self) -> float:
        """Distance from the body's origin to its farthest point."""
        return self.radius


@dataclass(frozen=True)
class Box:
    """A cuboid whose centre is the body's origin and whose edges follow the body's axes.

    Parameters
    ----------
    half_extents : (3,) tuple of float
        Half of the edge lengths along x, y and z, each above zero.
    """

    half_extents: tuple[float, float, float]

    kind: ClassVar[str] = "box"

    def __post_init__(self) -> None:
        """Check the documented range."""
        put(self, "half_extents", positive_vector(self.half_extents, "half_extents", 3))

    @property
    def bounding_radius(self) -> float:
        """Distance from the body's origin to its farthest point."""
        return math.hypot(*self.half_extents)


@dataclass(frozen=True)
class Capsule:
    """All points within `radius` of a segment on the body's z axis.

    Parameters
    ----------
    radius : float
        Above zero.
    half_length : float
        Half of the segment's length, above zero; the solid reaches `radius` farther.
    """

    radius: float
    half_length: float

    kind: ClassVar[str] = "capsule"

    def __post_init__(self) -> None:
        """Check the documented ranges."""
        put(self, "radius", positive(self.radius, "radius"))
        put(self, "half_length", positive(self.half_length, "half_length"))

    @property
    def bounding_radius(self) -> float:
        """Distance from the body's origin to its farthest point."""
        return self.half_length + self.radius


@dataclass(frozen=True)
class Cylinder:
    """A circular cylinder along the body's z axis.

    Parameters
    ----------
    radius : float
        Above zero.
    half_length : float
        Half of its height, above zero.
    """

    radius: float
    half_length: float

    kind: ClassVar[str] = "cylinder"

    def __post_init__(self) -> None:
        """Check the documented ranges."""
        put(self, "radius", positive(self.radius, "radius"))
        put(self, "half_length", positive(self.half_length, "half_length"))

    @property
    def bounding_radius(self) -> float:
        """Distance from the body's origin to its farthest point."""
        return math.hypot(self.radius, self.half_length)


PlanarShape = Disc | Polygon
SolidShape = Sphere | Box | Capsule | Cylinder
SpaceShape = SolidShape | SurfaceShape
Shape = PlanarShape | SpaceShape

PLANAR = (Disc, Polygon)
SOLID = (Sphere, Box, Capsule, Cylinder)
SPACE = SOLID + SURFACES
"""Shapes of bodies in space."""


def numbers_of(shape: Shape) -> list[float]:
    """Return the numbers of a shape, in the order of its fields."""
    return list(_flat(tuple(getattr(shape, field.name) for field in fields(shape))))


def _flat(value: Any) -> Iterator[float]:
    """Yield the numbers of nested tuples and of arrays."""
    if isinstance(value, np.ndarray):
        yield from value.ravel().tolist()
    elif isinstance(value, tuple):
        for part in value:
            yield from _flat(part)
    else:
        yield value
