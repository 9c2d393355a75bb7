"""Distances of points and segments to solids: boxes, capsules, cylinders and spheres."""

from __future__ import annotations

import numpy as np

from gcm_learn.collision.segments import segment_axis, segment_box, segment_cylinder
from gcm_learn.compiled import njit
from gcm_learn.scene.bodies import BOX, CAPSULE, KIND, SIZE, SPHERE


@njit(_nrt=False)
def to_body(poses, b, x, y, z):
    """Coordinates of a point in body b's frame."""
    dx, dy, dz = x - poses[b, 0], y - poses[b, 1], z - poses[b, 2]
    return (
        poses[b, 3] * dx + poses[b, 6] * dy + poses[b, 9] * dz,
        poses[b, 4] * dx + poses[b, 7] * dy + poses[b, 10] * dz,
        poses[b, 5] * dx + poses[b, 8] * dy + poses[b, 11] * dz,
    )


@njit(_nrt=False)
def solid_distance(bodies, poses, b, p, q):
    """Distance of the segment p-q to box, capsule or cylinder b at its pose; 0 when they meet."""
    kind, radius, length = bodies.rows[b, KIND], bodies.rows[b, SIZE], bodies.rows[b, SIZE + 1]
    p, q = to_body(poses, b, p[0], p[1], p[2]), to_body(poses, b, q[0], q[1], q[2])
    if kind == BOX:
        return segment_box(p, q, (radius, length, bodies.rows[b, SIZE + 2]))
    if kind == CAPSULE:
        return max(segment_axis(p, q, length) - radius, 0.0)
    return segment_cylinder(p, q, radius, length)


@njit(_nrt=False)
def room_in_pose(bodies, b, x, y, z, poses):
    """Signed distance of the point (x, y, z) to the solid of body b where row b of poses has it."""
    rows = bodies.rows
    kind, radius, length = rows[b, KIND], rows[b, SIZE], rows[b, SIZE + 1]
    dx, dy, dz = x - poses[b, 0], y - poses[b, 1], z - poses[b, 2]
    if kind == SPHERE:
        return np.sqrt(dx * dx + dy * dy + dz * dz) - radius
    u = abs(poses[b, 3] * dx + poses[b, 6] * dy + poses[b, 9] * dz)
    v = abs(poses[b, 4] * dx + poses[b, 7] * dy + poses[b, 10] * dz)
    w = abs(poses[b, 5] * dx + poses[b, 8] * dy + poses[b, 11] * dz)
    if kind == CAPSULE:
        w = max(w - length, 0.0)
        return np.sqrt(u * u + v * v + w * w) - radius
    if kind == BOX:
        u, v, w = u - radius, v - length, w - rows[b, SIZE + 2]
    else:  # a cylinder is a box in the half-plane of axis and point
        u, v, w = np.sqrt(u * u + v * v) - radius, -1e300, w - length
    inside = min(max(u, v, w), 0.0)
    u, v, w = max(u, 0.0), max(v, 0.0), max(w, 0.0)
    return np.sqrt(u * u + v * v + w * w) + inside
