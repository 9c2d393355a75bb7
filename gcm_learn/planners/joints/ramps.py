"""Moves of joints under limits of acceleration: a ramp, constant rates, and another ramp.

All joints accelerate over the same spans, each with its own constant acceleration.  So every piece
of a move is quadratic in time, and a move from rest to rest is straight in the joints.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.arms.curves import hermite
from gcm_learn.collision.postures import least_on
from gcm_learn.compiled import njit
from gcm_learn.motion.joint_verification import NOTHING, piece_fault
from gcm_learn.planners.joints.moves import rest_is_free

GIVEN, START_FREE, END_FREE = 0, 1, 2  # which rates of a move are given: a sum of these
EASE = 1e-6  # share of the limits that is not used, against rounding
SHORTEST = 1e-9  # a piece that takes less is left out [s]


class Ramp(NamedTuple):
    """Samples of a move that is quadratic in time between samples."""

    joints: np.ndarray  # (4, n) [rad]
    rates: np.ndarray  # (4, n) [rad/s]
    time: np.ndarray  # (4,): since the move began [s]


def new_ramp(dof: int) -> Ramp:
    """Return arrays for a move."""
    return Ramp(np.zeros((4, dof)), np.zeros((4, dof)), np.zeros(4))


@njit(_nrt=False)
def still_at(rates):
    """Return whether joints with these rates (n,) rest."""
    most = 0.0
    for j in range(rates.size):
        most = max(most, abs(rates[j]))
    return most == 0.0


@njit(_nrt=False)
def _longest(limits, q, r, p, v, span, free):
    """Longest time that each ramp may take so that no joint is too fast [s]."""
    whole, weight = (span, 0.5) if free else (0.5 * span, 1.0)
    for j in range(q.size):
        most, way, given = limits.joint_speed[j] * (1.0 - EASE), p[j] - q[j], 0.0
        if not free & START_FREE:
            given += 0.5 * r[j]
        if not free & END_FREE:
            given += 0.5 * v[j]
        if abs(way) > most * span:
            return -1.0
        # between the ramps a joint has (way - given s) / (span - weight s)
        if weight * most > given:
            whole = min(whole, (most * span - way) / (weight * most - given))
        if weight * most > -given:
            whole = min(whole, (most * span + way) / (weight * most + given))
    return whole


@njit(_nrt=False)
def ramp(limits, q, r, p, v, span, free, out):
    """Move from joints q with rates r to p with rates v (n,) in `span` [s].

    The ramps take as long as the limits of speed allow, since accelerations are least then.

    Parameters
    ----------
    free : int
        `START_FREE` and `END_FREE` name rates that are not given.  There the move begins or ends
        with its constant rates.
    out : Ramp
        Gets its samples.

    Returns
    -------
    int
        Number of pieces, 0 if no such move keeps the limits of speeds and accelerations.
    """
    last, n = 0, q.size
    took = _longest(limits, q, r, p, v, span, free) if free < START_FREE + END_FREE else 0.0
    if not took >= 0.0 or span <= 0.0:
        return 0
    first = 0.0 if free & START_FREE else took
    second = 0.0 if free & END_FREE else took
    for j in range(n):
        speed = limits.joint_speed[j] * (1.0 - EASE)
        most = limits.joint_acceleration[j] * (1.0 - EASE) * took
        before = 0.0 if free & START_FREE else r[j]
        after = 0.0 if free & END_FREE else v[j]
        rate = p[j] - q[j] - 0.5 * (before * first + after * second)
        rate /= span - 0.5 * (first + second)
        if abs(rate) > speed * (1.0 + 0.5 * EASE):
            return 0
        if not free & START_FREE and abs(rate - before) > most:
            return 0
        if not free & END_FREE and abs(rate - after) > most:
            return 0
        out.rates[1, j] = rate
        out.rates[0, j] = rate if free & START_FREE else before
        out.rates[3, j] = rate if free & END_FREE else after
        out.joints[0, j], out.joints[3, j] = q[j], p[j]
    out.time[0], last = 0.0, 0
    if first > SHORTEST:
        last = 1
        out.time[1] = first
        for j in range(n):
            out.joints[1, j] = q[j] + 0.5 * first * (out.rates[0, j] + out.rates[1, j])
    if second > SHORTEST and span - first - second > SHORTEST:
        out.time[last + 1] = span - second
        for j in range(n):
            rate = out.rates[1, j]
            out.joints[last + 1, j] = p[j] - 0.5 * second * (rate + out.rates[3, j])
            out.rates[last + 1, j] = rate
        last += 1
    if span - out.time[last] <= SHORTEST and last > 0:
        last -= 1
    out.time[last + 1] = span
    for j in range(n):
        end = out.rates[3, j]
        out.joints[last + 1, j], out.rates[last + 1, j] = p[j], end
    return last + 1


@njit(_nrt=False)
def least_ramp(limits, q, p, free):
    """Return the least time of a move from rest at q to p (n,), to rest or to a `free` end [s]."""
    top, force, halves = 1e300, 1e300, 0.5 if free else 1.0
    for j in range(q.size):
        way = abs(p[j] - q[j])
        if way > 0.0:
            top = min(top, limits.joint_speed[j] * (1.0 - 2.0 * EASE) / way)
            force = min(force, limits.joint_acceleration[j] * (1.0 - 2.0 * EASE) / way)
    if top == 1e300:
        return 0.0
    pace = min(top, np.sqrt(force / halves))
    return (1.0 / pace + halves * pace / force) * (1.0 + EASE)


@njit(_nrt=False)
def may_ramp(limits, q, r, p, span, backward):
    """Return whether joints may get from q with rates r to p (n,) in `span` [s].

    A necessary condition, which is quick to ask.  Backward, the rates are those at p.
    """
    for j in range(q.size):
        way, lever = p[j] - q[j], 0.5 * limits.joint_acceleration[j] * span * span
        if abs(way) > limits.joint_speed[j] * span or abs(way - r[j] * span) > lever:
            return False
    return True


@njit(_nrt=False)
def ramp_box(study, q, r, span):
    """Write the joints that are within reach of q (n,) with rates r in a time into low and high."""
    limb, limits = study.scene.limb, study.scene.limits
    for j in range(q.size):
        low = -_farthest(limits, j, -r[j], span)
        high = _farthest(limits, j, r[j], span)
        study.low[j] = max(limb.low[j], q[j] + low)
        study.high[j] = min(limb.high[j], q[j] + high)
        if study.low[j] > study.high[j]:  # the range ends before the joint can stop
            study.low[j] = study.high[j] = min(max(q[j], limb.low[j]), limb.high[j])


@njit(_nrt=False)
def _farthest(limits, j, rate, span):
    """Farthest turn upwards of joint j, from a rate, in a time."""
    most, force = limits.joint_speed[j], limits.joint_acceleration[j]
    if rate + force * span <= most:
        return (rate + 0.5 * force * span) * span * (1.0 - 2.0 * EASE)
    return (most * span - 0.5 * (most - rate) * (most - rate) / force) * (1.0 - 2.0 * EASE)


@njit(_nrt=False)
def ramp_is_free(study, moves, pieces, since):
    """Return whether a move that begins at `since` [s] keeps all limits and touches nothing."""
    scene, desk = study.scene, study.desk
    for k in range(pieces):
        span = moves.time[k + 1] - moves.time[k]
        hermite(
            moves.joints[k], moves.rates[k], moves.joints[k + 1], moves.rates[k + 1], span,
            desk.curve,
        )  # fmt: skip
        if piece_fault(scene, desk.curve, span, desk.joints) != NOTHING:
            return False
    for k in range(pieces):
        span = moves.time[k + 1] - moves.time[k]
        hermite(
            moves.joints[k], moves.rates[k], moves.joints[k + 1], moves.rates[k + 1], span,
            desk.curve,
        )  # fmt: skip
        begin = since + moves.time[k]
        best, _ = least_on(scene, begin, begin + span, study.touch, 1e300, 1e300, desk)
        if best <= study.touch:
            return False
    return True


@njit(_nrt=False)
def reach_ramped(study, q, r, since, p, v, t, free, out):
    """Free move from joints q with rates r at `since` [s] to p with rates v at t [s]; see `ramp`.

    A limb that rests at q may wait before it leaves; one that comes to rest at p may be early.

    Returns
    -------
    leave, arrive : float
        When the move begins and ends; -1 if none is free [s].
    """
    limits = study.scene.limits
    pieces = ramp(limits, q, r, p, v, t - since, free, out)
    if pieces > 0 and ramp_is_free(study, out, pieces, since):
        return since, t
    waits = not free & START_FREE and still_at(r)
    rests = not free & END_FREE and still_at(v)
    if not waits or not (rests or free & END_FREE):
        return -1.0, -1.0
    took = least_ramp(limits, q, p, free)
    if t - since < 1.05 * took:
        return -1.0, -1.0
    pieces = ramp(limits, q, r, p, v, took, free, out)
    if pieces == 0:
        return -1.0, -1.0
    if ramp_is_free(study, out, pieces, t - took) and rest_is_free(study, q, since, t - took):
        return t - took, t
    if rests and ramp_is_free(study, out, pieces, since):
        if rest_is_free(study, p, since + took, t):
            return since, since + took
    return -1.0, -1.0
