"""Headings: a chain turned about its first joint until the target is ahead.

Situations that differ by a turn about that axis are then one.  Only the range of the first joint
tells them apart.  A spatial arm has no heading; its symmetry is a mirror, see
`situation.spatial_frame`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from gcm_learn.arms import SPATIAL, ByKind
from gcm_learn.arms.chain_frames import PRISMATIC, line_of, parent_of
from gcm_learn.arms.chain_limb import place
from gcm_learn.arms.limbs import hand_of, inverts, place as place_of
from gcm_learn.compiled import njit
from gcm_learn.scene.bodies import HAND, PART, pose_at
from gcm_learn.situation import AnySituation, spatial_frame_of

AHEAD = 0.7  # instant at which the target is ahead [horizons]
NOTHING = 1e-9  # distance from the axis below which a target has no direction [reaches]


class Heading(NamedTuple):
    """Frame in which the target is ahead: x to the target, z along the first joint's axis."""

    rows: np.ndarray  # (3, 3): its axes in the frame of the base
    origin: np.ndarray  # (3,): a point on the first joint's axis
    shift: np.ndarray  # (n,): joints that are 0 in it [rad]


@njit(_nrt=False)
def nearest_target(scene, poses):
    """The target that is nearest to the hand at t = 0; -1 without targets."""
    x, y, z = hand_of(scene.limb, place_of(scene.limb, scene.limb.start))
    target, nearest = -1, 1e300
    for b in range(scene.bodies.rows.shape[0]):
        if scene.bodies.rows[b, PART] == HAND:
            pose_at(scene.bodies, b, 0.0, poses)
            away = (poses[b, 0] - x) ** 2 + (poses[b, 1] - y) ** 2 + (poses[b, 2] - z) ** 2
            if away < nearest:
                target, nearest = b, away
    return target


@njit
def heading_of(limb, scene):
    """Heading of a limb in a scene: that of the nearest target, late in the horizon.

    The first joint is within half a turn of 0 in it at t = 0.  That of spatial arms is the base's.
    """
    out = Heading(np.eye(3), np.zeros(3), np.zeros(limb.start.size))
    poses = np.zeros((scene.bodies.rows.shape[0], 12))
    target = nearest_target(scene, poses)
    alike = limb.joints[0, 0] != PRISMATIC and not inverts(limb)  # if the first joint turns all
    for k in range(1, limb.joints.shape[0]):
        alike = alike and line_of(limb.tree, k)[0] > 0 and parent_of(limb.tree, k) > 0
    if not alike or target < 0:
        return out
    place(limb, limb.start)
    axis = limb.axes[0, 3:6].copy()
    pose_at(scene.bodies, target, AHEAD * scene.limits.horizon, poses)
    off = poses[target, :3] - limb.axes[0, :3]
    off -= np.sum(off * axis) * axis
    size = np.sqrt(np.sum(off * off))
    if size <= NOTHING * limb.reach:
        return out
    first = np.zeros(3)
    first[np.argmin(np.abs(axis))] = 1.0
    first -= np.sum(first * axis) * axis
    first /= np.sqrt(np.sum(first * first))
    side = np.cross(axis, off) / size
    angle = np.arctan2(-np.sum(side * first), np.sum(off * first) / size)
    out.origin[:] = limb.axes[0, :3]
    out.rows[0], out.rows[1], out.rows[2] = off / size, side, axis
    turn = limb.start[0] - angle
    out.shift[0] = angle + 2.0 * np.pi * np.round(turn / (2.0 * np.pi))
    return out


def _mirrors(situation: AnySituation) -> np.ndarray:
    arm: Any = situation.arm
    return spatial_frame_of(situation).canonical_joints(np.ones(len(arm.joints)))  # type: ignore[arg-type]


def _ones(situation: AnySituation) -> np.ndarray:
    arm: Any = situation.arm
    return np.ones(len(arm.joints))


_SIGNS = ByKind({SPATIAL: _mirrors}, default=_ones)


def signs_of(situation: AnySituation) -> np.ndarray:
    """Return the signs (n,) that turn a situation's joints into those of its canonical form."""
    signs: np.ndarray = _SIGNS.of(situation)(situation)
    return signs
