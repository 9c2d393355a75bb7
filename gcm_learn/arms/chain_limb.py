"""Kinematics of a chain: frames, links, Jacobian and bounds of motion.

Kernels are in the frame of the base.  They write into arrays that the limb itself carries, so that
none is allocated; each worker packs a limb of its own.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from gcm_learn.arms import swivels
from gcm_learn.arms.chain import Chain
from gcm_learn.arms.chain_frames import (
    PRISMATIC,
    REVOLUTE,
    Tree,
    depth_of,
    line_of,
    moved_by,
    moving,
    place_frames,
    place_links,
    point_on,
    sweep_links,
    travel_of,
    tree_of,
)
from gcm_learn.arms.chain_model import ChainModel
from gcm_learn.arms.curves import on_curve, rate_of
from gcm_learn.arms.link_gaps import balls_about, nearest_pair
from gcm_learn.arms.rotations import frame_along, rotation_of
from gcm_learn.compiled import njit

POINT, AXIS = 0, 3  # columns of `ChainLimb.reaches`


class ChainLimb(NamedTuple):
    """Arrays of a chain of k joints and n coordinates for the kernels; frame 0 is at the origin."""

    joints: np.ndarray  # (k, 13): type, origin (3), rotation (9, row by row); z is the joint's axis
    low: np.ndarray  # (n,) ends of the joints' ranges
    high: np.ndarray  # (n,)
    carriers: np.ndarray  # (m + 1,): frame that carries each link, and last the hand
    ends: np.ndarray  # (m + 1, 6): ends of the links' axes; last the hand's point and its axis
    radii: np.ndarray  # (m,): of the links
    pairs: np.ndarray  # (p, 2): links that must not overlap
    ignored: np.ndarray  # (m, bodies) bool: links and obstacles that are not checked
    tails: np.ndarray  # (n,): bound of the hand's way for a unit of each joint, at any posture
    reach: float  # bound of the distance between frame 0 and the hand
    thickness: float  # 0: links have radii of their own
    length: float  # unit of resolutions and safeties
    start: np.ndarray  # (n,) joints at t = 0
    rates: np.ndarray  # (n,) of the joints at t = 0
    frames: np.ndarray  # (k + 1, 12): rotation (9), origin (3) of every frame
    axes: np.ndarray  # (k, 6): a point on each joint's axis and its direction
    reaches: np.ndarray  # (m + 1, 6): ends of the links, then hand and axis; written by `place`
    balls: np.ndarray  # (m, 4): centre, written by `place`, and radius of balls about the links
    near: np.ndarray  # (m,): links; written by `near_links`
    ways: np.ndarray  # (m,): how far points of each link travel; written by `swept`
    turns: np.ndarray  # (k,): how far joints turn; written by `swept`
    paces: np.ndarray  # (k,): rates of joints per share of a move; written by `swept`
    tree: Tree | None  # branches and followers, if there are any
    solved: np.ndarray  # (0,), or the numbers of a closed-form inverse; see `swivels`


@njit(_nrt=False, forceinline=True)
def inverts(limb):
    """Return whether the inverse has a closed form; else postures have to be pulled."""
    return limb.solved.size > 0


@njit(_nrt=False, forceinline=True)
def place(limb, q):
    """Write links at a posture (n,) into the limb's arrays.

    Frames and axes are written, too, unless the inverse has a closed form; see `place_axes`.
    """
    if inverts(limb):
        swivels.place_bones(limb.solved, q, limb.reaches, limb.balls)
    else:
        place_frames(limb.joints, q, limb.frames, limb.axes, limb.tree)
        place_links(limb.carriers, limb.ends, limb.frames, limb.reaches, limb.balls)
    return q.size


@njit(_nrt=False, forceinline=True)
def place_axes(limb, q):
    """Write frames and axes at a posture (n,) where `place` leaves them out."""
    if inverts(limb):
        place_frames(limb.joints, q, limb.frames, limb.axes, limb.tree)


@njit(_nrt=False)
def travel(limb, i, turns, rates, half):
    """Bound how far points of link i travel, by all joints' turns; see `travel_of`."""
    return travel_of(
        limb.joints, limb.axes, limb.reaches, limb.carriers, i, turns, rates, half, limb.tree
    )  # fmt: skip


@njit(_nrt=False, forceinline=True)
def dof(limb):
    """Number of joints."""
    return limb.low.size


@njit(_nrt=False, forceinline=True)
def hand_of(limb, place):
    """Return the hand's position, three numbers, as last written by `place`."""
    row = limb.radii.size
    return limb.reaches[row, 0], limb.reaches[row, 1], limb.reaches[row, 2]


@njit(_nrt=False, forceinline=True)
def axis_of(limb, place):
    """Return the hand's direction, three numbers, as last written by `place`."""
    row = limb.radii.size
    return limb.reaches[row, 3], limb.reaches[row, 4], limb.reaches[row, 5]


@njit(_nrt=False, forceinline=True)
def link_count(limb):
    """Number of links."""
    return limb.radii.size


@njit(_nrt=False, forceinline=True)
def link(limb, place, i):
    """Return the ends of a link's axis, six numbers as last written by `place`, and its radius."""
    r = limb.reaches
    return r[i, 0], r[i, 1], r[i, 2], r[i, 3], r[i, 4], r[i, 5], limb.radii[i]


@njit(_nrt=False, forceinline=True)
def ignores(limb, i, b):
    """Return whether a link is not checked against a body."""
    return limb.ignored[i, b]


@njit(_nrt=False, forceinline=True)
def self_gap(limb, place, slack, enough):
    """Distance of the nearest pair of links that must not overlap, and the same less slack.

    Pairs are left out where the balls about them are farther apart than `enough`.
    """
    return nearest_pair(limb.pairs, limb.radii, limb.reaches, limb.balls, limb.ways, enough)


@njit(_nrt=False)
def still(limb):
    """Note that no link moves."""
    for i in range(limb.ways.size):
        limb.ways[i] = 0.0
    return 0


@njit(_nrt=False, forceinline=True)
def swept(limb, curve, s, half, place):
    """Note how far points of each link travel from share s of a move to s +- half."""
    if inverts(limb):
        swivels.sweep_bones(limb.solved, hand_of(limb, place), curve, s, half, limb.ways)
        return 0
    sweep_links(
        limb.joints, limb.axes, limb.reaches, limb.carriers, curve, s, half, limb.turns,
        limb.paces, limb.ways, limb.tree,
    )  # fmt: skip
    return 0


@njit(_nrt=False, forceinline=True)
def slack_of(limb, slack, i):
    """Return the bound of travel of a link, as noted last."""
    return limb.ways[i]


@njit(_nrt=False)
def hand_rate(limb, curve, s, q):
    """Way of the hand per share of a move at share s; `q` (n,) gets the coordinates."""
    on_curve(curve, s, q)
    place_frames(limb.joints, q, limb.frames, limb.axes, limb.tree)
    hand, vx, vy, vz = limb.radii.size, 0.0, 0.0, 0.0
    x, y, z = point_on(limb.frames, limb.carriers, limb.ends, hand)
    for step in range(depth_of(limb.tree, limb.carriers, hand)):
        k = moving(limb.tree, hand, step)
        j, factor, _ = line_of(limb.tree, k)
        ax, ay, az = moved_by(limb.joints, limb.axes, k, x, y, z)
        rate = factor * rate_of(curve, j, s)
        vx, vy, vz = vx + rate * ax, vy + rate * ay, vz + rate * az
    return np.sqrt(vx * vx + vy * vy + vz * vz)


@njit(_nrt=False)
def hand_travel(limb, q, p):
    """Bound how far the hand travels on the straight move from q to p (n,)."""
    if inverts(limb):
        return swivels.travel_of_bones(limb.solved, q, p)
    way = 0.0
    for k in range(limb.tails.size):
        way += abs(p[k] - q[k]) * limb.tails[k]
    return way


@njit(_nrt=False)
def hand_bound(limb, rates):
    """Bound of the hand's speed while the joints' rates are at most `rates` (n,)."""
    if inverts(limb):
        return swivels.speed_of_bones(limb.solved, rates)
    speed = 0.0
    for k in range(limb.tails.size):
        speed += rates[k] * limb.tails[k]
    return speed


@njit(_nrt=False)
def axis_bound(limb, rates):
    """Bound of the angular speed of the hand's axis."""
    hand, speed = limb.radii.size, 0.0
    for step in range(depth_of(limb.tree, limb.carriers, hand)):
        k = moving(limb.tree, hand, step)
        if limb.joints[k, 0] == REVOLUTE:
            j, factor, _ = line_of(limb.tree, k)
            speed += abs(factor) * rates[j]
    return speed


@njit(_nrt=False, forceinline=True)
def reach_of(limb):
    """Bound of the distance between frame 0 and the hand."""
    return limb.reach


@njit(_nrt=False)
def lever(limb):
    """Bound of the hand's derivatives of all orders up to 3, for a unit of any coordinate.

    Each order turns the arm once more, by all joints of a coordinate; at most one joint slides.
    """
    hand, moves, spins = limb.radii.size, 1.0, 1.0
    for coordinate in range(0 if limb.tree is None else limb.low.size):
        moved, spun = 0.0, 0.0
        for step in range(depth_of(limb.tree, limb.carriers, hand)):
            k = moving(limb.tree, hand, step)
            j, factor, _ = line_of(limb.tree, k)
            if j == coordinate:
                moved += abs(factor)
                spun += abs(factor) if limb.joints[k, 0] == REVOLUTE else 0.0
        moves, spins = max(moves, moved), max(spins, spun)
    far = limb.reach
    for k in range(limb.joints.shape[0]):
        if limb.joints[k, 0] == PRISMATIC:
            far = max(far, 1.0)
    return far * moves * spins * spins


@njit(_nrt=False)
def direction_of(limb, q, x, y, z):
    """Direction (x, y, z) in the frame of the hand's joint, after `place` of q (n,), turned."""
    place_axes(limb, q)
    frame = limb.frames[limb.carriers[limb.radii.size]]
    return (
        frame[0] * x + frame[1] * y + frame[2] * z,
        frame[3] * x + frame[4] * y + frame[5] * z,
        frame[6] * x + frame[7] * y + frame[8] * z,
    )


@njit(_nrt=False)
def spins(limb, q, out):
    """Write the angular velocity of the hand by the joints, after `place`, into `out` (3, n)."""
    place_axes(limb, q)
    out[:] = 0.0
    hand = limb.radii.size
    for step in range(depth_of(limb.tree, limb.carriers, hand)):
        k = moving(limb.tree, hand, step)
        if limb.joints[k, 0] == REVOLUTE:
            j, factor, _ = line_of(limb.tree, k)
            for row in range(3):
                out[row, j] += factor * limb.axes[k, 3 + row]


@njit(_nrt=False)
def postures_at(limb, x, y, z, k, count, low, high, out):
    """Write the postures with swivel k of count; without a closed-form inverse, one posture.

    The one posture is point k of an additive recurrence between `low` and `high`.  The caller
    pulls it to where the hand should be.  The steps are powers of the root of x^(n+1) = x + 1
    (M. Roberts, 2018), which fill a box evenly.
    """
    if inverts(limb):
        return swivels.inverse(limb, x, y, z, 2.0 * np.pi * k / count, limb.start, out)
    n = limb.low.size
    ratio = 2.0
    for _ in range(20):
        ratio = (1.0 + ratio) ** (1.0 / (n + 1.0))
    for j in range(n):
        part = (0.5 + k * ratio ** -(j + 1.0)) % 1.0
        out[0, j] = low[j] + part * (high[j] - low[j])
    return 1


@njit(_nrt=False)
def jacobian(limb, q, out):
    """Write the derivative of the hand by the coordinates, after `place`, into `out` (3, n)."""
    place_axes(limb, q)
    x, y, z = hand_of(limb, 0)
    hand = limb.radii.size
    count = depth_of(limb.tree, limb.carriers, hand)
    out[:, count if limb.tree is None else 0 :] = 0.0
    for step in range(count):
        k = moving(limb.tree, hand, step)
        j, factor, _ = line_of(limb.tree, k)
        ax, ay, az = moved_by(limb.joints, limb.axes, k, x, y, z)
        if limb.tree is not None:  # several joints of one coordinate add up
            ax, ay, az = out[0, j] + factor * ax, out[1, j] + factor * ay, out[2, j] + factor * az
        out[0, j], out[1, j], out[2, j] = ax, ay, az


def _tails(arm: Chain) -> np.ndarray:
    """Bound of the hand's way for a unit of each coordinate (n,), at any posture."""
    model, tails = arm.model, np.zeros(len(arm.model.joints))
    far = math.hypot(*model.hand.point)
    for k in reversed(model.path(model.hand.joint)):
        joint = model.joints[k]
        slides = joint.type == "prismatic"
        tails[k] = 1.0 if slides else far
        far += math.hypot(*joint.origin) + (arm.farthest(k) if slides else 0.0)
    return tails @ np.abs(model.factors)


def limb_of_chain(arm: Chain, bodies: tuple[str, ...] = ()) -> ChainLimb:
    """Return the arrays of a chain that the kernels read.

    Parameters
    ----------
    arm : Chain
    bodies : tuple of str
        Names of the situation's bodies, for the pairs that the arm ignores.
    """
    model, m, count = arm.model, len(arm.model.links), len(arm.model.joints)
    low, high = np.array(arm.joint_range).T.copy()
    hand = model.hand
    joints, ends = _axes_along_z(model)
    ignored = np.zeros((m, len(bodies)), dtype=np.bool_)
    for link, name in arm.ignored:
        ignored[link, [b == name for b in bodies]] = True
    frames = np.zeros((count + 1, 12))
    frames[0, :9] = np.eye(3).ravel()
    return ChainLimb(
        joints=joints,
        low=low,
        high=high,
        carriers=np.array([link.joint for link in model.links] + [hand.joint]),
        ends=ends,
        radii=np.array([link.radius for link in model.links]),
        pairs=np.array(model.self_collision, dtype=np.int64).reshape(-1, 2),
        ignored=ignored,
        tails=_tails(arm),
        reach=arm.reach,
        thickness=arm.thickness,
        length=max(0.5 * arm.reach, *(link.radius for link in model.links)),
        start=np.array(arm.joints),
        rates=np.array(arm.joint_rates or (0.0,) * arm.dof),
        frames=frames,
        axes=np.zeros((count, 6)),
        reaches=np.zeros((m + 1, 6)),
        balls=balls_about(ends[:-1], np.array([link.radius for link in model.links])),
        near=np.zeros(m, dtype=np.int64),
        ways=np.zeros(m),
        turns=np.zeros(count),
        paces=np.zeros(count),
        tree=None if model.serial else tree_of(model),
        solved=np.empty(0),
    )


@lru_cache(maxsize=32)
def _axes_along_z(model: ChainModel) -> tuple[np.ndarray, np.ndarray]:
    """Return rows of joints (k, 13), and of links and hand (m + 1, 6), as `ChainLimb` has them.

    Frames are turned so that each joint moves about its z axis, which spares `place` a third.
    The arrays are kept, since a limb is packed for every situation.
    """
    turned, rows = [np.eye(3)], []
    for k, joint in enumerate(model.joints):
        before, turn = turned[model.parent(k)], frame_along(np.array(joint.axis))
        turned.append(turn)
        kind = REVOLUTE if joint.type == "revolute" else PRISMATIC
        rotation = before.T @ rotation_of(joint.rotation) @ turn
        rows.append([kind, *(before.T @ joint.origin), *rotation.ravel()])
    hand = model.hand
    ends = [(link.joint, link.start, link.end) for link in model.links]
    ends.append((hand.joint, hand.point, hand.axis))
    return np.array(rows), np.array([np.ravel(np.array([p, q]) @ turned[k]) for k, p, q in ends])
