"""Capsules along the z axis of the body; their sizes are the radius and half of the length."""

from __future__ import annotations

import numpy as np

from gcm_learn.compiled import njit
from gcm_learn.scene.bodies import CAPSULE, SIZE
from gcm_learn.scene.shapes import cylinder
from gcm_learn.scene.shapes.ball import ball_cut
from gcm_learn.scene.shapes.region import ShapeEntry

ENTRY = ShapeEntry(CAPSULE, lambda shape: (shape.radius, shape.half_length, 0.0), is_round=True)


@njit(_nrt=False, forceinline=True)
def gap(bodies, b, x, y, z):
    """Signed distance of a point, negative inside."""
    w = max(abs(z) - bodies.rows[b, SIZE + 1], 0.0)
    return np.sqrt(x * x + y * y + w * w) - bodies.rows[b, SIZE]


@njit(_nrt=False, forceinline=True)
def gap_of_bone(bodies, b, p, q):
    """Distance of the segment p-q, 0 when they meet."""
    return max(_off_axis(p, q, bodies.rows[b, SIZE + 1]) - bodies.rows[b, SIZE], 0.0)


@njit(_nrt=False)
def _off_axis(p, q, half_length):
    """Distance of segment p-q to the segment of the z axis between -half_length and half_length."""
    dx, dy, dz = q[0] - p[0], q[1] - p[1], q[2] - p[2]
    a = dx * dx + dy * dy + dz * dz
    flat = dx * dx + dy * dy
    s = 0.0
    if flat > 1e-18 * a and a > 0.0:
        # Nearest points of the two lines; the z coordinate is clamped, then s follows from it.
        s = min(max(-(p[0] * dx + p[1] * dy) / flat, 0.0), 1.0)
    z = min(max(p[2] + s * dz, -half_length), half_length)
    if a > 0.0:
        s = min(max(-(p[0] * dx + p[1] * dy + (p[2] - z) * dz) / a, 0.0), 1.0)
    z = min(max(p[2] + s * dz, -half_length), half_length)
    x, y, w = p[0] + s * dx, p[1] + s * dy, p[2] + s * dz - z
    return np.sqrt(x * x + y * y + w * w)


@njit(_nrt=False)
def from_nearest(bodies, b, x, y, z):
    """Vector (3) from the nearest point to a point; 0 from inside."""
    radius, length = bodies.rows[b, SIZE], bodies.rows[b, SIZE + 1]
    dz = z - min(max(z, -length), length)
    far = np.sqrt(x * x + y * y + dz * dz)
    out = max(far - radius, 0.0) / max(far, 1e-300)
    return out * x, out * y, out * dz


@njit(_nrt=False)
def inner_radius(bodies, b):
    """Radius of the largest ball about the centre inside."""
    return bodies.rows[b, SIZE]


@njit(_nrt=False)
def long_axis(bodies, b):
    """Longest axis (3), as long as half of the capsule's segment."""
    return 0.0, 0.0, bodies.rows[b, SIZE + 1]


@njit(_nrt=False)
def cut(bodies, poses, b, made):
    """Cut a capsule with the plane z = 0: the cuts of a cylinder and of both end balls."""
    radius, half = bodies.rows[b, SIZE], bodies.rows[b, SIZE + 1]
    discs, corners = cylinder.cut(bodies, poses, b, made)
    x, y, z = half * poses[b, 5], half * poses[b, 8], half * poses[b, 11]
    px, py, pz = poses[b, 0], poses[b, 1], poses[b, 2]
    discs = ball_cut(made.discs, discs, radius, px - x, py - y, pz - z)
    return ball_cut(made.discs, discs, radius, px + x, py + y, pz + z), corners
