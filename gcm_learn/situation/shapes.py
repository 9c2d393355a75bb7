"""Shapes of bodies, in the body's own frame; lengths in forearm lengths."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, fields
from typing import Any, ClassVar

from gcm_learn.checks import positive, positive_vector, put, sequence, vector
from gcm_learn.situation.polygons import check_polygon


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
Shape = PlanarShape | SolidShape

PLANAR = (Disc, Polygon)
SOLID = (Sphere, Box, Capsule, Cylinder)


def numbers_of(shape: Shape) -> list[float]:
    """Return the numbers of a shape, in the order of its fields."""
    return list(_flat(tuple(getattr(shape, field.name) for field in fields(shape))))


def _flat(value: float | tuple[Any, ...]) -> Iterator[float]:
    """Yield the numbers of nested tuples."""
    if isinstance(value, tuple):
        for part in value:
            yield from _flat(part)
    else:
        yield value
