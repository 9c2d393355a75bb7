"""Clearance of a whole family of movements, proven for every instant.

Places are the joints, or the hand of a planar arm. They may be off a given way by bounds that grow
along it. Bodies may be off their places, too. The limb and every obstacle are asked in the middle
of a span of time. Bounds of all deviations and of all motion say whether the answer holds for the
span and for the whole family. If not, a shorter span is asked.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.arms.limbs import place, self_gap, swept
from gcm_learn.arms.planar_limb import PlanarLimb, elbow_of
from gcm_learn.collision.distance import segment_distance
from gcm_learn.collision.postures import gap_to
from gcm_learn.compiled import by_type, njit
from gcm_learn.cover.limits import elbow_rates
from gcm_learn.scene.bodies import LIMB, PART, drift, pose_at

NARROWEST = 1e-7  # share of a piece of the way at which a proof is given up
ITSELF, NOWHERE = -1, -2  # in place of a body's index


class Work(NamedTuple):
    """Arrays for intermediate results."""

    poses: np.ndarray  # (bodies, 12)
    curve: np.ndarray  # (m, 4)
    middle: np.ndarray  # (m,)
    away: np.ndarray  # (m,)


@njit(_nrt=False)
def _room_of_hand(limb, scene, b, t, off, touch, work):
    """Bound the distance of a planar limb to body b from below; see `room_of`.

    Points of the upper arm move at most as far as the elbow. Points of the forearm move at most as
    far as the farther of its ends.
    """
    x, y = work.middle[0], work.middle[1]
    far = np.sqrt(work.away[0] ** 2 + work.away[1] ** 2)
    radius = np.sqrt(x * x + y * y)
    upper = elbow_rates(radius - far, radius + far, limb.rho)[0] * far * limb.rho
    fore = max(upper, far)
    ex, ey = elbow_of(x, y, limb.rho, limb.side)
    pose_at(scene.bodies, b, t, work.poses)
    first = segment_distance(scene.bodies, work.poses, b, 0.0, 0.0, ex, ey) - upper
    second = segment_distance(scene.bodies, work.poses, b, ex, ey, x, y) - fore
    return min(first, second) - off


@njit(_nrt=False)
def _write_deviations(work):
    """Write a move to ``work.curve`` that turns each joint by the bound of its deviation.

    `swept` takes the smaller of two bounds. One of them uses the joints' rates in the middle, which
    hold for a single direction.  Deviations may have any direction.  So this move rests in the
    middle, and bends as much as turns each joint by its bound within half the move.
    """
    for j in range(work.middle.size):
        bend = 2.0 * work.away[j]
        work.curve[j, 0], work.curve[j, 1] = work.middle[j] + 0.5 * work.away[j], -bend
        work.curve[j, 2], work.curve[j, 3] = bend, 0.0


@njit(_nrt=False)
def _room_of_joints(limb, scene, b, t, off, touch, work):
    """Bound a limb's distance from below, for arms that move in their joints; see `room_of`."""
    where = place(limb, work.middle)
    _write_deviations(work)
    slack = swept(limb, work.curve, 0.5, 0.5, where)
    return gap_to(limb, where, slack, scene.bodies, b, t, off, touch, work.poses)[1]


@njit(_nrt=False)
def _no_room(limb, touch, work):
    """Return that the limb cannot touch itself."""
    return 1e300


@njit(_nrt=False)
def _room_of_itself(limb, touch, work):
    """Bound the least distance of links that must not overlap from below."""
    where = place(limb, work.middle)
    _write_deviations(work)
    return self_gap(limb, where, swept(limb, work.curve, 0.5, 0.5, where), touch)[1]


room_of = by_type({PlanarLimb: _room_of_hand, None: _room_of_joints})
"""Bound the distance of limb and body b at t [s] from below, for all deviations at once.

Parameters
----------
off : float
    How much nearer the body may be.
touch : float
    Bounds above this need not be sharp.
work : Work
    `middle` is the place, `away` (m,) bounds the deviation of each coordinate.
"""
_room_within = by_type({PlanarLimb: _no_room, None: _room_of_itself})


@njit(_nrt=False)
def _between(scene, way, away, k, s, half, until, work):
    """Write place and bounds of deviations about share s of piece k into `work`.

    Bounds grow along the way, so those at share `until` hold for all of the span.
    """
    for j in range(way.shape[1]):
        step = way[k + 1, j] - way[k, j]
        work.middle[j] = way[k, j] + s * step
        grown = away[k, j] + until * (away[k + 1, j] - away[k, j])
        work.away[j] = abs(step) * half + grown


@njit(_nrt=False)
def _room_in_span(scene, span, at, b, off, touch, work):
    """Bound the distance to body b, or of the limb to itself, over the span that is in `work`.

    Parameters
    ----------
    span : (float, float)
        Begin and end [s].
    at : float
        Instant of the place in `work` [s].
    """
    if b == ITSELF:
        return _room_within(scene.limb, touch, work)
    moved = off + 0.5 * drift(scene.bodies, b, span[0], span[1])
    return room_of(scene.limb, scene, b, at, moved, touch, work)


@njit(_nrt=False)
def _piece_fails(scene, moves, k, b, off, touch, work):
    """Return the time at which body b may be touched in piece k; -1 if a touch is ruled out."""
    time, way, away = moves
    s, width = 0.0, 1.0
    span = time[k + 1] - time[k]
    while s < 1.0:
        width = min(width, 1.0 - s)
        middle = s + 0.5 * width
        at = time[k] + middle * span
        _between(scene, way, away, k, middle, 0.5 * width, s + width, work)
        times = (time[k] + s * span, time[k] + (s + width) * span)
        if _room_in_span(scene, times, at, b, off, touch, work) > touch:
            s, width = s + width, 2.0 * width
            continue
        _between(scene, way, away, k, middle, 0.0, middle, work)
        if width < NARROWEST or _room_in_span(scene, (at, at), at, b, off, touch, work) <= touch:
            return at
        width *= 0.5
    return -1.0


@njit
def first_touch(scene, moves, off, touch):
    """Find an obstacle that may be touched by some movement of a family.

    Parameters
    ----------
    moves : tuple
        Times (n,) [s]; places (n, m), linear in between; bounds (n, m) of deviations from them,
        which grow.
    off : (n, bodies) ndarray
        How far bodies may be off at the times; less than the larger value in between.
    touch : float
        Distance that counts as touching.

    Returns
    -------
    body : int
        Index, ITSELF, or NOWHERE if nothing can be touched.
    when : float
        [s]
    """
    time, way, _ = moves
    rows, columns = scene.bodies.rows, way.shape[1]
    work = Work(
        np.zeros((rows.shape[0], 12)), np.zeros((columns, 4)), np.zeros(columns), np.zeros(columns)
    )
    for b in range(ITSELF, rows.shape[0]):
        if b >= 0 and rows[b, PART] != LIMB:
            continue
        for k in range(time.size - 1):
            moved = 0.0 if b == ITSELF else max(off[k, b], off[k + 1, b])
            when = _piece_fails(scene, moves, k, b, moved, touch, work)
            if when >= 0.0:
                return b, when
    return NOWHERE, -1.0
