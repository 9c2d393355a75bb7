"""Distances of points and segments to bodies of any shape, at their poses."""

from __future__ import annotations

from gcm_learn.compiled import njit
from gcm_learn.scene.bodies import BALL
from gcm_learn.scene.shapes.ball import gap as gap_of_ball
from gcm_learn.scene.shapes.choice import gap, gap_of_bone


@njit(_nrt=False, forceinline=True)
def to_body(bodies, poses, b, x, y, z):
    """Coordinates of a point in body b's frame, which is not turned for balls."""
    dx, dy, dz = x - poses[b, 0], y - poses[b, 1], z - poses[b, 2]
    if bodies.rows[b, BALL] > 0.0:  # its pose has no turn
        return dx, dy, dz
    return (
        poses[b, 3] * dx + poses[b, 6] * dy + poses[b, 9] * dz,
        poses[b, 4] * dx + poses[b, 7] * dy + poses[b, 10] * dz,
        poses[b, 5] * dx + poses[b, 8] * dy + poses[b, 11] * dz,
    )


@njit(_nrt=False)
def bone_distance(bodies, poses, b, p, q):
    """Distance of the segment p-q to body b at its pose; 0 when they meet."""
    p = to_body(bodies, poses, b, p[0], p[1], p[2])
    q = to_body(bodies, poses, b, q[0], q[1], q[2])
    return gap_of_bone(bodies, b, p, q)


@njit(_nrt=False)
def _turned_distance(bodies, poses, b, x, y, z):
    """Signed distance of the point (x, y, z) to body b, whose pose has a turn."""
    x, y, z = to_body(bodies, poses, b, x, y, z)
    return gap(bodies, b, x, y, z)


@njit(_nrt=False, forceinline=True)
def point_distance(bodies, poses, b, x, y, z):
    """Signed distance of the point (x, y, z) to body b at its pose, negative inside."""
    if bodies.rows[b, BALL] > 0.0:  # most targets, for which calls would take as long again
        return gap_of_ball(bodies, b, x - poses[b, 0], y - poses[b, 1], z - poses[b, 2])
    return _turned_distance(bodies, poses, b, x, y, z)
