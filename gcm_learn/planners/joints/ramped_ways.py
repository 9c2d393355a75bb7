"""Ways under limits of acceleration: shortened, made earlier, and as samples."""

from __future__ import annotations

import numpy as np

from gcm_learn.arms.curves import hermite, on_curve, rate_of
from gcm_learn.compiled import njit
from gcm_learn.motion.joint_interception import first_meeting
from gcm_learn.planners.joints import ramps
from gcm_learn.planners.joints.moves import rest_is_free
from gcm_learn.planners.joints.pull import pulled
from gcm_learn.planners.joints.ways import write, write_rates

HALVINGS = 10  # of the time by which a catch may become earlier


@njit(_nrt=False)
def _leap(study, way, k, since, m, moves):
    """Go from posture k of a way, left at `since`, to posture m; return the arrival [s].

    The way from there on remains as it was.  -1 if the move is not free.
    """
    limits, q, r = study.scene.limits, way.joints[k], way.rates[k]
    p, v, before = way.joints[m], way.rates[m], way.reached[m]
    if ramps.still_at(r) and ramps.still_at(v):
        took = ramps.least_ramp(limits, q, p, ramps.GIVEN)
        if since + took <= before:
            pieces = ramps.ramp(limits, q, r, p, v, took, ramps.GIVEN, moves)
            if pieces > 0 and ramps.ramp_is_free(study, moves, pieces, since):
                if rest_is_free(study, p, since + took, before):
                    return since + took
    pieces = ramps.ramp(limits, q, r, p, v, before - since, ramps.GIVEN, moves)
    if pieces > 0 and ramps.ramp_is_free(study, moves, pieces, since):
        return before
    return -1.0


@njit(_nrt=False)
def shorten_ramped(study, way, moves, free, out):
    """Leave out postures that are not needed, the farthest first.

    `free` says whether the rates at the end are; see `ramps.ramp`.
    """
    k, since, n = 0, way.reached[0], 0
    last, end = way.size[0] - 1, way.left[way.size[0] - 1]
    out.body[0] = way.body[0]
    while True:
        write(out, n, way.joints[k], since, since)
        write_rates(out, n, way.rates[k], way.free[k])
        n += 1
        begin, arrive = ramps.reach_ramped(
            study, way.joints[k], way.rates[k], since,
            way.joints[last], way.rates[last], end, free, moves,
        )  # fmt: skip
        if begin >= 0.0 or k + 1 == last:
            if begin >= 0.0:
                out.free[n - 1] = free
            out.left[n - 1] = begin if begin >= 0.0 else way.left[k]
            write(out, n, way.joints[last], arrive if begin >= 0.0 else way.reached[last], end)
            write_rates(out, n, way.rates[last], way.free[last])
            return
        m, found = last - 1, -1.0
        while m > k + 1 and found < 0.0:
            found = _leap(study, way, k, since, m, moves)
            m -= 1
        if found >= 0.0:
            k, since, out.free[n - 1] = m + 1, found, ramps.GIVEN
        else:
            out.left[n - 1] = way.left[k]
            k, since = k + 1, way.reached[k + 1]


@njit(_nrt=False)
def hasten_ramped(study, way, moves):
    """Make the catch by a way's last move as early as possible."""
    k, scene, goal = way.size[0] - 2, study.scene, study.goal
    q, r, p, since = way.joints[k], way.rates[k], way.joints[k + 1], way.reached[k]
    low, t = since, way.left[k + 1]
    for _ in range(HALVINGS):
        middle = 0.5 * (low + t)
        ramps.ramp_box(study, q, r, middle - since)
        for j in range(goal.size):
            goal[j] = min(max(p[j], study.low[j]), study.high[j])
        pieces = 0
        if pulled(study, way.body[0], middle, goal):
            pieces = ramps.ramp(scene.limits, q, r, goal, r, middle - since, ramps.END_FREE, moves)
        if pieces > 0 and ramps.ramp_is_free(study, moves, pieces, since):
            t = middle
            write(way, k + 1, goal, t, t)
            way.left[k], way.free[k] = since, ramps.END_FREE
        else:
            low = middle


@njit
def ramped_samples(study, way, moves):
    """A way as samples of a cubic Hermite curve.

    Returns
    -------
    time : (n,) ndarray
        [s]
    joints : (n, dof) ndarray
        [rad]
    rates : (n, dof) ndarray
        [rad/s]
    """
    most, n = 4 * way.size[0] + 1, 1
    time = np.empty(most)
    joints, rates = np.empty((most, way.joints.shape[1])), np.empty((most, way.joints.shape[1]))
    time[0], joints[0], rates[0] = way.reached[0], way.joints[0], way.rates[0]
    for k in range(way.size[0] - 1):
        if way.left[k] > time[n - 1]:
            time[n], joints[n], rates[n] = way.left[k], way.joints[k], way.rates[k]
            n += 1
        span = way.reached[k + 1] - way.left[k]
        pieces = ramps.ramp(
            study.scene.limits, way.joints[k], way.rates[k], way.joints[k + 1],
            way.rates[k + 1], span, way.free[k], moves,
        )  # fmt: skip
        for i in range(1, pieces + 1):
            time[n] = way.left[k] + moves.time[i] if i < pieces else way.reached[k + 1]
            joints[n], rates[n] = moves.joints[i], moves.rates[i]
            n += 1
    end = way.left[way.size[0] - 1]
    if end > time[n - 1]:
        time[n], joints[n], rates[n] = end, joints[n - 1], rates[n - 1]
        n += 1
    return time[:n].copy(), joints[:n].copy(), rates[:n].copy()


@njit
def cut_samples(study, time, joints, rates, body):
    """Cut samples of `ramped_samples` at the first target within reach; the target comes last."""
    n, curve, desk = time.size, study.desk.curve, study.desk
    for k in range(n - 1):
        span = time[k + 1] - time[k]
        hermite(joints[k], rates[k], joints[k + 1], rates[k + 1], span, curve)
        t, b = first_meeting(
            study.scene, curve, time[k], time[k + 1], study.catch, study.instant, desk.poses
        )
        if b >= 0 and t > time[k]:
            share = (t - time[k]) / span
            on_curve(curve, share, joints[k + 1])
            for j in range(joints.shape[1]):
                rates[k + 1, j] = rate_of(curve, j, share) / span
            time[k + 1] = t
            return time[: k + 2].copy(), joints[: k + 2].copy(), rates[: k + 2].copy(), b
    return time, joints, rates, body
