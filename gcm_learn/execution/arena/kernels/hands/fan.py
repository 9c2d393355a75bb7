"""The fan: how far the hand can go in each of 24 directions before the limb touches."""

from __future__ import annotations

import numpy as np

from gcm_learn.arms.planar_limb import elbow_of
from gcm_learn.collision.distance import arm_distance, limb_point2
from gcm_learn.compiled import njit
from gcm_learn.scene.bodies import BALL, HAND, PART, REACH, pose_at

RAY = 2  # numbers of a ray
RAYS = 25  # directions, the first to the meeting with the target, and last to rest
RAY_X = np.append(np.cos(2.0 * np.pi * np.arange(RAYS - 1) / (RAYS - 1)), 0.0)
RAY_Y = np.append(np.sin(2.0 * np.pi * np.arange(RAYS - 1) / (RAYS - 1)), 0.0)
REACHES = np.array([0.06, 0.12, 0.2, 0.3, 0.45, 0.65, 0.9])  # ways along a ray [forearm lengths]


@njit
def tell_fan(scene, floor, view, dx, dy, poses, row, at):
    """For every ray how far the hand can go before the limb touches, and how near it comes.

    The first ray is in direction (dx, dy), the others follow counter-clockwise.

    Parameters
    ----------
    scene : Scene
    floor : float
        Distance at which an obstacle counts as touching the limb.
    view : View
    poses : (n, 12) ndarray
        Overwritten.
    row : (width,) ndarray
        RAY numbers for each ray are written, from `at` on.
    """
    bodies, limb = scene.bodies, scene.limb
    speed, horizon, rho = scene.limits.speed, scene.limits.horizon, limb.rho
    n, reaches = bodies.rows.shape[0], REACHES.size
    table, gaps = np.empty((reaches * n, 12)), np.empty(n)
    for j in range(reaches):  # poses of all bodies, instant by instant
        for b in range(n):
            if bodies.rows[b, PART] != HAND:
                pose_at(bodies, b, min(view.t + REACHES[j] / speed, horizon), poses)
                for i in range(12):
                    table[j * n + b, i] = poses[b, i]
    for ray in range(RAYS):
        reach, least, last = REACHES[reaches - 1], 0.5, 0.0
        ux, uy = dx * RAY_X[ray] - dy * RAY_Y[ray], dy * RAY_X[ray] + dx * RAY_Y[ray]
        for j in range(reaches):
            hx, hy = view.x + REACHES[j] * ux, view.y + REACHES[j] * uy
            r = np.sqrt(hx * hx + hy * hy)
            if r > limb.far or r < limb.near:
                reach = last
                break
            ex, ey = elbow_of(hx, hy, rho, 1.0)
            room = least  # what is farther changes nothing
            for b in range(n):  # balls first: what they leave is checked closely
                gaps[b] = 1e300
                if bodies.rows[b, PART] == HAND:
                    continue
                px, py, pz = table[j * n + b, 0], table[j * n + b, 1], table[j * n + b, 2]
                d2 = limb_point2(px, py, hx, hy, ex, ey)
                gap = np.sqrt(d2 + pz * pz) - bodies.rows[b, REACH] - floor
                if bodies.rows[b, BALL] > 0.0:
                    room = min(room, gap)
                else:
                    gaps[b] = gap
            for b in range(n):
                if gaps[b] < room:
                    for q in range(12):
                        poses[b, q] = table[j * n + b, q]
                    gap = arm_distance(bodies, poses, b, hx, hy, ex, ey)
                    room = min(room, gap - floor)
            if room <= 0.0:
                reach, least = last, 0.0
                break
            least, last = room, REACHES[j]
        row[at + RAY * ray], row[at + RAY * ray + 1] = reach, least
