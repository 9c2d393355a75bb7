"""Spatial arms in the arena: entries of the table in `limbs`."""

from __future__ import annotations

import numpy as np

from gcm_learn.arms.spatial_limb import SpatialLimb, limb_at
from gcm_learn.collision.postures import body_distance
from gcm_learn.compiled import njit
from gcm_learn.execution.arena.kernels.joints import fan
from gcm_learn.execution.arena.kernels.joints.nearness import (
    SOFTER,
    braking,
    limb_velocity,
    nearest_on_bone,
)
from gcm_learn.execution.arena.kernels.world import put, put_vector

START = slice(23, 31)  # columns of a world's limbs: joints and rates at t = 0


@njit
def blank(world):
    """Limb of the first situation, which has no arrays to overwrite."""
    return _limb(world.limbs[0])


@njit(forceinline=True)
def limb_in(limb, world, s):
    """Limb of situation s."""
    return _limb(world.limbs[s])


@njit(forceinline=True)
def _limb(a):
    """Limb of a row, the fields of `SpatialLimb` one after the other."""
    return SpatialLimb(
        a[0:3], a[3:6], a[6:10], a[10:14], a[14:17], a[17:20], a[20], a[21], a[22], a[23:27],
        a[27:31],
    )  # fmt: skip


@njit(forceinline=True)
def buffers(limb):
    """Return a mere number, which costs nothing to hand on."""
    return 0


@njit(_nrt=False, forceinline=True)
def beside(limb, own, k):
    """Return the same limb: places are numbers."""
    return limb


@njit(_nrt=False, forceinline=True)
def gap_of(limb, place, bodies, b, t, enough, poses):
    """As the table says."""
    found, _ = body_distance(bodies, b, t, place, 0.0, 0.0, enough, poses)
    return found


@njit(_nrt=False, forceinline=True)
def shape_numbers(limb):
    """Count of the elbow's numbers."""
    return 3


@njit(_nrt=False, forceinline=True)
def tell_shape(limb, place, reach, row, at):
    """Write the elbow."""
    put_vector(row, at, place[0], place[1], place[2], reach)


@njit(_nrt=False, forceinline=True)
def size_numbers(limb):
    """Count of length and thickness."""
    return 2


@njit(_nrt=False, forceinline=True)
def tell_sizes(limb, place, touch, reach, row, at):
    """Write the length of the upper arm and the thickness."""
    row[at] = limb.rho / reach
    put(row, at + 1, limb.thickness / reach)


@njit(_nrt=False, forceinline=True)
def approach_numbers(limb):
    """No numbers of an approach."""
    return 0


@njit(_nrt=False, forceinline=True)
def tell_approach(limb, place, scene, b, t, poses, row, at):
    """Write nothing."""


@njit(_nrt=False, forceinline=True)
def nearest_point(limb, place, bodies, b, poses):
    """As the table says; of two points equally near that of the forearm."""
    ex, ey, ez, hx, hy, hz = place
    s, x, y, z = nearest_on_bone(bodies, b, poses, (0.0, 0.0, 0.0), (ex, ey, ez))
    u, v, w, px = nearest_on_bone(bodies, b, poses, (ex, ey, ez), (hx, hy, hz))
    if v * v + w * w + px * px <= x * x + y * y + z * z:
        return 1, ex + u * (hx - ex), ey + u * (hy - ey), ez + u * (hz - ez), v, w, px, 0.0
    return 0, s * ex, s * ey, s * ez, x, y, z, 0.0


@njit(_nrt=False, forceinline=True)
def point_velocity_on(limb, place, i, joints, rates, x, y, z):
    """As the table says."""
    return limb_velocity(joints, rates, (place[0], place[1], place[2]), x, y, z, i == 1)


@njit(_nrt=False)
def brakes_slowly(limb, scene, speed, end, rates, span, own):
    """As the table says: braking all at once, rates only fall, and the hand gets little farther."""
    _, _, _, x, y, z = limb_at(limb, end)
    bend = 0.0
    for j in range(2, 4):
        most = scene.limits.joint_acceleration[j] * span * (1.0 - SOFTER)
        bend += span * braking(rates[j], most)
    far = min(np.sqrt(x * x + y * y + z * z) + bend * limb.length, limb.rho + limb.length)
    turning = np.hypot(rates[0], rates[1]) * far + np.hypot(rates[2], rates[3]) * limb.length
    return turning <= speed


@njit(_nrt=False)
def tell_fan(limb, view, time, posture, e, body, place, aim, row, at):
    """As the table says."""
    fan.tell_fan(view, time, posture, e, body, place, aim, row, at)
