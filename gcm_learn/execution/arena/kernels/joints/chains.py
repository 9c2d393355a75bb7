"""Limbs in the arena: their numbers in observations, and their rows in a `World`.

A row holds counts, then fields of `ChainLimb` one after the other. Arms of a world have as many
joints and links; shorter lists of pairs and of ignored bodies are filled up.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from gcm_learn.arms.chain_limb import PRISMATIC, ChainLimb
from gcm_learn.arms.limbs import (
    axis_of,
    dof,
    ignores,
    inverts,
    link,
    link_count,
    place,
    self_gap,
    still,
)
from gcm_learn.arms.swivels import RHO
from gcm_learn.collision.postures import gap_to
from gcm_learn.compiled import njit
from gcm_learn.execution.arena.kernels.joints import fan
from gcm_learn.execution.arena.kernels.joints.nearness import lay, nearest_on_bone, wish
from gcm_learn.execution.arena.kernels.world import World, put, put_vector
from gcm_learn.motion.joint_interception import approach_axis, approach_excess, approaches
from gcm_learn.motion.joint_verification import hand_too_fast
from gcm_learn.scene import Scene
from gcm_learn.scene.bodies import REACH
from gcm_learn.scene.shapes.ball import off_bone

LINKS, PAIRS, MOST_PAIRS, MOST_BODIES, SOLVED = range(5)  # columns of the counts
FIRST = 5  # column of the joints at t = 0
_APPROACH = 5  # numbers of an approach


def rows_of(scenes: Sequence[Scene]) -> np.ndarray:
    """Return the limbs of scenes as rows (s, k), for `World`."""
    limbs = [scene.limb for scene in scenes]
    pairs = max(len(limb.pairs) for limb in limbs)
    bodies = max(limb.ignored.shape[1] for limb in limbs)
    return np.array([_row_of(limb, pairs, bodies) for limb in limbs])


def starts_of(world: World) -> np.ndarray:
    """Return joints and rates at t = 0 (s, 2 dof)."""
    return world.limbs[:, FIRST : FIRST + 2 * ((world.limits.shape[1] - 3) // 2)]


def _row_of(limb: ChainLimb, pairs: int, bodies: int) -> np.ndarray:
    """Return a limb as a row (k,), its lists filled up to `pairs` pairs and `bodies` bodies."""
    more = np.zeros((pairs - len(limb.pairs), 2))
    ignored = np.zeros((len(limb.radii), bodies))
    ignored[:, : limb.ignored.shape[1]] = limb.ignored
    counts = [len(limb.radii), len(limb.pairs), pairs, bodies, limb.solved.size]
    parts = (
        counts, limb.start, limb.rates, limb.joints, limb.low, limb.high, limb.carriers, limb.ends,
        limb.radii, limb.balls, limb.tails, [limb.reach, limb.thickness, limb.length], limb.pairs,
        more, ignored, limb.solved,
    )  # fmt: skip
    return np.concatenate([np.ravel(part).astype(float) for part in parts])


@njit
def blank(world):
    """Limb with zeros in arrays of the world's sizes."""
    n, row = (world.limits.shape[1] - 3) // 2, world.limbs[0]
    m, pairs, bodies = int(row[LINKS]), int(row[MOST_PAIRS]), int(row[MOST_BODIES])
    return ChainLimb(
        np.zeros((n, 13)), np.zeros(n), np.zeros(n), np.zeros(m + 1, np.int64),
        np.zeros((m + 1, 6)), np.zeros(m), np.zeros((pairs, 2), np.int64),
        np.zeros((m, bodies), np.bool_), np.zeros(n), 1.0, 0.0, 1.0, np.zeros(n), np.zeros(n),
        _first_frame(n), np.zeros((n, 6)), np.zeros((m + 1, 6)), np.zeros((m, 4)),
        np.zeros(m, np.int64), np.zeros(m), np.zeros(n), np.zeros(n), None,
        np.zeros(int(row[SOLVED])),
    )  # fmt: skip


@njit
def _first_frame(n):
    """Frames (n + 1, 12) of which the first is the base's own."""
    frames = np.zeros((n + 1, 12))
    frames[0, 0] = frames[0, 4] = frames[0, 8] = 1.0
    return frames


@njit(_nrt=False, forceinline=True)
def _read(row, at, out):
    """Read numbers of a row into an array; where the next begin."""
    for i in range(out.shape[0]):
        out[i] = row[at + i]
    return at + out.shape[0]


@njit(_nrt=False, forceinline=True)
def _read_table(row, at, out):
    """Read numbers of a row into a table; where the next begin."""
    for i in range(out.shape[0]):
        for j in range(out.shape[1]):
            out[i, j] = row[at]
            at += 1
    return at


@njit
def limb_in(limb, world, s):
    """Return the limb of situation s, in the arrays of `limb`, made by `blank`."""
    row = world.limbs[s]
    at = _read(row, _read(row, FIRST, limb.start), limb.rates)
    at = _read(row, _read(row, _read_table(row, at, limb.joints), limb.low), limb.high)
    at = _read_table(row, _read(row, at, limb.carriers), limb.ends)
    at = _read(row, _read_table(row, _read(row, at, limb.radii), limb.balls), limb.tails)
    reach, thickness, length = row[at], row[at + 1], row[at + 2]
    most = int(row[MOST_PAIRS])
    pairs = limb.pairs[: int(row[PAIRS])]
    _read_table(row, at + 3, pairs)
    at += 3 + 2 * most
    for i in range(limb.ignored.shape[0]):
        for b in range(limb.ignored.shape[1]):
            limb.ignored[i, b] = row[at] != 0.0
            at += 1
    _read(row, at, limb.solved)
    return ChainLimb(
        limb.joints, limb.low, limb.high, limb.carriers, limb.ends, limb.radii, pairs,
        limb.ignored, limb.tails, reach, thickness, length, limb.start, limb.rates, limb.frames,
        limb.axes, limb.reaches, limb.balls, limb.near, limb.ways, limb.turns, limb.paces,
        limb.tree, limb.solved,
    )  # fmt: skip


class Buffers(NamedTuple):
    """Arrays for two further places of a limb, and for its steps of braking."""

    frames: np.ndarray  # (2, n + 1, 12)
    axes: np.ndarray  # (2, n, 6)
    reaches: np.ndarray  # (2, m + 1, 6)
    balls: np.ndarray  # (2, m, 4)
    near: np.ndarray  # (m,)
    ways: np.ndarray  # (m,)
    turns: np.ndarray  # (n,)
    paces: np.ndarray  # (n,)
    posture: np.ndarray  # (1, 2 n)
    rows: np.ndarray  # (4, n)
    curve: np.ndarray  # (n, 4)


@njit
def buffers(limb):
    """Return buffers for limbs of the same sizes."""
    n, m = limb.low.size, limb.radii.size
    frames = np.zeros((2, n + 1, 12))
    frames[0], frames[1] = _first_frame(n), _first_frame(n)
    return Buffers(
        frames, np.zeros((2, n, 6)), np.zeros((2, m + 1, 6)), np.zeros((2, m, 4)),
        np.zeros(m, np.int64), np.zeros(m), np.zeros(n), np.zeros(n), np.zeros((1, 2 * n)),
        np.zeros((4, n)), np.zeros((n, 4)),
    )  # fmt: skip


@njit(_nrt=False)
def beside(limb, own, k):
    """Return a limb that writes its places into the buffers of index k, 0 or 1."""
    for i in range(limb.radii.size):
        own.balls[k, i, 3] = limb.balls[i, 3]
    return ChainLimb(
        limb.joints, limb.low, limb.high, limb.carriers, limb.ends, limb.radii, limb.pairs,
        limb.ignored, limb.tails, limb.reach, limb.thickness, limb.length, limb.start, limb.rates,
        own.frames[k], own.axes[k], own.reaches[k], own.balls[k], own.near, own.ways, own.turns,
        own.paces, limb.tree, limb.solved,
    )  # fmt: skip


@njit(_nrt=False)
def gap_of(limb, place, bodies, b, t, enough, poses):
    """Distance of body b at t [s] to a limb at a place."""
    return gap_to(limb, place, still(limb), bodies, b, t, 0.0, 1e300, poses)[0]


@njit(_nrt=False, forceinline=True)
def shape_numbers(limb):
    """Count of the numbers that `tell_shape` writes."""
    return 3 if inverts(limb) else 3 + 3 * limb.radii.size


@njit(_nrt=False)
def tell_shape(limb, place, reach, row, at):
    """Write the hand's axis and the outer ends of the links; of a spatial arm the elbow."""
    if inverts(limb):
        _, _, _, x, y, z, _ = link(limb, place, 0)
        put_vector(row, at, x, y, z, reach)
        return
    x, y, z = axis_of(limb, place)
    put_vector(row, at, x, y, z, 1.0)
    for i in range(link_count(limb)):
        _, _, _, x, y, z, _ = link(limb, place, i)
        put_vector(row, at + 3 + 3 * i, x, y, z, reach)


@njit(_nrt=False, forceinline=True)
def size_numbers(limb):
    """Count of the numbers that `tell_sizes` writes."""
    return 2 if inverts(limb) else limb.radii.size + 1


@njit(_nrt=False)
def tell_sizes(limb, place, touch, reach, row, at):
    """Write the radii of the links and the distance before the limb touches itself.

    Of a spatial arm the length of the upper arm, and the thickness.
    """
    if inverts(limb):
        put(row, at, limb.solved[RHO] / reach)
        put(row, at + 1, limb.thickness / reach)
        return
    for i in range(limb.radii.size):
        put(row, at + i, limb.radii[i] / reach)
    gap, _ = self_gap(limb, place, still(limb), 1e300)
    put(row, at + limb.radii.size, (gap - touch) / reach)


@njit(_nrt=False, forceinline=True)
def approach_numbers(limb):
    """Count of the numbers of an approach; spatial arms observe none."""
    return 0 if inverts(limb) else _APPROACH


@njit(_nrt=False)
def tell_approach(limb, place, q, scene, b, t, poses, row, at):
    """Write whether target b has an approach, the first, and the angle that is too much."""
    for k in range(approach_numbers(limb)):
        row[at + k] = 0.0
    if not inverts(limb) and approaches(scene, b) > 0:
        row[at] = 1.0
        x, y, z = approach_axis(scene, b, 0, t, poses)
        put_vector(row, at + 1, x, y, z, 1.0)
        put(row, at + 4, approach_excess(scene, place, q, b, t, poses))


@njit(_nrt=False)
def nearest_point(limb, place, bodies, b, poses):
    """Return the link nearest to body b at its pose, and the nearest point on the link's axis.

    Links whose balls are farther off are left out.

    Returns
    -------
    i : int
        The link.
    px, py, pz : float
        The point.
    x, y, z : float
        From that point to the nearest point of the body; 0 where they meet.
    radius : float
        Of the link, beyond the limb's thickness.
    """
    reach, near, best = bodies.rows[b, REACH], -1, 1e300
    fx = fy = fz = vx = vy = vz = 0.0
    cx, cy, cz = poses[b, 0], poses[b, 1], poses[b, 2]
    for i in range(link_count(limb)):
        px, py, pz, qx, qy, qz, radius = link(limb, place, i)
        if ignores(limb, i, b):
            continue
        least = off_bone(cx - px, cy - py, cz - pz, qx - px, qy - py, qz - pz) - reach - radius
        if near >= 0 and least >= best:
            continue
        s, x, y, z = nearest_on_bone(bodies, b, poses, (px, py, pz), (qx, qy, qz))
        gap = np.sqrt(x * x + y * y + z * z) - radius
        if near < 0 or gap < best:
            near, best, vx, vy, vz = i, gap, x, y, z
            fx, fy, fz = px + s * (qx - px), py + s * (qy - py), pz + s * (qz - pz)
    return near, fx, fy, fz, vx, vy, vz, limb.radii[near]


@njit(_nrt=False)
def point_velocity_on(limb, place, i, joints, rates, x, y, z):
    """Return the velocity (3) of a point of link i: the sum over the joints before the link."""
    vx = vy = vz = 0.0
    for k in range(limb.carriers[i]):
        ax, ay, az = limb.axes[k, 3], limb.axes[k, 4], limb.axes[k, 5]
        if limb.joints[k, 0] != PRISMATIC:
            px, py, pz = x - limb.axes[k, 0], y - limb.axes[k, 1], z - limb.axes[k, 2]
            ax, ay, az = ay * pz - az * py, az * px - ax * pz, ax * py - ay * px
        vx, vy, vz = vx + rates[k] * ax, vy + rates[k] * ay, vz + rates[k] * az
    return vx, vy, vz


@njit(_nrt=False)
def brakes_slowly(limb, scene, speed, end, rates, span, own):
    """Return whether the hand keeps its speed limit while the joints brake after a step.

    `end` and `rates` (dof,) are joints and rates after the step; the steps of braking are checked.
    """
    posture, curve, n, longest = own.posture, own.curve, dof(limb), 0.0
    after, there, joints = own.rows[1], own.rows[2], own.rows[3]
    for j in range(n):
        own.rows[0, j] = 0.0
        posture[0, j], posture[0, n + j] = end[j], rates[j]
        longest = max(longest, abs(rates[j]) / scene.limits.joint_acceleration[j])
    for _ in range(int(longest / span) + 2):
        wish(scene, posture, 0, own.rows, span, after)
        lay(scene, posture, 0, after, span, there, curve)
        if hand_too_fast(limb, curve, speed * span, joints):
            return False
        for j in range(n):
            posture[0, j], posture[0, n + j] = there[j], after[j]
    return True


@njit(_nrt=False)
def tell_fan(limb, view, time, posture, e, body, aim, row, at):
    """Write the fan of a spatial arm; chains have none."""
    if inverts(limb):
        fan.tell_fan(view, time, posture, e, body, aim, row, at)
        for j in range(dof(limb)):
            view.joints[1, j] = posture[e, j]
        place(limb, view.joints[1])
