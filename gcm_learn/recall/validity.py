"""Whether a bent path holds: what the verification of plans would say, at less cost."""

from __future__ import annotations

import numpy as np

from gcm_learn.collision.distance import arm_distance, limb_point2
from gcm_learn.collision.sweep import DEEPEST, Sweep, least_in_segment, limb_distance, limb_sweep
from gcm_learn.compiled import njit
from gcm_learn.motion.verification import nearest_to_shoulder
from gcm_learn.recall.kernels import HUB
from gcm_learn.scene.bodies import (
    DISC,
    HAND,
    KIND,
    PART,
    REACH,
    SWING,
    drift,
    glide,
    pose_at,
    swing,
)
from gcm_learn.scene.limb import elbow_of

_ORDER = (2, 0, 1, 3)  # in which instants are looked at, of every four: far ones first


@njit
def holds(query, time, hand, count):
    """Whether the limb keeps free and out of the hole on a path, its first `count` samples.

    Instants at which the bodies' poses are known come first: most paths that touch do so at one of
    them. What is left is shown to be free, segment by segment, by the balls that hold the bodies,
    and where these are too large by the exact rule of `least_distance`. Both say what it would say.
    """
    if count > 1 and nearest_to_shoulder(hand[:count]) < max(query.scene.limb.near, 0.5 * HUB):
        return False
    return not _touches_at_a_look(query, time, hand, count) and _is_free(query, time, hand, count)


@njit(_nrt=False)
def _ball_distance(query, b, x, y, z, hx, hy, ex, ey):
    """Distance of the limb to the ball that holds body b, whose centre is at (x, y, z)."""
    d2 = limb_point2(x, y, hx, hy, ex, ey)
    return np.sqrt(d2 + z * z) - query.scene.bodies.rows[b, REACH]


@njit(_nrt=False)
def _touches_at_a_look(query, time, hand, count):
    """Whether the limb touches an obstacle at one of the instants of the table."""
    instants, n = query.table.shape[0], query.scene.bodies.rows.shape[0]
    step = query.scene.limits.horizon / (instants - 1)
    last = int(time[count - 1] / step)
    for phase in _ORDER:
        k = 0
        for g in range(phase, last + 1, 4):
            t = g * step
            while k < count - 2 and time[k + 1] < t:
                k += 1
            x, y = hand[k, 0], hand[k, 1]
            if count > 1 and time[k + 1] > time[k]:
                s = min((t - time[k]) / (time[k + 1] - time[k]), 1.0)
                x += s * (hand[k + 1, 0] - x)
                y += s * (hand[k + 1, 1] - y)
            ex, ey = elbow_of(x, y, query.scene.limb.rho, query.scene.limb.side)
            poses = query.table[g]
            for b in range(n):
                if query.scene.bodies.rows[b, PART] == HAND:
                    continue
                px, py, pz = poses[b, 0], poses[b, 1], poses[b, 2]
                if _ball_distance(query, b, px, py, pz, x, y, ex, ey) > query.rules.touch:
                    continue
                if query.scene.bodies.rows[b, KIND] == DISC:
                    return True
                if arm_distance(query.scene.bodies, poses, b, x, y, ex, ey) <= query.rules.touch:
                    return True
    return False


@njit
def _is_free(query, time, hand, count):
    """Whether the limb stays farther than the floor from all obstacles, between samples too."""
    bodies, floor = query.scene.bodies, query.rules.touch
    n = bodies.rows.shape[0]
    poses = np.zeros((n, 12))
    work = Sweep(time, hand, floor, 1e300, poses, np.empty((DEEPEST + 2, 3)))
    before, after = np.empty(n), np.empty(n)
    looks = 0
    for k in range(count):
        x, y = hand[k, 0], hand[k, 1]
        ex, ey = elbow_of(x, y, query.scene.limb.rho, query.scene.limb.side)
        sweep = 0.0
        if k > 0:
            sweep = limb_sweep(hand[k - 1, 0], hand[k - 1, 1], x, y, query.scene.limb.rho)
        for b in range(n):
            if bodies.rows[b, PART] == HAND:
                continue
            after[b] = _ball_at(query, b, time[k], x, y, ex, ey, poses)
            if after[b] <= floor:
                pose_at(bodies, b, time[k], poses)
                after[b] = arm_distance(bodies, poses, b, x, y, ex, ey)
                if after[b] <= floor:
                    return False
            if k == 0:
                continue
            moved = sweep + drift(bodies, b, time[k - 1], time[k])
            if 0.5 * (before[b] + after[b] - moved) > floor:
                continue
            d0 = limb_distance(query.scene, b, time[k - 1], hand[k - 1, 0], hand[k - 1, 1], poses)
            d1 = limb_distance(query.scene, b, time[k], x, y, poses)
            least, _, looks = least_in_segment(
                query.scene, work, b, k - 1, d0, d1, min(d0, d1), 0.0, looks
            )
            if least <= floor:
                return False
        before, after = after, before
    return True


@njit(_nrt=False)
def _ball_at(query, b, t, hx, hy, ex, ey, poses):
    """Distance of the limb to the ball of body b at time t."""
    if query.scene.bodies.rows[b, SWING] >= 0.0:
        x, y, z = swing(query.scene.bodies, b, t, poses)
    else:
        x, y, z = glide(query.scene.bodies, b, t, poses)
    return _ball_distance(query, b, x, y, z, hx, hy, ex, ey)
