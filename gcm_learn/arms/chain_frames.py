"""Frames and links of a chain in plain arrays, and bounds of their motion.

Calls hand over every array of a tuple, number by number, which takes as long as the work of a small
function.  So these kernels take the arrays that they need.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gcm_learn.arms.curves import rate_of, turn_of
from gcm_learn.compiled import njit

if TYPE_CHECKING:
    from gcm_learn.arms.chain_model import ChainModel

REVOLUTE, PRISMATIC = 0.0, 1.0


class Tree(NamedTuple):
    """Branches and followers of a chain of k joints; a serial chain has None instead of a Tree."""

    parents: np.ndarray  # (k,): frame on which each joint stands
    leaders: np.ndarray  # (k,): coordinate of each joint
    lines: np.ndarray  # (k, 2): factor and offset of each joint's value
    depths: np.ndarray  # (m + 1,): joints that move each link, and last the hand
    paths: np.ndarray  # (m + 1, k): these joints, from the base outwards


def tree_of(model: ChainModel) -> Tree:
    """Return branches and followers of a chain as kernels read them."""
    paths = [
        model.path(frame) for frame in [*(link.joint for link in model.links), model.hand.joint]
    ]
    table = np.zeros((len(paths), len(model.joints)), dtype=np.int64)
    for row, path in zip(table, paths, strict=True):
        row[: len(path)] = path
    return Tree(
        parents=np.array([model.parent(k) for k in range(len(model.joints))]),
        leaders=np.array([line.coordinate for line in model.lines]),
        lines=np.array([[line.factor, line.offset] for line in model.lines]),
        depths=np.array([len(path) for path in paths]),
        paths=table,
    )


@njit(_nrt=False, forceinline=True)
def depth_of(tree, carriers, i):
    """Number of the joints that move link i."""
    return carriers[i] if tree is None else tree.depths[i]


@njit(_nrt=False, forceinline=True)
def moving(tree, i, step):
    """Return joint number `step`, from the base outwards, among the joints that move link i."""
    return step if tree is None else tree.paths[i, step]


@njit(_nrt=False, forceinline=True)
def parent_of(tree, k):
    """Frame on which joint k stands."""
    return k if tree is None else tree.parents[k]


@njit(_nrt=False, forceinline=True)
def line_of(tree, k):
    """Return the coordinate of joint k, and the factor and offset of the joint's value."""
    return (k, 1.0, 0.0) if tree is None else (tree.leaders[k], tree.lines[k, 0], tree.lines[k, 1])


@njit(_nrt=False, forceinline=True)
def point_on(frames, carriers, ends, m):
    """First end (3) of link m, by the frames."""
    k, u, v, w = carriers[m], ends[m, 0], ends[m, 1], ends[m, 2]
    return (
        frames[k, 9] + frames[k, 0] * u + frames[k, 1] * v + frames[k, 2] * w,
        frames[k, 10] + frames[k, 3] * u + frames[k, 4] * v + frames[k, 5] * w,
        frames[k, 11] + frames[k, 6] * u + frames[k, 7] * v + frames[k, 8] * w,
    )


@njit(_nrt=False)
def place_links(carriers, ends, frames, out, balls):
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
def place_frames(rows, q, frames, axes, tree):
    """Write frames and axes.  The frame at hand is kept in numbers: arrays may overlap."""
    a, b, c, d, e, f, g, h, i = 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0
    x, y, z = 0.0, 0.0, 0.0
    for k in range(rows.shape[0]):
        j, factor, offset = line_of(tree, k)
        value = factor * q[j] + offset
        p = parent_of(tree, k)
        if p != k:
            a, b, c, x = frames[p, 0], frames[p, 1], frames[p, 2], frames[p, 9]
            d, e, f, y = frames[p, 3], frames[p, 4], frames[p, 5], frames[p, 10]
            g, h, i, z = frames[p, 6], frames[p, 7], frames[p, 8], frames[p, 11]
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
            u, v = np.cos(value), np.sin(value)
            a, d, g = u * ax + v * bx, u * ay + v * by, u * az + v * bz
            b, e, h = u * bx - v * ax, u * by - v * ay, u * bz - v * az
        else:
            a, d, g, b, e, h = ax, ay, az, bx, by, bz
            x, y, z = x + c * value, y + f * value, z + i * value
        frames[k + 1, 0], frames[k + 1, 1], frames[k + 1, 2] = a, b, c
        frames[k + 1, 3], frames[k + 1, 4], frames[k + 1, 5] = d, e, f
        frames[k + 1, 6], frames[k + 1, 7], frames[k + 1, 8] = g, h, i
        frames[k + 1, 9], frames[k + 1, 10], frames[k + 1, 11] = x, y, z


@njit(_nrt=False, forceinline=True)
def turned_by(axes, k, x, y, z):
    """Velocity (3) of a point that joint k turns at a unit of rate."""
    px, py, pz = x - axes[k, 0], y - axes[k, 1], z - axes[k, 2]
    ax, ay, az = axes[k, 3], axes[k, 4], axes[k, 5]
    return ay * pz - az * py, az * px - ax * pz, ax * py - ay * px


@njit(_nrt=False, forceinline=True)
def moved_by(joints, axes, k, x, y, z):
    """Velocity (3) of a point that joint k moves at a unit of rate."""
    if joints[k, 0] == PRISMATIC:
        return axes[k, 3], axes[k, 4], axes[k, 5]
    return turned_by(axes, k, x, y, z)


@njit(_nrt=False, forceinline=True)
def travel_of(joints, axes, reaches, carriers, i, turns, rates, half, tree):
    """Bound how far points of link i travel from share s of a move to s +- half.

    There are two bounds; on a link the farther end bounds all points.

    Joint by joint, the outermost moves first: it carries points no farther than its turn times
    their distance to its axis, which is where `place` left it.  Each joint before it finds them
    displaced by what the others did.

    Or all joints move at once, and points go on with their velocity at s.  They stray by what rates
    change, and by their acceleration: each joint turns the velocity that joints beyond it give.

    Parameters
    ----------
    turns : (n,) ndarray
        Bound how far each joint turns.
    rates : (n,) ndarray
        Of the joints at s, per share.
    """
    way, stray, before = 0.0, 0.0, 0.0
    x, y, z = reaches[i, 0], reaches[i, 1], reaches[i, 2]
    u, v, w = reaches[i, 3], reaches[i, 4], reaches[i, 5]
    ax, ay, az, bx, by, bz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    last = depth_of(tree, carriers, i)
    for step in range(last):
        k = moving(tree, i, step)
        before += turns[k] if joints[k, 0] == REVOLUTE else 0.0
    for step in range(last - 1, -1, -1):
        k = moving(tree, i, step)
        if turns[k] > 0.0:
            if joints[k, 0] == PRISMATIC:
                px, py, pz = axes[k, 3], axes[k, 4], axes[k, 5]
                qx, qy, qz, gain, turn = px, py, pz, turns[k], 0.0
                changed = turns[k] - half * abs(rates[k])
            else:
                px, py, pz = turned_by(axes, k, x, y, z)
                qx, qy, qz = turned_by(axes, k, u, v, w)
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
def sweep_links(joints, axes, reaches, carriers, curve, s, half, turns, rates, ways, tree):
    """Write how far points of each link travel into `ways` (m,); see `swept`."""
    for k in range(turns.size):
        j, factor, _ = line_of(tree, k)
        turns[k], rates[k] = abs(factor) * turn_of(curve, j, s, half), factor * rate_of(curve, j, s)
    for i in range(ways.size):
        ways[i] = travel_of(joints, axes, reaches, carriers, i, turns, rates, half, tree)
