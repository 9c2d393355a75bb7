"""Kinematics of a chain: frames, links, Jacobian and bounds of motion.

Kernels are in the frame of the base.  They write into arrays that the limb itself carries, so that
none is allocated; each worker packs a limb of its own.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from gcm_learn.arms.chain import Chain, ChainJoint
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
    farthest: float  # bound of the distance of the hand from any joint's axis
    thickness: float  # 0: links have radii of their own
    length: float  # unit of resolutions and safeties
    start: np.ndarray  # (n,) joints at t = 0
    rates: np.ndarray  # (n,) of the joints at t = 0
    frames: np.ndarray  # (n + 1, 12): rotation (9), origin (3) of every frame; written by `place`
    axes: np.ndarray  # (n, 6): a point on each joint's axis and its direction; written by `place`
    reaches: np.ndarray  # (m + 1, 6): ends of the links, then hand and axis; written by `place`
    ways: np.ndarray  # (m,): how far points of each link travel; written by `swept`


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


def chain_limb(arm: Chain, obstacles: dict[str, int] | None = None, bodies: int = 0) -> ChainLimb:
    """Return a chain as kernels read it.

    Parameters
    ----------
    arm : Chain
    obstacles : dict of str to int, optional
        Index of each obstacle, by name, for the pairs that the arm ignores.
    bodies : int
        Number of all bodies.
    """
    model, n, m = arm.model, arm.dof, len(arm.model.links)
    low, high = np.array(arm.joint_range).T.copy()
    hand = model.hand
    ends = [(*link.start, *link.end) for link in model.links] + [(*hand.point, *hand.axis)]
    ignored = np.zeros((m, bodies), dtype=np.bool_)
    for link, name in arm.ignore:
        if obstacles is not None and name in obstacles:
            ignored[link, obstacles[name]] = True
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
        farthest=arm.reach,
        thickness=arm.thickness,
        length=0.5 * arm.reach,
        start=np.array(arm.joints),
        rates=np.array(arm.joint_rates or (0.0,) * n),
        frames=frames,
        axes=np.zeros((n, 6)),
        reaches=np.zeros((m + 1, 6)),
        ways=np.zeros(m),
    )


def _joint_row(joint: ChainJoint) -> list[float]:
    kind = REVOLUTE if joint.type == "revolute" else PRISMATIC
    rotation = rotation_of(joint.rotation).ravel().tolist()
    return [kind, *joint.origin, *rotation, *joint.axis]


@njit
def _hands_and_links(limb, joints, out):
    """Write `reaches` of postures (k, n) into `out` (k, m + 1, 6)."""
    for k in range(joints.shape[0]):
        place(limb, joints[k])
        out[k] = limb.reaches


def links_of_chain(arm: Chain, joints: ArrayLike) -> np.ndarray:
    """Return the ends of all links, then hand and its axis, in the world.

    Parameters
    ----------
    arm : Chain
    joints : (k, n) array_like
        Postures, in their ranges or not.

    Returns
    -------
    (k, m + 1, 2, 3) ndarray
        For every posture and link both ends; last the hand's point and its axis.
    """
    given = np.ascontiguousarray(joints, dtype=float).reshape(-1, arm.dof)
    limb = chain_limb(arm)
    out = np.empty((given.shape[0], *limb.reaches.shape))
    _hands_and_links(limb, given, out)
    rows = out.reshape(given.shape[0], -1, 2, 3) @ rotation_of(arm.base.rotation).T
    rows[:, :-1] += np.array(arm.base.origin)
    rows[:, -1, 0] += np.array(arm.base.origin)
    return rows
