"""Kinematics of a chain: frames, links, Jacobian and bounds of motion.

Kernels are in the frame of the base.  They write into arrays that the limb itself carries, so that
none is allocated; each worker packs a limb of its own.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from gcm_learn.arms.chain import Chain, ChainJoint
from gcm_learn.arms.curves import on_curve, rate_of, turn_of
from gcm_learn.arms.link_gaps import middles_gap, segments_gap2
from gcm_learn.arms.rotations import rotation_of
from gcm_learn.compiled import njit

REVOLUTE, PRISMATIC = 0.0, 1.0
POINT, AXIS = 0, 3  # columns of `ChainLimb.reaches`


class ChainLimb(NamedTuple):
    """A chain as kernels read it, frame 0 at the origin."""

    joints: np.ndarray  # (n, 16): type, origin (3), rotation (9, row by row), axis (3)
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
    frames: np.ndarray  # (n + 1, 12): rotation (9), origin (3) of every frame; written by `place`
    axes: np.ndarray  # (n, 6): a point on each joint's axis and its direction; written by `place`
    reaches: np.ndarray  # (m + 1, 6): ends of the links, then hand and axis; written by `place`
    ways: np.ndarray  # (m,): how far points of each link travel; written by `swept`
    turns: np.ndarray  # (n,): how far joints turn; written by `swept`


@njit(_nrt=False)
def place(limb, q):
    """Write frames, axes and links at a posture (n,) into the limb's arrays."""
    frames, joints, axes = limb.frames, limb.joints, limb.axes
    for k in range(joints.shape[0]):
        _step(limb, k, q[k])
    for i in range(limb.carriers.size):
        f = limb.carriers[i]
        for e in range(2):
            x, y, z = limb.ends[i, 3 * e], limb.ends[i, 3 * e + 1], limb.ends[i, 3 * e + 2]
            shift = 0.0 if i == limb.radii.size and e == 1 else 1.0  # the hand's axis is no point
            for r in range(3):
                turned = frames[f, 3 * r] * x + frames[f, 3 * r + 1] * y + frames[f, 3 * r + 2] * z
                limb.reaches[i, 3 * e + r] = turned + shift * frames[f, 9 + r]
    return axes.shape[0]


@njit(_nrt=False)
def _step(limb, k, value):
    """Write frame k + 1 from frame k: the joint's place, then its motion."""
    frames, row = limb.frames, limb.joints
    for r in range(3):
        a, b, c = frames[k, 3 * r], frames[k, 3 * r + 1], frames[k, 3 * r + 2]
        at = frames[k, 9 + r] + a * row[k, 1] + b * row[k, 2] + c * row[k, 3]
        u = a * row[k, 4] + b * row[k, 7] + c * row[k, 10]
        v = a * row[k, 5] + b * row[k, 8] + c * row[k, 11]
        w = a * row[k, 6] + b * row[k, 9] + c * row[k, 12]
        along = u * row[k, 13] + v * row[k, 14] + w * row[k, 15]
        limb.axes[k, r], limb.axes[k, 3 + r] = at, along
        frames[k + 1, 3 * r], frames[k + 1, 3 * r + 1], frames[k + 1, 3 * r + 2] = u, v, w
        frames[k + 1, 9 + r] = at + (along * value if row[k, 0] == PRISMATIC else 0.0)
    if row[k, 0] == REVOLUTE:
        _turn(frames, k + 1, value, row[k, 13], row[k, 14], row[k, 15])


@njit(_nrt=False, forceinline=True)
def _turn(frames, f, angle, x, y, z):
    """Turn frame f about its own axis (x, y, z): Rodrigues' formula from the right."""
    c, s = np.cos(angle), np.sin(angle)
    v = 1.0 - c
    for r in range(3):
        a, b, d = frames[f, 3 * r], frames[f, 3 * r + 1], frames[f, 3 * r + 2]
        along = (a * x + b * y + d * z) * v
        frames[f, 3 * r] = c * a + along * x + s * (b * z - d * y)
        frames[f, 3 * r + 1] = c * b + along * y + s * (d * x - a * z)
        frames[f, 3 * r + 2] = c * d + along * z + s * (a * y - b * x)


@njit(_nrt=False, forceinline=True)
def _off_axis(limb, k, x, y, z):
    """Distance of a point to the axis of joint k."""
    px, py, pz = x - limb.axes[k, 0], y - limb.axes[k, 1], z - limb.axes[k, 2]
    ax, ay, az = limb.axes[k, 3], limb.axes[k, 4], limb.axes[k, 5]
    u, v, w = ay * pz - az * py, az * px - ax * pz, ax * py - ay * px
    return np.sqrt(u * u + v * v + w * w)


@njit(_nrt=False)
def travel(limb, i, turns):
    """Bound how far points of link i travel while each joint moves by at most its turn (n,).

    The outermost joint is moved first: it carries points no farther than its turn times their
    distance to its axis, which is where `place` left it.  Each joint before it finds them displaced
    by what the others did.  On a link the farther end bounds all points.
    """
    way = 0.0
    x, y, z = limb.reaches[i, 0], limb.reaches[i, 1], limb.reaches[i, 2]
    u, v, w = limb.reaches[i, 3], limb.reaches[i, 4], limb.reaches[i, 5]
    for k in range(limb.carriers[i] - 1, -1, -1):
        if turns[k] > 0.0:
            if limb.joints[k, 0] == PRISMATIC:
                way += turns[k]
            else:
                off = max(_off_axis(limb, k, x, y, z), _off_axis(limb, k, u, v, w))
                way += turns[k] * (off + way)
    return way


@njit(_nrt=False, forceinline=True)
def dof(limb):
    """Number of joints."""
    return limb.low.size


@njit(_nrt=False, forceinline=True)
def hand_of(limb, place):
    """Hand where `place` left it."""
    row = limb.radii.size
    return limb.reaches[row, 0], limb.reaches[row, 1], limb.reaches[row, 2]


@njit(_nrt=False, forceinline=True)
def axis_of(limb, place):
    """Direction of the hand where `place` left it."""
    row = limb.radii.size
    return limb.reaches[row, 3], limb.reaches[row, 4], limb.reaches[row, 5]


@njit(_nrt=False, forceinline=True)
def link_count(limb):
    """Number of links."""
    return limb.radii.size


@njit(_nrt=False, forceinline=True)
def link(limb, place, i):
    """Ends of a link's axis where `place` left them, and its radius."""
    r = limb.reaches
    return r[i, 0], r[i, 1], r[i, 2], r[i, 3], r[i, 4], r[i, 5], limb.radii[i]


@njit(_nrt=False, forceinline=True)
def ignores(limb, i, b):
    """Return whether a link is not checked against a body."""
    return limb.ignored[i, b]


@njit(_nrt=False)
def self_gap(limb, place, slack, enough):
    """Distance of the nearest pair of links that must not overlap, and the same less slack."""
    best, room, r = 1e300, 1e300, limb.reaches
    for k in range(limb.pairs.shape[0]):
        i, j = limb.pairs[k, 0], limb.pairs[k, 1]
        thick, slip = limb.radii[i] + limb.radii[j], limb.ways[i] + limb.ways[j]
        gap = middles_gap(r, i, j) - thick
        if gap - slip <= enough:
            gap = np.sqrt(max(segments_gap2(r, i, j), 0.0)) - thick
        best, room = min(best, gap), min(room, gap - slip)
    return best, room


@njit(_nrt=False)
def still(limb):
    """Note that no link moves."""
    for i in range(limb.ways.size):
        limb.ways[i] = 0.0
    return 0


@njit(_nrt=False)
def swept(limb, curve, s, half, place):
    """Note how far points of each link travel from share s of a move to s +- half."""
    for k in range(limb.turns.size):
        limb.turns[k] = turn_of(curve, k, s, half)
    for i in range(limb.ways.size):
        limb.ways[i] = travel(limb, i, limb.turns)
    return 0


@njit(_nrt=False, forceinline=True)
def slack_of(limb, slack, i):
    """Return the bound of travel of a link, as noted last."""
    return limb.ways[i]


@njit(_nrt=False)
def hand_rate(limb, curve, s, q):
    """Way of the hand per share of a move at share s; `q` (n,) gets the joints."""
    on_curve(curve, s, q)
    place(limb, q)
    hand, last = limb.radii.size, limb.carriers[limb.radii.size]
    vx, vy, vz = 0.0, 0.0, 0.0
    for k in range(last):
        rate = rate_of(curve, k, s)
        ax, ay, az = limb.axes[k, 3], limb.axes[k, 4], limb.axes[k, 5]
        if limb.joints[k, 0] == REVOLUTE:
            x = limb.reaches[hand, 0] - limb.axes[k, 0]
            y = limb.reaches[hand, 1] - limb.axes[k, 1]
            z = limb.reaches[hand, 2] - limb.axes[k, 2]
            ax, ay, az = ay * z - az * y, az * x - ax * z, ax * y - ay * x
        vx, vy, vz = vx + rate * ax, vy + rate * ay, vz + rate * az
    return np.sqrt(vx * vx + vy * vy + vz * vz)


@njit(_nrt=False)
def hand_travel(limb, q, p):
    """Bound how far the hand travels on the straight move from q to p (n,)."""
    way = 0.0
    for k in range(limb.tails.size):
        way += abs(p[k] - q[k]) * limb.tails[k]
    return way


@njit(_nrt=False)
def hand_bound(limb, rates):
    """Bound of the hand's speed while the joints' rates are at most `rates` (n,)."""
    speed = 0.0
    for k in range(limb.tails.size):
        speed += rates[k] * limb.tails[k]
    return speed


@njit(_nrt=False)
def axis_bound(limb, rates):
    """Bound of the angular speed of the hand's axis."""
    speed = 0.0
    for k in range(limb.carriers[limb.radii.size]):
        if limb.joints[k, 0] == REVOLUTE:
            speed += rates[k]
    return speed


@njit(_nrt=False, forceinline=True)
def reach_of(limb):
    """Bound of the distance between frame 0 and the hand."""
    return limb.reach


@njit(_nrt=False)
def lever(limb):
    """Bound of the hand's way for a unit of any joint; at least 1, as of prismatic joints."""
    return max(limb.reach, 1.0)


@njit(_nrt=False)
def axis_turns(limb, q, out):
    """Write the derivative of the hand's axis by the joints (n,) into `out` (3, n)."""
    place(limb, q)
    hand, last = limb.radii.size, limb.carriers[limb.radii.size]
    x, y, z = limb.reaches[hand, 3], limb.reaches[hand, 4], limb.reaches[hand, 5]
    for k in range(limb.low.size):
        ax, ay, az = limb.axes[k, 3], limb.axes[k, 4], limb.axes[k, 5]
        if k >= last or limb.joints[k, 0] == PRISMATIC:
            ax, ay, az = 0.0, 0.0, 0.0
        out[0, k], out[1, k], out[2, k] = ay * z - az * y, az * x - ax * z, ax * y - ay * x


@njit(_nrt=False)
def postures_at(limb, x, y, z, k, count, low, high, out):
    """Write one posture between `low` and `high`: point k of an additive recurrence.

    There is no closed-form inverse; the posture has to be pulled to where the hand should be.  The
    steps are powers of the root of x^(n+1) = x + 1 (M. Roberts, 2018), which fill a box evenly.
    """
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
    """Write the derivative of the hand by the joints (n,) into `out` (3, n)."""
    place(limb, q)
    hand, last = limb.radii.size, limb.carriers[limb.radii.size]
    for k in range(limb.joints.shape[0]):
        ax, ay, az = limb.axes[k, 3], limb.axes[k, 4], limb.axes[k, 5]
        x = limb.reaches[hand, 0] - limb.axes[k, 0]
        y = limb.reaches[hand, 1] - limb.axes[k, 1]
        z = limb.reaches[hand, 2] - limb.axes[k, 2]
        if k >= last:
            ax, ay, az = 0.0, 0.0, 0.0
        if limb.joints[k, 0] == REVOLUTE:
            ax, ay, az = ay * z - az * y, az * x - ax * z, ax * y - ay * x
        out[0, k], out[1, k], out[2, k] = ax, ay, az


def _tails(arm: Chain) -> np.ndarray:
    """Bound of the hand's way for a unit of each joint (n,), at any posture."""
    hand, tails = arm.model.hand, np.zeros(arm.dof)
    far = math.hypot(*hand.point)
    for k in range(hand.joint - 1, -1, -1):
        joint = arm.model.joints[k]
        if joint.type == "prismatic":
            tails[k] = 1.0
            far += max(abs(joint.range[0]), abs(joint.range[1]))
        else:
            tails[k] = far
        far += math.hypot(*joint.origin)
    return tails


def chain_limb_of(arm: Chain, bodies: tuple[str, ...] = ()) -> ChainLimb:
    """Return a chain as kernels read it.

    Parameters
    ----------
    arm : Chain
    bodies : tuple of str
        Names of the situation's bodies, for the pairs that the arm ignores.
    """
    model, n, m = arm.model, arm.dof, len(arm.model.links)
    low, high = np.array(arm.joint_range).T.copy()
    hand = model.hand
    ends = [(*link.start, *link.end) for link in model.links] + [(*hand.point, *hand.axis)]
    ignored = np.zeros((m, len(bodies)), dtype=np.bool_)
    for link, name in arm.ignore:
        ignored[link, [b == name for b in bodies]] = True
    frames = np.zeros((n + 1, 12))
    frames[0, :9] = np.eye(3).ravel()
    return ChainLimb(
        joints=np.array([_joint_row(joint) for joint in model.joints]),
        low=low,
        high=high,
        carriers=np.array([link.joint for link in model.links] + [hand.joint]),
        ends=np.array(ends, dtype=float),
        radii=np.array([link.radius for link in model.links]),
        pairs=np.array(model.self_collision, dtype=np.int64).reshape(-1, 2),
        ignored=ignored,
        tails=_tails(arm),
        reach=arm.reach,
        thickness=arm.thickness,
        length=max(0.5 * arm.reach, *(link.radius for link in model.links)),
        start=np.array(arm.joints),
        rates=np.array(arm.joint_rates or (0.0,) * n),
        frames=frames,
        axes=np.zeros((n, 6)),
        reaches=np.zeros((m + 1, 6)),
        ways=np.zeros(m),
        turns=np.zeros(n),
    )


def _joint_row(joint: ChainJoint) -> list[float]:
    kind = REVOLUTE if joint.type == "revolute" else PRISMATIC
    rotation = rotation_of(joint.rotation).ravel().tolist()
    return [kind, *joint.origin, *rotation, *joint.axis]
