"""Kernels of joint movements under limits of acceleration: they keep their times, if they can.

A movement ends when the memory did, or at the nearest time at which a target can be met within the
limits.  Its other times are stretched with it.  Pieces that are too fast for the joints or the hand
get time from their neighbours.  The arm follows step by step: each step aims, with one constant
acceleration, at a later place of the movement.  The error at the end is added to all of it, and it
is followed again.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.arms.curves import hermite
from gcm_learn.arms.limbs import dof, hand_of, place
from gcm_learn.collision.postures import least_on
from gcm_learn.compiled import njit
from gcm_learn.motion.joint_interception import ANGLE, approach_excess, target_room
from gcm_learn.motion.joint_verification import NOTHING, piece_fault
from gcm_learn.planners.joints.moves import Study, time_of
from gcm_learn.planners.joints.pull import pulled
from gcm_learn.recall.joint_moves import KNOTS, STEPS, load, seed_end, write_path
from gcm_learn.recall.joint_pushes import CLEARANCE, INSTANTS, PROGRESS, JointTouch, sides_of
from gcm_learn.recall.styles import KEEP, POLAR, PUSHED, Habits, Style
from gcm_learn.scene.bodies import HAND, PART

AHEAD = 2  # steps after which a step aims to be where the movement is
ROUNDS = 6  # of following a movement, until it ends where it should
CLOSE = 1e-5  # to the end that counts as there [rad]
HAIR = 1e-6  # share of the limits that is not used, against rounding
SPARE = 1.2  # times its least time that a piece is given: followed, it is not evenly fast
EDGE = 0.03  # that movements keep to the ends of the joints' ranges, in between [rad]
LEAST = 1e-3  # a remembered movement that takes less has no times to keep [horizons]


def _stretches() -> np.ndarray:
    """Times of the end that are tried, by the memory's own: the nearest first."""
    far = np.array([0.06, 0.13, 0.2, 0.3, 0.4, 0.55, 0.7, 0.9])
    return np.exp(np.concatenate([[0.0], np.stack([far, -far], axis=1).ravel()]))


STRETCHES = _stretches()


class TimedQuery(NamedTuple):
    """Situation with limits of acceleration, in the form that adaptations take."""

    study: Study
    turns: np.ndarray  # (dof,): signs that make joints of a left arm those of this one
    shift: np.ndarray  # (dof,): added to them, see `recall.headings`


@njit(_nrt=False)
def _remembered(paths, m, query, work):
    """Load memory m, with its start moved to the arm; return the time of its end [s]."""
    load(query, paths, m, Style(POLAR, KEEP), work)
    horizon, wanted = query.study.scene.limits.horizon, work.wanted
    if wanted[KNOTS - 1] < LEAST * horizon:
        for k in range(KNOTS):
            wanted[k] = 0.5 * horizon * k / (KNOTS - 1)
    return wanted[KNOTS - 1]


@njit(_nrt=False)
def _timed(study, until, work):
    """Write the movement, to end at `until` [s]; return whether there is time for all pieces."""
    when, last, path, least = work.time, KNOTS - 1, work.path, work.track.least
    write_path(study, EDGE, work)
    for k in range(KNOTS):
        when[k] = until * (work.wanted[k] / work.wanted[last])
    for k in range(1, KNOTS):
        took, _ = time_of(study, path[k - 1], path[k])
        least[k] = SPARE * took
        when[k] = max(when[k], when[k - 1] + least[k])
    when[last] = until
    for k in range(last - 1, 0, -1):
        when[k] = min(when[k], when[k + 1] - least[k + 1])
    return when[1] >= least[1]


@njit(_nrt=False)
def _sampled(work):
    """Write the movement at the instants of the track."""
    when, path, track, k = work.time, work.path, work.track, 0
    until = when[KNOTS - 1]
    for i in range(STEPS + 1):
        t = until * (i / STEPS)
        track.time[i] = t
        while k < KNOTS - 2 and when[k + 1] <= t:
            k += 1
        span = when[k + 1] - when[k]
        s = min((t - when[k]) / span, 1.0) if span > 0.0 else 1.0
        for j in range(path.shape[1]):
            track.aims[i, j] = path[k, j] + s * (path[k + 1, j] - path[k, j])
    for j in range(path.shape[1]):
        track.aims[STEPS, j] = path[KNOTS - 1, j]


@njit(_nrt=False)
def _follow(study, track):
    """Follow the movement as nearly as the limits of rates and accelerations allow."""
    limb, limits, aims = study.scene.limb, study.scene.limits, track.aims
    h = track.time[STEPS] / STEPS
    for j in range(dof(limb)):
        top = limits.joint_speed[j] * (1.0 - HAIR)
        most = limits.joint_acceleration[j] * (1.0 - HAIR)
        track.joints[0, j], track.rates[0, j], add = limb.start[j], limb.rates[j], 0.0
        for _ in range(ROUNDS):
            q, v = limb.start[j], limb.rates[j]
            for i in range(STEPS):
                k = min(i + AHEAD, STEPS)
                span = (k - i) * h
                force = 2.0 * (aims[k, j] + add * k / STEPS - q - v * span) / (span * span)
                force = min(max(force, (-top - v) / h), (top - v) / h)
                force = min(max(force, -most), most)
                q += h * (v + 0.5 * h * force)
                v += h * force
                track.joints[i + 1, j], track.rates[i + 1, j] = q, v
            off = aims[STEPS, j] - q
            if abs(off) < CLOSE:
                break
            add += off


@njit(_nrt=False)
def _piece(track, k, curve):
    """Write piece k of the track into `curve` (dof, 4); return the duration [s]."""
    q, v, span = track.joints, track.rates, track.time[k + 1] - track.time[k]
    hermite(q[k], v[k], q[k + 1], v[k + 1], span, curve)
    return span


@njit(_nrt=False)
def _adapted(study, b, until, work):
    """Adapt the movement to catch target b at `until` [s]; return whether the limits allow it."""
    scene, desk, track = study.scene, study.desk, work.track
    seed_end(study, work)
    if not pulled(study, b, until, work.end) or not _timed(study, until, work):
        return False
    _sampled(work)
    _follow(study, track)
    q = track.joints[STEPS]
    where = place(scene.limb, q)
    x, y, z = hand_of(scene.limb, where)
    if target_room(scene, b, x, y, z, track.time[STEPS], desk.poses) > study.catch:
        return False
    if approach_excess(scene, where, q, b, track.time[STEPS], desk.poses) > ANGLE:
        return False
    for k in range(STEPS):
        span = _piece(track, k, desk.curve)
        if not span > 0.0 or piece_fault(scene, desk.curve, span, desk.joints) != NOTHING:
            return False
    return True


@njit(_nrt=False)
def _is_free(study, track):
    """Return whether the limb is free on the track."""
    for k in range(STEPS):
        _piece(track, k, study.desk.curve)
        best, _ = least_on(
            study.scene, track.time[k], track.time[k + 1], study.touch, 1e300, 1e300, study.desk
        )
        if best <= study.touch:
            return False
    return True


@njit
def met(query, paths, m, _style, work, bends):
    """Try end times of memory m, nearest first, until a catch keeps all limits without contact.

    Parameters
    ----------
    bends : int
        With 0 the nearest time that keeps all limits is the only one.

    Returns
    -------
    count : int
        Times that keep all limits; the first, and the target caught without contact, are noted.
    body : int
        Target at the first of these times, -1 if there is none.
    """
    study, track = query.study, work.track
    own = _remembered(paths, m, query, work)
    rows, count, first, times = study.scene.bodies.rows, 0, -1, STRETCHES.size if bends > 0 else 1
    track.body[0] = -1
    for stretch in STRETCHES:
        until = own * stretch
        if until > study.scene.limits.horizon:
            continue
        for b in range(rows.shape[0]):
            if rows[b, PART] == HAND and _adapted(study, b, until, work):
                count += 1
                if count == 1:
                    first, track.until[0] = b, until
                if _is_free(study, track):
                    track.body[0] = b
                    return count, first
                if count >= times:
                    return count, first
    return count, first


@njit
def write_best(work):
    """Write the followed movement as the best; return the number of samples."""
    work.best_time[: STEPS + 1] = work.track.time
    work.best_joints[: STEPS + 1] = work.track.joints
    return STEPS + 1


@njit
def failures(_query, most):
    """Return an array for notes, which such movements leave empty."""
    return np.empty((most, 1, 1))


@njit(_nrt=False)
def note(_query, _row, _work, _count):
    """Note nothing: times differ as much as ways do."""


@njit(_nrt=False)
def is_near(_query, _row, _work, _count, _novelty):
    """Return False: every movement is checked."""
    return False


@njit(_nrt=False)
def habits(_query):
    """Return the numbers by which such movements are changed: their times stay."""
    return Habits(PUSHED, 0.0, PROGRESS, False, True, 0)


@njit(_nrt=False)
def again(query, body, _style, work, _since):
    """Adapt the movement to its target at its time; return that, or -1 past limits, and samples."""
    until = work.track.until[0]
    return until if _adapted(query.study, body, until, work) else -1.0, STEPS + 1


@njit(_nrt=False)
def quick_check(query, work, _count, _margin, most):
    """Find contacts of the movement that is followed, by pieces; see `recall.freeing`."""
    study, track = query.study, work.track
    near = CLEARANCE * study.scene.limb.length
    cost, first, last = 0.0, -1, -2
    for k in range(STEPS):
        _piece(track, k, study.desk.curve)
        room, _ = least_on(
            study.scene,
            track.time[k],
            track.time[k + 1],
            -1e300,
            0.1 * near,
            study.touch + near,
            study.desk,
        )
        cost += study.touch + near - room
        if room <= study.touch:
            if first < 0:
                first, last = k, k
            elif last == k - 1:
                last = k
        if first >= 0 and cost > most:
            break
    return cost, first, last


@njit
def touch_of(query, work, _count, first, last):
    """Return where the movement that is followed touches, from piece `first` to `last`."""
    study, track = query.study, work.track
    n = min(last - first + 2, INSTANTS)
    share, time, joints = np.empty(n), np.empty(n), np.empty((n, dof(study.scene.limb)))
    for i in range(n):
        k = first + (last + 1 - first) * i // (n - 1)
        time[i], joints[i] = track.time[k], track.joints[k]
        share[i] = np.interp(time[i], work.time, work.share)
    before = max(first - 1, 0)
    study.far[:] = track.joints[before]
    sides = sides_of(study, study.far, track.time[before])
    return JointTouch(share, time, joints, sides, np.array([1, 1]), np.zeros(2))
