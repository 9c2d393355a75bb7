"""Limbs as chains of segments in space: their distances to bodies, and when they are free.

The limb of a planar arm is a chain in z = 0.  Planar bodies, whose z never matters, reach to both
sides of the plane for ever.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.collision.distance import segment_distance
from gcm_learn.collision.segments import segment_axis, segment_box, segment_cylinder
from gcm_learn.compiled import njit
from gcm_learn.scene.bodies import (
    BOX,
    CAPSULE,
    DISC,
    KIND,
    POLYGON,
    SIZE,
    SPHERE,
    TOP_SPEED,
    Bodies,
    pose_at,
)


class Chains(NamedTuple):
    """Limbs at rest and the bodies that may come to them."""

    bodies: Bodies
    which: np.ndarray  # (k,): the bodies that count
    joints: np.ndarray  # (m, j, 3): of every limb [forearm lengths]
    gap: np.ndarray  # (m,): distance at which a body counts as near
    scratch: np.ndarray  # (n, 12): room for poses
    shortest: float  # resolution [s]


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


@njit(_nrt=False)
def bone_distance(bodies, poses, b, joints, m, k):
    """Distance of the segment between joints k and k + 1 of limb m to body b at its pose."""
    kind, radius = bodies.rows[b, KIND], bodies.rows[b, SIZE]
    px, py, pz = joints[m, k, 0], joints[m, k, 1], joints[m, k, 2]
    qx, qy, qz = joints[m, k + 1, 0], joints[m, k + 1, 1], joints[m, k + 1, 2]
    if kind == DISC or kind == POLYGON:
        return segment_distance(bodies, poses, b, px, py, qx, qy)
    if kind == SPHERE:
        x, y, z = poses[b, 0], poses[b, 1], poses[b, 2]
        p, q = (px - x, py - y, pz - z), (qx - x, qy - y, qz - z)
        return max(segment_axis(p, q, 0.0) - radius, 0.0)
    return solid_distance(bodies, poses, b, (px, py, pz), (qx, qy, qz))


@njit(_nrt=False)
def room_of(chains, m, b, t):
    """Distance of limb m to body b at t [s], less the gap at which it is near."""
    pose_at(chains.bodies, b, t, chains.scratch)
    least = 1e300
    for k in range(chains.joints.shape[1] - 1):
        found = bone_distance(chains.bodies, chains.scratch, b, chains.joints, m, k)
        least = min(least, found)
    return least - chains.gap[m]


@njit(_nrt=False)
def advance(chains, m, t):
    """Whether a body is near limb m at t [s], and for how long that surely stays so."""
    near, apart, together = False, 1e300, 0.0
    for i in range(chains.which.size):
        b = chains.which[i]
        speed = chains.bodies.rows[b, TOP_SPEED]
        room = room_of(chains, m, b, t)
        stays = abs(room) / speed if speed > 0.0 else 1e300
        if room <= 0.0:
            near = True
            together = max(together, stays)
        else:
            apart = min(apart, stays)
    return near, max(together if near else apart, chains.shortest)


@njit
def add_spans(chains, m, end, wanted, times, total):
    """Add the spans of [0, end] in which a body is near limb m (wanted) or none is (not wanted).

    By conservative advancement: what is shorter than the resolution may be missed.

    Parameters
    ----------
    times : (k, 2) ndarray
        Begin and end of spans, of which `total` are known [s].

    Returns
    -------
    total : int
    times : (k, 2) ndarray
        The same or, where there was no room for them, a longer one.
    """
    t, since = 0.0, -1.0
    while t < end:
        near, stays = advance(chains, m, t)
        if (near == wanted) != (since >= 0.0):
            if near == wanted:
                since = t
            else:
                total, times = _noted(times, total, since, t)
                since = -1.0
        t += stays
    if since >= 0.0:
        total, times = _noted(times, total, since, end)
    return total, times


@njit
def _noted(times, total, since, until):
    """Add a span; the array is doubled where it is full."""
    if total == times.shape[0]:
        times = np.concatenate((times, np.empty_like(times)))
    times[total, 0], times[total, 1] = since, until
    return total + 1, times
