"""Remembered movements under limits of acceleration: they keep their times, if they can.

A movement ends when the memory did, or at the nearest time at which a target can be met and the
limits be kept; its other times are stretched with it.  Only where a piece would be too fast for the
joints or the hand its neighbours make room for it.  The arm follows step by step: each step aims,
with one constant acceleration, at where the movement is a little later.  What is missing at the end
is added to all of it, and it is followed anew.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.collision.postures import hermite, least_on
from gcm_learn.compiled import njit
from gcm_learn.motion.interception_in_space import target_room
from gcm_learn.motion.verification_in_space import NOTHING, piece_fault
from gcm_learn.planners.space.goals import pulled
from gcm_learn.planners.space.moves import time_of
from gcm_learn.recall.space.kernels import KEEP, KNOTS, load, seed_end, write_path
from gcm_learn.recall.trials import learn, most_promising
from gcm_learn.scene.bodies import HAND, PART
from gcm_learn.scene.spatial_limb import limb_at

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
def catch_by(knots, m, query, times, work, track):
    """Adapt memory m until it catches; the movement is left in `track`.

    Parameters
    ----------
    knots : (n, KNOTS, COLUMNS) ndarray of float32
        All memories.
    times : int
        At how many times of the end that keep all limits it is looked for touches.

    Returns
    -------
    body : int
        The target that is caught, -1 if none is.
    looked : int
        How often it was looked at.
    """
    study, looked = query.study, 0
    rows, own = study.scene.bodies.rows, _remembered(knots, m, query, work)
    for stretch in STRETCHES:
        until = own * stretch
        if until > study.scene.limits.horizon:
            continue
        for b in range(rows.shape[0]):
            if rows[b, PART] == HAND and _adapted(study, b, until, work, track):
                looked += 1
                if _is_free(study, track):
                    return b, looked
                if looked >= times:
                    return -1, looked
    return -1, looked


@njit
def catch_times(knots, chosen, query, times, work, track):
    """When memories catch (m,) [s]; as `recall.space.trials.catch_times`."""
    out = np.full(chosen.size, -1.0)
    for i in range(chosen.size):
        body, _ = catch_by(knots, chosen[i], query, times, work, track)
        if body >= 0:
            out[i] = track.time[STEPS]
    return out


@njit
def first_valid(knots, offer, query, times, budget, work, track):
    """Try memories, the most promising first; as `recall.space.trials.first_valid`.

    Looks at other times come before the one check of a memory, and count as none.

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
        body, looked = catch_by(knots, offer.chosen[i], query, times, work, track)
        if looked > 0 or budget.novelty <= 0.0:
            checked += 1
        if body >= 0:
            return i, body, checked
        if budget.penalty > 0.0:
            learn(offer, i, budget.penalty)
    return -1, -1, checked
