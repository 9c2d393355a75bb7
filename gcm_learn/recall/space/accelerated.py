"""Remembered movements under limits of acceleration: they keep their times, if they can.

A movement ends when the memory did, or at the nearest time at which a target can be met and the
limits be kept; its other times are stretched with it.  Only where a piece would be too fast for the
joints or the hand its neighbours make room for it.  The arm follows step by step: each step aims,
with one constant acceleration, at where the movement is a little later.  What is missing at the end
is added to all of it, and it is followed anew.  What touches at all these times is pushed aside.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.arms.curves import hermite
from gcm_learn.arms.spatial_limb import limb_at
from gcm_learn.collision.postures import least_on
from gcm_learn.compiled import njit
from gcm_learn.motion.interception_in_space import target_room
from gcm_learn.motion.verification_in_space import NOTHING, piece_fault
from gcm_learn.planners.space.moves import time_of
from gcm_learn.planners.space.pull import pulled
from gcm_learn.recall.space.bending import (
    CLEARANCE,
    INSTANTS,
    PROGRESS,
    PUSHED,
    SIDES,
    WIDTHS,
    Touch,
    copy_move,
    pushed,
    sides_of,
)
from gcm_learn.recall.space.kernels import KEEP, KNOTS, load, seed_end, write_path
from gcm_learn.recall.trials import learn, most_promising
from gcm_learn.scene.bodies import HAND, PART

STEPS = 24  # of a movement that is followed, as long as each other
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


class Track(NamedTuple):
    """Room for a movement and for what follows it, at STEPS + 1 instants."""

    aims: np.ndarray  # (STEPS + 1, 4): the movement [rad]
    time: np.ndarray  # (STEPS + 1,) [s]
    joints: np.ndarray  # (STEPS + 1, 4) [rad]
    rates: np.ndarray  # (STEPS + 1, 4) [rad/s]
    least: np.ndarray  # (KNOTS,): that the pieces of the movement need [s]


def new_track() -> Track:
    """Room for a movement."""
    aims, joints, rates = np.zeros((3, STEPS + 1, 4))
    return Track(aims, np.zeros(STEPS + 1), joints, rates, np.zeros(KNOTS))


@njit(_nrt=False)
def _remembered(knots, m, query, work):
    """Move the start of memory m to where the arm is; the time at which it ends [s]."""
    load(knots, m, query, KEEP, work)
    horizon, wanted = query.study.scene.limits.horizon, work.wanted
    if wanted[KNOTS - 1] < LEAST * horizon:
        for k in range(KNOTS):
            wanted[k] = 0.5 * horizon * k / (KNOTS - 1)
    return wanted[KNOTS - 1]


@njit(_nrt=False)
def _timed(study, until, work, track):
    """Write the movement that is over at `until` [s]; whether there is time for all its pieces."""
    when, last, path, least = work.time, KNOTS - 1, work.path, track.least
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
def _sampled(work, track):
    """Write where the movement is at the instants of the track."""
    when, path, k = work.time, work.path, 0
    until = when[KNOTS - 1]
    for i in range(STEPS + 1):
        t = until * (i / STEPS)
        track.time[i] = t
        while k < KNOTS - 2 and when[k + 1] <= t:
            k += 1
        span = when[k + 1] - when[k]
        s = min((t - when[k]) / span, 1.0) if span > 0.0 else 1.0
        for j in range(4):
            track.aims[i, j] = path[k, j] + s * (path[k + 1, j] - path[k, j])
    for j in range(4):
        track.aims[STEPS, j] = path[KNOTS - 1, j]


@njit(_nrt=False)
def _follow(study, track):
    """Follow the movement as nearly as the limits of rates and accelerations allow."""
    limb, limits, aims = study.scene.limb, study.scene.limits, track.aims
    h = track.time[STEPS] / STEPS
    for j in range(4):
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
    """Write piece k of the track into `curve` (4, 4); how long it takes [s]."""
    q, v, span = track.joints, track.rates, track.time[k + 1] - track.time[k]
    hermite(q[k], v[k], q[k + 1], v[k + 1], span, curve)
    return span


@njit(_nrt=False)
def _adapted(study, b, until, work, track):
    """Adapt the movement so that it catches target b at `until` [s]; whether it keeps limits."""
    scene, desk = study.scene, study.desk
    seed_end(study, work)
    if not pulled(study, b, until, work.end) or not _timed(study, until, work, track):
        return False
    _sampled(work, track)
    _follow(study, track)
    _, _, _, x, y, z = limb_at(scene.limb, track.joints[STEPS])
    if target_room(scene, b, x, y, z, track.time[STEPS], desk.poses) > study.catch:
        return False
    for k in range(STEPS):
        span = _piece(track, k, desk.curve)
        if not span > 0.0 or piece_fault(scene, desk.curve, span, desk.joints) != NOTHING:
            return False
    return True


@njit(_nrt=False)
def _is_free(study, track):
    """Whether the limb touches nothing on the track."""
    for k in range(STEPS):
        _piece(track, k, study.desk.curve)
        best, _ = least_on(
            study.scene, track.time[k], track.time[k + 1], study.touch, 1e300, 1e300, study.desk
        )
        if best <= study.touch:
            return False
    return True


@njit(_nrt=False)
def _at_some_time(study, own, times, work, track):
    """Adapt the movement to the nearest time of its end at which it catches.

    Returns
    -------
    body : int
        The target that is caught, -1 if none is.
    looked : int
        How often it was looked at.
    first : int
        Target of the first look.
    until : float
        When it would have been caught there [s].
    """
    rows, looked, first, since = study.scene.bodies.rows, 0, -1, 0.0
    for stretch in STRETCHES:
        until = own * stretch
        if until > study.scene.limits.horizon:
            continue
        for b in range(rows.shape[0]):
            if rows[b, PART] == HAND and _adapted(study, b, until, work, track):
                looked += 1
                if looked == 1:
                    first, since = b, until
                if _is_free(study, track):
                    return b, looked, first, since
                if looked >= times:
                    return -1, looked, first, since
    return -1, looked, first, since


@njit(_nrt=False)
def _look(study, track, most):
    """How much the limb touches, and the first and last piece of the first time; -1 if not.

    What is nearer than CLEARANCE costs what it lacks; if it touches, to know that it is above
    `most` is enough.
    """
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
def _touch(study, work, track, first, last):
    """Where the movement that is followed touches, from piece `first` to `last`."""
    n = min(last - first + 2, INSTANTS)
    share, time, joints = np.empty(n), np.empty(n), np.empty((n, 4))
    for i in range(n):
        k = first + (last + 1 - first) * i // (n - 1)
        time[i], joints[i] = track.time[k], track.joints[k]
        share[i] = np.interp(time[i], work.time, work.share)
    before = max(first - 1, 0)
    study.far[:] = track.joints[before]
    sides = sides_of(study, study.far, track.time[before])
    return Touch(share, time, joints, sides, 1)


@njit
def _bent(study, b, until, bends, work, track):
    """Push a movement that would catch target b at `until` [s] aside until it touches nothing.

    As `recall.space.bending.bend`, but its times stay. Returns whether it is free.
    """
    if not _adapted(study, b, until, work, track):
        return False
    cost, first, last = _look(study, track, np.inf)
    for _ in range(bends):
        if first < 0:
            return True
        copy_move(work.base, work.wanted, work.from_base, work.from_wanted)
        touch, side = _touch(study, work, track, first, last), np.zeros(4)
        before, least = cost, cost
        for change in range(PUSHED):
            copy_move(work.from_base, work.from_wanted, work.base, work.wanted)
            if change % SIDES == 0:
                side[:] = 0.0
            if not pushed(study, work, touch, WIDTHS[change // SIDES], side):
                continue
            if not _adapted(study, b, until, work, track):
                continue
            cost, first, _ = _look(study, track, least)
            if first < 0:
                return True
            if cost < least:
                least = cost
                copy_move(work.base, work.wanted, work.least_base, work.least_wanted)
        if least > PROGRESS * before:
            return False
        copy_move(work.least_base, work.least_wanted, work.base, work.wanted)
        _adapted(study, b, until, work, track)
        cost, first, last = _look(study, track, np.inf)
    return first < 0


@njit
def catch_by(knots, m, query, bends, work, track):
    """Adapt memory m until it catches; the movement is left in `track`.

    Parameters
    ----------
    knots : (n, KNOTS, COLUMNS) ndarray of float32
        All memories.
    bends : int
        Changes at most of a movement that touches at all times of its end; with 0 the nearest that
        keeps all limits is the only one.

    Returns
    -------
    body : int
        The target that is caught, -1 if none is.
    met : bool
        Whether any can be met with all limits kept.
    """
    times = STRETCHES.size if bends > 0 else 1
    own = _remembered(knots, m, query, work)
    body, looked, first, until = _at_some_time(query.study, own, times, work, track)
    if body < 0 and looked > 0 and _bent(query.study, first, until, bends, work, track):
        body = first
    return body, looked > 0


@njit
def catch_times(knots, chosen, query, bends, work, track):
    """When memories catch (m,) [s]; as `recall.space.trials.catch_times`."""
    out = np.full(chosen.size, -1.0)
    for i in range(chosen.size):
        body, _ = catch_by(knots, chosen[i], query, bends, work, track)
        if body >= 0:
            out[i] = track.time[STEPS]
    return out


@njit
def first_valid(knots, offer, query, budget, work, track):
    """Try memories, the most promising first; as `recall.space.trials.first_valid`.

    Other times and pushes come before the one check of a memory, and count as none.

    Returns
    -------
    place, body, checked : int
        The movement is left in `track`.
    """
    checked = 0
    while checked < budget.tries:
        i = most_promising(offer)
        if i < 0:
            break
        offer.left[i] = False
        body, met = catch_by(knots, offer.chosen[i], query, budget.changes, work, track)
        if met or budget.novelty <= 0.0:
            checked += 1
        if body >= 0:
            return i, body, checked
        if budget.penalty > 0.0:
            learn(offer, i, budget.penalty)
    return -1, -1, checked
