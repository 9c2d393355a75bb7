"""Remembered movements of the joints, adapted to a new situation and timed.

A remembered movement is `KNOTS` rows (four joints of a left arm, time, earliest).  Its start is
moved to the joints at t = 0, its end to a posture that catches the target at the time at which the
movement can be over, in between it is moved by as much of each as is left of it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.arms.spatial_limb import limb_at
from gcm_learn.collision.postures import move_is_free
from gcm_learn.compiled import njit
from gcm_learn.motion.interception_in_space import fastest_hand, target_room
from gcm_learn.planners.space.moves import Study, time_of, turning_time
from gcm_learn.planners.space.pull import pulled
from gcm_learn.planners.space.ways import Way, new_way, write
from gcm_learn.scene.bodies import HAND, PART, TOP_SPEED, pose_at

KNOTS = 12  # of a remembered movement, see `gcm_learn.recall.space.waypoints`
TIME, EARLIEST = 4, 5  # columns of a knot, after its joints
COLUMNS = 6
HURRY, KEEP = 0, 1  # waits are kept and the rest is hurried, or all times are kept

_TURNS = 40  # instants of interception that are tried at most
_LONGEST = 60.0  # times the lateness that a step may be long
_STRIDE = 32.0  # steps in a horizon while there is no target to be met
_CLOSE = 2e-3  # share of the horizon within which the instant is found
_STILL = 1e-6  # a movement shorter than this is shared out by time [s]


class Query(NamedTuple):
    """What an adaptation must know of a situation."""

    study: Study
    turns: np.ndarray  # (4,): signs that make joints of a left arm those of this one


class Work(NamedTuple):
    """Buffers for one adaptation after the other."""

    share: np.ndarray  # (KNOTS,): of its length that lies behind it
    base: np.ndarray  # (KNOTS, 4): the movement with its start where the arm is [rad]
    wanted: np.ndarray  # (KNOTS,): when it may be there at the earliest [s]
    end: np.ndarray  # (4,): joints that catch [rad]
    path: np.ndarray  # (KNOTS, 4): the movement that was adapted last [rad]
    time: np.ndarray  # (KNOTS,): of it [s]
    way: Way  # the best so far
    from_base: np.ndarray  # (KNOTS, 4), (KNOTS,): base and wanted that a change begins with
    from_wanted: np.ndarray
    least_base: np.ndarray  # (KNOTS, 4), (KNOTS,): of the change that touches least
    least_wanted: np.ndarray


def work_room() -> Work:
    """Buffers for adaptations."""
    share, wanted, time, from_wanted, least_wanted = np.zeros((5, KNOTS))
    base, path, from_base, least_base = np.zeros((4, KNOTS, 4))
    kept = from_base, from_wanted, least_base, least_wanted
    return Work(share, base, wanted, np.zeros(4), path, time, new_way(), *kept)


@njit(_nrt=False)
def load(knots, m, query, tempo, work):
    """Move the start of memory m to where the arm is."""
    study, share, base = query.study, work.share, work.base
    limb, rate = study.scene.limb, study.scene.limits.joint_speed
    share[0] = 0.0
    for k in range(KNOTS):
        for j in range(4):
            base[k, j] = query.turns[j] * np.float64(knots[m, k, j])
        work.wanted[k] = knots[m, k, EARLIEST if tempo == HURRY else TIME]
        if k > 0:
            share[k] = share[k - 1] + turning_time(rate, base[k - 1], base[k])
    total, last = share[KNOTS - 1], max(np.float64(knots[m, KNOTS - 1, TIME]), 1e-9)
    for k in range(KNOTS):
        share[k] = knots[m, k, TIME] / last if total < _STILL else share[k] / total
    share[KNOTS - 1] = 1.0
    for j in range(4):
        off = limb.start[j] - base[0, j]
        for k in range(KNOTS):
            base[k, j] += (1.0 - share[k]) * off


@njit(_nrt=False)
def _soonest_end(study, work):
    """When a movement to the end can be over, if nothing but the joints' speeds limits it [s]."""
    base, share, end, rate = work.base, work.share, work.end, study.scene.limits.joint_speed
    t = 0.0
    for k in range(1, KNOTS):
        step, took = share[k] - share[k - 1], 0.0
        for j in range(4):
            turn = base[k, j] - base[k - 1, j] + step * (end[j] - base[KNOTS - 1, j])
            took = max(took, abs(turn) / rate[j])
        t = max(t + took, work.wanted[k])
    return t


@njit(_nrt=False)
def write_path(study, edge, work):
    """Write the movement to the end, between its ends by `edge` [rad] within the joints' ranges."""
    limb, base, share, end, path = study.scene.limb, work.base, work.share, work.end, work.path
    for j in range(4):
        off, room = end[j] - base[KNOTS - 1, j], min(edge, 0.5 * (limb.high[j] - limb.low[j]))
        low, high = limb.low[j] + room, limb.high[j] - room
        for k in range(KNOTS):
            path[k, j] = min(max(base[k, j] + share[k] * off, low), high)
        path[0, j], path[KNOTS - 1, j] = limb.start[j], end[j]


@njit(_nrt=False)
def _paced(study, work):
    """Write the movement to the end and its times: as early as limits allow, no wait cut short."""
    write_path(study, 0.0, work)
    path = work.path
    work.time[0] = 0.0
    for k in range(1, KNOTS):
        took, _ = time_of(study, path[k - 1], path[k])
        work.time[k] = max(work.time[k - 1] + took, work.wanted[k])
    return work.time[KNOTS - 1]


@njit(_nrt=False)
def _away(study, b, fast, t):
    """How long target b surely stays out of reach, of the arm or of a straight hand [s]."""
    limb, top, poses = study.scene.limb, study.scene.bodies.rows[b, TOP_SPEED], study.desk.poses
    _, _, _, x, y, z = limb_at(limb, limb.start)
    ring = target_room(study.scene, b, 0.0, 0.0, 0.0, t, poses)
    ring -= study.catch + limb.rho + limb.length
    way = target_room(study.scene, b, x, y, z, t, poses) - study.catch - fast * t
    wait = way / (fast + top)
    if ring > 0.0:
        wait = max(wait, ring / top if top > 0.0 else 1e300)
    return wait


@njit(_nrt=False)
def seed_end(study, work):
    """Begin with the end of the memory, within the joints' ranges."""
    limb = study.scene.limb
    for j in range(4):
        study.low[j], study.high[j] = limb.low[j], limb.high[j]
        work.end[j] = min(max(work.base[KNOTS - 1, j], limb.low[j]), limb.high[j])


@njit(_nrt=False)
def meet(query, b, work, since):
    """Adapt the movement to where target b can be met and time it: the instant, or -1.

    No instant before `since` [s] is tried.

    The sooner the instant, the better: one that comes late by some time needs at least that part
    of it in which hand and target can close the gap.
    """
    study = query.study
    horizon, fast = study.scene.limits.horizon, fastest_hand(study.scene)
    closing = fast / (fast + study.scene.bodies.rows[b, TOP_SPEED])
    close, t, rough = _CLOSE * horizon, since, True
    before, late_before = -1.0, 0.0
    for _ in range(_TURNS):
        if t > horizon:
            return -1.0
        away = _away(study, b, fast, t)
        if away > close:
            t, before = t + away, -1.0
            continue
        seed_end(study, work)
        if not pulled(study, b, t, work.end):
            t, before, rough = t + horizon / _STRIDE, -1.0, True
            continue
        if rough:
            late = _soonest_end(study, work) - t
            rough = late > close
        if not rough:
            late = _paced(study, work) - t
            if late <= 0.0:
                return t
        step = late * closing
        if before >= 0.0 and late < late_before:  # the secant, where hand gains on target
            step = max(step, late * min((t - before) / (late_before - late), _LONGEST))
        before, late_before = t, late
        t += max(step, study.instant)
    return -1.0


@njit(_nrt=False)
def keep(work, t, b):
    """Keep the movement that was just adapted as the best, over when b is caught at t [s]."""
    way, last = work.way, KNOTS - 1
    for k in range(KNOTS):
        write(way, k, work.path[k], work.time[k], work.time[k] if k < last else t)
    way.body[0] = b


@njit(_nrt=False)
def adapt_to_targets(knots, m, query, tempo, work):
    """Adapt memory m to the target that it can catch first; its way is left in ``work.way``.

    Returns
    -------
    bool
        Whether any can be met in time.
    """
    load(knots, m, query, tempo, work)
    return meet_any(query, work)


@njit(_nrt=False)
def meet_any(query, work):
    """Adapt the movement to the target that it can catch first; whether any can be met in time."""
    best, rows = -1.0, query.study.scene.bodies.rows
    for b in range(rows.shape[0]):
        if rows[b, PART] == HAND:
            t = meet(query, b, work, 0.0)
            if t >= 0.0 and (best < 0.0 or t < best):
                best = t
                keep(work, t, b)
    return best >= 0.0


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
def least_times(study, joints):
    """Least times (n - 1,) of the moves between postures (n, 4) [s]."""
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
