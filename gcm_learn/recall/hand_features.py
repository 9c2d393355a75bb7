"""Clearance features of a planar arm, on a polar lattice of hands about the shoulder.

Everything is known at t = 0. The lattice begins in the direction of the hand and runs to the side
on which canonical arms turn. Its instants are given by the way that the hand can have come. At
each, the clearance of the limb, with its hand there, to each body is computed. Shapes and motions
of bodies are not seen, only what they forbid. Bodies stay apart: a path is valid if it is so
against each.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.arms.planar_limb import elbow_of
from gcm_learn.collision.distance import arm_distance, limb_point2
from gcm_learn.compiled import njit
from gcm_learn.motion.interception import first_interception
from gcm_learn.motion.rules import Rules
from gcm_learn.recall.features import TOUCH, Features
from gcm_learn.scene import Scene
from gcm_learn.scene.bodies import BALL, HAND, PART, REACH, pose_at, poses_at
from gcm_learn.scene.packing import pack
from gcm_learn.situation import Situation

DIRECTIONS = 24  # of hands, over the whole turn
RINGS = np.array([0.1, 0.28, 0.46, 0.64, 0.8, 0.94])  # shares of the ring
LENGTHS = np.array([0.15, 0.4, 0.7, 1.0, 1.35, 1.7, 2.1, 2.5, 2.9, 3.4, 4.0, 4.8])
"""Instants: ways that the hand can have come [forearm lengths]."""
FREE = 0.4  # clearance beyond this is as good as free [forearm lengths]
TOUCHING = 1e-6  # clearance up to this is none [forearm lengths]
SLACK = 0.25  # hands that are farther than the hand can be by this are not asked for [same]
INSTANT = 1e-3  # resolution of interceptions, coarser than a plan's: encoders know it [horizons]

CELLS = len(LENGTHS) * len(RINGS) * DIRECTIONS
TRACK = 5  # numbers of the target at an instant
SCALARS = 14
CONTEXT = TRACK * len(LENGTHS) + SCALARS


def clearance_features(situation: Situation, scene: Scene | None = None) -> Features:
    """Return the clearance features of a situation in any frame.

    Parameters
    ----------
    situation : Situation
    scene : Scene, optional
        The situation packed, if the caller has it at hand.
    """
    scene = pack(situation) if scene is None else scene
    limits = scene.limits
    rules = Rules(0.0, limits.grasp, limits.speed, INSTANT * limits.horizon)
    return Features(*_features(scene, rules))


@njit
def _features(scene, rules):
    """Context and cells, as of `Features`."""
    bodies, limb, limits = scene.bodies, scene.limb, scene.limits
    x, y, width, speed = limb.x, limb.y, limb.far - limb.near, limits.speed
    poses, out = np.zeros((bodies.rows.shape[0], 12)), np.zeros(CONTEXT, dtype=np.float32)
    obstacles = np.flatnonzero(bodies.rows[:, PART] != HAND)
    cells = np.zeros((obstacles.size, CELLS), dtype=np.float32)
    angle = np.arctan2(y, x)
    start = np.sqrt(x * x + y * y)
    if obstacles.size > 0:
        _fill_cells(scene, poses, angle, start, obstacles, cells)
    target = _nearest_target(bodies, poses, x, y)
    at = 0
    for k in range(LENGTHS.size):
        pose_at(bodies, target, min(LENGTHS[k] / speed, limits.horizon), poses)
        _fill_track(limb, poses, target, angle, out, at)
        gap = np.sqrt((poses[target, 0] - x) ** 2 + (poses[target, 1] - y) ** 2)
        out[at + 4] = min(max(gap - LENGTHS[k], -2.0), 2.0)
        at += TRACK
    soonest, body, px, py = first_interception(scene, rules, x, y, 0.0, 0.0, limits.horizon)
    if body >= 0:
        a = limb.side * (np.arctan2(py, px) - angle)
        out[at], out[at + 1] = 1.0, soonest * speed * 0.3
        out[at + 2], out[at + 3] = np.cos(a), np.sin(a)
        out[at + 4] = (np.sqrt(px * px + py * py) - limb.near) / width
    out[at + 5], out[at + 6] = (start - limb.near) / width, limb.rho
    out[at + 7], out[at + 8] = speed * 0.3, speed * limits.horizon * 0.25
    out[at + 9], out[at + 10] = limb.thickness * 10.0, limits.grasp * 10.0
    out[at + 11] = bodies.rows[target, REACH] * 5.0
    if limits.shoulder < np.inf:  # slow joints count, fast ones are as good as no limit
        out[at + 12] = speed / (speed + limits.shoulder)
        out[at + 13] = speed / (speed + limits.elbow)
    near_ones = np.empty(obstacles.size, dtype=np.bool_)
    for o in range(obstacles.size):
        near_ones[o] = cells[o].any()
    return out, cells[near_ones]


class Limbs(NamedTuple):
    """Limbs with the hand at each node of the lattice of rings and directions."""

    joints: np.ndarray  # (rings, DIRECTIONS, 4): hand, elbow
    away2: np.ndarray  # (rings, DIRECTIONS): of the hand from where it starts, squared
    longest: np.ndarray  # (rings,): of hand and elbow the distance from the shoulder that is larger
    elbow: np.ndarray  # (rings,): direction of the elbow from that of the hand
    thickness: float
    close: np.ndarray  # (DIRECTIONS,): buffer for directions of a ring


@njit
def _limbs(limb, angle, start):
    """Limbs of a lattice that begins in the direction `angle`."""
    rho, side, near, far = limb.rho, limb.side, limb.near, limb.far
    rings, n, step = RINGS.size, DIRECTIONS, 2.0 * np.pi / DIRECTIONS
    joints, away2 = np.empty((rings, n, 4)), np.empty((rings, n))
    made = Limbs(
        joints, away2, np.empty(rings), np.empty(rings), limb.thickness, np.empty(n, dtype=np.int64)
    )
    for i in range(rings):
        r = near + RINGS[i] * (far - near)
        made.longest[i] = max(r, rho)
        ex, ey = elbow_of(r, 0.0, rho, side)
        made.elbow[i] = side * np.arctan2(ey, ex)
    for j in range(n):
        c, s = np.cos(angle + side * step * j), np.sin(angle + side * step * j)
        cosine = np.cos(step * j)
        for i in range(rings):
            r = near + RINGS[i] * (far - near)
            ex, ey = elbow_of(r, 0.0, rho, side)
            joints[i, j, 0], joints[i, j, 1] = r * c, r * s
            joints[i, j, 2], joints[i, j, 3] = ex * c - ey * s, ex * s + ey * c
            away2[i, j] = r * r + start * start - 2.0 * r * start * cosine
    return made


@njit
def _fill_cells(scene, poses, angle, start, obstacles, out):
    """Fill in how little clearance each body leaves the limb where the hand can have come to."""
    bodies, side = scene.bodies, scene.limb.side
    limbs, step = _limbs(scene.limb, angle, start), 2.0 * np.pi / DIRECTIONS
    for k in range(LENGTHS.size):
        poses_at(bodies, min(LENGTHS[k] / scene.limits.speed, scene.limits.horizon), poses)
        for o in range(obstacles.size):
            b = obstacles[o]
            ball = bodies.rows[b, REACH] + limbs.thickness + FREE
            away, middle, half = _sector(poses, b, angle, side, ball)
            for i in range(RINGS.size):
                if away > limbs.longest[i] + ball:
                    continue
                first, last = 0, DIRECTIONS - 1
                if away > ball:  # the limb lies within the sector of hand and elbow
                    first = int(np.ceil((middle - half - max(limbs.elbow[i], 0.0)) / step))
                    last = int(np.floor((middle + half - min(limbs.elbow[i], 0.0)) / step))
                    last = min(last, first + DIRECTIONS - 1)
                _fill_ring(bodies, poses, b, limbs, k, i, first, last, out, o)


@njit(_nrt=False, forceinline=True)
def _sector(poses, b, angle, side, ball):
    """Return distance, direction and half the width of a ball about body b from the shoulder."""
    x, y = poses[b, 0], poses[b, 1]
    away = np.sqrt(x * x + y * y)
    if away <= ball:
        return away, 0.0, np.pi
    return away, side * (np.arctan2(y, x) - angle), np.arcsin(ball / away)


@njit(_nrt=False, forceinline=True)
def _fill_ring(bodies, poses, b, limbs, k, i, first, last, out, o):
    """Fill in the cells of row o at instant k on ring i, from direction `first` to `last`.

    Balls are asked first, in a loop that calls nothing.
    """
    px, py, pz, reach = poses[b, 0], poses[b, 1], poses[b, 2], bodies.rows[b, REACH]
    ball, limit = reach + limbs.thickness + FREE, (LENGTHS[k] + SLACK) ** 2
    is_ball, count, at = bodies.rows[b, BALL] > 0.0, 0, (k * RINGS.size + i) * DIRECTIONS
    z2 = pz * pz
    for turn in range(first, last + 1):
        j = turn % DIRECTIONS
        if limbs.away2[i, j] > limit:
            continue
        hx, hy = limbs.joints[i, j, 0], limbs.joints[i, j, 1]
        ex, ey = limbs.joints[i, j, 2], limbs.joints[i, j, 3]
        d2 = limb_point2(px, py, hx, hy, ex, ey) + z2
        if d2 >= ball * ball:
            continue
        if is_ball:
            out[o, at + j] = _closeness(np.sqrt(d2) - reach - limbs.thickness)
        else:
            limbs.close[count] = j
            count += 1
    for c in range(count):
        j = limbs.close[c]
        hx, hy = limbs.joints[i, j, 0], limbs.joints[i, j, 1]
        ex, ey = limbs.joints[i, j, 2], limbs.joints[i, j, 3]
        clearance = arm_distance(bodies, poses, b, hx, hy, ex, ey) - limbs.thickness
        out[o, at + j] = _closeness(clearance)


@njit(forceinline=True)
def _closeness(clearance):
    """Number of a cell: how little clearance is left."""
    if clearance <= TOUCHING:
        return TOUCH
    return max(1.0 - clearance / FREE, 0.0)


@njit(_nrt=False)
def _nearest_target(bodies, poses, x, y):
    """The target that is nearest at t = 0."""
    best, least = -1, 1e300
    for b in range(bodies.rows.shape[0]):
        if bodies.rows[b, PART] != HAND:
            continue
        pose_at(bodies, b, 0.0, poses)
        d2 = (poses[b, 0] - x) ** 2 + (poses[b, 1] - y) ** 2 + poses[b, 2] ** 2
        if d2 < least:
            best, least = b, d2
    return best


@njit(_nrt=False)
def _fill_track(limb, poses, target, angle, out, at):
    """Fill in where the target is: direction, share of the ring, distance from the plane."""
    px, py = poses[target, 0], poses[target, 1]
    r = np.sqrt(px * px + py * py)
    a = limb.side * (np.arctan2(py, px) - angle)
    share = min((r - limb.near) / (limb.far - limb.near), 2.0)
    scale = min(r, 1.0)
    out[at], out[at + 1] = np.cos(a) * scale, np.sin(a) * scale
    out[at + 2] = share
    out[at + 3] = min(abs(poses[target, 2]), 1.0)
