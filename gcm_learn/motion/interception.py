"""Interceptions: meetings of hand and target along a path, or straight ahead."""

from __future__ import annotations

import numpy as np

from gcm_learn.collision.distance import segment_distance
from gcm_learn.compiled import njit
from gcm_learn.scene import Scene
from gcm_learn.scene.bodies import HAND, PART, REACH, TOP_SPEED, pose_at
from gcm_learn.scene.shapes.choice import gap_in_plane
from gcm_learn.scene.shapes.region import EMPTY_DISTANCE

NEVER = 1e300  # [s]
_PROBE = 1e-6  # finite difference for the direction of the nearest point [forearm lengths]


@njit
def first_catch(bodies, time, hand, catch, shortest):
    """First moment along a timed path at which a target is within `catch` of the hand.

    Conservative advancement on the distance to the solid, which cannot jump; within `catch` of
    that, steps of `shortest` [s] until the hand is within `catch` of the cut.

    Returns
    -------
    time : float
        -1 if there is none.
    body : int
    """
    poses = np.zeros((bodies.rows.shape[0], 12))
    best, body = -1.0, -1
    for b in range(bodies.rows.shape[0]):
        if bodies.rows[b, PART] != HAND:
            continue
        k, t = 0, time[0]
        while best < 0.0 or t < best:
            while k + 2 < time.size and time[k + 1] <= t:
                k += 1
            last = k + 1 if k + 1 < time.size else k
            span = time[last] - time[k]
            s = min(max((t - time[k]) / span, 0.0), 1.0) if span > 0.0 else 1.0
            x = hand[k, 0] + s * (hand[last, 0] - hand[k, 0])
            y = hand[k, 1] + s * (hand[last, 1] - hand[k, 1])
            pose_at(bodies, b, t, poses)
            room = segment_distance(bodies, poses, b, x, y, x, y) - max(catch, 0.0)
            if room <= 0.0 and gap_in_plane(bodies, poses, b, x, y) <= catch:
                best, body = t, b
                break
            if t >= time[-1]:
                break
            speed = bodies.rows[b, TOP_SPEED]
            if span > 0.0:
                speed += (
                    np.sqrt((hand[last, 0] - hand[k, 0]) ** 2 + (hand[last, 1] - hand[k, 1]) ** 2)
                    / span
                )
            step = room / speed if room > 0.0 and speed > 0.0 else 0.0
            # The hand's speed is known for this segment only: do not step beyond its end.
            end = time[last] if time[last] > t else time[-1]
            t = min(t + max(step, shortest), max(end, t + shortest), time[-1])
    return best, body


@njit
def approach(bodies, poses, b, x, y, catch, far):
    """Point within `catch` of the target nearest to (x, y): (px, py, found)."""
    d = gap_in_plane(bodies, poses, b, x, y)
    if d >= EMPTY_DISTANCE:
        return x, y, False
    if d > catch:
        gx = gap_in_plane(bodies, poses, b, x + _PROBE, y)
        gx -= gap_in_plane(bodies, poses, b, x - _PROBE, y)
        gy = gap_in_plane(bodies, poses, b, x, y + _PROBE)
        gy -= gap_in_plane(bodies, poses, b, x, y - _PROBE)
        size = np.sqrt(gx * gx + gy * gy)
        if size == 0.0:
            return x, y, False
        # A hair deeper than the nearest point, against the rounding of the direction.
        x -= (d - catch + 1e-9) * gx / size
        y -= (d - catch + 1e-9) * gy / size
    r = np.sqrt(x * x + y * y)
    if r > far:
        x, y = x * far / r, y * far / r
    return x, y, gap_in_plane(bodies, poses, b, x, y) <= catch


@njit
def first_interception(scene, rules, x, y, start, since, end):
    """Earliest moment at which a hand going straight from (x, y) can catch a target.

    Parameters
    ----------
    scene : Scene
    rules : Rules
        The hand's speed, the distance that counts as a catch, and the resolution in time.
    start : float
        When the hand leaves (x, y) [s].
    since, end : float
        Span of time that is searched [s].

    Returns
    -------
    time : float
        -1 if there is none.
    body : int
    px, py : float
        Where the hand then is.
    """
    bodies, near, far = scene.bodies, scene.limb.near, scene.limb.far
    speed, catch, shortest = rules.speed, rules.catch, rules.instant
    poses = np.zeros((bodies.rows.shape[0], 12))
    best, body, bx, by = -1.0, -1, x, y
    for b in range(bodies.rows.shape[0]):
        if bodies.rows[b, PART] != HAND:
            continue
        t = since
        while t <= end and (best < 0.0 or t < best):
            pose_at(bodies, b, t, poses)
            room = segment_distance(bodies, poses, b, x, y, x, y) - max(catch, 0.0)
            room -= speed * (t - start)
            if room <= 0.0:
                px, py, found = approach(bodies, poses, b, x, y, catch, far)
                away = np.sqrt((px - x) ** 2 + (py - y) ** 2)
                inside = px * px + py * py >= near * near
                if found and inside and away <= speed * (t - start) + 1e-12:
                    best, body, bx, by = t, b, px, py
                    break
                t += max(_away_until(bodies, poses, b, catch, near, far), shortest)
            else:
                t += max(room / (speed + bodies.rows[b, TOP_SPEED]), shortest)
    return best, body, bx, by


def anywhere(scene: Scene) -> Scene:
    """Return the scene with an arm of unlimited reach, for which interceptions come first."""
    return scene._replace(limb=scene.limb._replace(near=0.0, far=np.inf))


@njit(_nrt=False)
def _away_until(bodies, poses, b, catch, near, far):
    """Bound the time [s] in which no hand can catch a target, by the ball around the target.

    That ball is above or below the plane, beyond the ring, or in the ring's hole.
    """
    ball, top = bodies.rows[b, REACH], bodies.rows[b, TOP_SPEED]
    away = np.sqrt(poses[b, 0] ** 2 + poses[b, 1] ** 2)
    margin = ball + max(catch, 0.0)
    room = max(abs(poses[b, 2]) - ball, away - margin - far, near - margin - away)
    if room <= 0.0:
        return 0.0
    return room / top if top > 0.0 else NEVER


@njit
def may_be_reached(scene):
    """Tell whether a target may be within the ring and within the hand's way at some moment.

    A necessary condition by conservative advancement, so False is certain.
    """
    bodies, x, y, far = scene.bodies, scene.limb.x, scene.limb.y, scene.limb.far
    speed, grasp, end = scene.limits.speed, scene.limits.grasp, scene.limits.horizon
    poses = np.zeros((bodies.rows.shape[0], 12))
    tiny = 1e-5 * end
    for b in range(bodies.rows.shape[0]):
        if bodies.rows[b, PART] != HAND:
            continue
        t = 0.0
        top = bodies.rows[b, TOP_SPEED]
        while t <= end:
            pose_at(bodies, b, t, poses)
            ring = segment_distance(bodies, poses, b, 0.0, 0.0, 0.0, 0.0) - grasp - far
            way = segment_distance(bodies, poses, b, x, y, x, y) - grasp - speed * t
            wait = way / (top + speed)
            if ring > 0.0:
                wait = max(wait, ring / top if top > 0.0 else NEVER)
            if wait <= tiny:  # now, or too soon to differ from now
                return True
            t += wait
    return False
