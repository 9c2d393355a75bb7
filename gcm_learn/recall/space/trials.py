"""Many memories tried on one situation of a spatial arm: adapted, checked, repaired.

A movement that touches an obstacle is moved once more, by a bump in the joints whose top is where
the limb first touches, no higher than needed for it to be free there.  Where it touches at its end,
the bump rises to the end, and the target is met from there.  What comes out counts as another one.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.collision.postures import distance_at
from gcm_learn.compiled import njit
from gcm_learn.planners.space.moves import between
from gcm_learn.planners.space.ways import new_way, samples_of
from gcm_learn.recall.space.kernels import (
    KNOTS,
    Work,
    adapt_to_targets,
    first_touch,
    keep,
    meet,
)
from gcm_learn.recall.trials import learn, most_promising

PUSHES = np.array([0.1, 0.2, 0.35, 0.55, 0.8])  # heights of bumps [rad]
CLEARANCE = 0.01  # by which a pushed limb is free where it touched [forearms]
INSTANTS = 8  # at most at which a push is tried
LOOKS = 40  # at a movement, for when it touches
PROBE = 1e-3  # finite difference for the direction away from obstacles [rad]
END = 0.9  # share of a movement from which a touch is one at its end


def work_room() -> Work:
    """Buffers for adaptations."""
    share, wanted, time = np.zeros((3, KNOTS))
    base, path = np.zeros((2, KNOTS, 4))
    return Work(share, base, wanted, np.zeros(4), path, time, new_way())


def _directions() -> np.ndarray:
    """Pushes that are tried besides that away from the obstacle (12, 4)."""
    single = np.vstack([np.eye(4), -np.eye(4)])
    pairs = np.array([[a, b, 0.0, 0.0] for a in (-1.0, 1.0) for b in (-1.0, 1.0)])
    return np.vstack([single, 0.8 * pairs])


_SIDES = _directions()


@njit
def catch_times(knots, chosen, query, tempo, repairs, work):
    """When memories, adapted to a situation, catch in it (m,) [s]; negative where they do not.

    Parameters
    ----------
    knots : (n, KNOTS, COLUMNS) ndarray of float32
        All memories.
    chosen : (m,) ndarray of int64
        Which of them to try.
    query : Query
    tempo : int
    repairs : int
        How often a movement that touches is pushed aside.
    work : Work
    """
    out = np.full(chosen.size, -1.0)
    for i in range(chosen.size):
        met = adapt_to_targets(knots, chosen[i], query, tempo, work)
        for k in range(repairs + 1):
            if not met:
                break
            time, joints, _ = samples_of(query.study, work.way)
            touched = first_touch(query.study, time, joints)
            if touched < 0:
                out[i] = time[-1]
                break
            met = k < repairs and repair(query, work, time, joints, touched)
    return out


@njit
def first_valid(knots, offer, query, tempo, budget, work):
    """Try memories, the most promising first, until one is valid; as `recall.trials.first_valid`.

    Returns
    -------
    place : int
        Position in the offer, -1 if none is valid.
    body : int
        The target that is caught.
    checked : int
        Movements that were checked.
    time, joints : (m,), (m, 4) ndarray
        The valid movement.
    """
    none, nothing = np.empty(0), np.empty((0, 4))
    failed = np.empty((budget.tries, KNOTS, 5))
    checked, kept = 0, 0
    while True:
        i = most_promising(offer)
        if i < 0 or checked >= budget.tries:
            return -1, -1, checked, none, nothing
        offer.left[i] = False
        met = adapt_to_targets(knots, offer.chosen[i], query, tempo, work)
        if not met and budget.novelty <= 0.0:
            checked += 1
        for k in range(budget.changes + 1):
            if checked >= budget.tries:
                return -1, -1, checked, none, nothing
            if not met or (budget.novelty > 0.0 and _known(failed[:kept], work, budget.novelty)):
                break
            checked += 1
            time, joints, body = samples_of(query.study, work.way)
            touched = first_touch(query.study, time, joints)
            if touched < 0:
                return i, body, checked, time, joints
            _note(failed[kept], work)
            kept += 1
            met = k < budget.changes and repair(query, work, time, joints, touched)
        if budget.penalty > 0.0:
            learn(offer, i, budget.penalty)


@njit(_nrt=False)
def _note(row, work):
    """Note the best movement."""
    for k in range(KNOTS):
        for j in range(4):
            row[k, j] = work.way.joints[k, j]
        row[k, 4] = work.way.reached[k]


@njit(_nrt=False)
def _known(failed, work, novelty):
    """Whether a noted movement is everywhere within `novelty` [rad] of the best one.

    A second counts as much as ten radians.
    """
    way = work.way
    for row in range(failed.shape[0]):
        apart = 0.0
        for k in range(KNOTS):
            apart = max(apart, 10.0 * abs(failed[row, k, 4] - way.reached[k]))
            for j in range(4):
                apart = max(apart, abs(failed[row, k, j] - way.joints[k, j]))
            if apart > novelty:
                break
        if apart <= novelty:
            return True
    return False


@njit
def repair(query, work, time, joints, touched):
    """Push the best movement aside where it first touches; whether it can be met again.

    Parameters
    ----------
    query : Query
    work : Work
    time, joints : (n,), (n, 4) ndarray
        The movement's samples.
    touched : int
        Piece that touches first.
    """
    count, start, step = _touching(query.study, time, joints, touched)
    if count == 0:
        return False
    height, top, side = _push(query.study, work, time, joints, start, step, count)
    if height == 0.0:
        return False
    for k in range(1, KNOTS):
        bump = height * _bump(work.share[k], top)
        for j in range(4):
            work.base[k, j] += bump * side[j]
    body = work.way.body[0]
    t = meet(query, body, work)
    if t < 0.0:
        return False
    keep(work, t, body)
    return True


@njit(_nrt=False)
def _bump(share, top):
    """Height of a bump at a share of the movement: 1 at its top, 0 at ends that are not its top."""
    s = 1.0
    if share != top:
        s = share / top if share < top else (1.0 - share) / (1.0 - top)
    return np.sin(0.5 * np.pi * min(max(s, 0.0), 1.0)) ** 2


@njit(_nrt=False)
def _posture(time, joints, t, out):
    """Write the joints of a sampled movement at t [s] into `out`."""
    k = min(max(np.searchsorted(time, t, side="right") - 1, 0), time.size - 2)
    between(joints[k], joints[k + 1], (t - time[k]) / (time[k + 1] - time[k]), out)


@njit(_nrt=False)
def _touching(study, time, joints, touched):
    """The first run of instants at which the limb touches: how many, the first, and their step."""
    step, q, count, first = (time[-1] - time[touched]) / LOOKS, study.near, 0, 0.0
    step = min(step, time[-1] / LOOKS)
    if step <= 0.0:
        return 0, 0.0, 0.0
    looks = int((time[-1] - time[touched]) / step)
    for g in range(looks + 1):
        t = min(time[touched] + g * step, time[-1])
        _posture(time, joints, t, q)
        if distance_at(study.scene, q, t, study.desk) <= study.touch:
            if count == 0:
                first = t
            count += 1
        elif count > 0:
            break
    return count, first, step


@njit(_nrt=False)
def _share_at(work, t):
    """Share of the best movement that lies behind it at t [s]."""
    way = work.way
    for k in range(1, KNOTS):
        if t < way.reached[k]:
            span = way.reached[k] - way.reached[k - 1]
            s = (t - way.reached[k - 1]) / span if span > 0.0 else 0.0
            return work.share[k - 1] + max(s, 0.0) * (work.share[k] - work.share[k - 1])
    return 1.0


@njit
def _push(study, work, time, joints, first, step, count):
    """The lowest bump that frees the limb at the instants of a touch.

    Returns
    -------
    height : float
        0 if none does [rad].
    top : float
        Share of the movement at which it is highest; 1 is a bump that rises to the end.
    side : (4,) ndarray
        Where to, in joints.
    """
    n, limb = min(count, INSTANTS), study.scene.limb
    place, when, rows = np.empty(n), np.empty(n), np.empty((n, 4))
    for i in range(n):
        when[i] = min(first + step * (count - 1) * i / max(n - 1, 1), time[-1])
        _posture(time, joints, when[i], rows[i])
        place[i] = _share_at(work, when[i])
    top = 0.5 * (place[0] + place[n - 1])
    top = 1.0 if place[n - 1] > END else min(max(top, 0.05), 0.95)
    sides = np.empty((_SIDES.shape[0] + 1, 4))
    sides[1:] = _SIDES
    before = max(when[0] - step, 0.0)
    _posture(time, joints, before, study.far)
    _uphill(study, study.far, before, sides[0])
    q, enough = study.posture, study.touch + CLEARANCE * limb.length
    for push in PUSHES:
        best, chosen = enough, -1
        for d in range(sides.shape[0]):
            least = 1e300
            for i in range(n):
                height = push * _bump(place[i], top)
                for j in range(4):
                    q[j] = rows[i, j] + height * sides[d, j]
                    q[j] = min(max(q[j], limb.low[j]), limb.high[j])
                least = min(least, distance_at(study.scene, q, when[i], study.desk))
                if least <= best:
                    break
            if least > best:
                best, chosen = least, d
        if chosen >= 0:
            return push, top, sides[chosen]
    return 0.0, top, sides[0]


@njit(_nrt=False)
def _uphill(study, q, t, out):
    """Write the direction in the joints in which the limb's distance grows fastest into `out`."""
    size = 0.0
    for j in range(4):
        angle = q[j]
        q[j] = angle + PROBE
        rise = distance_at(study.scene, q, t, study.desk)
        q[j] = angle - PROBE
        rise -= distance_at(study.scene, q, t, study.desk)
        q[j] = angle
        out[j] = rise
        size += rise * rise
    for j in range(4):
        out[j] = out[j] / np.sqrt(size) if size > 0.0 else 0.0
