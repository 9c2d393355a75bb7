"""A situation of a spatial arm as a row of numbers of fixed length, see `recall.raw_features`.

Lengths are in reaches, in the frame of the base, as a left arm has it.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.arms import SpatialArm
from gcm_learn.arms.spatial_limb import limb_at
from gcm_learn.collision.postures import body_distance
from gcm_learn.compiled import njit
from gcm_learn.recall.raw_features import INSTANTS, OBSTACLE, SLOTS, TARGET, own_axis
from gcm_learn.scene import Scene
from gcm_learn.scene.bodies import HAND, PART, REACH, pose_at
from gcm_learn.scene.packing import pack
from gcm_learn.situation import Situation, spatial_frame_of

ARM = 20  # numbers of the arm
COUNT = ARM + TARGET + SLOTS * OBSTACLE
FAR = 2.0  # a body's centre is told to be no farther than this [reaches]


def raw_features_in_space(
    situation: Situation[SpatialArm], scene: Scene | None = None
) -> np.ndarray:
    """Raw parameters (COUNT,) float32 of a situation in any frame; zeros in slots that are free."""
    arm, horizon = situation.arm, situation.horizon
    frame = spatial_frame_of(situation)
    scene = pack(situation) if scene is None else scene
    out = np.zeros(COUNT, dtype=np.float32)
    ends = [frame.canonical_joints(np.array(end)) for end in np.array(arm.joint_range).T]
    out[0:4] = frame.canonical_joints(arm.joints)
    out[4:8], out[8:12] = np.minimum(*ends), np.maximum(*ends)
    # slow joints count, fast ones are as good as no limit
    out[12:16] = 1.0 / (1.0 + np.array(arm.max_joint_speed) * horizon)
    speed = scene.limits.speed * horizon / arm.reach
    out[16] = 1.0 / (1.0 + speed)
    out[17:20] = scene.limb.rho / arm.reach, arm.thickness / arm.reach, arm.grasp / arm.reach
    _fill(scene, -1.0 if frame.mirrored else 1.0, arm.reach, out)
    return out


@njit
def _fill(scene, side, reach, out):
    """Fill in the target that is nearest at t = 0 and the SLOTS nearest obstacles."""
    bodies, limb, horizon = scene.bodies, scene.limb, scene.limits.horizon
    n = bodies.rows.shape[0]
    poses, gap, limb_now = np.zeros((n, 12)), np.full(n, 1e300), limb_at(limb, limb.start)
    target, nearest = -1, 1e300
    for b in range(n):
        if bodies.rows[b, PART] == HAND:
            pose_at(bodies, b, 0.0, poses)
            away = 0.0
            for j in range(3):
                away += (poses[b, j] - limb_now[3 + j]) ** 2
            if away < nearest:
                target, nearest = b, away
    for k in range(INSTANTS):
        t = horizon * k / (INSTANTS - 1)
        pose_at(bodies, target, t, poses)
        x, y, z = poses[target, 0], poses[target, 1], poses[target, 2]
        way = (limb_now[3], limb_now[4], limb_now[5], x, y, z)
        for b in range(n):
            if bodies.rows[b, PART] != HAND:
                for place in (limb_now, way):
                    found, _ = body_distance(bodies, b, t, place, 0.0, 0.0, 0.0, poses)
                    gap[b] = min(gap[b], found)
    _places(bodies, target, side, reach, horizon, poses, out, ARM)
    out[ARM + 9] = bodies.rows[target, REACH] / reach
    for slot in range(SLOTS):
        b = int(np.argmin(gap))
        if gap[b] >= 1e300:
            break
        gap[b] = 1e300
        at = ARM + TARGET + slot * OBSTACLE
        out[at] = 1.0
        _places(bodies, b, side, reach, horizon, poses, out, at + 1)
        out[at + 10] = bodies.rows[b, REACH] / reach
        x, y, z = own_axis(bodies, b)
        for j in range(3):  # an axis has no head
            along = poses[b, 3 + 3 * j] * x + poses[b, 4 + 3 * j] * y + poses[b, 5 + 3 * j] * z
            out[at + 11 + j] = abs(along) / reach


@njit(_nrt=False)
def _places(bodies, b, side, reach, horizon, poses, out, at):
    """Where body b is at t = 0, and how far it gets in half and all of the horizon: 9 numbers.

    The pose that is left in `poses` is that at t = 0.
    """
    for k in range(2, -1, -1):
        pose_at(bodies, b, 0.5 * k * horizon, poses)
        for j in range(3):
            place = poses[b, j] / reach * (side if j == 1 else 1.0)
            out[at + 3 * k + j] = min(max(place, -FAR), FAR)
    for k in range(1, 3):
        for j in range(3):
            out[at + 3 * k + j] -= out[at + j]
