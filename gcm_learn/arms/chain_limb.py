"""Kinematics of a chain: frames, links, Jacobian and bounds of motion.

Kernels are in the frame of the base.  They write into arrays that the limb itself carries, so that
none is allocated; each worker packs a limb of its own.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from gcm_learn.arms.chain import Chain, ChainModel
from gcm_learn.arms.curves import on_curve, rate_of, turn_of
from gcm_learn.arms.link_gaps import segments_gap2
from gcm_learn.arms.rotations import rotation_of
from gcm_learn.compiled import njit

REVOLUTE, PRISMATIC = 0.0, 1.0
POINT, AXIS = 0, 3  # columns of `ChainLimb.reaches`


class ChainLimb(NamedTuple):
    """A chain as kernels read it, frame 0 at the origin."""

    joints: np.ndarray  # (n, 13): type, origin (3), rotation (9, row by row); z is the joint's axis
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
    balls: np.ndarray  # (m, 4): centre, written by `place`, and radius of balls about the links
    near: np.ndarray  # (m,): links; written by `near_links`
    ways: np.ndarray  # (m,): how far points of each link travel; written by `swept`
    turns: np.ndarray  # (n,): how far joints turn; written by `swept`
    paces: np.ndarray  # (n,): rates of joints per share of a move; written by `swept`


# A call hands over every array of a tuple, number by number, which takes as long as the work of a
# small function. So small functions are in the place of their call, and larger ones take what they
# need.
@njit(_nrt=False, forceinline=True)
def place(limb, q):
    """Write frames, axes and links at a posture (n,) into the limb's arrays."""
    _frames(limb.joints, q, limb.frames, limb.axes)
    _links(limb.carriers, limb.ends, limb.frames, limb.reaches, limb.balls)
    return q.size


@njit(_nrt=False)
def _links(carriers, ends, frames, out, balls):
    """Write ends and balls of links, and last the hand's point and axis, by the frames."""
    for m in range(carriers.size):
        k = carriers[m]
        a, b, c, x = frames[k, 0], frames[k, 1], frames[k, 2], frames[k, 9]
        d, e, f, y = frames[k, 3], frames[k, 4], frames[k, 5], frames[k, 10]
        g, h, i, z = frames[k, 6], frames[k, 7], frames[k, 8], frames[k, 11]
        u, v, w = ends[m, 0], ends[m, 1], ends[m, 2]
        r, s, t = ends[m, 3], ends[m, 4], ends[m, 5]
        px, py, pz = a * u + b * v + c * w, d * u + e * v + f * w, g * u + h * v + i * w
        qx, qy, qz = a * r + b * s + c * t, d * r + e * s + f * t, g * r + h * s + i * t
        out[m, 0], out[m, 1], out[m, 2] = px + x, py + y, pz + z
        if m + 1 < carriers.size:  # the hand's axis is no point
            qx, qy, qz = qx + x, qy + y, qz + z
            balls[m, 0], balls[m, 1] = 0.5 * (px + qx + x), 0.5 * (py + qy + y)
            balls[m, 2] = 0.5 * (pz + qz + z)
        out[m, 3], out[m, 4], out[m, 5] = qx, qy, qz


@njit(_nrt=False)
def _frames(rows, q, frames, axes):
    """Write frames and axes.  The frame at hand is kept in numbers: arrays may overlap."""
    a, b, c, d, e, f, g, h, i = 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0
    x, y, z = 0.0, 0.0, 0.0
    for k in range(q.size):
        u, v, w = rows[k, 1], rows[k, 2], rows[k, 3]
        x, y, z = (
            x + a * u + b * v + c * w, y + d * u + e * v + f * w, z + g * u + h * v + i * w
        )  # fmt: skip
        u, v, w = rows[k, 4], rows[k, 7], rows[k, 10]
        ax, ay, az = a * u + b * v + c * w, d * u + e * v + f * w, g * u + h * v + i * w
        u, v, w = rows[k, 5], rows[k, 8], rows[k, 11]
        bx, by, bz = a * u + b * v + c * w, d * u + e * v + f * w, g * u + h * v + i * w
        u, v, w = rows[k, 6], rows[k, 9], rows[k, 12]
        c, f, i = a * u + b * v + c * w, d * u + e * v + f * w, g * u + h * v + i * w
        axes[k, 0], axes[k, 1], axes[k, 2] = x, y, z
        axes[k, 3], axes[k, 4], axes[k, 5] = c, f, i
        if rows[k, 0] == REVOLUTE:
            u, v = np.cos(q[k]), np.sin(q[k])
            a, d, g = u * ax + v * bx, u * ay + v * by, u * az + v * bz
            b, e, h = u * bx - v * ax, u * by - v * ay, u * bz - v * az
        else:
            a, d, g, b, e, h = ax, ay, az, bx, by, bz
            x, y, z = x + c * q[k], y + f * q[k], z + i * q[k]
        frames[k + 1, 0], frames[k + 1, 1], frames[k + 1, 2] = a, b, c
        frames[k + 1, 3], frames[k + 1, 4], frames[k + 1, 5] = d, e, f
        frames[k + 1, 6], frames[k + 1, 7], frames[k + 1, 8] = g, h, i
        frames[k + 1, 9], frames[k + 1, 10], frames[k + 1, 11] = x, y, z


@njit(_nrt=False, forceinline=True)
def _turned_by(axes, k, x, y, z):
    """Velocity (3) of a point that joint k turns at a unit of rate."""
    px, py, pz = x - axes[k, 0], y - axes[k, 1], z - axes[k, 2]
    ax, ay, az = axes[k, 3], axes[k, 4], axes[k, 5]
    return ay * pz - az * py, az * px - ax * pz, ax * py - ay * px


@njit(_nrt=False, forceinline=True)
def _travel(joints, axes, reaches, last, i, turns, rates, half):
    """Bound how far points of link i travel from share s of a move to s +- half.

    There are two bounds; on a link the farther end bounds all points.

    Joint by joint, the outermost moves first: it carries points no farther than its turn times
    their distance to its axis, which is where `place` left it.  Each joint before it finds them
    displaced by what the others did.

    Or all joints move at once, and points go on with their velocity at s.  They stray by what rates
    change, and by their acceleration: each joint turns the velocity that joints beyond it give.

    Parameters
    ----------
    last : int
        Joints before this one carry the link.
    turns : (n,) ndarray
        Bound how far each joint turns.
    rates : (n,) ndarray
        Of the joints at s, per share.
    """
    way, stray, before = 0.0, 0.0, 0.0
    x, y, z = reaches[i, 0], reaches[i, 1], reaches[i, 2]
    u, v, w = reaches[i, 3], reaches[i, 4], reaches[i, 5]
    ax, ay, az, bx, by, bz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(last):
        before += turns[k] if joints[k, 0] == REVOLUTE else 0.0
    for k in range(last - 1, -1, -1):
        if turns[k] > 0.0:
            if joints[k, 0] == PRISMATIC:
                px, py, pz = axes[k, 3], axes[k, 4], axes[k, 5]
                qx, qy, qz, gain, turn = px, py, pz, turns[k], 0.0
                changed = turns[k] - half * abs(rates[k])
            else:
                px, py, pz = _turned_by(axes, k, x, y, z)
                qx, qy, qz = _turned_by(axes, k, u, v, w)
                off = max(px * px + py * py + pz * pz, qx * qx + qy * qy + qz * qz)
                off, turn = np.sqrt(off) + way, turns[k]
                gain, changed = turn * off, (turn - half * abs(rates[k])) * off
            way += gain
            before -= turn
            stray += changed + gain * (before + 0.5 * turn)
            ax, ay, az = ax + rates[k] * px, ay + rates[k] * py, az + rates[k] * pz
            bx, by, bz = bx + rates[k] * qx, by + rates[k] * qy, bz + rates[k] * qz
    fast = np.sqrt(max(ax * ax + ay * ay + az * az, bx * bx + by * by + bz * bz))
    return min(way, half * fast + stray)


@njit(_nrt=False)
def travel(limb, i, turns, rates, half):
    """Bound how far points of link i travel; see `_travel`."""
    return _travel(
        limb.joints, limb.axes, limb.reaches, limb.carriers[i], i, turns, rates, half
    )  # fmt: skip


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


@njit(_nrt=False)
def near_links(balls, ways, x, y, z, far, near):
    """Write the links whose balls are within `far` of a point, less their slack, into `near`.

    Returns
    -------
    int
        Number of these links.
    """
    count = 0
    for i in range(ways.size):
        u, v, w = x - balls[i, 0], y - balls[i, 1], z - balls[i, 2]
        most = far + balls[i, 3] + ways[i]
        near[count] = i
        if most >= 0.0 and u * u + v * v + w * w <= most * most:
            count += 1
    return count


@njit(_nrt=False, forceinline=True)
def ignores(limb, i, b):
    """Return whether a link is not checked against a body."""
    return limb.ignored[i, b]


@njit(_nrt=False, forceinline=True)
def self_gap(limb, place, slack, enough):
    """Distance of the nearest pair of links that must not overlap, and the same less slack.

    Pairs are left out where the balls about them are farther apart than `enough`.
    """
    return _nearest_pair(limb.pairs, limb.radii, limb.reaches, limb.balls, limb.ways, enough)


@njit(_nrt=False)
def _nearest_pair(pairs, radii, r, balls, ways, enough):
    best, room = 1e300, 1e300
    for k in range(pairs.shape[0]):
        i, j = pairs[k, 0], pairs[k, 1]
        slip = ways[i] + ways[j]
        far = enough + slip + balls[i, 3] + balls[j, 3]
        x, y, z = balls[i, 0] - balls[j, 0], balls[i, 1] - balls[j, 1], balls[i, 2] - balls[j, 2]
        if far < 0.0 or x * x + y * y + z * z > far * far:
            continue
        gap = np.sqrt(max(segments_gap2(r, i, j), 0.0)) - radii[i] - radii[j]
        best, room = min(best, gap), min(room, gap - slip)
    return best, room


@njit(_nrt=False)
def still(limb):
    """Note that no link moves."""
    for i in range(limb.ways.size):
        limb.ways[i] = 0.0
    return 0


@njit(_nrt=False, forceinline=True)
def swept(limb, curve, s, half, place):
    """Note how far points of each link travel from share s of a move to s +- half."""
    _sweep(
        limb.joints, limb.axes, limb.reaches, limb.carriers, curve, s, half, limb.turns,
        limb.paces, limb.ways,
    )  # fmt: skip
    return 0


@njit(_nrt=False)
def _sweep(joints, axes, reaches, carriers, curve, s, half, turns, rates, ways):
    for k in range(turns.size):
        turns[k], rates[k] = turn_of(curve, k, s, half), rate_of(curve, k, s)
    for i in range(ways.size):
        ways[i] = _travel(joints, axes, reaches, carriers[i], i, turns, rates, half)


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
    """Write the derivative of the hand's axis, after `place`, into `out` (3, n)."""
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
    """Write the derivative of the hand by the joints (n,), after `place`, into `out` (3, n)."""
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
    joints, ends = _axes_along_z(model)
    ignored = np.zeros((m, len(bodies)), dtype=np.bool_)
    for link, name in arm.ignore:
        ignored[link, [b == name for b in bodies]] = True
    frames = np.zeros((n + 1, 12))
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
        rates=np.array(arm.joint_rates or (0.0,) * n),
        frames=frames,
        axes=np.zeros((n, 6)),
        reaches=np.zeros((m + 1, 6)),
        balls=_balls(ends[:-1], np.array([link.radius for link in model.links])),
        near=np.zeros(m, dtype=np.int64),
        ways=np.zeros(m),
        turns=np.zeros(n),
        paces=np.zeros(n),
    )


def _axes_along_z(model: ChainModel) -> tuple[np.ndarray, np.ndarray]:
    """Return rows of joints (n, 13), and of links and hand (m + 1, 6), as `ChainLimb` has them.

    Frames are turned so that each joint moves about its z axis, which spares `place` a third.
    """
    turned, rows = [np.eye(3)], []
    for joint in model.joints:
        before, turn = turned[-1], _to_z(np.array(joint.axis))
        turned.append(turn)
        kind = REVOLUTE if joint.type == "revolute" else PRISMATIC
        rotation = before.T @ rotation_of(joint.rotation) @ turn
        rows.append([kind, *(before.T @ joint.origin), *rotation.ravel()])
    hand = model.hand
    ends = [(link.joint, link.start, link.end) for link in model.links]
    ends.append((hand.joint, hand.point, hand.axis))
    return np.array(rows), np.array([np.ravel(np.array([p, q]) @ turned[k]) for k, p, q in ends])


def _balls(ends: np.ndarray, radii: np.ndarray) -> np.ndarray:
    """Return balls about links (m, 4): centres, not yet known, and radii."""
    balls = np.zeros((len(ends), 4))
    # rounded up, as a link must not stick out
    balls[:, 3] = (0.5 * np.linalg.norm(ends[:, 3:] - ends[:, :3], axis=1) + radii) * (1.0 + 1e-9)
    return balls


def _to_z(axis: np.ndarray) -> np.ndarray:
    """Return a rotation (3, 3) whose third column is a unit vector (3,)."""
    if axis[0] == axis[1] == 0.0 < axis[2]:
        return np.eye(3)
    first = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(axis, first), axis], axis=1)
