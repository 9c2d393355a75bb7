"""Ways in the joints: postures, when each is reached and left, and the catch at the end."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.arms.curves import line
from gcm_learn.compiled import njit
from gcm_learn.motion.joint_interception import first_meeting
from gcm_learn.planners.joints import moves
from gcm_learn.planners.joints.goals import earlier, reach

MOST = 512  # postures of a way


class JointWay(NamedTuple):
    """A movement that ends in a catch; between postures the joints go straight."""

    joints: np.ndarray  # (MOST, n) [rad]
    reached: np.ndarray  # (MOST,) [s]
    left: np.ndarray  # (MOST,): that of the last posture is the time of the catch [s]
    rates: np.ndarray  # (MOST, n): while a posture is reached and left [rad/s]
    free: np.ndarray  # (MOST,): rates of the move after a posture that were free; see `ramp`
    body: np.ndarray  # (1,): that is caught
    size: np.ndarray  # (1,): how many postures there are


def new_way(dof: int) -> JointWay:
    """Return a way without postures."""
    return JointWay(
        np.zeros((MOST, dof)),
        np.zeros(MOST),
        np.zeros(MOST),
        np.zeros((MOST, dof)),
        np.zeros(MOST, np.int64),
        np.zeros(1, np.int64),
        np.zeros(1, np.int64),
    )


@njit(_nrt=False)
def write(way, k, q, reached, left):
    """Make joints q (dof,) posture k of a way, and the last."""
    for j in range(q.size):
        way.joints[k, j] = q[j]
    way.reached[k], way.left[k] = reached, left
    way.size[0] = k + 1


@njit(_nrt=False)
def write_rates(way, k, rates, free):
    """Write the rates (dof,) at posture k, and which rates of the next move were free."""
    for j in range(rates.size):
        way.rates[k, j] = rates[j]
    way.free[k] = free


@njit(_nrt=False)
def _leap(study, way, k, since, m):
    """Go straight from posture k of a way, left at `since`, to posture m; return the arrival.

    The limb waits at m for the former arrival, so that the rest of the way remains. -1 if that
    is not free.
    """
    q, p = way.joints[k], way.joints[m]
    took, pieces = moves.time_of(study, q, p)
    arrive, before = since + took, way.reached[m]
    if arrive > before:
        return -1.0
    if moves.timed_move_is_free(study, q, since, p, arrive, pieces):
        if moves.rest_is_free(study, p, arrive, before):
            return arrive
    if arrive < before and moves.timed_move_is_free(study, q, since, p, before, pieces):
        return before
    return -1.0


@njit(_nrt=False)
def shorten(study, way, out):
    """Leave out needless postures of a way, the farthest first, and write the rest to `out`."""
    k, since, n = 0, 0.0, 0
    last, end = way.size[0] - 1, way.left[way.size[0] - 1]
    out.body[0] = way.body[0]
    while True:
        write(out, n, way.joints[k], since, since)
        n += 1
        begin, arrive = reach(study, way.joints[k], since, way.left[k], way.joints[last], end)
        if begin >= 0.0 or k + 1 == last:
            out.left[n - 1] = begin if begin >= 0.0 else way.left[k]
            write(out, n, way.joints[last], arrive if begin >= 0.0 else way.reached[last], end)
            return
        m, found = last - 1, -1.0
        while m > k and found < 0.0:
            found = _leap(study, way, k, since, m)
            m -= 1
        if found >= 0.0:
            k, since = m + 1, found
        else:
            out.left[n - 1] = way.left[k]
            k, since = k + 1, way.reached[k + 1]


@njit(_nrt=False)
def hasten(study, way):
    """Make the catch by a way's last move as early as possible."""
    k = way.size[0] - 2
    since, end = way.reached[k], way.left[k + 1]
    t = earlier(study, way.joints[k], since, way.body[0], way.joints[k + 1], end)
    if t < end:
        way.left[k], way.reached[k + 1], way.left[k + 1] = since, t, t


@njit
def samples_of(study, way):
    """A way as samples, cut at the first target within reach.

    Returns
    -------
    time : (n,) ndarray
        [s]
    joints : (n, dof) ndarray
        [rad]
    body : int
        That is caught.
    """
    most = way.size[0] * (moves.PIECES + 2)
    time, joints, n = np.empty(most), np.empty((most, way.joints.shape[1])), 1
    time[0] = 0.0
    joints[0] = way.joints[0]
    for k in range(way.size[0]):
        q = way.joints[k]
        n = _append(time, joints, n, q, way.left[k])
        if k + 1 < way.size[0]:
            p, begin, end = way.joints[k + 1], way.left[k], way.reached[k + 1]
            took, pieces = moves.time_of(study, q, p)
            stretch = (end - begin) / took if took > 0.0 else 0.0
            for i in range(pieces - 1):
                moves.between(q, p, (i + 1.0) / pieces, study.near)
                n = _append(time, joints, n, study.near, begin + stretch * study.pace[i])
            n = _append(time, joints, n, p, end)
    curve, work = study.desk.curve, study.near
    for k in range(n - 1):
        line(joints[k], joints[k + 1], curve)
        t, b = first_meeting(
            study.scene, curve, time[k], time[k + 1], study.catch, study.instant, study.desk.poses
        )
        if b >= 0 and t > time[k]:
            moves.between(joints[k], joints[k + 1], (t - time[k]) / (time[k + 1] - time[k]), work)
            time[k + 1] = t
            joints[k + 1] = work
            return time[: k + 2].copy(), joints[: k + 2].copy(), b
    return time[:n].copy(), joints[:n].copy(), way.body[0]


@njit(_nrt=False)
def _append(time, joints, n, q, t):
    """Append a sample that is later than the last; return the number of samples."""
    if t <= time[n - 1]:
        return n
    time[n] = t
    for j in range(q.size):
        joints[n, j] = q[j]
    return n + 1
