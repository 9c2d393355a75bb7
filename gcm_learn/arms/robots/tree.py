"""Robots as files describe them: a tree of links and joints, with convex parts for collisions."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

FAR = 5.0
"""A link longer than this many times the distances of its joints may have a wrong unit."""
CLOSE = 1e-6  # shorter distances are rounding
CORNERS = 24
"""Corners of the polygons that stand for circles; they lie outside of the circle."""


class Hull(NamedTuple):
    """Convex hull of balls: a part of a link, or a piece of a part cut by planes."""

    balls: np.ndarray  # (n, 4): centres and radii
    link: int = -1
    """Number of the link, once that is known."""

    @property
    def centres(self) -> np.ndarray:
        """(n, 3)"""
        return self.balls[:, :3]

    @property
    def radii(self) -> np.ndarray:
        """(n,)"""
        return self.balls[:, 3]

    def moved(self, transform: np.ndarray) -> Hull:
        """Return the hull in another frame.

        Parameters
        ----------
        transform : (4, 4) ndarray
            Pose of the present frame in the other one.
        """
        there = self.centres @ transform[:3, :3].T + transform[:3, 3]
        return self._replace(balls=np.column_stack([there, self.radii]))


def all_balls(hulls: Sequence[Hull]) -> np.ndarray:
    """Return all balls (n, 4) of parts."""
    return np.concatenate([hull.balls for hull in hulls])


class Inertial(NamedTuple):
    """Mass, centre of mass and inertia of a rigid body."""

    mass: float
    """[kg]"""
    centre: np.ndarray
    """(3,) Centre of mass."""
    inertia: np.ndarray
    """(3, 3) About the centre, along the axes of the frame [kg m^2]."""

    def moved(self, transform: np.ndarray) -> Inertial:
        """Return the same in another frame.

        Parameters
        ----------
        transform : (4, 4) ndarray
            Pose of the present frame in the other one.
        """
        turn = transform[:3, :3]
        centre = turn @ self.centre + transform[:3, 3]
        return Inertial(self.mass, centre, turn @ self.inertia @ turn.T)


def together(parts: Sequence[Inertial]) -> Inertial:
    """Return the combined mass, centre and inertia of bodies fixed to each other."""
    mass = sum(part.mass for part in parts)
    if mass == 0.0:
        return Inertial(0.0, np.zeros(3), sum((p.inertia for p in parts), np.zeros((3, 3))))
    centre = np.array(sum(part.mass * part.centre for part in parts)) / mass
    inertia = np.zeros((3, 3))
    for part in parts:
        x = part.centre - centre
        inertia += part.inertia + part.mass * (x @ x * np.eye(3) - np.outer(x, x))
    return Inertial(mass, centre, inertia)


class RobotLink(NamedTuple):
    """A rigid link."""

    name: str
    hulls: tuple[Hull, ...]
    """Collision geometry; empty where nothing can be hit."""
    inertial: Inertial | None = None
    """Mass in the link's frame, if the file says."""
    looks: bool = False
    """True if the file has geometry that is only to be seen."""

    @property
    def size(self) -> float:
        """Longest edge of the box about the geometry."""
        balls = all_balls(self.hulls) if self.hulls else np.zeros((1, 4))
        ends = [balls[:, :3] - balls[:, 3:], balls[:, :3] + balls[:, 3:]]
        return float(np.ptp(np.concatenate(ends), axis=0).max())


class Drive(NamedTuple):
    """Motor of a joint, as far as the file says."""

    torque: float | None = None
    """The largest [N m, or N]."""
    armature: float = 0.0
    """Inertia of the rotor, as the joint feels it [kg m^2, or kg]."""
    damping: float = 0.0
    """[N m s, or N s/m]"""


class RobotJoint(NamedTuple):
    """A joint between two links."""

    name: str
    type: str
    """fixed, revolute, continuous or prismatic; others are kept as the file names them."""
    parent: str
    child: str
    origin: np.ndarray
    """Pose (4, 4) of the child in the parent's frame, where the joint is 0."""
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    """In the child's frame."""
    range: tuple[float, float] | None = None
    """Lowest and highest value [rad or lengths]."""
    max_speed: float | None = None
    follows: tuple[str, float, float] | None = None
    """Joint that this one follows, and the factor and offset of its value.

    The name does not matter where the factor is 0."""
    drive: Drive = Drive()
    soft: bool = False
    """True if the range is narrower than the file's, by its soft limits."""


class Tie(NamedTuple):
    """Bond of links or joints that no chain can keep."""

    reason: str
    """Line that names it."""
    links: tuple[str, ...] = ()
    joints: tuple[str, ...] = ()


class Robot(NamedTuple):
    """A tree of links."""

    name: str
    links: Mapping[str, RobotLink]
    joints: Sequence[RobotJoint]
    notes: tuple[str, ...] = ()
    """Parts of the file that were left out, a line each."""
    ties: tuple[Tie, ...] = ()
    """Bonds that matter where the chain moves what they hold."""

    def remarks(self, chain: Collection[str]) -> Iterator[str]:
        """Yield remarks: omissions, missing geometry, soft limits on `chain`, doubtful units."""
        yield from self.notes
        seen = [link.name for link in self.links.values() if link.looks and not link.hulls]
        if seen:
            yield f"no collision geometry: {', '.join(seen)}; --visual takes their looks"
        for joint in self.joints:
            if joint.soft and joint.range and joint.name in chain:
                low, high = joint.range
                yield f"{joint.name}: from {low:g} to {high:g} by its soft limits"
        longest = distance(self.joints)
        for link in self.links.values():
            own = distance(j for j in self.joints if link.name in (j.parent, j.child)) or longest
            far = link.size
            if far > max(FAR * own, longest) > 0.0:
                yield f"{link.name}: {far:.3g} long, joints {own:.3g} apart; is the unit right?"


def distance(joints: Iterable[RobotJoint]) -> float:
    """Return the largest distance between a joint and the joint before it."""
    places = (float(np.linalg.norm(joint.origin[:3, 3])) for joint in joints)
    return max((place for place in places if place > CLOSE), default=0.0)


def motion(kind: str, axis: Sequence[float], value: float) -> np.ndarray:
    """Return the child's pose (4, 4) at a joint's value; the identity for a fixed joint."""
    pose = np.eye(4)
    if kind == "prismatic":
        pose[:3, 3] = np.asarray(axis) * value
    elif kind != "fixed":
        pose[:3, :3] = Rotation.from_rotvec(np.asarray(axis) * value).as_matrix()
    return pose


def ball(radius: float) -> Hull:
    """Return a ball about the origin."""
    return Hull(np.array([[0.0, 0.0, 0.0, radius]]))


def capsule(radius: float, half: float) -> Hull:
    """Return a capsule along z with an axis of length 2 `half`."""
    return Hull(np.array([[0.0, 0.0, -half, radius], [0.0, 0.0, half, radius]]))


def cylinder(radius: float, half: float) -> Hull:
    """Return a prism about a cylinder along z, which has twice the height `half`."""
    turn = np.arange(CORNERS) * (2.0 * math.pi / CORNERS)
    rim = radius / math.cos(math.pi / CORNERS) * np.column_stack([np.cos(turn), np.sin(turn)])
    ends = [np.column_stack([rim, np.full(CORNERS, z)]) for z in (-half, half)]
    return corners(np.concatenate(ends))


def box(size: Sequence[float]) -> Hull:
    """Return a box about the origin with edges of the lengths `size` (3)."""
    signs = np.array(np.meshgrid(*[(-0.5, 0.5)] * 3)).reshape(3, -1).T
    return corners(signs * np.asarray(size, float))


def sphere(count: int) -> np.ndarray:
    """Return directions (count, 3), spread evenly (Fibonacci's sphere)."""
    k = np.arange(count) + 0.5
    z, turn = 1.0 - 2.0 * k / count, math.pi * (1.0 + math.sqrt(5.0)) * k
    return np.column_stack([np.sqrt(1.0 - z * z) * f(turn) for f in (np.cos, np.sin)] + [z])


def ellipsoid(half: Sequence[float], count: int = 200) -> Hull:
    """Return a polytope about an ellipsoid with half axes of the lengths `half` (3)."""
    points = sphere(count)
    within = -ConvexHull(points).equations[:, 3].max()
    return corners(points / within * np.asarray(half, float))


def corners(points: np.ndarray) -> Hull:
    """Return the hull of points (n, 3)."""
    return Hull(np.column_stack([points, np.zeros(len(points))]))


def crossings(points: np.ndarray, pairs: np.ndarray, along: np.ndarray) -> np.ndarray:
    """Return where lines between pairs of points (e, 2) cross the plane of zero `along` (n,)."""
    a, b = along[pairs].T
    crossing = a * b < 0.0
    share = (a[crossing] / (a[crossing] - b[crossing]))[:, None]
    first, second = points[pairs[crossing]].transpose(1, 0, 2)
    return np.asarray(first + share * (second - first))


def mesh(vertices: np.ndarray, faces: np.ndarray, slabs: int = 3) -> list[Hull]:
    """Return convex hulls that together contain the volume of a closed triangle mesh.

    The mesh is cut into slabs of equal thickness across its longest direction. A slab's boundary is
    part of the mesh and two plane sections, so the hull of the mesh's points in it holds it.

    Parameters
    ----------
    vertices : (n, 3) ndarray
    faces : (m, 3) ndarray of int
    slabs : int
    """
    middle = vertices.mean(axis=0)
    along = (vertices - middle) @ np.linalg.svd(vertices - middle, full_matrices=False)[2][0]
    pairs = np.unique(
        np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])), axis=0
    )
    edges = np.linspace(along.min(), along.max(), slabs + 1)
    hulls = []
    for low, high in pairwise(edges):
        points = [vertices[(along >= low) & (along <= high)]]
        for plane in (low, high):
            points.append(crossings(vertices, pairs, along - plane))
        inside = np.concatenate(points)
        if len(inside):
            hulls.append(corners(inside))
    return hulls
