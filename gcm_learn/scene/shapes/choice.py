"""Kernels for bodies of any shape; only this file branches on a body's shape.

Points are in the body's own frame unless a pose is given. A table has the packing of each shape.
"""

from __future__ import annotations

from gcm_learn.compiled import njit
from gcm_learn.scene.bodies import BALL, BOX, CAPSULE, CLOUD, CYLINDER, KIND, MESH, POLYGON
from gcm_learn.scene.shapes import ball, box, capsule, cloud, cylinder, mesh, polygon
from gcm_learn.scene.shapes.region import ShapeEntry, new_cut, region_distance
from gcm_learn.situation import Box, Capsule, Cloud, Cylinder, Disc, Mesh, Polygon, Shape, Sphere


@njit(_nrt=False)
def gap(bodies, b, x, y, z):
    """Signed distance of a point to body b, negative inside."""
    kind = bodies.rows[b, KIND]
    if kind == BOX:
        return box.gap(bodies, b, x, y, z)
    if kind == CAPSULE:
        return capsule.gap(bodies, b, x, y, z)
    if kind == CYLINDER:
        return cylinder.gap(bodies, b, x, y, z)
    if kind == POLYGON:
        return polygon.gap(bodies, b, x, y, z)
    if kind == CLOUD:
        return cloud.gap(bodies, b, x, y, z)
    if kind == MESH:
        return mesh.gap(bodies, b, x, y, z)
    return ball.gap(bodies, b, x, y, z)


@njit(_nrt=False, forceinline=True)
def gap_of_bone(bodies, b, p, q, near, far):
    """Distance of the segment p-q to body b, 0 when they meet; p and q are tuples of 3 floats.

    The answer is exact up to `near`. Above that it may be too large, but is at most `far` if the
    distance is. An answer above `far` says only that the distance is above `far`.
    """
    kind = bodies.rows[b, KIND]
    if kind == POLYGON:
        return polygon.gap_of_bone(bodies, b, p, q)
    if kind == BOX:
        return box.gap_of_bone(bodies, b, p, q)
    if kind == CAPSULE:
        return capsule.gap_of_bone(bodies, b, p, q)
    if kind == CYLINDER:
        return cylinder.gap_of_bone(bodies, b, p, q)
    if kind == CLOUD:
        return cloud.gap_of_bone(bodies, b, p, q, near, far)
    if kind == MESH:
        return mesh.gap_of_bone(bodies, b, p, q, near, far)
    return ball.gap_of_bone(bodies, b, p, q)


@njit(_nrt=False)
def part_near(bodies, b, p, q):
    """Row of the convex part of body b nearest to the segment p-q; -1 for the whole body."""
    kind = bodies.rows[b, KIND]
    if kind == CLOUD:
        return cloud.part_near(bodies, b, p, q)
    return mesh.part_near(bodies, b, p, q) if kind == MESH else -1


@njit(_nrt=False)
def from_nearest(bodies, b, part, x, y, z):
    """Vector (3) from the nearest point of a part of solid b to a point; 0 from inside."""
    kind = bodies.rows[b, KIND]
    if kind == BOX:
        return box.from_nearest(bodies, b, x, y, z)
    if kind == CAPSULE:
        return capsule.from_nearest(bodies, b, x, y, z)
    if kind == CYLINDER:
        return cylinder.from_nearest(bodies, b, x, y, z)
    if kind == CLOUD:
        return cloud.from_nearest(bodies, b, part, x, y, z)
    if kind == MESH:
        return mesh.from_nearest(bodies, b, part, x, y, z)
    return ball.from_nearest(bodies, b, x, y, z)


@njit(_nrt=False, forceinline=True)
def is_convex(bodies, b):
    """Return whether body b is convex, so that a point's distance is convex in its position."""
    kind = bodies.rows[b, KIND]
    return kind != POLYGON and kind != CLOUD and kind != MESH


@njit(_nrt=False)
def inner_radius(bodies, b):
    """Radius of the largest ball about the centre of solid b that lies inside b."""
    kind = bodies.rows[b, KIND]
    if kind == BOX:
        return box.inner_radius(bodies, b)
    if kind == CAPSULE:
        return capsule.inner_radius(bodies, b)
    if kind == CYLINDER:
        return cylinder.inner_radius(bodies, b)
    return ball.inner_radius(bodies, b)


@njit(_nrt=False)
def long_axis(bodies, b):
    """Longest axis (3) of body b, as long as the body is longer than wide."""
    kind = bodies.rows[b, KIND]
    if kind == BOX:
        return box.long_axis(bodies, b)
    if kind == CAPSULE:
        return capsule.long_axis(bodies, b)
    if kind == CYLINDER:
        return cylinder.long_axis(bodies, b)
    if kind == POLYGON:
        return polygon.long_axis(bodies, b)
    if kind == CLOUD:
        return cloud.long_axis(bodies, b)
    if kind == MESH:
        return mesh.long_axis(bodies, b)
    return ball.long_axis(bodies, b)


@njit(_nrt=False)
def cut(bodies, poses, b, made):
    """Cut solid b at its pose with the plane z = 0.

    Parameters
    ----------
    poses : (n, 12) ndarray
        In arm-plane coordinates; capsules and cylinders lie along the last column of the rotation.
    made : Cut
        Filled.

    Returns
    -------
    discs : int
        A plane that touches a ball gives radius 0.
    corners : int
        0 when there is no polygon, and 1 or 2 (or no area) when the plane only touches the solid.
    """
    kind = bodies.rows[b, KIND]
    if kind == BOX:
        return box.cut(bodies, poses, b, made)
    if kind == CYLINDER:
        return cylinder.cut(bodies, poses, b, made)
    if kind == CAPSULE:
        return capsule.cut(bodies, poses, b, made)
    return ball.cut(bodies, poses, b, made)


@njit
def gap_in_plane(bodies, poses, b, x, y):
    """Signed distance of the point (x, y) to body b's region of the arm's plane.

    `EMPTY_DISTANCE` if the region is empty. The region of a solid is its cut with the plane.
    """
    if bodies.rows[b, BALL] > 0.0:
        return ball.gap_in_plane(bodies, poses, b, x, y)
    if bodies.rows[b, KIND] == POLYGON:
        dx, dy = x - poses[b, 0], y - poses[b, 1]
        c, s = poses[b, 3], poses[b, 6]
        return polygon.gap(bodies, b, c * dx + s * dy, -s * dx + c * dy, 0.0)
    made = new_cut()
    discs, corners = cut(bodies, poses, b, made)
    return region_distance(x, y, made, discs, corners)


ENTRIES: dict[type, ShapeEntry] = {
    Disc: ball.DISC_ENTRY,
    Polygon: polygon.ENTRY,
    Sphere: ball.SPHERE_ENTRY,
    Box: box.ENTRY,
    Capsule: capsule.ENTRY,
    Cylinder: cylinder.ENTRY,
    Cloud: cloud.ENTRY,
    Mesh: mesh.ENTRY,
}


def entry_of(shape: Shape) -> ShapeEntry:
    """Return the entry of a shape."""
    return ENTRIES[type(shape)]
