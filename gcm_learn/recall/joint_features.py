"""Clearance features of an arm in joints, at postures about a straight movement and all over.

Everything is known at t = 0. A straight movement in the joints leads from the start to the target.
Postures lie about it, and all over the joints' ranges. At some instants the clearance of the limb,
in each posture, to each body is computed. Shapes and motions of bodies stay hidden behind what they
forbid, and their number may vary. Of a chain there are so many numbers as its joints ask for, and
it is turned until the target is ahead; see `recall.headings`.
"""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

import numpy as np

from gcm_learn.arms.chain_limb import REVOLUTE
from gcm_learn.arms.limbs import axis_of, dof, hand_of, inverts, place, still
from gcm_learn.arms.swivels import FORE, RHO, UPPER, limb_at
from gcm_learn.collision.postures import gap_to
from gcm_learn.compiled import njit
from gcm_learn.motion import Rules
from gcm_learn.motion.joint_interception import approach_axis, approaches
from gcm_learn.planners.joints.moves import study_of, turning_time
from gcm_learn.planners.joints.pull import pulled
from gcm_learn.recall.features import TOUCH, Features
from gcm_learn.recall.headings import heading_of, nearest_target, signs_of
from gcm_learn.scene import Scene
from gcm_learn.scene.bodies import REACH, TOP_SPEED, WITHIN, pose_at
from gcm_learn.scene.packing import pack
from gcm_learn.situation import Situation

TRACKED = np.array([0.0, 0.1, 0.2, 0.3, 0.45, 0.6, 0.8, 1.0, 1.3, 1.6])  # of the target [s]
FAR = 1.5  # distances of targets are cut at this [reaches]
TRACK = 5  # numbers of the target at an instant
PER_JOINT, WHOLE = 7, 16  # numbers of a joint, of the arm besides
APPROACH = 3 * len(TRACKED) + 2  # numbers of a target's approach


@njit
def context_of(study, heading, target, signs, reach, end, when):
    """Context (m,) float32 of a situation.

    Parameters
    ----------
    study : Study
    heading : Heading
    target : int
        Body that is looked at.
    signs : (n,) ndarray
        Of the joints.
    reach : float
        Unit of lengths.
    end : (n,) ndarray
        Joints at the end of the straight way.
    when : float
        Time at which that catches, negative if it comes late [s].
    """
    limb = study.scene.limb
    size = TRACK * TRACKED.size + PER_JOINT * dof(limb) + WHOLE + (0 if inverts(limb) else APPROACH)
    out = np.zeros(size, dtype=np.float32)
    _fill_context(study, heading, target, signs, reach, end, when, out)
    return out


@njit(_nrt=False)
def _fill_context(study, heading, target, signs, reach, end, when, out):
    """Fill in the target's track, then numbers of the arm."""
    scene, poses, limb, limits = study.scene, study.desk.poses, study.scene.limb, study.scene.limits
    n, side, at = dof(limb), (signs[3] if inverts(limb) else 1.0), 0
    for k in range(TRACKED.size):
        pose_at(scene.bodies, target, min(TRACKED[k], limits.horizon), poses)
        x, y, z = _ahead(heading, poses[target, 0], poses[target, 1], poses[target, 2])
        x, y, z = x / reach, y / reach, z / reach
        far = np.sqrt(x * x + y * y + z * z)
        scale = FAR / max(far, FAR)
        out[at], out[at + 1], out[at + 2] = x * scale, side * y * scale, z * scale
        out[at + 3], out[at + 4] = min(far, 2.0), 1.0 if far < 1.0 else 0.0
        at += TRACK
    for j in range(n):
        shift, start = heading.shift[j], limb.start[j]
        low, high = signs[j] * (limb.low[j] - shift), signs[j] * (limb.high[j] - shift)
        out[at + j], out[at + n + j] = signs[j] * (start - shift), signs[j] * (end[j] - shift)
        out[at + 2 * n + j], out[at + 3 * n + j] = min(low, high), max(low, high)
        out[at + 4 * n + j] = np.cos(start - shift)
        out[at + 5 * n + j] = signs[j] * np.sin(start - shift)
        out[at + 6 * n + j] = 0.2 * limits.joint_speed[j]
    at += PER_JOINT * n
    if inverts(limb):
        _fill_elbow(limb, side, reach, out, at)
    else:
        _fill_hand(limb, heading, reach, out, at)
    out[at + 6], out[at + 9] = limits.horizon, 10.0 * limits.grasp / reach
    out[at + 10] = 5.0 * scene.bodies.rows[target, REACH] / reach
    out[at + 11] = 1.0 / (1.0 + limits.speed / reach)
    out[at + 14], out[at + 15] = abs(when), 1.0 if when > 0.0 else 0.0
    _fill_approach(limb, scene, heading, target, poses, out, at + WHOLE)


@njit(_nrt=False)
def _ahead(heading, x, y, z):
    """Turn a point of the base's frame to the heading."""
    rows, origin = heading.rows, heading.origin
    x, y, z = x - origin[0], y - origin[1], z - origin[2]
    return (
        rows[0, 0] * x + rows[0, 1] * y + rows[0, 2] * z,
        rows[1, 0] * x + rows[1, 1] * y + rows[1, 2] * z,
        rows[2, 0] * x + rows[2, 1] * y + rows[2, 2] * z,
    )


@njit(_nrt=False)
def _fill_elbow(limb, side, reach, out, at):
    place = limb_at(limb, limb.start)
    for i in range(6):
        out[at + i] = place[i] / reach
    out[at + 1], out[at + 4] = side * out[at + 1], side * out[at + 4]
    out[at + 7], out[at + 8] = limb.solved[RHO] / reach, 10.0 * limb.thickness / reach
    out[at + 12] = side * limb.solved[UPPER + 1] / reach
    out[at + 13] = limb.solved[FORE + 2] / reach


@njit(_nrt=False)
def _fill_hand(limb, heading, reach, out, at):
    where = place(limb, limb.start)
    x, y, z = hand_of(limb, where)
    x, y, z = _ahead(heading, x, y, z)
    out[at], out[at + 1], out[at + 2] = x / reach, y / reach, z / reach
    x, y, z = axis_of(limb, where)
    out[at + 3], out[at + 4], out[at + 5] = _turned_ahead(heading, x, y, z)


@njit(_nrt=False)
def _turned_ahead(heading, x, y, z):
    """Turn a direction of the base's frame to the heading."""
    origin = heading.origin
    return _ahead(heading, x + origin[0], y + origin[1], z + origin[2])


@njit(_nrt=False)
def _fill_approach(limb, scene, heading, target, poses, out, at):
    """Fill in the approach of the target; features stay 0 without an approach."""
    if inverts(limb) or approaches(scene, target) == 0:
        return
    for k in range(TRACKED.size):
        t = min(TRACKED[k], scene.limits.horizon)
        pose_at(scene.bodies, target, t, poses)
        x, y, z = approach_axis(scene, target, 0, t, poses)
        out[at], out[at + 1], out[at + 2] = _turned_ahead(heading, x, y, z)
        at += 3
    out[at], out[at + 1] = 1.0, np.cos(scene.bodies.rows[target, WITHIN])


POSTURES = 64  # all over the joints
LOW = np.array([-2.4, -0.5, -2.2, -2.4])  # of left arms, ends of what is covered [rad]
HIGH = np.array([2.0, 1.8, 2.2, -0.05])
AROUND = 1.2  # turn of a chain's first joint from the target that is covered [rad]
INNER = 0.4  # half of what is covered of its other joints [ranges]
WIDEST = 3.0  # at most half of what is covered [rad]
TIMES = np.array([0.05, 0.2, 0.4, 0.7, 1.1])  # instants for these [s]
ROUND = 48  # postures round the straight way
LATER = np.array([0.0, 0.2, 0.5])  # instants for these: after the straight way is there [s]
ASIDE, BENT = 0.35, 0.9  # how far aside they are, at its ends and more in its middle [rad]
MEETINGS = 16  # instants at which the end of the straight way is looked for
FREE = 0.3  # clearance beyond this is as good as free [reaches]

CELLS = POSTURES * len(TIMES) + ROUND * len(LATER)


class AskedPostures(NamedTuple):
    """Postures that are asked about, and the signs of joints."""

    signs: np.ndarray  # (n,)
    everywhere: np.ndarray  # (POSTURES, n): shares of what is covered
    beside: np.ndarray  # (ROUND, n + 1): share of the straight way, and where to from there


def _spread(count: int, numbers: int) -> np.ndarray:
    """Points (count, numbers) spread evenly over the unit cube: an additive recurrence."""
    ratio = 2.0
    for _ in range(60):  # the root of x^(numbers + 1) = x + 1
        ratio = (1.0 + ratio) ** (1.0 / (numbers + 1))
    steps = ratio ** -np.arange(1.0, numbers + 1.0)
    out: np.ndarray = (0.5 + np.arange(1, count + 1)[:, None] * steps) % 1.0
    return out


@cache
def _postures(joints: int) -> tuple[np.ndarray, np.ndarray]:
    """Return where postures lie all over the joints and beside the straight way."""
    beside = _spread(ROUND, joints + 1)
    beside[:, 1:] = 2.0 * beside[:, 1:] - 1.0
    return _spread(POSTURES, joints), beside


def posture_features(situation: Situation[Any], scene: Scene | None = None) -> Features:
    """Return the clearance features of a situation in any frame.

    Parameters
    ----------
    situation : Situation
        Of a spatial arm or a chain.
    scene : Scene, optional
        The situation packed, if the caller has it at hand.
    """
    scene = pack(situation) if scene is None else scene
    view = AskedPostures(signs_of(situation), *_postures(len(situation.arm.joints)))
    return Features(*_features(scene, view, situation.arm.reach))


@njit
def _features(scene, view, reach):
    """Context and cells, as of `Features`."""
    limits, limb = scene.limits, scene.limb
    study = study_of(scene, Rules(0.0, limits.grasp, limits.speed, limits.horizon))
    heading = heading_of(limb, scene)
    target = nearest_target(scene, study.desk.poses)
    when = _meeting(study, target)
    end = study.goal.copy()
    context = context_of(study, heading, target, view.signs, reach, end, when)
    cells = np.zeros((study.desk.obstacles.size, CELLS), dtype=np.float32)
    _fill_cells(study, heading, view, end, abs(when), FREE * reach, cells)
    near = np.empty(cells.shape[0], dtype=np.bool_)
    for o in range(near.size):
        near[o] = cells[o].any()
    return context, cells[near]


@njit(_nrt=False)
def _meeting(study, target):
    """Return when a straight way first meets the target [s]; leave its end in ``study.goal``.

    Negative where it comes late: then the end is the last posture that would catch, or the start.
    """
    limb, goal, last = study.scene.limb, study.goal, study.posture
    for j in range(dof(limb)):
        study.low[j], study.high[j], last[j] = limb.low[j], limb.high[j], limb.start[j]
    horizon = study.scene.limits.horizon
    for k in range(1, MEETINGS + 1):
        t = horizon * k / MEETINGS
        for j in range(dof(limb)):
            goal[j] = limb.start[j]
        if pulled(study, target, t, goal):
            if turning_time(study.scene.limits.joint_speed, limb.start, goal) <= t:
                return t
            for j in range(dof(limb)):
                last[j] = goal[j]
    for j in range(dof(limb)):
        goal[j] = last[j]
    return -horizon


@njit
def _fill_cells(study, heading, view, end, when, far, cells):
    """Fill in the cells of postures all over the joints, then of those beside the straight way."""
    limb, horizon, q, signs = study.scene.limb, study.scene.limits.horizon, study.near, view.signs
    low, high = _covered(limb, heading)
    c = 0
    for p in range(POSTURES):
        for j in range(dof(limb)):
            q[j] = low[j] + view.everywhere[p, j] * (high[j] - low[j])
            q[j] = min(max(heading.shift[j] + signs[j] * q[j], limb.low[j]), limb.high[j])
        where = place(limb, q)
        for k in range(TIMES.size):
            _fill_cell(study, where, min(TIMES[k], horizon), k > 0, far, c, cells)
            c += 1
    for p in range(ROUND):
        share = view.beside[p, 0]
        aside = ASIDE + BENT * 4.0 * share * (1.0 - share)
        for j in range(dof(limb)):
            q[j] = limb.start[j] + share * (end[j] - limb.start[j])
            q[j] += signs[j] * aside * view.beside[p, 1 + j]
            q[j] = min(max(q[j], limb.low[j]), limb.high[j])
        where = place(limb, q)
        for k in range(LATER.size):
            _fill_cell(study, where, min(share * when + LATER[k], horizon), k > 0, far, c, cells)
            c += 1


@njit(_nrt=False)
def _fill_cell(study, where, t, again, far, c, cells):
    """Fill in cell c of all obstacles at t [s]; `again` if the cell before has this posture."""
    limb, bodies, obstacles = study.scene.limb, study.scene.bodies, study.desk.obstacles
    for o in range(obstacles.size):
        if again and bodies.rows[obstacles[o], TOP_SPEED] == 0.0:
            cells[o, c] = cells[o, c - 1]
            continue
        found, _ = gap_to(
            limb, where, still(limb), bodies, obstacles[o], t, 0.0, far + limb.thickness,
            study.desk.poses,
        )  # fmt: skip
        room = found - limb.thickness
        cells[o, c] = TOUCH if room <= 0.0 else max(1.0 - room / far, 0.0)


@njit
def _covered(limb, heading):
    """Ends (n,), (n,) of the joints that are covered all over, in the limb's heading."""
    if inverts(limb):
        return LOW.copy(), HIGH.copy()
    low, high = np.empty(dof(limb)), np.empty(dof(limb))
    for j in range(low.size):
        middle = 0.5 * (limb.low[j] + limb.high[j]) - heading.shift[j]
        half = min(INNER * (limb.high[j] - limb.low[j]), WIDEST)
        if j == 0 and limb.joints[0, 0] == REVOLUTE:
            middle, half = 0.0, AROUND
        low[j], high[j] = middle - half, middle + half
    return low, high
