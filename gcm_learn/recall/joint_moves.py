"""Kernels of remembered joint movements: load, move, time and check them.

A remembered movement is `KNOTS` rows: joints of a left arm, or of a chain turned to the target,
then time and earliest time.  Its start is moved to the joints at t = 0, its end to a posture that
catches the target just in time.  In between it is moved by as much of each as is left of it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.arms.limbs import dof, hand_of, place, reach_of
from gcm_learn.collision.postures import move_is_free
from gcm_learn.compiled import njit
from gcm_learn.motion.joint_interception import fastest_hand, target_room
from gcm_learn.planners.joints.moves import PIECES, Study, time_of, turning_time
from gcm_learn.planners.joints.pull import pulled
from gcm_learn.planners.joints.ways import JointWay, new_way, samples_of, write
from gcm_learn.recall.styles import HURRY, Chase
from gcm_learn.scene.bodies import TOP_SPEED, pose_at

KNOTS = 12  # of a remembered movement, see `gcm_learn.recall.waypoints`
TIME, EARLIEST = -2, -1  # columns of a knot, after its joints
AFTER = -1.0  # earliest time of knots after a catch: the ends of its hold and of the movement
STEPS = 24  # of a movement that is followed, of equal length
MOST = KNOTS * (PIECES + 2)  # samples of a movement

_TRIALS = 40  # instants of interception that are tried at most
_STRIDE = 32.0  # steps in a horizon while there is no target to be met
_CLOSE = 2e-3  # share of the horizon within which the instant is found
_STILL = 1e-6  # a movement shorter than this is shared out by time [s]


class JointQuery(NamedTuple):
    """Situation in the form that adaptations of joint movements take."""

    study: Study
    turns: np.ndarray  # (dof,): signs that make joints of a left arm those of this one
    shift: np.ndarray  # (dof,): added to them, see `recall.headings`


class Track(NamedTuple):
    """Movement under limits of acceleration: aims, and the arm's joints that follow them."""

    aims: np.ndarray  # (STEPS + 1, dof): the movement [rad]
    time: np.ndarray  # (STEPS + 1,) [s]
    joints: np.ndarray  # (STEPS + 1, dof) [rad]
    rates: np.ndarray  # (STEPS + 1, dof) [rad/s]
    least: np.ndarray  # (KNOTS,): least times of the movement's pieces [s]
    until: np.ndarray  # (1,): end of the movement [s]
    body: np.ndarray  # (1,) int64: target caught without contact, -1 if there is none


class JointWork(NamedTuple):
    """Buffers of the kernels, reused by every adaptation."""

    share: np.ndarray  # (KNOTS,): of its length that lies behind it
    base: np.ndarray  # (KNOTS, dof): the movement with its start where the arm is [rad]
    wanted: np.ndarray  # (KNOTS,): when it may be there at the earliest [s]
    end: np.ndarray  # (dof,): joints that catch [rad]
    path: np.ndarray  # (KNOTS, dof): the movement that was adapted last [rad]
    time: np.ndarray  # (KNOTS,): of it [s]
    way: JointWay  # the best so far
    best_time: np.ndarray  # (MOST,): samples of the best movement [s]
    best_joints: np.ndarray  # (MOST, dof) [rad]
    from_base: np.ndarray  # (KNOTS, dof): base of the movement before a change
    from_wanted: np.ndarray  # (KNOTS,)
    least_base: np.ndarray  # (KNOTS, dof): base of the change with the least contact
    least_wanted: np.ndarray  # (KNOTS,)
    track: Track


def joint_work(n: int) -> JointWork:
    """Return buffers for adaptations of movements of n joints."""
    share, wanted, time, from_wanted, least_wanted, least = np.zeros((6, KNOTS))
    base, path, from_base, least_base = np.zeros((4, KNOTS, n))
    aims, joints, rates = np.zeros((3, STEPS + 1, n))
    followed = aims, np.zeros(STEPS + 1), joints, rates
    track = Track(*followed, least, np.zeros(1), np.zeros(1, np.int64))
    sampled = np.zeros(MOST), np.zeros((MOST, n))
    kept = from_base, from_wanted, least_base, least_wanted
    return JointWork(
        share, base, wanted, np.zeros(n), path, time, new_way(n), *sampled, *kept, track
    )


@njit
def bodies_of(query):
    """Return the bodies of a situation."""
    return query.study.scene.bodies


@njit(_nrt=False)
def load(query, paths, m, style, work):
    """Copy memory m into the buffers, and move its start to the arm.

    Parameters
    ----------
    query : JointQuery
    paths : ((n, KNOTS, dof + 2), (n, 6)) ndarrays of float32
        Knots and goals of all memories.
    m : int
    style : Style
    work : JointWork
    """
    knots, _ = paths
    study, share, base = query.study, work.share, work.base
    limb, rate = study.scene.limb, study.scene.limits.joint_speed
    share[0] = 0.0
    for k in range(KNOTS):
        for j in range(dof(limb)):
            base[k, j] = query.turns[j] * np.float64(knots[m, k, j]) + query.shift[j]
        work.wanted[k] = knots[m, k, EARLIEST if style.tempo == HURRY else TIME]
        if k > 0:
            share[k] = share[k - 1] + turning_time(rate, base[k - 1], base[k])
    total, last = share[KNOTS - 1], max(np.float64(knots[m, KNOTS - 1, TIME]), 1e-9)
    for k in range(KNOTS):
        share[k] = knots[m, k, TIME] / last if total < _STILL else share[k] / total
    share[KNOTS - 1] = 1.0
    for j in range(dof(limb)):
        off = limb.start[j] - base[0, j]
        for k in range(KNOTS):
            base[k, j] += (1.0 - share[k]) * off


@njit(_nrt=False)
def _soonest_end(study, work):
    """Return when a movement to the end can be over by the joints' speeds alone [s]."""
    base, share, end, rate = work.base, work.share, work.end, study.scene.limits.joint_speed
    t = 0.0
    for k in range(1, KNOTS):
        step, took = share[k] - share[k - 1], 0.0
        for j in range(dof(study.scene.limb)):
            turn = base[k, j] - base[k - 1, j] + step * (end[j] - base[KNOTS - 1, j])
            took = max(took, abs(turn) / rate[j])
        t = max(t + took, work.wanted[k])
    return t


@njit(_nrt=False)
def write_path(study, edge, work):
    """Write the movement to `work.end`; inner knots stay `edge` [rad] within the joints' ranges."""
    limb, base, share, end, path = study.scene.limb, work.base, work.share, work.end, work.path
    for j in range(dof(limb)):
        off, room = end[j] - base[KNOTS - 1, j], min(edge, 0.5 * (limb.high[j] - limb.low[j]))
        low, high = limb.low[j] + room, limb.high[j] - room
        for k in range(KNOTS):
            path[k, j] = min(max(base[k, j] + share[k] * off, low), high)
        path[0, j], path[KNOTS - 1, j] = limb.start[j], end[j]


@njit(_nrt=False)
def _paced(study, work):
    """Write the movement with the earliest times that limits and waits allow; return the last."""
    write_path(study, 0.0, work)
    path = work.path
    work.time[0] = 0.0
    for k in range(1, KNOTS):
        took, _ = time_of(study, path[k - 1], path[k])
        work.time[k] = max(work.time[k - 1] + took, work.wanted[k])
    return work.time[KNOTS - 1]


@njit(_nrt=False)
def _away(study, b, fast, t):
    """Return for how long target b stays out of reach of arm and straight hand [s]."""
    limb, top, poses = study.scene.limb, study.scene.bodies.rows[b, TOP_SPEED], study.desk.poses
    x, y, z = hand_of(limb, place(limb, limb.start))
    ring = target_room(study.scene, b, 0.0, 0.0, 0.0, t, poses)
    ring -= study.catch + reach_of(limb)
    way = target_room(study.scene, b, x, y, z, t, poses) - study.catch - fast * t
    wait = way / (fast + top)
    if ring > 0.0:
        wait = max(wait, ring / top if top > 0.0 else 1e300)
    return wait


@njit(_nrt=False)
def seed_end(study, work):
    """Begin with the end of the memory, within the joints' ranges."""
    limb = study.scene.limb
    for j in range(dof(limb)):
        study.low[j], study.high[j] = limb.low[j], limb.high[j]
        work.end[j] = min(max(work.base[KNOTS - 1, j], limb.low[j]), limb.high[j])


@njit(_nrt=False)
def chase(query, b, since):
    """Return the settings of the search, from `since` [s] on, for the instant of meeting b."""
    study = query.study
    horizon, fast = study.scene.limits.horizon, fastest_hand(study.scene)
    top = study.scene.bodies.rows[b, TOP_SPEED]
    return Chase(
        since,
        fast,
        horizon,
        fast / (fast + top),
        _CLOSE * horizon,
        horizon / _STRIDE,
        study.instant,
        _TRIALS,
    )


@njit(_nrt=False)
def away(query, b, t, speed, _work):
    """Return for how long target b surely stays out of reach [s]."""
    return _away(query.study, b, speed, t)


@njit(_nrt=False)
def lateness(query, b, t, rough, close, _style, work):
    """Adapt the movement to target b at t [s]; while far too late, compare turns of joints only.

    Returns
    -------
    late : float
        Delay of the movement [s].
    rough : bool
        True if only turns were compared.
    found : bool
        False if no posture near the end catches.
    """
    study, late = query.study, 0.0
    seed_end(study, work)
    if not pulled(study, b, t, work.end):
        return 0.0, True, False
    if rough:
        late = _soonest_end(study, work) - t
        rough = late > close
    if not rough:
        late = _paced(study, work) - t
    return late, rough, True


@njit(_nrt=False)
def keep(work, t, b):
    """Keep the adapted movement as the best, until b is caught at t [s]; return the knot count."""
    way, last = work.way, KNOTS - 1
    for k in range(KNOTS):
        write(way, k, work.path[k], work.time[k], work.time[k] if k < last else t)
    way.body[0] = b
    return KNOTS


@njit(_nrt=False)
def cut(_query, work, body):
    """Return the knot count and the target unchanged: joint movements are not cut."""
    return KNOTS, body


@njit
def check(query, work, _count, _body):
    """Sample the best movement, and check whether the limb touches an obstacle.

    Returns
    -------
    count : int
        Samples until the first catch, in the buffers.
    free : bool
        True if no piece touches an obstacle.
    body : int
        Target caught first.
    """
    time, joints, body = samples_of(query.study, work.way)
    count = time.size
    work.best_time[:count], work.best_joints[:count] = time, joints
    return count, first_touch(query.study, time, joints) < 0, body


@njit
def first_touch(study, time, joints):
    """First piece of a sampled movement that touches an obstacle, -1 if none does."""
    for k in range(time.size - 1):
        if not move_is_free(
            study.scene, joints[k], time[k], joints[k + 1], time[k + 1], study.touch, study.desk
        ):
            return k
    return -1


@njit
def failures(query, most):
    """Return an array that records `most` movements."""
    return np.empty((most, KNOTS, dof(query.study.scene.limb) + 1))


@njit(_nrt=False)
def note(query, row, work, _count):
    """Write the best movement into `row`."""
    n = dof(query.study.scene.limb)
    for k in range(KNOTS):
        for j in range(n):
            row[k, j] = work.way.joints[k, j]
        row[k, n] = work.way.reached[k]


@njit(_nrt=False)
def is_near(query, row, work, _count, novelty):
    """Return whether the best movement stays within `novelty` [rad] of the one in `row`.

    A second counts as much as ten radians.
    """
    way, apart, n = work.way, 0.0, dof(query.study.scene.limb)
    for k in range(KNOTS):
        apart = max(apart, 10.0 * abs(row[k, n] - way.reached[k]))
        for j in range(n):
            apart = max(apart, abs(row[k, j] - way.joints[k, j]))
        if apart > novelty:
            return False
    return True


@njit
def least_times(study, joints):
    """Least times (n - 1,) of the moves between postures (n, dof) [s]."""
    out = np.empty(joints.shape[0] - 1)
    for k in range(out.size):
        out[k], _ = time_of(study, joints[k], joints[k + 1])
    return out


@njit
def centre_of(bodies, b, t):
    """Centre (3,) of body b at t [s]."""
    poses = np.zeros((bodies.rows.shape[0], 12))
    pose_at(bodies, b, t, poses)
    return poses[b, :3].copy()
