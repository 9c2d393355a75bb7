"""A situation as a row of numbers of fixed length: the raw parameters that neighbours are found by.

Everything is known at t = 0: shapes, poses, and by the laws of motion the bodies' later places. All
numbers are lengths. A planar arm has its hand on the x axis and its elbow on the right. A spatial
one is a left arm in the frame of its base, and lengths are in reaches. A chain is turned about its
first joint until the target is ahead. A motion is given by three
places, at t = 0 and at half and all of the horizon. For constant acceleration that is position,
velocity and acceleration, and it serves pendulums too.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from gcm_learn.arms import Chain, SpatialArm
from gcm_learn.arms.chain_limb import ChainLimb
from gcm_learn.arms.limbs import hand_of, link, link_count, place
from gcm_learn.arms.swivels import RHO, limb_at
from gcm_learn.collision.distance import segment_point2
from gcm_learn.compiled import by_type, njit
from gcm_learn.motion.joint_interception import approach_axis, approaches
from gcm_learn.recall.headings import AHEAD, Heading, heading_of, nearest_target
from gcm_learn.scene import Scene
from gcm_learn.scene.bodies import HAND, PART, REACH, SPIN, WITHIN, pose_at
from gcm_learn.scene.packing import pack
from gcm_learn.scene.shapes.ball import off_bone
from gcm_learn.scene.shapes.choice import long_axis
from gcm_learn.situation import Situation, spatial_frame_of

SLOTS = 4  # obstacles that are included, the nearest to hand, arm and path first
HAND_ARM, JOINT_ARM = 7, 20  # numbers of the arm
TARGET, OBSTACLE = 10, 14  # numbers of a target, of an obstacle
CHAIN_ARM = 8  # numbers of a chain besides two for each joint
HAND_COUNT = HAND_ARM + TARGET + SLOTS * OBSTACLE
JOINT_COUNT = JOINT_ARM + TARGET + SLOTS * OBSTACLE
INSTANTS = 9  # at which nearness is measured
FAR = 2.0  # largest coordinate of a body's centre for a spatial arm [reaches]


class HandView(NamedTuple):
    """Frame of a planar arm."""

    x: float  # hand
    y: float
    c: float  # direction of the hand
    s: float
    side: float  # of the elbow
    unit: float  # length of 1
    arm: int  # numbers of the arm


class JointView(NamedTuple):
    """Frame of a spatial arm."""

    limb: tuple[float, float, float, float, float, float]  # elbow and hand
    side: float  # -1 for a right arm
    unit: float  # length of 1
    arm: int  # numbers of the arm


class ChainView(NamedTuple):
    """Frame of a chain."""

    limb: ChainLimb
    heading: Heading
    unit: float  # length of 1
    arm: int  # numbers of the arm


def hand_raw_features(situation: Situation, scene: Scene | None = None) -> np.ndarray:
    """Return the raw parameters (HAND_COUNT,) float32 of a situation of a planar arm.

    Slots without an obstacle are 0.
    """
    arm, horizon = situation.arm, situation.horizon
    scene = pack(situation) if scene is None else scene
    out = np.zeros(HAND_COUNT, dtype=np.float32)
    x, y = arm.hand
    out[0], out[1] = np.hypot(x, y), arm.upper_arm
    out[2], out[3], out[4] = arm.max_hand_speed * horizon, arm.thickness, arm.grasp
    if arm.max_joint_speed is not None:  # slow joints count, fast ones are as good as no limit
        out[5:7] = 1.0 / (1.0 + np.asarray(arm.max_joint_speed) * horizon)
    angle = float(np.arctan2(y, x))
    _fill_by_hand(scene, angle, out)
    return out


def joint_raw_features(situation: Situation[SpatialArm], scene: Scene | None = None) -> np.ndarray:
    """Return the raw parameters (JOINT_COUNT,) float32 of a situation of a spatial arm.

    Slots without an obstacle are 0.
    """
    arm, horizon = situation.arm, situation.horizon
    frame = spatial_frame_of(situation)
    scene = pack(situation) if scene is None else scene
    out = np.zeros(JOINT_COUNT, dtype=np.float32)
    ends = [frame.canonical_joints(np.array(end)) for end in np.array(arm.joint_range).T]
    out[0:4] = frame.canonical_joints(arm.joints)
    out[4:8], out[8:12] = np.minimum(*ends), np.maximum(*ends)
    # slow joints count, fast ones are as good as no limit
    out[12:16] = 1.0 / (1.0 + np.array(arm.max_joint_speed) * horizon)
    speed = scene.limits.speed * horizon / arm.reach
    out[16] = 1.0 / (1.0 + speed)
    out[17:20] = np.array([scene.limb.solved[RHO], arm.thickness, arm.grasp]) / arm.reach
    _fill_by_joints(scene, -1.0 if frame.mirrored else 1.0, arm.reach, out)
    return out


def chain_raw_features(situation: Situation[Chain], scene: Scene | None = None) -> np.ndarray:
    """Return the raw parameters (CHAIN_ARM + 2 n + TARGET + SLOTS * OBSTACLE,) float32 of a chain.

    Slots without an obstacle are 0.
    """
    arm, n = situation.arm, len(situation.arm.joints)
    scene = pack(situation) if scene is None else scene
    head = 2 * n + CHAIN_ARM
    out = np.zeros(head + TARGET + SLOTS * OBSTACLE, dtype=np.float32)
    heading = heading_of(scene.limb, scene)
    out[:n] = scene.limb.start - heading.shift
    # slow joints count, fast ones are as good as no limit
    out[n : 2 * n] = 1.0 / (1.0 + np.array(arm.max_joint_speed) * situation.horizon)
    out[2 * n : 2 * n + 2] = np.array(arm.joint_range[0]) - heading.shift[0]
    speed = scene.limits.speed * situation.horizon / arm.reach
    out[2 * n + 2 : 2 * n + 4] = 1.0 / (1.0 + speed), arm.grasp / arm.reach
    _fill_by_chain(ChainView(scene.limb, heading, arm.reach, head), scene, out)
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
def _fill_by_hand(scene, angle, out):
    """Fill in the bodies for a planar arm with the hand in a direction [rad]."""
    limb = scene.limb
    view = HandView(limb.x, limb.y, np.cos(angle), np.sin(angle), limb.side, 1.0, HAND_ARM)
    _fill(view, scene.bodies, scene.limits.horizon, out)


@njit
def _fill_by_joints(scene, side, reach, out):
    """Fill in the bodies for a spatial arm."""
    view = JointView(limb_at(scene.limb, scene.limb.start), side, reach, JOINT_ARM)
    _fill(view, scene.bodies, scene.limits.horizon, out)


@njit
def _fill_by_chain(view, scene, out):
    """Fill in the bodies for a chain, and the target's approach."""
    poses = np.zeros((scene.bodies.rows.shape[0], 12))
    target = nearest_target(scene, poses)
    if approaches(scene, target):
        axis = approach_axis(scene, target, 0, AHEAD * scene.limits.horizon, poses)
        for r in range(3):
            for j in range(3):
                out[view.arm - 4 + r] += view.heading.rows[r, j] * axis[j]
        out[view.arm - 1] = np.cos(scene.bodies.rows[target, WITHIN])
    _fill(view, scene.bodies, scene.limits.horizon, out)


@njit
def _away2_of_hand(view, poses, b):
    """Return the squared distance of body b from the hand, in the plane."""
    return (poses[b, 0] - view.x) ** 2 + (poses[b, 1] - view.y) ** 2


@njit
def _away2_in_space(view, poses, b):
    """Return the squared distance of body b from the hand."""
    away = 0.0
    for j in range(3):
        away += (poses[b, j] - view.limb[3 + j]) ** 2
    return away


@njit
def _away2_of_chain(view, poses, b):
    """Return the squared distance of body b from the hand of a chain."""
    x, y, z = hand_of(view.limb, place(view.limb, view.limb.start))
    return (poses[b, 0] - x) ** 2 + (poses[b, 1] - y) ** 2 + (poses[b, 2] - z) ** 2


@njit
def _gap_by_ball(view, bodies, b, t, goal, poses):
    """Return the distance of a ball about body b from the arm and the hand's way to the goal."""
    pose_at(bodies, b, t, poses)
    d2 = segment_point2(poses[b, 0], poses[b, 1], view.x, view.y, goal[0], goal[1])
    d2 = min(d2, segment_point2(poses[b, 0], poses[b, 1], 0.0, 0.0, view.x, view.y))
    d2 += poses[b, 2] ** 2
    return np.sqrt(d2) - bodies.rows[b, REACH]


@njit
def _gap_in_space(view, bodies, b, t, goal, poses):
    """Return the distance of a ball about body b from the limb and the hand's way to the goal."""
    pose_at(bodies, b, t, poses)
    x, y, z = poses[b, 0], poses[b, 1], poses[b, 2]
    ex, ey, ez, hx, hy, hz = view.limb
    gap = min(off_bone(x, y, z, ex, ey, ez), off_bone(x, y, z, hx, hy, hz))
    gap = min(gap, off_bone(x - ex, y - ey, z - ez, hx - ex, hy - ey, hz - ez))
    gap = min(gap, off_bone(x - hx, y - hy, z - hz, goal[0] - hx, goal[1] - hy, goal[2] - hz))
    return gap - bodies.rows[b, REACH]


@njit
def _gap_to_chain(view, bodies, b, t, goal, poses):
    """Return the distance of a ball about body b from the links and the hand's way to the goal."""
    pose_at(bodies, b, t, poses)
    limb, x, y, z = view.limb, poses[b, 0], poses[b, 1], poses[b, 2]
    where = place(limb, limb.start)
    hx, hy, hz = hand_of(limb, where)
    gap = off_bone(x - hx, y - hy, z - hz, goal[0] - hx, goal[1] - hy, goal[2] - hz)
    for i in range(link_count(limb)):
        ax, ay, az, bx, by, bz, radius = link(limb, where, i)
        gap = min(gap, off_bone(x - ax, y - ay, z - az, bx - ax, by - ay, bz - az) - radius)
    return gap - bodies.rows[b, REACH]


@njit
def _place_by_hand(view, poses, b, out, at):
    """Write the centre of body b (3)."""
    px, py = poses[b, 0], poses[b, 1]
    out[at] = view.c * px + view.s * py
    out[at + 1] = view.side * (view.c * py - view.s * px)
    out[at + 2] = view.side * poses[b, 2]


@njit
def _place_in_space(view, poses, b, out, at):
    """Write the centre of body b (3)."""
    for j in range(3):
        place = poses[b, j] / view.unit * (view.side if j == 1 else 1.0)
        out[at + j] = min(max(place, -FAR), FAR)


@njit
def _place_by_chain(view, poses, b, out, at):
    """Write the centre of body b (3)."""
    rows, origin = view.heading.rows, view.heading.origin
    for r in range(3):
        there = 0.0
        for j in range(3):
            there += rows[r, j] * (poses[b, j] - origin[j])
        out[at + r] = min(max(there / view.unit, -FAR), FAR)


@njit
def _axis_by_hand(view, bodies, b, horizon, poses, out, at):
    """Write the axis of body b as its doubled angle, since axes have no head, and its turn (3)."""
    dx, dy = axis_in_plane(bodies, b, poses)
    dx, dy = view.c * dx + view.s * dy, view.side * (view.c * dy - view.s * dx)
    length = np.sqrt(dx * dx + dy * dy)
    if length > 0.0:
        out[at] = (dx * dx - dy * dy) / length
        out[at + 1] = 2.0 * dx * dy / length
    out[at + 2] = view.side * bodies.rows[b, SPIN + 2] * horizon * length


@njit
def _axis_in_space(view, bodies, b, _horizon, poses, out, at):
    """Write the axis of body b (3), which has no head."""
    x, y, z = long_axis(bodies, b)
    for j in range(3):
        along = poses[b, 3 + 3 * j] * x + poses[b, 4 + 3 * j] * y + poses[b, 5 + 3 * j] * z
        out[at + j] = abs(along) / view.unit


@njit
def _axis_by_chain(view, bodies, b, _horizon, poses, out, at):
    """Write the axis of body b (3), which has no head."""
    x, y, z = long_axis(bodies, b)
    rows = view.heading.rows
    for r in range(3):
        along = 0.0
        for j in range(3):
            part = poses[b, 3 + 3 * j] * x + poses[b, 4 + 3 * j] * y + poses[b, 5 + 3 * j] * z
            along += rows[r, j] * part
        out[at + r] = abs(along) / view.unit


_away2 = by_type({HandView: _away2_of_hand, JointView: _away2_in_space, ChainView: _away2_of_chain})
_gap = by_type({HandView: _gap_by_ball, JointView: _gap_in_space, ChainView: _gap_to_chain})
_place = by_type({HandView: _place_by_hand, JointView: _place_in_space, ChainView: _place_by_chain})
_axis = by_type({HandView: _axis_by_hand, JointView: _axis_in_space, ChainView: _axis_by_chain})


@njit
def _fill(view, bodies, horizon, out):
    """Fill in the target that is nearest at t = 0 and the SLOTS nearest obstacles."""
    n = bodies.rows.shape[0]
    poses, gap = np.zeros((n, 12)), np.full(n, 1e300)
    target, nearest = -1, 1e300
    for b in range(n):
        if bodies.rows[b, PART] == HAND:
            pose_at(bodies, b, 0.0, poses)
            away = _away2(view, poses, b)
            if away < nearest:
                target, nearest = b, away
    for k in range(INSTANTS):
        t = horizon * k / (INSTANTS - 1)
        pose_at(bodies, target, t, poses)
        goal = (poses[target, 0], poses[target, 1], poses[target, 2])
        for b in range(n):
            if bodies.rows[b, PART] != HAND:
                gap[b] = min(gap[b], _gap(view, bodies, b, t, goal, poses))
    _places(view, bodies, target, horizon, poses, out, view.arm)
    out[view.arm + 9] = bodies.rows[target, REACH] / view.unit
    for slot in range(SLOTS):
        b = int(np.argmin(gap))
        if gap[b] >= 1e300:
            break
        gap[b] = 1e300
        at = view.arm + TARGET + slot * OBSTACLE
        out[at] = 1.0
        _places(view, bodies, b, horizon, poses, out, at + 1)
        out[at + 10] = bodies.rows[b, REACH] / view.unit
        _axis(view, bodies, b, horizon, poses, out, at + 11)


@njit
def _places(view, bodies, b, horizon, poses, out, at):
    """Write body b's place at t = 0, and its moves until half and all of the horizon (9).

    The pose that is left in `poses` is that at t = 0.
    """
    for k in range(2, -1, -1):
        pose_at(bodies, b, 0.5 * k * horizon, poses)
        _place(view, poses, b, out, at + 3 * k)
    for k in range(1, 3):
        for j in range(3):
            out[at + 3 * k + j] -= out[at + j]


@njit
def axis_in_plane(bodies, b, poses):
    """In-plane part of a body's longest axis, as long as the body is longer than wide."""
    x, y, z = long_axis(bodies, b)
    dx = poses[b, 3] * x + poses[b, 4] * y + poses[b, 5] * z
    return dx, poses[b, 6] * x + poses[b, 7] * y + poses[b, 8] * z
