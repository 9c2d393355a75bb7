"""Kernels that find contacts of a joint movement, and push the movement aside or hold it back."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.arms.limbs import dof, hand_travel
from gcm_learn.collision.postures import distance_at
from gcm_learn.compiled import njit
from gcm_learn.planners.joints.moves import between
from gcm_learn.recall.joint_moves import KNOTS
from gcm_learn.recall.styles import PUSHED, Habits, QuickCheck, bump
from gcm_learn.scene.bodies import TOP_SPEED

LOOKS = 96  # instants in a horizon
PUSHES = np.array([0.15, 0.35, 0.7, 1.1, 1.6])  # heights of bumps [rad]
HOLDS = np.array([0.15, 0.3, 0.6])  # by which a movement is held back [horizons]
CLEARANCE = 0.01  # by which a pushed limb is free where it touched [forearms]
MARGIN = 0.004  # by which a changed movement has to look free [forearms]
INSTANTS = 6  # at most at which a push is tried
PROGRESS = 0.85  # share of what touches that a change may leave, or no other is made
END = 0.9  # share of a movement from which a touch is one at its end
CARRYING = 4  # first joints that are pushed alone: later ones hardly move but the hand
DIAGONAL = 0.8  # of each joint in pushes of the first two together
PROBE = 1e-3  # finite difference for the direction away from obstacles [rad]


class JointTouch(NamedTuple):
    """Postures and times at which a movement touches."""

    share: np.ndarray  # (n,): of the movement that lies behind it
    time: np.ndarray  # (n,) [s]
    joints: np.ndarray  # (n, dof) [rad]
    sides: np.ndarray  # (13, dof): directions of pushes, first that away from the obstacle
    knots: np.ndarray  # (2,) int64: the last one before it touches, and the one after the start
    times: np.ndarray  # (2,): of these [s]


@njit(_nrt=False)
def habits(_query):
    """Return the numbers by which joint movements are changed."""
    return Habits(PUSHED + 1 + 2 * HOLDS.size, MARGIN, PROGRESS, False, True, 0)


@njit(_nrt=False)
def horizon(query):
    """Return the horizon [s]."""
    return query.study.scene.limits.horizon


@njit(_nrt=False)
def hold(_query, i):
    """Return delay i [horizons]."""
    return HOLDS[i]


@njit(_nrt=False)
def caught_at(_query, work):
    """Return when the best movement catches [s]."""
    return work.way.left[KNOTS - 1]


@njit(_nrt=False)
def _posture(way, t, q):
    """Write the joints of a movement at t [s] into q (dof,); knot before, and share from there."""
    k = 0
    while k < KNOTS - 2 and way.reached[k + 1] <= t:
        k += 1
    span = way.reached[k + 1] - way.left[k]
    s = min((t - way.left[k]) / span, 1.0) if span > 0.0 else 1.0
    between(way.joints[k], way.joints[k + 1], s, q)
    return k, s


@njit(_nrt=False)
def sweep(query, work, _count):
    """Return the numbers of a quick check of the best movement."""
    study, way = query.study, work.way
    scene = study.scene
    step, length, nearer, top = scene.limits.horizon / LOOKS, scene.limb.length, 0.0, 0.0
    for k in range(KNOTS - 1):
        span = way.reached[k + 1] - way.left[k]
        if span > 0.0:
            way_of_hand = hand_travel(scene.limb, way.joints[k], way.joints[k + 1])
            nearer = max(nearer, way_of_hand / span)
    for b in range(scene.bodies.rows.shape[0]):
        top = max(top, scene.bodies.rows[b, TOP_SPEED])
    nearer = max((nearer + top) * step, 1e-12)
    enough = study.touch + CLEARANCE * length
    return QuickCheck(study.touch, length, enough, way.left[KNOTS - 1] / step, nearer, 1.0 * LOOKS)


@njit(_nrt=False)
def room(query, work, _count, g, _enough):
    """Return the limb's clearance at instant g."""
    study, way = query.study, work.way
    t = min(g * (study.scene.limits.horizon / LOOKS), way.left[KNOTS - 1])
    _posture(way, t, study.near)
    return distance_at(study.scene, study.near, t, study.desk)


@njit
def touch_of(query, work, _count, first, last):
    """Return where the best movement touches, from instant `first` to `last`."""
    study, way = query.study, work.way
    n, step = min(last - first + 1, INSTANTS), study.scene.limits.horizon / LOOKS
    share, time, joints = np.empty(n), np.empty(n), np.empty((n, dof(study.scene.limb)))
    knot = 1
    for i in range(n):
        t = min((first + (last - first) * i // max(n - 1, 1)) * step, way.left[KNOTS - 1])
        k, s = _posture(way, t, joints[i])
        share[i] = work.share[k] + s * (work.share[k + 1] - work.share[k])
        time[i] = t
        if i == 0:
            knot = max(k, 1)
    before = max(first - 1, 0) * step
    _posture(way, before, study.far)
    knots, times = np.array([knot, 1]), np.array([way.reached[knot], way.reached[1]])
    return JointTouch(share, time, joints, sides_of(study, study.far, before), knots, times)


@njit
def sides_of(study, q, t):
    """Directions of pushes for a limb that is about to touch, with joints q (dof,) at t [s].

    After that away from the obstacle each of the first joints alone, then two of them together.
    """
    n = q.size
    m = min(n, CARRYING)
    sides = np.zeros((2 * m + (5 if m > 1 else 1), n))
    for j in range(m):
        sides[1 + j, j], sides[1 + m + j, j] = 1.0, -1.0
    for d in range(2 * m + 1, sides.shape[0]):
        sides[d, 0] = DIAGONAL if d >= 2 * m + 3 else -DIAGONAL
        sides[d, 1] = DIAGONAL if (d - 2 * m) % 2 == 0 else -DIAGONAL
    _uphill(study, q, t, sides[0])
    return sides


@njit(_nrt=False)
def _uphill(study, q, t, out):
    """Write the direction in the joints in which the limb's distance grows fastest into `out`."""
    size = 0.0
    for j in range(dof(study.scene.limb)):
        angle = q[j]
        q[j] = angle + PROBE
        rise = distance_at(study.scene, q, t, study.desk)
        q[j] = angle - PROBE
        rise -= distance_at(study.scene, q, t, study.desk)
        q[j] = angle
        out[j] = rise
        size += rise * rise
    for j in range(dof(study.scene.limb)):
        out[j] = out[j] / np.sqrt(size) if size > 0.0 else 0.0


@njit(_nrt=False)
def pushed(query, work, touch, wide, side):
    """Push a movement aside by the lowest bump that frees the limb where it touched.

    Parameters
    ----------
    side : (dof,) ndarray
        Previous push, which the new push must not continue; overwritten by the new push.

    Returns
    -------
    bool
        True if a bump frees the limb.
    """
    study = query.study
    limb, n, q = study.scene.limb, touch.share.size, study.posture
    top = 0.5 * (touch.share[0] + touch.share[n - 1])
    top = 1.0 if touch.share[n - 1] > END else min(max(top, 0.05), 0.95)
    for push in PUSHES:
        best, chosen = study.touch + CLEARANCE * limb.length, -1
        for d in range(touch.sides.shape[0]):
            along = 0.0
            for j in range(dof(limb)):
                along += touch.sides[d, j] * side[j]
            if along > 0.0:
                continue
            least = 1e300
            for i in range(n):
                height = push * bump(touch.share[i], top, wide)
                for j in range(dof(limb)):
                    q[j] = touch.joints[i, j] + height * touch.sides[d, j]
                    q[j] = min(max(q[j], limb.low[j]), limb.high[j])
                least = min(least, distance_at(study.scene, q, touch.time[i], study.desk))
                if least <= best:
                    break
            if least > best:
                best, chosen = least, d
        if chosen >= 0:
            for j in range(dof(limb)):
                side[j] = touch.sides[chosen, j]
                for k in range(1, KNOTS):
                    work.base[k, j] += push * bump(work.share[k], top, wide) * side[j]
            return True
    return False
