"""Meetings of hand and target in time and space: the goals of the goal-directed search.

A target in the shadow of an obstacle, or out of reach, is none: no movement ends there. Spans of
time in which that is so are shut, so that the search does not head for them. Times in seconds.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.arms.planar_limb import elbow_of
from gcm_learn.collision.distance import arm_distance
from gcm_learn.collision.intervals import NEVER
from gcm_learn.compiled import njit
from gcm_learn.planners.sipp_labels import Aim
from gcm_learn.scene.bodies import HAND, PART, REACH, drift, pose_at

SPANS = 32  # of a horizon
LOOKS = 4  # at a span, for a place where the hand can be
RINGS = 2  # of places around a target's centre
TURNS = 8  # places of a ring
SHUT = -1e300  # distance at which a target counts as met that cannot be


@njit
def aim_at(ground, end):
    """Sample the places of targets over [0, end], and when a hand can be there."""
    bodies, poses, step = ground.scene.bodies, ground.postures.scratch, end / SPANS
    count = bodies.rows.shape[0]
    ways, targets, blocker = np.empty((SPANS, count, 4)), 0, 0
    for b in range(count):
        if bodies.rows[b, PART] != HAND:
            continue
        near = ground.scene.limits.grasp + bodies.rows[b, REACH]
        for i in range(SPANS):
            since, middle, until = step * i, step * (i + 0.5), step * (i + 1)
            blocker = obstructed(ground, b, near, i, step, max(blocker, 0))
            pose_at(bodies, b, middle, poses)
            for a in range(3):
                ways[i, targets, a] = poses[b, a]
            away = max(drift(bodies, b, since, middle), drift(bodies, b, middle, until))
            ways[i, targets, 3] = SHUT if blocker >= 0 else near + away
        targets += 1
    return Aim(ways[:, :targets].copy(), step, end)


@njit(_nrt=False)
def obstructed(ground, b, near, i, step, blocker):
    """Look for a moment of span i, and a place around target b, at which the hand can be there.

    Returns -1 if there is one, else a body that is in the way; `blocker` is asked first.
    """
    bodies, poses = ground.scene.bodies, ground.postures.scratch
    for k in range(LOOKS):
        for other in range(bodies.rows.shape[0]):
            pose_at(bodies, other, step * (i + (k + 0.5) / LOOKS), poses)
        radius2 = near * near - poses[b, 2] ** 2
        if radius2 >= 0.0:
            blocker = shadowed(ground, poses[b, 0], poses[b, 1], np.sqrt(radius2), blocker)
            if blocker < 0:
                return -1
    return blocker


@njit(_nrt=False)
def shadowed(ground, x, y, radius, blocker):
    """Look for a place within a circle where the hand can be, for bodies in their poses.

    Returns -1 if there is one, else a body that is in the way; `blocker` is asked first.
    """
    limb = ground.scene.limb
    for k in range(1 + RINGS * TURNS):
        out, turn = (k + TURNS - 1) // TURNS * radius / RINGS, 2.0 * np.pi * k / TURNS
        px, py = x + out * np.cos(turn), y + out * np.sin(turn)
        away = np.sqrt(px * px + py * py)
        within = min(max(away, limb.near), limb.far)
        if away != within:  # the nearest place that the hand can reach
            px, py = px * within / max(away, 1e-9), py * within / max(away, 1e-9)
            if (px - x) ** 2 + (py - y) ** 2 > radius * radius:
                continue
        touched = touches(ground, px, py, blocker)
        if touched < 0:
            return -1
        blocker = touched
    return blocker


@njit(_nrt=False)
def touches(ground, x, y, first):
    """Find a body that the limb touches with the hand at (x, y), or -1; try body `first` first."""
    bodies, limb, poses = ground.scene.bodies, ground.scene.limb, ground.postures.scratch
    ex, ey = elbow_of(x, y, limb.rho, limb.side)
    for k in range(bodies.rows.shape[0]):
        b = (first + k) % bodies.rows.shape[0]
        if bodies.rows[b, PART] == HAND:
            continue
        if arm_distance(bodies, poses, b, x, y, ex, ey) <= ground.rules.touch:
            return b
    return -1


@njit(_nrt=False)
def outlook(aim, speed, x, y, t):
    """Estimate when a hand at (x, y) at time t meets a target before the bound.

    Returns F and the time to move, both NEVER if it cannot; F is late by at most a span.
    """
    ways, step = aim.ways, aim.step
    for i in range(int(t / step), ways.shape[0]):
        if step * i > aim.bound:
            break
        late, best = min(step * (i + 1), aim.bound), NEVER
        for b in range(ways.shape[1]):
            dx, dy, dz = x - ways[i, b, 0], y - ways[i, b, 1], ways[i, b, 2]
            away = np.sqrt(dx * dx + dy * dy + dz * dz) - ways[i, b, 3]
            best = min(best, max(away, 0.0) / speed)
        if t + best <= late:
            return max(step * i, t + best), best
    return NEVER, NEVER


@njit(_nrt=False)
def last_use(aim, speed, x, y):
    """Last moment at which a hand at (x, y) may still meet a target before the bound.

    -1 if it cannot at all.
    """
    ways, last = aim.ways, -1.0
    for i in range(ways.shape[0]):
        late = min(aim.step * (i + 1), aim.bound)
        for b in range(ways.shape[1]):
            dx, dy, dz = x - ways[i, b, 0], y - ways[i, b, 1], ways[i, b, 2]
            away = np.sqrt(dx * dx + dy * dy + dz * dz) - ways[i, b, 3]
            last = max(last, late - max(away, 0.0) / speed)
    return last


@njit(_nrt=False)
def comes_near(aim, x, y, near, i):
    """From span i on, the first in which a target comes that near to (x, y); -1 if none does."""
    ways = aim.ways
    for k in range(i, ways.shape[0]):
        if aim.step * k > aim.bound:
            break
        for b in range(ways.shape[1]):
            dx, dy, dz = x - ways[k, b, 0], y - ways[k, b, 1], ways[k, b, 2]
            if ways[k, b, 3] >= 0.0 and dx * dx + dy * dy + dz * dz <= (ways[k, b, 3] + near) ** 2:
                return k
    return -1
