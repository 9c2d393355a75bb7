"""Adapted paths that touch are bent, in compiled code: pushed aside, or held back until it is free.

A path that was adapted to a situation is looked at, at the instants of the query's table. What
touches an obstacle there is changed: by a bump whose top is where the limb first touches, which is
zero at both ends and no higher than needed for the limb to be free there, to the one side or the
other; by leaving later, or waiting before it would touch; or by leaving its remembered waits out.
The first change that looks free is taken, else the one that touches least, and that is looked at
again. Until the end some room is asked for; then a path may pass as near as it can. One that comes
too late is shortened before. What comes out is verified like any other.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.arms.planar_limb import elbow_of
from gcm_learn.collision.distance import arm_distance, limb_point2
from gcm_learn.compiled import njit
from gcm_learn.recall.kernels import EARLIEST, HURRY, KNOTS, POLAR, keep, meet, meet_any
from gcm_learn.scene.bodies import DISC, HAND, KIND, PART, REACH, TOP_SPEED, poses_at

PUSHES = np.array([0.06, 0.12, 0.2, 0.3, 0.42])  # heights of bumps [forearm lengths]
TURNS = 8  # directions of bumps
CLEARANCE = 0.012  # by which a pushed limb is free where it touched [forearm lengths]
MARGIN = 0.005  # by which a changed path has to look free [forearm lengths]
SHORTER = (0.6, 0.3)  # shares of its detours that a path keeps if it takes too long
INSTANTS = 8  # at most at which a push is tried
HOLDS = np.array([0.02, 0.05, 0.1, 0.2, 0.35])  # by which a path is held back [horizons]
WIDTHS = (1.0, 0.3)  # of bumps [shares of the path]
SIDES = 2
PUSHED = SIDES * len(WIDTHS)  # changes that are pushes; then waits are left out, then the path is
CHANGES = PUSHED + 1 + 2 * HOLDS.size  # held back before it touches, or at its start
_RINGS = (0.03, 0.985)  # shares of the ring between which a push may end


class Way(NamedTuple):
    """Where a path touches."""

    places: np.ndarray  # (n, 3): share of the path, radius and direction of the hand
    instants: np.ndarray  # (n,) int64: of the table
    knots: np.ndarray  # (2,) int64: the last one before it touches, and the one after the start
    times: np.ndarray  # (2,): of these


@njit
def bend(query, style, work, count, body, rounds):
    """Change the best path in the workspace until it looks free.

    Parameters
    ----------
    count, body : int
        Samples of the path, and the target that it catches.
    rounds : int
        Changes at most, one upon the other; none, and nothing is looked at.

    Returns
    -------
    count : int
        Samples of the path that is the best now.
    free : bool
        Whether it looks free, or was not looked at.
    """
    if rounds == 0 or style.space != POLAR:
        return count, True
    cost, first, last = look(query, work, count, 0.0)
    if first < 0:
        return count, True
    for _ in range(rounds):
        _copy(work.base, work.knots, work.from_base, work.from_early)
        way = _way_of(query, work, count, first, last)
        least, found, turn, rise = cost, False, 0.0, 0.0
        for change in range(CHANGES):
            _restore(work.from_base, work.from_early, work)
            if change < PUSHED:
                wide = WIDTHS[change // SIDES]
                if change % SIDES == 0:
                    turn, rise = 0.0, 0.0
                turn, rise, top = _push(query, way, wide, turn, rise)
                if top < 0.0:
                    continue
                _raise(work, turn, rise, top, wide)
            elif style.tempo != HURRY or not _hold(query, work, change - PUSHED, way):
                continue
            t = meet(query, body, style, work)
            if t < 0.0:
                continue
            keep(work, t)
            count = KNOTS + 1
            cost, first, last = look(query, work, count, MARGIN)
            if first < 0:
                return count, True
            if cost < least:
                least, found = cost, True
                _copy(work.base, work.knots, work.least_base, work.least_early)
        if found:
            _restore(work.least_base, work.least_early, work)
        else:
            _restore(work.from_base, work.from_early, work)
        t = meet(query, body, style, work)
        if t < 0.0:
            return count, False
        keep(work, t)
        count = KNOTS + 1
        cost, first, last = look(query, work, count, MARGIN)
        if not found:
            break
    return count, look(query, work, count, 0.0)[1] < 0


@njit
def hasten(query, style, work):
    """Change the path in the workspace, which comes too late for all targets, until it does not.

    Its waits are left out, then the most of its detours. Returns what `meet_any` does.
    """
    if style.space != POLAR or style.tempo != HURRY:
        return 0, -1
    if _drop_waits(work):
        count, body = meet_any(query, style, work)
        if count > 0:
            return count, body
    last = KNOTS - 1
    _copy(work.base, work.knots, work.from_base, work.from_early)
    base = work.from_base
    for part in SHORTER:
        for k in range(1, last):
            for i in range(2):
                straight = base[0, i] + work.share[k] * (base[last, i] - base[0, i])
                work.base[k, i] = straight + part * (base[k, i] - straight)
        count, body = meet_any(query, style, work)
        if count > 0:
            return count, body
    return 0, -1


@njit(_nrt=False)
def _drop_waits(work):
    """Leave out a path's waits; whether it has any."""
    changed = False
    for k in range(KNOTS):
        changed = changed or work.knots[k, EARLIEST] > 0.0
        work.knots[k, EARLIEST] = 0.0
    return changed


@njit(_nrt=False)
def _copy(base, knots, to_base, to_early):
    """Keep a path as it is adapted from."""
    for k in range(KNOTS):
        to_base[k, 0], to_base[k, 1] = base[k, 0], base[k, 1]
        to_early[k] = knots[k, EARLIEST]


@njit(_nrt=False)
def _restore(base, early, work):
    """Go back to a path that was kept."""
    for k in range(KNOTS):
        work.base[k, 0], work.base[k, 1] = base[k, 0], base[k, 1]
        work.knots[k, EARLIEST] = early[k]


@njit(_nrt=False)
def _clearance(query, g, x, y, enough):
    """Least distance of the limb to any obstacle at instant g of the table, or more than enough."""
    bodies, poses = query.scene.bodies, query.table[g]
    if np.isnan(poses[0, 0]):
        poses_at(bodies, query.scene.limits.horizon * g / (query.table.shape[0] - 1), poses)
    ex, ey = elbow_of(x, y, query.scene.limb.rho, query.scene.limb.side)
    least = 1e300
    for b in range(bodies.rows.shape[0]):
        if bodies.rows[b, PART] == HAND:
            continue
        px, py, pz = poses[b, 0], poses[b, 1], poses[b, 2]
        d2 = limb_point2(px, py, x, y, ex, ey)
        d = np.sqrt(d2 + pz * pz) - bodies.rows[b, REACH]
        if d <= enough and bodies.rows[b, KIND] != DISC:
            d = arm_distance(bodies, poses, b, x, y, ex, ey)
        least = min(least, d)
    return least


@njit(_nrt=False)
def _at(query, work, count, g):
    """Where the best path is at instant g of the table: segment, position in it, and hand."""
    time, hand = work.best_time, work.best_hand
    t, k = g * (query.scene.limits.horizon / (query.table.shape[0] - 1)), 0
    while k < count - 2 and time[k + 1] < t:
        k += 1
    span = time[k + 1] - time[k] if count > 1 else 0.0
    s = min(max((t - time[k]) / span, 0.0), 1.0) if span > 0.0 else 0.0
    x = hand[k, 0] + s * (hand[k + 1, 0] - hand[k, 0])
    return k, s, x, hand[k, 1] + s * (hand[k + 1, 1] - hand[k, 1])


@njit(_nrt=False)
def look(query, work, count, margin):
    """How much the best path touches, and the first and last instant of the first time; -1 if not.

    What is nearer than CLEARANCE costs what it lacks.
    """
    cost, first, last, enough = 0.0, -1, -2, query.rules.touch + CLEARANCE
    if count < 2:
        return cost, -1, -1
    step = query.scene.limits.horizon / (query.table.shape[0] - 1)
    end, nearer = int(work.best_time[count - 1] / step), 0.0
    for b in range(query.scene.bodies.rows.shape[0]):
        nearer = max(nearer, step * (query.rules.speed + query.scene.bodies.rows[b, TOP_SPEED]))
    g = 0
    while g < end:
        g += 1
        _, _, x, y = _at(query, work, count, g)
        clearance = _clearance(query, g, x, y, enough)
        if clearance > enough:
            g += int(min((clearance - enough) / nearer, 1.0 * end))
            continue
        cost += max(enough - clearance, 0.0)
        if clearance <= query.rules.touch + margin:
            if first < 0:
                first, last = g, g
            elif last == g - 1:
                last = g
    return cost, first, last


@njit
def _way_of(query, work, count, first, last):
    """Where the best path touches from instant `first` to `last`."""
    n, share = min(last - first + 1, INSTANTS), work.share
    way = Way(
        np.empty((n, 3)), np.empty(n, dtype=np.int64), np.empty(2, dtype=np.int64), np.empty(2)
    )
    for i in range(n):
        g = first + (last - first) * i // max(n - 1, 1)
        k, s, x, y = _at(query, work, count, g)
        before, after = min(k, KNOTS - 1), min(k + 1, KNOTS - 1)
        way.places[i, 0] = share[before] + s * (share[after] - share[before])
        way.places[i, 1], way.places[i, 2] = np.sqrt(x * x + y * y), np.arctan2(y, x)
        way.instants[i] = g
        if i == 0:
            way.knots[0], way.knots[1] = max(before, 1), 1
    for i in range(2):
        way.times[i] = work.best_time[way.knots[i]]
    return way


@njit
def bump(share, top, wide):
    """Height of a bump at a share of the path: 1 at its top, 0 `wide` from there and at the ends.

    An end that is its top is 1.
    """
    s = 1.0
    if share != top:
        s = 1.0 - abs(share - top) / min(wide, top if share < top else 1.0 - top)
    return np.sin(0.5 * np.pi * min(max(s, 0.0), 1.0)) ** 2


@njit(_nrt=False)
def _raise(work, turn, rise, top, wide):
    """Move the path by a bump."""
    for k in range(1, KNOTS - 1):
        height = bump(work.share[k], top, wide)
        work.base[k, 0] += height * turn
        work.base[k, 1] += height * rise


@njit(_nrt=False)
def _hold(query, work, which, way):
    """Leave out waits, or hold the path back before it touches or at its start; if it changes."""
    early = work.knots
    if which == 0:
        return _drop_waits(work)
    place, size = (which - 1) // HOLDS.size, HOLDS[(which - 1) % HOLDS.size]
    k = way.knots[place]
    if place == 1 and way.knots[0] == k:
        return False
    late = way.times[place] + size * query.scene.limits.horizon
    early[k, EARLIEST] = max(np.float64(early[k, EARLIEST]), late)
    return late <= query.scene.limits.horizon


@njit(_nrt=False)
def _push(query, way, wide, turn_before, rise_before):
    """The lowest bump that frees the limb where it touched, to another side than one before.

    If none does so by CLEARANCE it is the one that does by most.

    Returns
    -------
    turn, rise : float
        By which its top moves the hand [rad, shares of the ring].
    top : float
        Share of the path at which it is, -1 if none frees the limb.
    """
    limb, places, n = query.scene.limb, way.places, way.instants.size
    width, middle = limb.far - limb.near, max(places[n // 2, 1], 0.2)
    top = min(max(0.5 * (places[0, 0] + places[n - 1, 0]), 0.04), 0.96)
    most, turn, rise = query.rules.touch, 0.0, 0.0
    for push in PUSHES:
        for d in range(TURNS):
            a = push * np.sin(2.0 * np.pi * d / TURNS) / middle
            u = push * np.cos(2.0 * np.pi * d / TURNS) / width
            if a * turn_before * middle * middle + u * rise_before * width * width > 0.0:
                continue
            least = _least_on(query, way, a, u, top, wide, most)
            if least > most:
                most, turn, rise = least, a, u
        if most > query.rules.touch + CLEARANCE:
            break
    return turn, rise, top if turn != 0.0 or rise != 0.0 else -1.0


@njit(_nrt=False)
def _least_on(query, way, a, u, top, wide, enough):
    """Least clearance of a bump where the path touched; the rest is left out if that is enough."""
    limb, least = query.scene.limb, 1e300
    width = limb.far - limb.near
    for i in range(way.instants.size):
        height = bump(way.places[i, 0], top, wide)
        ring = (way.places[i, 1] - limb.near) / width + height * u
        r = limb.near + min(max(ring, _RINGS[0]), _RINGS[1]) * width
        turned = way.places[i, 2] + limb.side * height * a
        x, y = r * np.cos(turned), r * np.sin(turned)
        least = min(least, _clearance(query, way.instants[i], x, y, enough))
        if least <= enough:
            break
    return least
