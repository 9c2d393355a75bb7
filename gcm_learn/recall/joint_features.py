"""Clearance features of a spatial arm, at postures about a straight movement and all over.

Everything is known at t = 0. A straight movement in the joints leads from the start to the target.
Postures lie about it, and all over the joints' ranges. At some instants the clearance of the limb,
in each posture, to each body is computed. Shapes and motions of bodies stay hidden behind what they
forbid, and their number may vary.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.arms import SpatialArm
from gcm_learn.arms.limbs import dof
from gcm_learn.arms.spatial_limb import limb_at
from gcm_learn.collision.postures import body_distance
from gcm_learn.compiled import njit
from gcm_learn.motion import Rules
from gcm_learn.planners.joints.moves import study_of, turning_time
from gcm_learn.planners.joints.pull import pulled
from gcm_learn.recall.features import TOUCH, Features
from gcm_learn.scene import Scene
from gcm_learn.scene.bodies import HAND, PART, REACH, TOP_SPEED, pose_at
from gcm_learn.scene.packing import pack
from gcm_learn.situation import Situation, spatial_frame_of

POSTURES = 64  # all over the joints
LOW = np.array([-2.4, -0.5, -2.2, -2.4])  # of left arms, ends of what is covered [rad]
HIGH = np.array([2.0, 1.8, 2.2, -0.05])
TIMES = np.array([0.05, 0.2, 0.4, 0.7, 1.1])  # instants for these [s]
ROUND = 48  # postures round the straight way
LATER = np.array([0.0, 0.2, 0.5])  # instants for these: after the straight way is there [s]
ASIDE, BENT = 0.35, 0.9  # how far aside they are, at its ends and more in its middle [rad]
MEETINGS = 16  # instants at which the end of the straight way is looked for
TRACKED = np.array([0.0, 0.1, 0.2, 0.3, 0.45, 0.6, 0.8, 1.0, 1.3, 1.6])  # of the target [s]
FREE = 0.3  # clearance beyond this is as good as free [reaches]
FAR = 1.5  # distances of targets are cut at this [reaches]

CELLS = POSTURES * len(TIMES) + ROUND * len(LATER)
TRACK = 5  # numbers of the target at an instant
SCALARS = 44
CONTEXT = TRACK * len(TRACKED) + SCALARS


def _spread(count: int, numbers: int) -> np.ndarray:
    """Points (count, numbers) spread evenly over the unit cube: an additive recurrence."""
    ratio = 2.0
    for _ in range(60):  # the root of x^(numbers + 1) = x + 1
        ratio = (1.0 + ratio) ** (1.0 / (numbers + 1))
    steps = ratio ** -np.arange(1.0, numbers + 1.0)
    out: np.ndarray = (0.5 + np.arange(1, count + 1)[:, None] * steps) % 1.0
    return out


EVERYWHERE = LOW + _spread(POSTURES, LOW.size) * (HIGH - LOW)
BESIDE = _spread(ROUND, LOW.size + 1)
"""Shares of the straight way, and where to from there (-1 to 1 in each joint)."""
BESIDE[:, 1:] = 2.0 * BESIDE[:, 1:] - 1.0
AGAIN = np.concatenate(
    [np.tile(np.arange(t.size) > 0, n) for t, n in ((TIMES, POSTURES), (LATER, ROUND))]
)
"""True for a cell with the posture of the cell before, at another instant."""


def posture_features(situation: Situation[SpatialArm], scene: Scene | None = None) -> Features:
    """Return the clearance features of a situation in any frame.

    Parameters
    ----------
    situation : Situation
    scene : Scene, optional
        The situation packed, if the caller has it at hand.
    """
    scene = pack(situation) if scene is None else scene
    turns = spatial_frame_of(situation).canonical_joints(np.ones(len(situation.arm.joints)))
    return Features(*_features(scene, turns, situation.arm.reach))


@njit
def _features(scene, turns, reach):
    """Context and cells, as of `Features`."""
    limits = scene.limits
    study = study_of(scene, Rules(0.0, limits.grasp, limits.speed, limits.horizon))
    context, obstacles = np.zeros(CONTEXT, dtype=np.float32), study.desk.obstacles
    cells = np.zeros((obstacles.size, CELLS), dtype=np.float32)
    target = _nearest_target(study)
    when = _meeting(study, target)
    end = study.goal.copy()
    _fill_context(study, target, turns, reach, end, when, context)
    limbs, times = _looked_at(study, turns, end, abs(when))
    far = FREE * reach
    for o in range(obstacles.size):
        still = study.scene.bodies.rows[obstacles[o], TOP_SPEED] == 0.0
        for c in range(CELLS):
            if still and AGAIN[c]:
                cells[o, c] = cells[o, c - 1]
                continue
            place = (
                limbs[c, 0], limbs[c, 1], limbs[c, 2], limbs[c, 3], limbs[c, 4], limbs[c, 5]
            )  # fmt: skip
            found, _ = body_distance(
                study.scene.bodies, obstacles[o], times[c], place, 0.0, 0.0,
                far + study.scene.limb.thickness, study.desk.poses,
            )  # fmt: skip
            room = found - study.scene.limb.thickness
            cells[o, c] = TOUCH if room <= 0.0 else max(1.0 - room / far, 0.0)
    near = np.empty(obstacles.size, dtype=np.bool_)
    for o in range(near.size):
        near[o] = cells[o].any()
    return context, cells[near]


@njit(_nrt=False)
def _nearest_target(study):
    """The target that is nearest at t = 0."""
    bodies, poses = study.scene.bodies, study.desk.poses
    _, _, _, x, y, z = limb_at(study.scene.limb, study.scene.limb.start)
    target, nearest = -1, 1e300
    for b in range(bodies.rows.shape[0]):
        if bodies.rows[b, PART] == HAND:
            pose_at(bodies, b, 0.0, poses)
            away = (poses[b, 0] - x) ** 2 + (poses[b, 1] - y) ** 2 + (poses[b, 2] - z) ** 2
            if away < nearest:
                target, nearest = b, away
    return target


@njit(_nrt=False)
def _meeting(study, target):
    """Return when a straight way meets the target first [s]; its end is left in ``study.goal``.

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
def _looked_at(study, turns, end, when):
    """Limbs (CELLS, 6) that are asked about, and at which instants (CELLS,) [s]."""
    limb, horizon, q = study.scene.limb, study.scene.limits.horizon, study.near
    limbs, times, c = np.empty((CELLS, 6)), np.empty(CELLS), 0
    for p in range(POSTURES):
        for j in range(dof(limb)):
            q[j] = min(max(turns[j] * EVERYWHERE[p, j], limb.low[j]), limb.high[j])
        row = limb_at(limb, q)
        for k in range(TIMES.size):
            for i in range(6):
                limbs[c, i] = row[i]
            times[c] = min(TIMES[k], horizon)
            c += 1
    for p in range(ROUND):
        share = BESIDE[p, 0]
        aside = ASIDE + BENT * 4.0 * share * (1.0 - share)
        for j in range(dof(limb)):
            q[j] = limb.start[j] + share * (end[j] - limb.start[j])
            q[j] = min(max(q[j] + turns[j] * aside * BESIDE[p, 1 + j], limb.low[j]), limb.high[j])
        row = limb_at(limb, q)
        for k in range(LATER.size):
            for i in range(6):
                limbs[c, i] = row[i]
            times[c] = min(share * when + LATER[k], horizon)
            c += 1
    return limbs, times


@njit(_nrt=False)
def _fill_context(study, target, turns, reach, end, when, out):
    """Fill in where the target is, what the arm is, and how it could go straight."""
    scene, poses, side, at = study.scene, study.desk.poses, turns[3], 0
    limb, limits, n = scene.limb, scene.limits, dof(scene.limb)
    for k in range(TRACKED.size):
        pose_at(scene.bodies, target, min(TRACKED[k], limits.horizon), poses)
        x, y, z = poses[target, 0] / reach, poses[target, 1] / reach, poses[target, 2] / reach
        far = np.sqrt(x * x + y * y + z * z)
        scale = FAR / max(far, FAR)
        out[at], out[at + 1], out[at + 2] = x * scale, side * y * scale, z * scale
        out[at + 3], out[at + 4] = min(far, 2.0), 1.0 if far < 1.0 else 0.0
        at += TRACK
    for j in range(n):
        low, high = turns[j] * limb.low[j], turns[j] * limb.high[j]
        out[at + j], out[at + n + j] = turns[j] * limb.start[j], turns[j] * end[j]
        out[at + 2 * n + j], out[at + 3 * n + j] = min(low, high), max(low, high)
        out[at + 4 * n + j] = np.cos(limb.start[j])
        out[at + 5 * n + j] = turns[j] * np.sin(limb.start[j])
        out[at + 6 * n + j] = 0.2 * limits.joint_speed[j]
    at += 7 * n
    place = limb_at(limb, limb.start)
    for i in range(6):
        out[at + i] = place[i] / reach
    out[at + 1], out[at + 4] = side * out[at + 1], side * out[at + 4]
    at += 6
    out[at], out[at + 1] = limits.horizon, limb.rho / reach
    out[at + 2], out[at + 3] = 10.0 * limb.thickness / reach, 10.0 * limits.grasp / reach
    out[at + 4] = 5.0 * scene.bodies.rows[target, REACH] / reach
    out[at + 5] = 1.0 / (1.0 + limits.speed / reach)
    out[at + 6], out[at + 7] = side * limb.upper[1] / reach, limb.fore[2] / reach
    out[at + 8], out[at + 9] = abs(when), 1.0 if when > 0.0 else 0.0
