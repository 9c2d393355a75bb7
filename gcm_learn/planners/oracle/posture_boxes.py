"""A bound on all movements of a spatial arm: a free posture in reach must meet a target.

Boxes of joints and time are split until each is excluded for certain, or one holds a posture that
is free, in reach and on a target.  A box is excluded if its hands are off all targets, if the
hand's limit of speed forbids them, or if all its limbs are inside one obstacle.  Joints that cannot
have turned so far by then are cut off.  The way from the start to the posture is left out.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.arms.limbs import dof
from gcm_learn.arms.swivels import RHO, limb_at
from gcm_learn.collision.postures import distance_at
from gcm_learn.compiled import njit
from gcm_learn.motion.joint_interception import target_room
from gcm_learn.planners.joints.moves import Study, turning_time
from gcm_learn.scene.bodies import LIMB, PART, drift

SLICES = 32  # of the horizon, looked through one after the other
MOST = 1_000_000  # boxes that are checked
FINEST = 1e-3  # share of the reach by which limbs of a box may differ: it is split no more
_POINTS = 6  # of each bone that are held against an obstacle
_HAIR = 1e-9  # share of the reach, against rounding
_GRANTED = 1.1e-6  # share of limits and ranges by which movements may exceed them
_DEEPEST = 200


@njit(_nrt=False)
def ways_in_box(study, low, high, q):
    """Bounds of how far points of both bones are from where they are in the middle of a box.

    Parameters
    ----------
    low, high : (dof,) ndarray
        Ends of the box in the joints.
    q : (dof,) ndarray
        Filled with its middle.
    """
    limb = study.scene.limb
    for j in range(dof(limb)):
        q[j] = 0.5 * (low[j] + high[j])
    h0, h1, h2, h3 = high[0] - q[0], high[1] - q[1], high[2] - q[2], high[3] - q[3]
    _, _, _, x, y, z = limb_at(limb, q)
    turn, bend = np.hypot(h0, h1), np.hypot(h2, h3) * limb.length
    farthest = min(np.sqrt(x * x + y * y + z * z) + bend, limb.reach)
    return turn * limb.solved[RHO], max(turn * limb.solved[RHO], turn * farthest + bend)


@njit(_nrt=False)
def may_meet(study, since, until, place, way):
    """Return if a hand that is at most `way` from that of `place` may be on a target in a span."""
    scene, t, hand = study.scene, 0.5 * (since + until), place[3:]
    for b in range(scene.bodies.rows.shape[0]):
        if scene.bodies.rows[b, PART] != LIMB:
            off = 0.5 * drift(scene.bodies, b, since, until) + way
            room = target_room(scene, b, hand[0], hand[1], hand[2], t, study.desk.poses)
            if room - off <= scene.limits.grasp:
                return True
    return False


@njit(_nrt=False)
def is_blocked(study, since, until, place, upper, fore):
    """Return whether one obstacle always touches all limbs within `upper` and `fore` of `place`."""
    scene, t = study.scene, 0.5 * (since + until)
    ex, ey, ez, hx, hy, hz = place
    for k in range(study.desk.obstacles.size):
        b = study.desk.obstacles[k]
        off = 0.5 * drift(scene.bodies, b, since, until)
        for i in range(1, 2 * _POINTS + 1):
            s = i / _POINTS
            way = upper
            x, y, z = s * ex, s * ey, s * ez
            if s > 1.0:
                s, way = s - 1.0, fore
                x, y, z = ex + s * (hx - ex), ey + s * (hy - ey), ez + s * (hz - ez)
            room = target_room(scene, b, x, y, z, t, study.desk.poses)
            if room + off + way < scene.limb.thickness:
                return True
    return False


@njit(_nrt=False)
def _widest(study, low, high, since, until, farthest):
    """Axis of a box (4 is time) along which limb or target differ most, and by how much."""
    scene, axis, most = study.scene, 4, 0.0
    for b in range(scene.bodies.rows.shape[0]):
        most = max(most, 0.5 * drift(scene.bodies, b, since, until))
    for j in range(dof(scene.limb)):
        arm = farthest if j < 2 else scene.limb.length
        if 0.5 * (high[j] - low[j]) * arm > most:
            axis, most = j, 0.5 * (high[j] - low[j]) * arm
    return axis, most


@njit(_nrt=False)
def _is_witness(study, q, t, place):
    """Return if joints q (dof,) meet a target at t [s], free, and in reach of a straight move."""
    scene = study.scene
    if turning_time(scene.limits.joint_speed, scene.limb.start, q) > t:
        return False
    if not may_meet(study, t, t, place, study.catch - scene.limits.grasp):
        return False
    return distance_at(scene, q, t, study.desk) > study.touch


@njit(_nrt=False)
def slice_is_ruled_out(study, since, until, most, stack):
    """Return whether every catch in a span of time is excluded, and how many boxes that took.

    Parameters
    ----------
    most : int
        Boxes that may be checked; if that is not enough a catch counts as possible.
    stack : (_DEEPEST, 10) ndarray
        Room to work in.
    """
    scene, q = study.scene, study.goal
    limb, rate, low, high = scene.limb, scene.limits.joint_speed, study.low, study.high
    reach, looks, depth = limb.reach, 0, 1
    _, _, _, sx, sy, sz = limb_at(limb, limb.start)
    for j in range(dof(limb)):
        hair = _GRANTED * max(abs(limb.low[j]), abs(limb.high[j]))
        stack[0, j], stack[0, 5 + j] = limb.low[j] - hair, limb.high[j] + hair
    stack[0, 4], stack[0, 9] = since, until
    while depth > 0:
        depth -= 1
        looks += 1
        begin, end = stack[depth, 4], stack[depth, 9]
        empty = False
        for j in range(dof(limb)):
            turn = rate[j] * end * (1.0 + _GRANTED)
            low[j] = max(stack[depth, j], limb.start[j] - turn)
            high[j] = min(stack[depth, 5 + j], limb.start[j] + turn)
            empty = empty or low[j] > high[j]
        if empty:
            continue
        upper, fore = ways_in_box(study, low, high, q)
        upper, fore = upper + _HAIR * reach, fore + _HAIR * reach
        place = limb_at(limb, q)
        _, _, _, x, y, z = place
        way = np.sqrt((x - sx) ** 2 + (y - sy) ** 2 + (z - sz) ** 2)
        if way - fore > scene.limits.speed * end * (1.0 + _GRANTED):
            continue
        if not may_meet(study, begin, end, place, fore):
            continue
        if is_blocked(study, begin, end, place, upper, fore):
            continue
        if looks >= most or depth + 2 > _DEEPEST:
            return False, looks
        moment = 0.5 * (begin + end)
        if way <= scene.limits.speed * moment and _is_witness(study, q, moment, place):
            return False, looks
        farthest = min(np.sqrt(x * x + y * y + z * z) + fore, reach)
        axis, widest = _widest(study, low, high, begin, end, farthest)
        if widest < FINEST * reach:
            return False, looks
        for j in range(dof(limb)):
            stack[depth, j], stack[depth, 5 + j] = low[j], high[j]
        for i in range(10):
            stack[depth + 1, i] = stack[depth, i]
        middle = 0.5 * (stack[depth, axis] + stack[depth, 5 + axis])
        stack[depth, axis] = middle
        stack[depth + 1, 5 + axis] = middle
        depth += 2
    return True, looks


def earliest_possible(study: Study, most: int = MOST) -> float:
    """A moment before which no movement catches; infinite if none does at all [s].

    It holds for every movement that keeps the limits of joints and hand and touches nothing.  It
    may be too early to be useful.
    """
    end, stack = study.scene.limits.horizon, np.zeros((_DEEPEST, 10))
    for k in range(SLICES):
        since, until = end * (k / SLICES), end * ((k + 1) / SLICES)
        ruled_out, looks = slice_is_ruled_out(study, since, until, most, stack)
        most -= looks
        if not ruled_out:
            return float(since)
    return np.inf
