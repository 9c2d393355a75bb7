"""Shapes of obstacles that others measured or drew: clouds of balls and meshes of triangles."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property
from hashlib import blake2b
from itertools import chain
from typing import Any, ClassVar

import numpy as np

from gcm_learn.checks import LARGEST, positive, put, sequence, show, vector
from gcm_learn.errors import SituationError


class Surface:
    """Shape with arrays; two shapes of one class are equal if their numbers are."""

    @cached_property
    def _digest(self) -> bytes:
        numbers = [np.asarray(getattr(self, field.name)).tobytes() for field in fields(self)]  # type: ignore[arg-type]
        return blake2b(b"".join(numbers), digest_size=16).digest()

    def __eq__(self, other: object) -> bool:
        if self is other or type(self) is not type(other):
            return self is other
        return self._digest == other._digest  # type: ignore[attr-defined]

    def __hash__(self) -> int:
        return int.from_bytes(self._digest[:8], "little")


@dataclass(frozen=True, eq=False)
class Cloud(Surface):
    """Balls of one radius about many points.

    Parameters
    ----------
    points : (n, 3) array_like
        Centres of the balls, at least one.
    radius : float
        Above zero.
    """

    points: np.ndarray
    radius: float

    kind: ClassVar[str] = "cloud"

    def __post_init__(self) -> None:
        """Check the documented ranges."""
        put(self, "points", _triples(self.points, "points", "points"))
        put(self, "radius", positive(self.radius, "radius"))

    @cached_property
    def bounding_radius(self) -> float:
        """Distance from the body's origin to its farthest point."""
        return float(np.linalg.norm(self.points, axis=1).max()) + self.radius

    @property
    def mirrored(self) -> Cloud:
        """The cloud mirrored in its own xz-plane."""
        return Cloud(self.points * _MIRROR, self.radius)

    def simplified(self, cell: float) -> tuple[Cloud, float]:
        """Return a cloud of fewer balls that contains this cloud.

        Parameters
        ----------
        cell : float
            Edge of the cubes in which points are joined, above zero.

        Returns
        -------
        cloud : Cloud
            One ball for each cube that has points, about their mean. Its radius is larger by
            `grown`.
        grown : float
            Largest distance of a point from the mean of its cube.
        """
        means, cube = _clustered(self.points, cell)
        grown = float(np.linalg.norm(self.points - means[cube], axis=1).max())
        return Cloud(means, self.radius + grown), grown


@dataclass(frozen=True, eq=False)
class Mesh(Surface):
    """A surface of triangles, which has no inside.

    Parameters
    ----------
    vertices : (v, 3) array_like
    triangles : (t, 3) array_like of int
        Indices of vertices, from 0; at least one triangle. One without area is a segment or a
        point.
    """

    vertices: np.ndarray
    triangles: np.ndarray

    kind: ClassVar[str] = "mesh"

    def __post_init__(self) -> None:
        """Check the documented ranges."""
        put(self, "vertices", _triples(self.vertices, "vertices", "points"))
        put(self, "triangles", _triples(self.triangles, "triangles", "triangles", int))
        wrong = np.argwhere((self.triangles < 0) | (self.triangles >= len(self.vertices)))
        if len(wrong):
            k, i = wrong[0]
            reason = f"{self.triangles[k, i]} is no vertex (there are {len(self.vertices)})"
            raise SituationError(f"triangles[{k}][{i}]", reason)

    @cached_property
    def corners(self) -> np.ndarray:
        """Corners (t, 3, 3) of the triangles."""
        return self.vertices[self.triangles]

    @cached_property
    def bounding_radius(self) -> float:
        """Distance from the body's origin to its farthest point."""
        return float(np.linalg.norm(self.corners, axis=2).max())

    @property
    def mirrored(self) -> Mesh:
        """The mesh mirrored in its own xz-plane."""
        return Mesh(self.vertices * _MIRROR, self.triangles)

    def simplified(self, cell: float) -> tuple[Mesh, float]:
        """Return a mesh of fewer triangles.

        Parameters
        ----------
        cell : float
            Edge of the cubes in which vertices are joined, above zero.

        Returns
        -------
        mesh : Mesh
            Its vertices are the means of those in one cube; triangles that become equal
            are one, and those that become sides or corners of others are left out.
        moved : float
            Largest way of a vertex. No point of the surface is farther from the new one: a margin
            of this size makes up for it.
        """
        means, cube = _clustered(self.vertices, cell)
        moved = float(np.linalg.norm(self.vertices - means[cube], axis=1)[self.triangles].max())
        triangles = np.unique(np.sort(cube[self.triangles], axis=1), axis=0)
        flat = (triangles[:, 0] == triangles[:, 1]) | (triangles[:, 1] == triangles[:, 2])
        sides = triangles[~flat][:, [[0, 1], [1, 2], [0, 2]]].reshape(-1, 2) @ (len(means), 1)
        corners = np.unique(triangles[~flat])
        covered = np.isin(triangles[:, [0, 2]] @ (len(means), 1), sides)
        point = triangles[:, 0] == triangles[:, 2]
        covered |= point & np.isin(triangles[:, 0], corners)
        return Mesh(means, triangles[~(flat & covered)]), moved


SurfaceShape = Cloud | Mesh
SURFACES = (Cloud, Mesh)
"""Shapes that only obstacles have."""
_MIRROR = np.array([1.0, -1.0, 1.0])


def _clustered(points: np.ndarray, cell: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the means (m, 3) of points (n, 3) by cubes, and the cube (n,) of each."""
    cell = positive(cell, "cell")
    _, cube = np.unique(np.floor(points / cell), axis=0, return_inverse=True)
    cube = cube.reshape(-1)  # a column in some versions of numpy
    sums = np.stack([np.bincount(cube, weights=column) for column in points.T], axis=1)
    return sums / np.bincount(cube)[:, None], cube


def _triples(value: Any, field: str, content: str, of: type = float) -> np.ndarray:
    """Return rows of three numbers, or of three indices, as a read-only array."""
    if isinstance(value, np.ndarray):
        fits = value.ndim == 2 and value.shape[1] == 3
        fits = fits and value.dtype.kind in ("iu" if of is int else "iuf")
    else:
        rows: Any = sequence(value, field, content)
        fits = all(isinstance(row, list | tuple) and len(row) == 3 for row in rows)
        fits = fits and set(map(type, chain.from_iterable(rows))) <= {int, of}
    if not fits or not _within(value):  # slowly, for the place of what is wrong
        value = [_row(row, f"{field}[{k}]", of) for k, row in enumerate(sequence(value, field, ""))]
    if not len(value):
        raise SituationError(field, f"must have {content} (got none)")
    made: np.ndarray = np.array(value, dtype=of)
    made.flags.writeable = False
    return made


def _within(value: Any) -> bool:
    """Return whether numbers are finite and not absurdly large."""
    try:
        return bool((np.abs(np.asarray(value, dtype=float)) <= LARGEST).all())
    except OverflowError:  # an integer beyond all floats
        return False


def _row(value: Any, field: str, of: type) -> tuple[float, ...]:
    """Return three numbers or indices; an error names the place of the wrong entry."""
    if of is float:
        return vector(value, field, 3)
    items = sequence(value, field, "3 indices")
    for k, item in enumerate(items):
        if isinstance(item, bool) or not isinstance(item, int | np.integer):
            raise SituationError(f"{field}[{k}]", f"must be an index (got {show(item)})")
    return vector(items, field, 3)
