"""Discs and balls: all points within a radius of the centre, in the plane or in space."""

from __future__ import annotations

import numpy as np

from gcm_learn.compiled import njit
from gcm_learn.scene.bodies import DISC, SIZE, SPHERE
from gcm_learn.scene.shapes.region import EMPTY_DISTANCE, ShapeEntry

DISC_ENTRY = ShapeEntry(DISC, lambda disc: (disc.radius, 0.0, 0.0), is_ball=True, is_round=True)
SPHERE_ENTRY = ShapeEntry(
    SPHERE, lambda sphere: (sphere.radius, 0.0, 0.0), is_ball=True, is_round=True
)


@njit(_nrt=False, forceinline=True)
def off_bone(px, py, pz, dx, dy, dz):
    """Distance of the point p to the segment from the origin to d."""
    length2 = dx * dx + dy * dy + dz * dz
    s = 0.0
    if length2 > 0.0:
        s = min(max((px * dx + py * dy + pz * dz) / length2, 0.0), 1.0)
    x, y, z = px - s * dx, py - s * dy, pz - s * dz
    return np.sqrt(x * x + y * y + z * z)


@njit(_nrt=False, forceinline=True)
def gap(bodies, b, x, y, z):
    """Signed distance of a point, negative inside."""
    return np.sqrt(x * x + y * y + z * z) - bodies.rows[b, SIZE]


@njit(_nrt=False)
def gap_of_bone(bodies, b, p, q):
    """Distance of the segment p-q, 0 when they meet."""
    away = off_bone(-p[0], -p[1], -p[2], q[0] - p[0], q[1] - p[1], q[2] - p[2])
    return max(away - bodies.rows[b, SIZE], 0.0)


@njit(_nrt=False)
def from_nearest(bodies, b, x, y, z):
    """Vector (3) from the nearest point to a point; 0 from inside."""
    far = np.sqrt(x * x + y * y + z * z)
    out = max(far - bodies.rows[b, SIZE], 0.0) / max(far, 1e-300)
    return out * x, out * y, out * z


@njit(_nrt=False)
def inner_radius(bodies, b):
    """Radius of the largest ball about the centre inside."""
    return bodies.rows[b, SIZE]


@njit(_nrt=False)
def long_axis(bodies, b):
    """Longest axis (3): none."""
    return 0.0, 0.0, 0.0


@njit(_nrt=False)
def gap_in_plane(bodies, poses, b, x, y):
    """Signed distance of the point (x, y) to the disc in the plane; `EMPTY_DISTANCE` if none."""
    radius = bodies.rows[b, SIZE]
    dx, dy = x - poses[b, 0], y - poses[b, 1]
    left = radius * radius - poses[b, 2] ** 2
    return np.sqrt(dx * dx + dy * dy) - np.sqrt(left) if left >= 0.0 else EMPTY_DISTANCE


@njit(_nrt=False)
def cut(bodies, poses, b, made):
    """Cut a ball with the plane z = 0: one disc, or none."""
    x, y, z = poses[b, 0], poses[b, 1], poses[b, 2]
    return ball_cut(made.discs, 0, bodies.rows[b, SIZE], x, y, z), 0


@njit(_nrt=False)
def ball_cut(discs, k, radius, x, y, z):
    """Write the disc that the plane cuts from a ball into row k; returns the next free row."""
    height = abs(z)
    if height > radius:
        return k
    discs[k, 0], discs[k, 1] = x, y
    discs[k, 2] = np.sqrt((radius - height) * (radius + height))
    return k + 1
