"""The fan: how far the hand can go in each of 24 directions before the limb touches."""

from __future__ import annotations

import numpy as np

from gcm_learn.collision.distance import arm_distance, limb_point2
from gcm_learn.compiled import njit
from gcm_learn.envs.kernels import FAR, FLOOR, HORIZON, NEAR, RHO, SPEED
from gcm_learn.scene.bodies import DISC, HAND, KIND, PART, REACH, pose_at
from gcm_learn.scene.limb import elbow_of

RAY = 2  # numbers of a ray
RAYS = 25  # directions, the first to the meeting with the target, and last to rest
RAY_X = np.append(np.cos(2.0 * np.pi * np.arange(RAYS - 1) / (RAYS - 1)), 0.0)
RAY_Y = np.append(np.sin(2.0 * np.pi * np.arange(RAYS - 1) / (RAYS - 1)), 0.0)
REACHES = np.array([0.06, 0.12, 0.2, 0.3, 0.45, 0.65, 0.9])  # ways along a ray [forearm lengths]


@njit(_nrt=False)
def _exact_gap(bodies, b, row, table, hx, hy, ex, ey, poses):
    """Distance of the limb to body b, whose pose is a row of a table."""
    for q in range(12):
        poses[b, q] = table[row, q]
    return arm_distance(bodies, poses, b, hx, hy, ex, ey)


@njit
def tell_fan(bodies, arms, s, e, t, x, y, c, sn, at, poses, out):
    """For every ray how far the hand can go before the limb touches, and how near it comes.

    The first ray is in direction (c, sn), the others follow counter-clockwise.
    """
    n, reaches = bodies.rows.shape[0], REACHES.size
    speed, floor, rho, horizon = arms[s, SPEED], arms[s, FLOOR], arms[s, RHO], arms[s, HORIZON]
    table, gaps = np.empty((reaches * n, 12)), np.empty(n)
    for j in range(reaches):  # poses of all bodies, instant by instant
        for b in range(n):
            if bodies.rows[b, PART] != HAND:
                pose_at(bodies, b, min(t + REACHES[j] / speed, horizon), poses)
                for i in range(12):
                    table[j * n + b, i] = poses[b, i]
    for ray in range(RAYS):
        way, least, last = REACHES[reaches - 1], 0.5, 0.0
        dx, dy = c * RAY_X[ray] - sn * RAY_Y[ray], sn * RAY_X[ray] + c * RAY_Y[ray]
        for j in range(reaches):
            hx, hy = x + REACHES[j] * dx, y + REACHES[j] * dy
            r = np.sqrt(hx * hx + hy * hy)
            if r > arms[s, FAR] or r < arms[s, NEAR]:
                way = last
                break
            ex, ey = elbow_of(hx, hy, rho, 1.0)
            room = least  # what is farther changes nothing
            for b in range(n):  # balls first: what they leave is looked at closely
                gaps[b] = 1e300
                if bodies.rows[b, PART] == HAND:
                    continue
                px, py, pz = table[j * n + b, 0], table[j * n + b, 1], table[j * n + b, 2]
                d2 = limb_point2(px, py, hx, hy, ex, ey)
                gap = np.sqrt(d2 + pz * pz) - bodies.rows[b, REACH] - floor
                if bodies.rows[b, KIND] == DISC:
                    room = min(room, gap)
                else:
                    gaps[b] = gap
            for b in range(n):
                if gaps[b] < room:
                    gap = _exact_gap(bodies, b, j * n + b, table, hx, hy, ex, ey, poses)
                    room = min(room, gap - floor)
            if room <= 0.0:
                way, least = last, 0.0
                break
            least, last = room, REACHES[j]
        out[e, at + RAY * ray], out[e, at + RAY * ray + 1] = way, least
