"""A situation as a row of numbers of fixed length: the raw parameters that neighbours are found by.

Everything is known at t = 0: shapes, poses, and by the laws of motion where bodies will be. All
numbers are lengths, in the frame in which the hand starts on the x axis and the elbow is on the
right. A motion is told by three places, at t = 0 and at half and all of the horizon, which for
constant acceleration is the same as position, velocity and acceleration, and serves pendulums too.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gcm_learn.collision.distance import segment_point2
from gcm_learn.compiled import njit
from gcm_learn.scene import Scene
from gcm_learn.scene.bodies import (
    BOX,
    CAPSULE,
    CYLINDER,
    FIRST,
    HAND,
    KIND,
    LAST,
    PART,
    POLYGON,
    REACH,
    SIZE,
    SPIN,
    pose_at,
)
from gcm_learn.scene.packing import pack
from gcm_learn.situation import Situation

SLOTS = 4  # obstacles that are told, the nearest to hand, arm and path first
ARM, TARGET, OBSTACLE = 7, 10, 14  # numbers of the arm, of a target, of an obstacle
COUNT = ARM + TARGET + SLOTS * OBSTACLE
INSTANTS = 9  # instants at which nearness is asked for


def raw_features(situation: Situation, scene: Scene | None = None) -> np.ndarray:
    """Raw parameters (COUNT,) float32 of a situation in any frame; zeros in slots that are free."""
    arm, horizon = situation.arm, situation.horizon
    scene = pack(situation) if scene is None else scene
    out = np.zeros(COUNT, dtype=np.float32)
    x, y = arm.hand
    out[0], out[1] = np.hypot(x, y), arm.upper_arm
    out[2], out[3], out[4] = arm.max_hand_speed * horizon, arm.thickness, arm.grasp
    if arm.max_joint_speed is not None:  # slow joints count, fast ones are as good as no limit
        out[5:7] = 1.0 / (1.0 + np.asarray(arm.max_joint_speed) * horizon)
    angle = float(np.arctan2(y, x))
    _body_features(scene, angle, out)
    return out


@dataclass(frozen=True)
class Scale:
    """Brings raw parameters to a common scale; slots that are free lie in the middle of things."""

    mean: np.ndarray
    """(m,) float32"""
    spread: np.ndarray
    """(m,) float32"""

    @classmethod
    def of(cls, features: np.ndarray) -> Scale:
        """Fit to raw parameters (n, m); all slots of obstacles share one scale."""
        head = _head(features)
        slots = features[:, head:].reshape(-1, OBSTACLE)
        slots = slots[slots[:, 0] > 0.0]
        if len(slots) == 0:
            slots = np.zeros((1, OBSTACLE))
        mean = np.concatenate([features[:, :head].mean(axis=0), np.tile(slots.mean(axis=0), SLOTS)])
        spread = np.concatenate([features[:, :head].std(axis=0), np.tile(slots.std(axis=0), SLOTS)])
        mean[head::OBSTACLE], spread[head::OBSTACLE] = 0.0, 1.0  # whether there is one
        spread = np.where(spread > 1e-6, spread, 1.0)
        return cls(mean.astype(np.float32), spread.astype(np.float32))

    def __call__(self, features: np.ndarray) -> np.ndarray:
        """Parameters (..., m) on that scale."""
        out = (features - self.mean) / self.spread
        slots = out[..., _head(out) :].reshape(*out.shape[:-1], SLOTS, OBSTACLE)
        slots *= slots[..., :1]  # present is 1, free is 0
        return out


def _head(features: np.ndarray) -> int:
    """Numbers before the slots of obstacles: of arm and target, in the plane or in space."""
    return int(features.shape[-1] - SLOTS * OBSTACLE)


@njit
def _body_features(scene, angle, out):
    """Fill in the target that is nearest at t = 0 and the SLOTS nearest obstacles."""
    bodies, x, y, side = scene.bodies, scene.limb.x, scene.limb.y, scene.limb.side
    n, horizon = bodies.rows.shape[0], scene.limits.horizon
    poses = np.zeros((n, 12))
    gap = np.full(n, 1e300)
    target, nearest = -1, 1e300
    for b in range(n):
        if bodies.rows[b, PART] == HAND:
            pose_at(bodies, b, 0.0, poses)
            d = (poses[b, 0] - x) ** 2 + (poses[b, 1] - y) ** 2
            if d < nearest:
                target, nearest = b, d
    for k in range(INSTANTS):
        t = horizon * k / (INSTANTS - 1)
        pose_at(bodies, target, t, poses)
        gx, gy = poses[target, 0], poses[target, 1]
        for b in range(n):
            if bodies.rows[b, PART] == HAND:
                continue
            pose_at(bodies, b, t, poses)
            d2 = segment_point2(poses[b, 0], poses[b, 1], x, y, gx, gy)
            d2 = min(d2, segment_point2(poses[b, 0], poses[b, 1], 0.0, 0.0, x, y))
            d2 += poses[b, 2] ** 2
            gap[b] = min(gap[b], np.sqrt(d2) - bodies.rows[b, REACH])
    c, s = np.cos(angle), np.sin(angle)
    _places(bodies, target, c, s, side, horizon, poses, out, ARM)
    out[ARM + 9] = bodies.rows[target, REACH]
    for slot in range(SLOTS):
        b = int(np.argmin(gap))
        if gap[b] >= 1e300:
            break
        gap[b] = 1e300
        at = ARM + TARGET + slot * OBSTACLE
        out[at] = 1.0
        _places(bodies, b, c, s, side, horizon, poses, out, at + 1)
        out[at + 10] = bodies.rows[b, REACH]
        dx, dy = long_axis(bodies, b, poses)
        dx, dy = c * dx + s * dy, side * (c * dy - s * dx)
        length = np.sqrt(dx * dx + dy * dy)
        if length > 0.0:  # twice the angle: an axis has no head
            out[at + 11] = (dx * dx - dy * dy) / length
            out[at + 12] = 2.0 * dx * dy / length
        out[at + 13] = side * bodies.rows[b, SPIN + 2] * horizon * length


@njit
def _places(bodies, b, c, s, side, horizon, poses, out, at):
    """Where body b is at t = 0, and how far it gets in half and all of the horizon: 9 numbers.

    The pose that is left in `poses` is that at t = 0.
    """
    for k in range(2, -1, -1):
        pose_at(bodies, b, 0.5 * k * horizon, poses)
        px, py = poses[b, 0], poses[b, 1]
        out[at + 3 * k] = c * px + s * py
        out[at + 3 * k + 1] = side * (c * py - s * px)
        out[at + 3 * k + 2] = side * poses[b, 2]
    for k in range(1, 3):
        for j in range(3):
            out[at + 3 * k + j] -= out[at + j]


@njit
def long_axis(bodies, b, poses):
    """In-plane part of a body's longest axis, as long as the body is longer than wide."""
    x, y, z = own_axis(bodies, b)
    dx = poses[b, 3] * x + poses[b, 4] * y + poses[b, 5] * z
    return dx, poses[b, 6] * x + poses[b, 7] * y + poses[b, 8] * z


@njit
def own_axis(bodies, b):
    """A body's longest axis (3) in its own frame, as long as the body is longer than wide."""
    kind = bodies.rows[b, KIND]
    if kind == CAPSULE or kind == CYLINDER:
        return 0.0, 0.0, bodies.rows[b, SIZE + 1]
    if kind == BOX:
        x, y, z = bodies.rows[b, SIZE], bodies.rows[b, SIZE + 1], bodies.rows[b, SIZE + 2]
        if z > x and z > y:
            return 0.0, 0.0, z
        return (0.0, y, 0.0) if y > x else (x, 0.0, 0.0)
    if kind != POLYGON:
        return 0.0, 0.0, 0.0
    first, last = int(bodies.rows[b, FIRST]), int(bodies.rows[b, LAST])
    mx, my = 0.0, 0.0
    for k in range(first, last):
        mx += bodies.vertices[k, 0] / (last - first)
        my += bodies.vertices[k, 1] / (last - first)
    xx, xy, yy = 0.0, 0.0, 0.0
    for k in range(first, last):
        dx, dy = bodies.vertices[k, 0] - mx, bodies.vertices[k, 1] - my
        xx, xy, yy = xx + dx * dx, xy + dx * dy, yy + dy * dy
    spread = np.sqrt(np.sqrt((xx - yy) ** 2 + 4.0 * xy * xy) / (last - first))
    phi = 0.5 * np.arctan2(2.0 * xy, xx - yy)
    return spread * np.cos(phi), spread * np.sin(phi), 0.0
