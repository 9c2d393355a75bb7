"""Adapted movements that touch are bent: pushed aside in the joints, or held back until it is free.

As `recall.bending` does in the plane.  A movement is looked at, at instants that lie evenly in the
horizon.  What touches there is changed: by a bump in the joints whose top is where the limb first
touches, no higher than needed for it to be free there, to one side or another; by leaving later, or
slowing down before it would touch; or by leaving its waits out.  Where it touches at its end, the
bump rises to the end, and the target is met from there.  The first change that looks free is taken,
else the one that touches least, and that is looked at again.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.arms.spatial_limb import motion_bounds
from gcm_learn.collision.postures import distance_at
from gcm_learn.compiled import njit
from gcm_learn.planners.space.moves import between
from gcm_learn.recall.bending import SHORTER, bump
from gcm_learn.recall.space.kernels import HURRY, KNOTS, keep, meet, meet_any
from gcm_learn.scene.bodies import TOP_SPEED

LOOKS = 96  # instants in a horizon
PUSHES = np.array([0.15, 0.35, 0.7, 1.1, 1.6])  # heights of bumps [rad]
HOLDS = np.array([0.15, 0.3, 0.6])  # by which a movement is held back [horizons]
CLEARANCE = 0.01  # by which a pushed limb is free where it touched [forearms]
MARGIN = 0.004  # by which a changed movement has to look free [forearms]
INSTANTS = 6  # at most at which a push is tried
WIDTHS = (1.0, 0.3)  # of bumps [shares of the movement]
SIDES = 2
PUSHED = SIDES * len(WIDTHS)  # changes that are pushes; then waits are left out, then the movement
CHANGES = PUSHED + 1 + 2 * HOLDS.size  # is held back before it touches, or at its start
PROGRESS = 0.85  # share of what touches that a change may leave, or no other is made
END = 0.9  # share of a movement from which a touch is one at its end
PROBE = 1e-3  # finite difference for the direction away from obstacles [rad]


def _directions() -> np.ndarray:
    """Pushes that are tried besides that away from the obstacle (12, 4)."""
    single = np.vstack([np.eye(4), -np.eye(4)])
    pairs = np.array([[a, b, 0.0, 0.0] for a in (-1.0, 1.0) for b in (-1.0, 1.0)])
    return np.vstack([single, 0.8 * pairs])


_SIDES = _directions()


class Touch(NamedTuple):
    """Where a movement touches."""

    share: np.ndarray  # (n,): of the movement that lies behind it
    time: np.ndarray  # (n,) [s]
    joints: np.ndarray  # (n, 4) [rad]
    sides: np.ndarray  # (13, 4): directions of pushes, first that away from the obstacle
    knot: int  # the last one before it touches


@njit
def bend(query, tempo, work, rounds):
    """Change the best movement in the workspace until it looks free.

    Parameters
    ----------
    query : Query
    tempo : int
    work : Work
    rounds : int
        Changes at most, one upon the other.

    Returns
    -------
    bool
        Whether it looks free.
    """
    body = work.way.body[0]
    cost, first, last = _look(query.study, work.way, 0.0, np.inf)
    for _ in range(rounds):
        if first < 0:
            return True
        copy_move(work.base, work.wanted, work.from_base, work.from_wanted)
        touch = _touch(query.study, work, first, last)
        end, before, least, found = work.way.left[KNOTS - 1], cost, cost, -1.0
        times = work.way.reached[touch.knot], work.way.reached[1]
        side = np.zeros(4)
        for change in range(CHANGES):
            copy_move(work.from_base, work.from_wanted, work.base, work.wanted)
            if change < PUSHED:
                if change % SIDES == 0:
                    side[:] = 0.0
                if not pushed(query.study, work, touch, WIDTHS[change // SIDES], side):
                    continue
            elif tempo != HURRY or not _held(query.study, work, change - PUSHED, touch.knot, times):
                continue
            t = meet(query, body, work, end if change != PUSHED else 0.0)
            if t < 0.0:
                continue
            keep(work, t, body)
            cost, first, last = _look(query.study, work.way, MARGIN, least)
            if first < 0:
                return True
            if cost < least:
                least, found = cost, t
                copy_move(work.base, work.wanted, work.least_base, work.least_wanted)
        if found < 0.0 or least > PROGRESS * before:
            return False
        copy_move(work.least_base, work.least_wanted, work.base, work.wanted)
        keep(work, meet(query, body, work, found), body)
        cost, first, last = _look(query.study, work.way, MARGIN, np.inf)
    return first < 0


@njit
def hasten(query, tempo, work):
    """Change a movement that comes too late for all targets until it does not.

    Its waits are left out, then the most of its detours. Returns what `meet_any` does.
    """
    if tempo != HURRY:
        return False
    if _drop_waits(work) and meet_any(query, work):
        return True
    base, last = work.from_base, KNOTS - 1
    copy_move(work.base, work.wanted, base, work.from_wanted)
    for part in SHORTER:
        for k in range(1, last):
            for j in range(4):
                straight = base[0, j] + work.share[k] * (base[last, j] - base[0, j])
                work.base[k, j] = straight + part * (base[k, j] - straight)
        if meet_any(query, work):
            return True
    return False


@njit(_nrt=False)
def _drop_waits(work):
    """Leave out a movement's waits; whether it has any."""
    changed = False
    for k in range(KNOTS):
        changed = changed or work.wanted[k] > 0.0
        work.wanted[k] = 0.0
    return changed


@njit(_nrt=False)
def copy_move(base, wanted, to_base, to_wanted):
    """Keep a movement as it is adapted from."""
    for k in range(KNOTS):
        to_wanted[k] = wanted[k]
        for j in range(4):
            to_base[k, j] = base[k, j]


@njit(_nrt=False)
def _posture(way, t, q):
    """Write the joints of a movement at t [s] into q (4,); knot before, and share from there."""
    k = 0
    while k < KNOTS - 2 and way.reached[k + 1] <= t:
        k += 1
    span = way.reached[k + 1] - way.left[k]
    s = min((t - way.left[k]) / span, 1.0) if span > 0.0 else 1.0
    between(way.joints[k], way.joints[k + 1], s, q)
    return k, s


@njit(_nrt=False)
def _look(study, way, margin, most):
    """How much a movement touches, and the first and last instant of the first time; -1 if not.

    What is nearer than CLEARANCE costs what it lacks; of what touches, to know that it is above
    `most` is enough.
    """
    scene, q = study.scene, study.near
    step, length = scene.limits.horizon / LOOKS, scene.limb.length
    enough, nearer = study.touch + CLEARANCE * length, 0.0
    for k in range(KNOTS - 1):
        span = way.reached[k + 1] - way.left[k]
        if span > 0.0:
            way_of_hand = motion_bounds(scene.limb, way.joints[k], way.joints[k + 1])[1]
            nearer = max(nearer, way_of_hand / span)
    top = 0.0
    for b in range(scene.bodies.rows.shape[0]):
        top = max(top, scene.bodies.rows[b, TOP_SPEED])
    nearer = max((nearer + top) * step, 1e-12)
    cost, first, last, g, end = 0.0, -1, -2, 0, way.left[KNOTS - 1] / step
    while g < end and (first < 0 or cost <= most):
        g += 1
        t = min(g * step, way.left[KNOTS - 1])
        _posture(way, t, q)
        room = distance_at(scene, q, t, study.desk)
        if room > enough:
            g += int(min((room - enough) / nearer, 1.0 * LOOKS))
            continue
        cost += enough - room
        if room <= study.touch + margin * length:
            if first < 0:
                first, last = g, g
            elif last == g - 1:
                last = g
    return cost, first, last


@njit
def _touch(study, work, first, last):
    """Where the best movement touches from instant `first` to `last`."""
    n, way, step = min(last - first + 1, INSTANTS), work.way, study.scene.limits.horizon / LOOKS
    share, time, joints = np.empty(n), np.empty(n), np.empty((n, 4))
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
    return Touch(share, time, joints, sides_of(study, study.far, before), knot)


@njit
def sides_of(study, q, t):
    """Directions of pushes for a limb that is about to touch, with joints q (4,) at t [s]."""
    sides = np.empty((_SIDES.shape[0] + 1, 4))
    sides[1:] = _SIDES
    _uphill(study, q, t, sides[0])
    return sides


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


@njit(_nrt=False)
def pushed(study, work, touch, wide, side):
    """Push a movement aside by the lowest bump that frees the limb where it touched.

    Parameters
    ----------
    side : (4,) ndarray
        Push before, to the other side of which it has to be; overwritten with this one.

    Returns
    -------
    bool
        Whether any frees it.
    """
    limb, n, q = study.scene.limb, touch.share.size, study.posture
    top = 0.5 * (touch.share[0] + touch.share[n - 1])
    top = 1.0 if touch.share[n - 1] > END else min(max(top, 0.05), 0.95)
    for push in PUSHES:
        best, chosen = study.touch + CLEARANCE * limb.length, -1
        for d in range(touch.sides.shape[0]):
            along = 0.0
            for j in range(4):
                along += touch.sides[d, j] * side[j]
            if along > 0.0:
                continue
            least = 1e300
            for i in range(n):
                height = push * bump(touch.share[i], top, wide)
                for j in range(4):
                    q[j] = touch.joints[i, j] + height * touch.sides[d, j]
                    q[j] = min(max(q[j], limb.low[j]), limb.high[j])
                least = min(least, distance_at(study.scene, q, touch.time[i], study.desk))
                if least <= best:
                    break
            if least > best:
                best, chosen = least, d
        if chosen >= 0:
            for j in range(4):
                side[j] = touch.sides[chosen, j]
                for k in range(1, KNOTS):
                    work.base[k, j] += push * bump(work.share[k], top, wide) * side[j]
            return True
    return False


@njit(_nrt=False)
def _held(study, work, which, knot, times):
    """Leave out waits, or hold a movement back before it touches or at its start; if it changes."""
    if which == 0:
        return _drop_waits(work)
    place, size = (which - 1) // HOLDS.size, HOLDS[(which - 1) % HOLDS.size]
    if place == 1 and knot == 1:
        return False
    late = times[place] + size * study.scene.limits.horizon
    k = knot if place == 0 else 1
    work.wanted[k] = max(work.wanted[k], late)
    return late <= study.scene.limits.horizon
