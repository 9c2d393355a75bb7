"""Solids, limbs and paths as faces."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from gcm_learn import situation
from gcm_learn.arms import hands_along, links_along
from gcm_learn.rendering.camera import Faces, normals
from gcm_learn.rendering.shells import FACES, balls, turned
from gcm_learn.rendering.staging import ARM, INK, JOINT, rgb
from gcm_learn.situation import Box, Capsule, Cloud, Cylinder, SpaceShape, Sphere

RINGS = 14  # of a sphere, from pole to pole


def faces(shape: SpaceShape, most: int = FACES) -> np.ndarray:
    """Return the faces of a solid in its own frame.

    Parameters
    ----------
    shape : SpaceShape
    most : int
        Largest number of faces of a cloud, some of whose points are left out if need be.

    Returns
    -------
    (n, 4, 3) ndarray
        Quadrilaterals, counter-clockwise when seen from outside; those of a mesh as they come.
    """
    if type(shape) not in MESHES:
        raise TypeError(f"not a solid shape: {shape!r}")
    return MESHES[type(shape)].faces(shape, most)


def round_normals(shape: SpaceShape, corners: np.ndarray, most: int = FACES) -> np.ndarray | None:
    """Unit normals (n, 4, 3) at the corners of a solid's `faces`; None for flat faces."""
    rounded = MESHES[type(shape)].normals
    return None if rounded is None else rounded(shape, corners, most)


def has_edges(shape: SpaceShape) -> bool:
    """Return whether faces of a solid meet in edges."""
    return MESHES[type(shape)].has_edges


def _cylinder(shape: Cylinder, most: int) -> np.ndarray:
    r, h = shape.radius, shape.half_length
    return turned(np.array([(0.0, -h), (r, -h), (r, h), (0.0, h)]))


def _cylinder_normals(shape: Cylinder, corners: np.ndarray, most: int) -> np.ndarray:
    flat = normals(corners)
    side = np.abs(flat[:, 2]) < 0.5
    axial = corners * (1.0, 1.0, 0.0) / shape.radius
    return np.where(side[:, None, None], axial, flat[:, None])


def _normals_from(half: float, radius: float, corners: np.ndarray) -> np.ndarray:
    """Return normals that point away from a segment of the z axis."""
    core = np.zeros_like(corners)
    core[..., 2] = np.clip(corners[..., 2], -half, half)
    away: np.ndarray = (corners - core) / radius
    return away


@lru_cache(maxsize=256)
def _mesh(shape: SpaceShape, most: int) -> tuple[np.ndarray, np.ndarray | None]:
    corners = faces(shape, most)
    return corners, round_normals(shape, corners, most)


def placed(
    shape: SpaceShape, centre: np.ndarray, turn: np.ndarray, colour: np.ndarray,
    alpha: float = 1.0, scale: float = 1.0, most: int = FACES,
) -> Faces:  # fmt: skip
    """Return the faces of a solid with centre (3,), rotation (3, 3) and colour (3,)."""
    corners, normal = _mesh(shape, most)
    return Faces(
        centre + scale * corners @ turn.T, colour, alpha,
        None if normal is None else normal @ turn.T, both=isinstance(shape, situation.Mesh),
    )  # fmt: skip


def frame_along(z: np.ndarray) -> np.ndarray:
    """Return a rotation (3, 3) whose third column is the unit vector z."""
    x = np.cross(np.eye(3)[np.abs(z).argmin()], z)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def arrow(length: float, tip: float) -> np.ndarray:
    """Return the faces (n, 4, 3) of an arrow along z, whose point is `tip` below the origin."""
    thin, wide, neck = 0.07 * length, 0.17 * length, -tip - 0.45 * length
    low, high = -tip - length, -tip
    return turned(np.array([(0.0, low), (thin, low), (thin, neck), (wide, neck), (0.0, high)]))


def tube(points: np.ndarray, radius: float, sides: int = 6) -> np.ndarray:
    """Faces (n, 4, 3) of a thin tube along a path (k, 3) that nowhere turns back."""
    along = np.gradient(points, axis=0)
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
    u = np.empty_like(along)
    here = np.eye(3)[np.abs(along[0]).argmin()]
    for k, way in enumerate(along):  # the least twist from point to point
        here = here - (here @ way) * way
        here = u[k] = here / max(math.sqrt(here @ here), 1e-12)
    v = np.cross(along, u)
    angle = np.linspace(0.0, 2 * np.pi, sides + 1)[:, None]
    rings = points[:, None] + radius * (np.cos(angle) * u[:, None] + np.sin(angle) * v[:, None])
    a, b = rings[:-1], rings[1:]
    return np.stack([a[:, :-1], a[:, 1:], b[:, 1:], b[:, :-1]], axis=2).reshape(-1, 4, 3)


def _arc(radius: float, half_length: float) -> np.ndarray:
    """Profile (k, 2) of a sphere or capsule: distance from the axis, height; from low to high."""
    angle = np.linspace(-np.pi / 2, np.pi / 2, RINGS + 1)
    points = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)
    lower, upper = points[: RINGS // 2 + 1], points[RINGS // 2 :]
    low, high = lower - (0.0, half_length), upper + (0.0, half_length)
    return np.concatenate([low, high[1:] if half_length == 0.0 else high])


def _box(half: np.ndarray) -> np.ndarray:
    """Faces of a box."""
    out = []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for sign in (-1, 1):
            corners = np.full((4, 3), sign * half[axis])
            corners[:, u] = half[u] * np.array([-1, 1, 1, -1])
            corners[:, v] = half[v] * np.array([-1, -1, 1, 1])
            out.append(corners[::sign])
    return np.array(out)


class Mesh(NamedTuple):
    """Functions that draw a shape, a cloud with at most so many faces."""

    faces: Callable[[Any, int], np.ndarray]
    normals: Callable[[Any, np.ndarray, int], np.ndarray] | None
    has_edges: bool = False


MESHES: dict[type, Mesh] = {
    Box: Mesh(lambda box, most: _box(np.asarray(box.half_extents)), None, has_edges=True),
    Sphere: Mesh(
        lambda ball, most: turned(_arc(ball.radius, 0.0)),
        lambda ball, corners, most: _normals_from(0.0, ball.radius, corners),
    ),
    Capsule: Mesh(
        lambda rod, most: turned(_arc(rod.radius, rod.half_length)),
        lambda rod, corners, most: _normals_from(rod.half_length, rod.radius, corners),
    ),
    Cylinder: Mesh(_cylinder, _cylinder_normals, has_edges=True),
    Cloud: Mesh(
        lambda cloud, most: balls(cloud, most).start,
        lambda cloud, corners, most: balls(cloud, most).outward,
    ),
    situation.Mesh: Mesh(lambda mesh, most: mesh.corners[:, [0, 1, 2, 2]], None, has_edges=True),
}
"""Drawings of solids by shape."""


THINNEST = 0.022  # of the reach: thinner links are drawn so thick
BALL, HAND = 1.12, 1.3  # radii of joints and hand, in those of the links there
TOUCH = 1e-6  # of the reach: ends of links so close together are a joint


class Limb(NamedTuple):
    """Capsules of an arm at k postures, with the places of the hand and the base."""

    ends: np.ndarray
    """(k, m, 2, 3) float: both ends of every link's axis."""
    radii: np.ndarray
    """(m,) float: as drawn."""
    hand: np.ndarray
    """(k, 3) float"""
    base: np.ndarray
    """(3,) float"""


class Ball(NamedTuple):
    """A ball that marks the base, a joint or the hand."""

    name: str
    colour: str
    radius: float
    places: np.ndarray
    """(k, 3) float"""


def limb_along(arm: Any, joints: ArrayLike) -> Limb:
    """Return the capsules of an arm at joint postures (k, n), in the world."""
    ends, radii = links_along(arm, joints)
    drawn = np.maximum(radii, THINNEST * arm.reach)
    return Limb(ends, drawn, hands_along(arm, joints)[0], np.asarray(arm.base.origin))


def arm_faces(arm: Any, joints: ArrayLike, alpha: float = 1.0) -> list[Faces]:
    """Return an arm as capsules, with balls for base, joints and hand.

    Parameters
    ----------
    arm : SpatialArm, Chain or another arm that moves in its joints
    joints : (n,) array_like
        [rad or lengths]
    alpha : float
    """
    return limb_faces(limb_along(arm, np.atleast_2d(joints)), alpha)


def limb_faces(limb: Limb, alpha: float = 1.0) -> list[Faces]:
    """Return the first posture of a limb as capsules and balls."""
    out = []
    for (a, b), radius in zip(limb.ends[0], limb.radii, strict=True):
        turn, half = bone_pose(a, b)
        out.append(placed(bone_shape(radius, half), (a + b) / 2, turn, rgb(ARM), alpha))
    for ball in balls_of(limb):
        shape = Sphere(ball.radius)
        out.append(placed(shape, ball.places[0], np.eye(3), rgb(ball.colour), alpha))
    return out


def bone_pose(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, float]:
    """Return rotation (3, 3) and half the length of a capsule with an axis from a to b."""
    length = float(np.linalg.norm(b - a))
    return (frame_along((b - a) / length) if length > 0.0 else np.eye(3)), length / 2


def bone_shape(radius: float, half_length: float) -> Capsule | Sphere:
    """Return the shape of a link, a ball if its axis is a point."""
    return Capsule(radius, half_length) if half_length > 0.0 else Sphere(radius)


def balls_of(limb: Limb) -> Iterator[Ball]:
    """Yield balls where links meet, at the end nearest to the base, and at the hand."""
    first, size = limb.ends[0], TOUCH + TOUCH * float(np.abs(limb.ends).max())
    foot = divmod(int(np.linalg.norm(first - limb.base, axis=2).argmin()), 2)
    yield Ball("base", INK, BALL * limb.radii[foot[0]], limb.ends[:, foot[0], foot[1]])
    for i in range(len(first)):
        away = np.linalg.norm(first - first[i, 0], axis=2).min(axis=1)
        met = [j for j in range(len(first)) if j != i and away[j] <= size]
        if met and (i, 0) != foot:
            radius = BALL * float(limb.radii[[i, *met]].max())
            yield Ball(f"joint of link {i}", JOINT, radius, limb.ends[:, i, 0])
    last = np.linalg.norm(first - limb.hand[0], axis=2).min(axis=1).argmin()
    yield Ball("hand", ARM, HAND * limb.radii[last], limb.hand)
