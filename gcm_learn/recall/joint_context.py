"""Context of a situation of an arm in joints: target, arm, and where it could go straight.

All is in the heading of the limb; see `recall.headings`. A chain's numbers are as many as its
joints ask for.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.arms.chain_limb import ChainLimb
from gcm_learn.arms.limbs import axis_of, dof, hand_of, place
from gcm_learn.arms.spatial_limb import SpatialLimb, limb_at
from gcm_learn.compiled import njit
from gcm_learn.dispatch import by_type
from gcm_learn.motion.joint_interception import approach_axis, has_approach
from gcm_learn.scene.bodies import REACH, WITHIN, pose_at

TRACKED = np.array([0.0, 0.1, 0.2, 0.3, 0.45, 0.6, 0.8, 1.0, 1.3, 1.6])  # of the target [s]
FAR = 1.5  # distances of targets are cut at this [reaches]
TRACK = 5  # numbers of the target at an instant
PER_JOINT, WHOLE = 7, 16  # numbers of a joint, of the arm besides
APPROACH = 3 * len(TRACKED) + 2  # numbers of a target's approach


@njit
def context_of(study, heading, target, signs, reach, end, when):
    """Context (m,) float32 of a situation.

    Parameters
    ----------
    study : Study
    heading : Heading
    target : int
        Body that is looked at.
    signs : (n,) ndarray
        Of the joints.
    reach : float
        Unit of lengths.
    end : (n,) ndarray
        Joints at the end of the straight way.
    when : float
        Time at which that catches, negative if it comes late [s].
    """
    limb = study.scene.limb
    size = TRACK * TRACKED.size + PER_JOINT * dof(limb) + WHOLE + _approach_count(limb)
    out = np.zeros(size, dtype=np.float32)
    _fill_context(study, heading, target, signs, reach, end, when, out)
    return out


@njit(_nrt=False)
def _fill_context(study, heading, target, signs, reach, end, when, out):
    """Fill in the target's track, then numbers of the arm."""
    scene, poses, limb, limits = study.scene, study.desk.poses, study.scene.limb, study.scene.limits
    n, side, at = dof(limb), _side(limb, signs), 0
    for k in range(TRACKED.size):
        pose_at(scene.bodies, target, min(TRACKED[k], limits.horizon), poses)
        x, y, z = _ahead(heading, poses[target, 0], poses[target, 1], poses[target, 2])
        x, y, z = x / reach, y / reach, z / reach
        far = np.sqrt(x * x + y * y + z * z)
        scale = FAR / max(far, FAR)
        out[at], out[at + 1], out[at + 2] = x * scale, side * y * scale, z * scale
        out[at + 3], out[at + 4] = min(far, 2.0), 1.0 if far < 1.0 else 0.0
        at += TRACK
    for j in range(n):
        shift, start = heading.shift[j], limb.start[j]
        low, high = signs[j] * (limb.low[j] - shift), signs[j] * (limb.high[j] - shift)
        out[at + j], out[at + n + j] = signs[j] * (start - shift), signs[j] * (end[j] - shift)
        out[at + 2 * n + j], out[at + 3 * n + j] = min(low, high), max(low, high)
        out[at + 4 * n + j] = np.cos(start - shift)
        out[at + 5 * n + j] = signs[j] * np.sin(start - shift)
        out[at + 6 * n + j] = 0.2 * limits.joint_speed[j]
    at += PER_JOINT * n
    _fill_limb(limb, heading, side, reach, out, at)
    out[at + 6], out[at + 9] = limits.horizon, 10.0 * limits.grasp / reach
    out[at + 10] = 5.0 * scene.bodies.rows[target, REACH] / reach
    out[at + 11] = 1.0 / (1.0 + limits.speed / reach)
    out[at + 14], out[at + 15] = abs(when), 1.0 if when > 0.0 else 0.0
    _fill_approach(limb, scene, heading, target, poses, out, at + WHOLE)


@njit(_nrt=False)
def _ahead(heading, x, y, z):
    """Turn a point of the base's frame to the heading."""
    rows, origin = heading.rows, heading.origin
    x, y, z = x - origin[0], y - origin[1], z - origin[2]
    return (
        rows[0, 0] * x + rows[0, 1] * y + rows[0, 2] * z,
        rows[1, 0] * x + rows[1, 1] * y + rows[1, 2] * z,
        rows[2, 0] * x + rows[2, 1] * y + rows[2, 2] * z,
    )


@njit(_nrt=False)
def _side_of_arm(limb, signs):
    return signs[3]


@njit(_nrt=False)
def _no_side(limb, signs):
    return 1.0


_side = by_type({SpatialLimb: _side_of_arm, ChainLimb: _no_side})
"""Sign of a limb's lateral direction: -1 for right arms."""


@njit(_nrt=False)
def _fill_elbow(limb, heading, side, reach, out, at):
    place = limb_at(limb, limb.start)
    for i in range(6):
        out[at + i] = place[i] / reach
    out[at + 1], out[at + 4] = side * out[at + 1], side * out[at + 4]
    out[at + 7], out[at + 8] = limb.rho / reach, 10.0 * limb.thickness / reach
    out[at + 12], out[at + 13] = side * limb.upper[1] / reach, limb.fore[2] / reach


@njit(_nrt=False)
def _fill_hand(limb, heading, side, reach, out, at):
    where = place(limb, limb.start)
    x, y, z = hand_of(limb, where)
    x, y, z = _ahead(heading, x, y, z)
    out[at], out[at + 1], out[at + 2] = x / reach, y / reach, z / reach
    x, y, z = axis_of(limb, where)
    out[at + 3], out[at + 4], out[at + 5] = _turned_ahead(heading, x, y, z)


@njit(_nrt=False)
def _turned_ahead(heading, x, y, z):
    """Turn a direction of the base's frame to the heading."""
    origin = heading.origin
    return _ahead(heading, x + origin[0], y + origin[1], z + origin[2])


_fill_limb = by_type({SpatialLimb: _fill_elbow, ChainLimb: _fill_hand})
"""Fill in where the limb starts, and its measures as far as they differ from arm to arm.

A chain's are its model's, and an encoder knows one model.
"""


@njit(_nrt=False)
def _without_approach(limb, scene, heading, target, poses, out, at):
    return 0


@njit(_nrt=False)
def _with_approach(limb, scene, heading, target, poses, out, at):
    if not has_approach(scene, target):
        return 0
    for k in range(TRACKED.size):
        t = min(TRACKED[k], scene.limits.horizon)
        pose_at(scene.bodies, target, t, poses)
        x, y, z = approach_axis(scene, target, t, poses)
        out[at], out[at + 1], out[at + 2] = _turned_ahead(heading, x, y, z)
        at += 3
    out[at], out[at + 1] = 1.0, np.cos(scene.bodies.rows[target, WITHIN])
    return 0


_fill_approach = by_type({SpatialLimb: _without_approach, ChainLimb: _with_approach})
"""Fill in the target's approach; 0 if it has none."""


@njit(_nrt=False, forceinline=True)
def _none(limb):
    return 0


@njit(_nrt=False, forceinline=True)
def _numbers_of_approach(limb):
    return APPROACH


_approach_count = by_type({SpatialLimb: _none, ChainLimb: _numbers_of_approach})
"""Numbers of a target's approach."""
