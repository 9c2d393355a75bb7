"""Kinematics of chains with branches or followers: what differs from `chain_limb`.

A joint's value is a line of a coordinate, and a link is moved by the joints on its path alone.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.arms.chain import Chain
from gcm_learn.arms.chain_frames import REVOLUTE, place_frames, place_links, travel_of, turned_by
from gcm_learn.arms.chain_limb import ChainLimb, chain_limb_of
from gcm_learn.arms.curves import on_curve, rate_of, turn_of
from gcm_learn.compiled import njit


class TreeLimb(NamedTuple):
    """A chain of k joints and n coordinates; fields of `ChainLimb`, and then its own."""

    joints: np.ndarray  # (k, 13)
    low: np.ndarray  # (n,)
    high: np.ndarray  # (n,)
    carriers: np.ndarray  # (m + 1,)
    ends: np.ndarray  # (m + 1, 6)
    radii: np.ndarray  # (m,)
    pairs: np.ndarray  # (p, 2)
    ignored: np.ndarray  # (m, bodies) bool
    tails: np.ndarray  # (n,)
    reach: float
    thickness: float
    length: float
    start: np.ndarray  # (n,)
    rates: np.ndarray  # (n,)
    frames: np.ndarray  # (k + 1, 12)
    axes: np.ndarray  # (k, 6)
    reaches: np.ndarray  # (m + 1, 6)
    balls: np.ndarray  # (m, 4)
    near: np.ndarray  # (m,)
    ways: np.ndarray  # (m,)
    turns: np.ndarray  # (k,)
    paces: np.ndarray  # (k,)
    parents: np.ndarray  # (k,): frame on which each joint stands
    leaders: np.ndarray  # (k,): coordinate of each joint
    lines: np.ndarray  # (k, 2): factor and offset of each joint's value
    depths: np.ndarray  # (m + 1,): joints that move each link, and last the hand
    paths: np.ndarray  # (m + 1, k): these joints, from the base outwards
    values: np.ndarray  # (k,): of the joints; written by `place`
    slopes: np.ndarray  # (3, n): scratch


@njit(_nrt=False)
def place(limb, q):
    """Write frames, axes and links at a posture (n,) into the limb's arrays."""
    for k in range(limb.leaders.size):
        limb.values[k] = limb.lines[k, 0] * q[limb.leaders[k]] + limb.lines[k, 1]
    place_frames(limb.joints, limb.values, limb.frames, limb.axes, limb.parents)
    place_links(limb.carriers, limb.ends, limb.frames, limb.reaches, limb.balls)
    return q.size


@njit(_nrt=False)
def travel(limb, i, turns, rates, half):
    """Bound how far points of link i travel, by all joints' turns; see `travel_of`."""
    return travel_of(
        limb.joints, limb.axes, limb.reaches, limb.depths[i], i, turns, rates, half, limb.paths
    )  # fmt: skip


@njit(_nrt=False)
def swept(limb, curve, s, half, place):
    """Note how far points of each link travel from share s of a move to s +- half."""
    for k in range(limb.leaders.size):
        j, factor = limb.leaders[k], limb.lines[k, 0]
        limb.turns[k] = abs(factor) * turn_of(curve, j, s, half)
        limb.paces[k] = factor * rate_of(curve, j, s)
    for i in range(limb.ways.size):
        limb.ways[i] = travel(limb, i, limb.turns, limb.paces, half)
    return 0


@njit(_nrt=False)
def jacobian(limb, q, out):
    """Write the derivative of the hand by coordinates, after `place`, into `out` (3, n)."""
    hand = limb.radii.size
    x, y, z = limb.reaches[hand, 0], limb.reaches[hand, 1], limb.reaches[hand, 2]
    _clear(out)
    for step in range(limb.depths[hand]):
        k = limb.paths[hand, step]
        j, factor = limb.leaders[k], limb.lines[k, 0]
        ax, ay, az = limb.axes[k, 3], limb.axes[k, 4], limb.axes[k, 5]
        if limb.joints[k, 0] == REVOLUTE:
            ax, ay, az = turned_by(limb.axes, k, x, y, z)
        out[0, j] += factor * ax
        out[1, j] += factor * ay
        out[2, j] += factor * az


@njit(_nrt=False)
def axis_turns(limb, q, out):
    """Write the derivative of the hand's axis, after `place`, into `out` (3, n)."""
    hand = limb.radii.size
    x, y, z = limb.reaches[hand, 3], limb.reaches[hand, 4], limb.reaches[hand, 5]
    _clear(out)
    for step in range(limb.depths[hand]):
        k = limb.paths[hand, step]
        if limb.joints[k, 0] == REVOLUTE:
            j, factor = limb.leaders[k], limb.lines[k, 0]
            ax, ay, az = limb.axes[k, 3], limb.axes[k, 4], limb.axes[k, 5]
            out[0, j] += factor * (ay * z - az * y)
            out[1, j] += factor * (az * x - ax * z)
            out[2, j] += factor * (ax * y - ay * x)


@njit(_nrt=False)
def _clear(out):
    for i in range(out.shape[0]):
        for j in range(out.shape[1]):
            out[i, j] = 0.0


@njit(_nrt=False)
def hand_rate(limb, curve, s, q):
    """Way of the hand per share of a move at share s; `q` (n,) gets the coordinates."""
    on_curve(curve, s, q)
    place(limb, q)
    jacobian(limb, q, limb.slopes)
    vx, vy, vz = 0.0, 0.0, 0.0
    for j in range(q.size):
        rate = rate_of(curve, j, s)
        vx += rate * limb.slopes[0, j]
        vy += rate * limb.slopes[1, j]
        vz += rate * limb.slopes[2, j]
    return np.sqrt(vx * vx + vy * vy + vz * vz)


@njit(_nrt=False)
def axis_bound(limb, rates):
    """Bound of the angular speed of the hand's axis."""
    hand, speed = limb.radii.size, 0.0
    for step in range(limb.depths[hand]):
        k = limb.paths[hand, step]
        if limb.joints[k, 0] == REVOLUTE:
            speed += abs(limb.lines[k, 0]) * rates[limb.leaders[k]]
    return speed


@njit(_nrt=False)
def lever(limb):
    """Bound of the hand's derivatives of all orders up to 3, for a unit of any coordinate.

    Each order turns the arm once more, by all joints of a coordinate; at most one joint slides.
    """
    hand, moves, spins = limb.radii.size, 1.0, 1.0
    for j in range(limb.low.size):
        moved, spun = 0.0, 0.0
        for step in range(limb.depths[hand]):
            k = limb.paths[hand, step]
            if limb.leaders[k] == j:
                moved += abs(limb.lines[k, 0])
                spun += abs(limb.lines[k, 0]) if limb.joints[k, 0] == REVOLUTE else 0.0
        moves, spins = max(moves, moved), max(spins, spun)
    return max(limb.reach, 1.0) * moves * spins * spins


def limb_of_chain(arm: Chain, bodies: tuple[str, ...] = ()) -> ChainLimb | TreeLimb:
    """Return a chain as kernels read it; only one with branches or followers is a tree.

    Parameters
    ----------
    arm : Chain
    bodies : tuple of str
        Names of the situation's bodies, for the pairs that the arm ignores.
    """
    limb, model = chain_limb_of(arm, bodies), arm.model
    if model.serial:
        return limb
    count = len(model.joints)
    paths = [model.path(int(frame)) for frame in limb.carriers]
    table = np.zeros((len(paths), count), dtype=np.int64)
    for row, path in zip(table, paths, strict=True):
        row[: len(path)] = path
    return TreeLimb(
        *limb,
        parents=np.array([model.parent(k) for k in range(count)]),
        leaders=np.array([line.coordinate for line in model.lines]),
        lines=np.array([[line.factor, line.offset] for line in model.lines]),
        depths=np.array([len(path) for path in paths]),
        paths=table,
        values=np.zeros(count),
        slopes=np.zeros((3, arm.dof)),
    )
