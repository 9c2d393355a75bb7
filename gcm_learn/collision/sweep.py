"""Continuous clearance of a timed hand path: no instant between samples is missed."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.arms.planar_limb import elbow_of, elbows_of
from gcm_learn.collision.distance import arm_distance, limb_point2, segment_distance
from gcm_learn.compiled import njit
from gcm_learn.scene.bodies import HAND, PART, REACH, SWING, drift, glide, pose_at, swing

_SHOULDER = 1e-9  # hands this near to the shoulder have no direction [forearm lengths]
DEEPEST = 48  # bisections of one segment before it counts as touching
_PARTS = 10  # of the upper arm, each half as long as the one before, that have bounds of their own
_SHALLOW = 2  # bisections of a segment before they are asked for
HAIR = 1e-4  # legs that come nearer to touching may count as touching [forearm lengths]
_MOST = 1_000_000  # checks of one path before it counts as touching: bodies may spin absurdly fast


class Sweep(NamedTuple):
    """Timed path to be searched for the least distance, with working arrays."""

    time: np.ndarray  # (n,) [s]
    hand: np.ndarray  # (n, 2)
    floor: float  # distance at which the search may stop
    resolution: float
    poses: np.ndarray  # (bodies, 12)
    stack: np.ndarray  # (DEEPEST + 2, 3)


@njit
def _bend(r, rho):
    """Angle between upper arm and direction of the hand at radius r (the arccos of Eq. 5)."""
    if r < 1e-12:
        return 0.5 * np.pi
    return np.arccos(min(max((r * r + rho * rho - 1.0) / (2.0 * rho * r), -1.0), 1.0))


@njit
def limb_sweep(x0, y0, x1, y1, rho):
    """Bound the way that any point of the limb travels while the hand goes straight from 0 to 1.

    The elbow turns by at most the change of the hand's direction plus the variation of `_bend`
    over the radii on the way.  That function is monotone between the ends, the point nearest to the
    shoulder and, for rho > 1, the radius where it is stationary.
    """
    dx, dy = x1 - x0, y1 - y0
    length2 = dx * dx + dy * dy
    if length2 == 0.0:
        return 0.0
    r0, r1 = np.sqrt(x0 * x0 + y0 * y0), np.sqrt(x1 * x1 + y1 * y1)
    s = min(max(-(x0 * dx + y0 * dy) / length2, 0.0), 1.0)
    nearest = np.sqrt((x0 + s * dx) ** 2 + (y0 + s * dy) ** 2)
    if nearest < _SHOULDER:  # there the arm may point anywhere: no bound but the whole circle
        return 2.0 * np.pi * rho
    turn = abs(np.arctan2(x0 * y1 - y0 * x1, x0 * x1 + y0 * y1))
    b0, b1, b2 = _bend(r0, rho), _bend(r1, rho), _bend(nearest, rho)
    variation = abs(b0 - b2) + abs(b1 - b2)
    if rho > 1.0:
        stationary = np.sqrt(rho * rho - 1.0)
        b3 = _bend(stationary, rho)
        if nearest < stationary < r0:
            variation += abs(b0 - b3) + abs(b3 - b2) - abs(b0 - b2)
        if nearest < stationary < r1:
            variation += abs(b1 - b3) + abs(b3 - b2) - abs(b1 - b2)
    return max(np.sqrt(length2), rho * (turn + variation))


@njit(_nrt=False)
def limb_distance(scene, b, t, x, y, poses):
    """Distance of body b at time t [s] to the limb with its hand at (x, y).

    Parameters
    ----------
    poses : (n, 12) ndarray
        Row b is filled with the body's pose.
    """
    pose_at(scene.bodies, b, t, poses)
    ex, ey = elbow_of(x, y, scene.limb.rho, scene.limb.side)
    return arm_distance(scene.bodies, poses, b, x, y, ex, ey)


@njit(_nrt=False, forceinline=True)
def _balls_by(centre, bodies, b, time, hand, elbow, poses, bound):
    """Compute `_balls` with `centre` as the function of the body's centre: `glide` or `swing`."""
    nearest, reach = 0, bodies.rows[b, REACH]
    for k in range(time.size):
        x, y, z = centre(bodies, b, time[k], poses)
        d2 = limb_point2(x, y, hand[k, 0], hand[k, 1], elbow[k, 0], elbow[k, 1])
        bound[b, k] = max(np.sqrt(d2 + z * z) - reach, 0.0)
        if bound[b, k] < bound[b, nearest]:
            nearest = k
    return nearest


@njit(_nrt=False)
def _balls(bodies, b, time, hand, elbow, poses, bound):
    """Bound the limb's distance to body b from below at all samples, by the ball about b.

    Written into `bound`; exact for discs. Returns the sample with the smallest bound.
    """
    if bodies.rows[b, SWING] >= 0.0:
        return _balls_by(swing, bodies, b, time, hand, elbow, poses, bound)
    return _balls_by(glide, bodies, b, time, hand, elbow, poses, bound)


@njit(_nrt=False)
def _at_samples(bodies, time, hand, elbow, floor, poses, bound):
    """Return the smallest distance at the samples and its time; stop at a sample within `floor`.

    Parameters
    ----------
    bound : (bodies, n) ndarray
        Filled with a lower bound of the distance of every obstacle at every sample. Only where
        that may be the smallest one is the distance itself computed, and written there.
    """
    best, when, enough = 1e300, 0.0, 1e300
    for b in range(bodies.rows.shape[0]):
        if bodies.rows[b, PART] == HAND:
            continue
        k = _balls(bodies, b, time, hand, elbow, poses, bound)
        if bound[b, k] < enough:
            pose_at(bodies, b, time[k], poses)
            x, y, ex, ey = hand[k, 0], hand[k, 1], elbow[k, 0], elbow[k, 1]
            enough = min(enough, arm_distance(bodies, poses, b, x, y, ex, ey))
    enough = max(enough, floor)
    for k in range(time.size):
        for b in range(bodies.rows.shape[0]):
            if bodies.rows[b, PART] == HAND or bound[b, k] > enough:
                continue
            pose_at(bodies, b, time[k], poses)
            x, y, ex, ey = hand[k, 0], hand[k, 1], elbow[k, 0], elbow[k, 1]
            bound[b, k] = arm_distance(bodies, poses, b, x, y, ex, ey)
            if bound[b, k] < best:
                best, when = bound[b, k], time[k]
        if best <= floor:
            break
    return best, when


@njit
def least_distance(scene, time, hand, floor, resolution):
    """Smallest distance of the whole limb to any obstacle along a path that is linear in time.

    Every segment is bisected until nothing in it can come more than `resolution` below the
    smallest distance found.  This follows from the distances at its ends and a bound on all
    relative motion between them.

    Parameters
    ----------
    scene : Scene
    time, hand : (n,), (n, 2) ndarray
    floor : float
        Stop as soon as a distance at or below it is found.

    Returns
    -------
    distance : float
        At most `resolution` above the true one; 1e300 without obstacles; at most `floor` if the
        path comes that near or cannot be shown not to.
    when : float
        Where it was found [s].
    """
    bodies, limb, last = scene.bodies, scene.limb, time.size - 1
    count = bodies.rows.shape[0]
    poses, bound = np.zeros((count, 12)), np.empty((count, time.size))
    elbow = elbows_of(hand, limb.rho, limb.side)
    # All samples first: a good least distance at hand spares most of the bisections.
    best, when = _at_samples(bodies, time, hand, elbow, floor, poses, bound)
    if best <= floor or best >= 1e300:
        return best, when
    sweep, looks = np.empty(last), 0
    work = Sweep(time, hand, floor, resolution, poses, np.empty((DEEPEST + 2, 3)))
    for k in range(last):
        sweep[k] = limb_sweep(hand[k, 0], hand[k, 1], hand[k + 1, 0], hand[k + 1, 1], limb.rho)
    for b in range(count):
        if bodies.rows[b, PART] == HAND:
            continue
        for k in range(last):
            moved = drift(bodies, b, time[k], time[k + 1]) + sweep[k]
            low = 0.5 * (bound[b, k] + bound[b, k + 1] - moved)
            if low > floor and low >= best - resolution:
                continue
            for e in range(k, k + 2):
                bound[b, e] = limb_distance(scene, b, time[e], hand[e, 0], hand[e, 1], poses)
            best, when, looks = least_in_segment(
                scene, work, b, k, bound[b, k], bound[b, k + 1], best, when, looks
            )
            if best <= floor:
                return best, when
    return best, when


@njit(_nrt=False)
def _low_by_parts(scene, b, x0, y0, x1, y1, sweep, enough, poses):
    """Bound the distance of limb and resting body b over a straight piece of a path, part by part.

    The nearer to the shoulder, the less a point of the upper arm moves: parts that are halved
    towards it have bounds of their own. Only so it shows that a limb whose shoulder is nearest to
    a resting body stays equally far from it.

    Parameters
    ----------
    sweep : float
        How far any point of the limb moves.
    enough : float
        Bounds below it are of no use: the first one ends the search.
    """
    bodies, limb = scene.bodies, scene.limb
    ex0, ey0 = elbow_of(x0, y0, limb.rho, limb.side)
    ex1, ey1 = elbow_of(x1, y1, limb.rho, limb.side)
    d0 = segment_distance(bodies, poses, b, ex0, ey0, x0, y0)
    d1 = segment_distance(bodies, poses, b, ex1, ey1, x1, y1)
    low, outer = 0.5 * (d0 + d1 - sweep), 1.0
    for part in range(_PARTS):
        if low < enough:
            break
        inner = 0.5 * outer if part < _PARTS - 1 else 0.0
        d0 = segment_distance(bodies, poses, b, inner * ex0, inner * ey0, outer * ex0, outer * ey0)
        d1 = segment_distance(bodies, poses, b, inner * ex1, inner * ey1, outer * ex1, outer * ey1)
        low = min(low, 0.5 * (d0 + d1 - outer * sweep))
        outer = inner
    return low


@njit(_nrt=False)
def least_in_segment(scene, work, b, k, d0, d1, best, when, looks):
    """Search for `least_distance` to body b between samples k and k + 1, at distances d0 and d1.

    Parameters
    ----------
    scene : Scene
    work : Sweep
    best, when : float
        The least distance so far, and its time [s].
    looks : int
        Distances computed so far.

    Returns
    -------
    best, when, looks
        Their values after the search.
    """
    bodies, time, hand, poses, stack = scene.bodies, work.time, work.hand, work.poses, work.stack
    floor, resolution = work.floor, work.resolution
    t0, span = time[k], time[k + 1] - time[k]
    x0, y0 = hand[k, 0], hand[k, 1]
    dx, dy = hand[k + 1, 0] - x0, hand[k + 1, 1] - y0
    # The stack holds right ends of intervals: position s in [0, 1], distance, depth.
    stack[0, 0], stack[0, 1], stack[0, 2] = 1.0, d1, 0.0
    top = 1
    s0 = 0.0
    while top > 0:
        s1, d1, depth = stack[top - 1, 0], stack[top - 1, 1], stack[top - 1, 2]
        slip = drift(bodies, b, t0 + s0 * span, t0 + s1 * span)
        ax, ay, bx, by = x0 + s0 * dx, y0 + s0 * dy, x0 + s1 * dx, y0 + s1 * dy
        sweep = limb_sweep(ax, ay, bx, by, scene.limb.rho)
        # d falls by at most the way travelled from either end: the least is in between.
        low, enough = 0.5 * (d0 + d1 - slip - sweep), max(best - resolution, floor)
        if low <= enough and depth >= _SHALLOW and slip == 0.0:
            pose_at(bodies, b, t0 + s0 * span, poses)
            low = _low_by_parts(scene, b, ax, ay, bx, by, sweep, enough, poses)
        if low > floor and low >= best - resolution:
            s0, d0 = s1, d1
            top -= 1
            continue
        looks += 1
        if depth >= DEEPEST or looks > _MOST:
            return floor, t0 + s0 * span, looks
        m = 0.5 * (s0 + s1)
        d = limb_distance(scene, b, t0 + m * span, x0 + m * dx, y0 + m * dy, poses)
        if d < best:
            best, when = d, t0 + m * span
            if best <= floor:
                return best, when, looks
        stack[top - 1, 2] = depth + 1.0
        stack[top, 0], stack[top, 1], stack[top, 2] = m, d, depth + 1.0
        top += 1
    return best, when, looks


@njit(_nrt=False)
def leg_is_free(scene, work, sweeps, budget):
    """Tell whether the limb stays farther than `work.floor` from all obstacles on one segment.

    Distances within HAIR of the floor may count as touching.

    Parameters
    ----------
    scene : Scene
    work : Sweep
        Of a path of two samples, with a resolution that does not count.
    sweeps : (m,) ndarray
        Buffer for how far the limb moves on pieces of the segment, which all bodies need.
    budget : (1,) ndarray of int64
        Distances that may still be computed. Each lowers it; below 0 a leg counts as touching.
    """
    bodies, limb, time, hand, poses = scene.bodies, scene.limb, work.time, work.hand, work.poses
    x0, y0 = hand[0, 0], hand[0, 1]
    sweeps[:] = -1.0
    sweeps[1] = sweep = limb_sweep(x0, y0, hand[1, 0], hand[1, 1], limb.rho)
    ex, ey = elbow_of(x0, y0, limb.rho, limb.side)
    for b in range(bodies.rows.shape[0]):
        if bodies.rows[b, PART] == HAND:
            continue
        slip = drift(bodies, b, time[0], time[1])
        pose_at(bodies, b, time[0], poses)
        x, y, z = poses[b, 0], poses[b, 1], poses[b, 2]
        ball = limb_point2(x, y, x0, y0, ex, ey) + z * z
        if ball > (bodies.rows[b, REACH] + work.floor + slip + sweep) ** 2:
            continue
        d = arm_distance(bodies, poses, b, x0, y0, ex, ey)
        if d - slip - sweep > work.floor:
            continue
        if not _keeps_away(scene, b, work, sweeps, budget, d, slip):
            return False
    return True


@njit(_nrt=False)
def _keeps_away(scene, b, work, sweeps, budget, d0, slip):
    """`leg_is_free` of body b, at d0 when the leg begins, by bisection.

    The whole leg is piece 1, the halves of piece k are 2 k and 2 k + 1.  On each share of the leg
    the body moves by at most as large a share of `slip`.
    """
    time, hand, poses, stack = work.time, work.hand, work.poses, work.stack
    x0, y0, dx, dy = hand[0, 0], hand[0, 1], hand[1, 0] - hand[0, 0], hand[1, 1] - hand[0, 1]
    s0, top = 0.0, 1
    stack[0, 0], stack[0, 1], stack[0, 2] = 1.0, -1.0, 1.0
    while top > 0:
        s1, d1, piece = stack[top - 1, 0], stack[top - 1, 1], stack[top - 1, 2]
        x, y = x0 + s1 * dx, y0 + s1 * dy
        if d1 < 0.0:
            t = time[0] + s1 * (time[1] - time[0])
            d1 = stack[top - 1, 1] = limb_distance(scene, b, t, x, y, poses)
            budget[0] -= 1
            if d1 <= work.floor + HAIR or budget[0] < 0:
                return False
        way = sweeps[int(piece)] if piece < sweeps.size else -1.0
        if way < 0.0:
            way = limb_sweep(x0 + s0 * dx, y0 + s0 * dy, x, y, scene.limb.rho)
            if piece < sweeps.size:
                sweeps[int(piece)] = way
        way += slip * (s1 - s0)
        if 0.5 * (d0 + d1 - way) > work.floor:
            s0, d0 = s1, d1
            top -= 1
        elif way < HAIR or top > DEEPEST:
            return False
        else:
            stack[top - 1, 2] = 2.0 * piece + 1.0
            stack[top, 0], stack[top, 1], stack[top, 2] = 0.5 * (s0 + s1), -1.0, 2.0 * piece
            top += 1
    return True
