"""Interception of targets by a limb that moves in its joints, in the frame of its base."""

from __future__ import annotations

import numpy as np

from gcm_learn.arms import limbs
from gcm_learn.arms.curves import on_curve
from gcm_learn.collision.distance import point_distance
from gcm_learn.compiled import njit
from gcm_learn.scene import bodies

ANGLE = 3e-7  # by which an approach may miss its angle; the contract grants 1e-6 [rad]
_CLOSE = 1e-5  # share of the horizon too short to differ from now


@njit(_nrt=False)
def target_room(scene, b, x, y, z, t, poses):
    """Signed distance of the point (x, y, z) to the solid of body b at t [s].

    Parameters
    ----------
    poses : (bodies, 12) ndarray
        Row b is filled with the body's pose.
    """
    bodies.pose_at(scene.bodies, b, t, poses)
    return point_distance(scene.bodies, poses, b, x, y, z)


@njit(_nrt=False, forceinline=True)
def approaches(scene, b):
    """Count of the approaches of a target: 0, 1 or 2."""
    row, count = scene.bodies.rows, 0
    for k in (bodies.APPROACH, bodies.APPROACH + bodies.SECOND):
        if row[b, k] != 0.0 or row[b, k + 1] != 0.0 or row[b, k + 2] != 0.0:
            count += 1
    return count


@njit(_nrt=False)
def approach_axis(scene, b, i, t, poses):
    """Return the direction of approach i of target b at t [s]; row b of `poses` gets the turn."""
    row, k = scene.bodies.rows, bodies.APPROACH + i * bodies.SECOND
    bodies.turn_at(scene.bodies, b, t, poses)
    x, y, z = row[b, k], row[b, k + 1], row[b, k + 2]
    return (
        poses[b, 3] * x + poses[b, 4] * y + poses[b, 5] * z,
        poses[b, 6] * x + poses[b, 7] * y + poses[b, 8] * z,
        poses[b, 9] * x + poses[b, 10] * y + poses[b, 11] * z,
    )


@njit(_nrt=False)
def hand_direction(scene, where, q, b, i):
    """Direction of the hand that approach i of target b asks about, at joints q (n,)."""
    row, k = scene.bodies.rows, bodies.TOWARDS + i * bodies.SECOND
    x, y, z = row[b, k], row[b, k + 1], row[b, k + 2]
    if x == 0.0 and y == 0.0 and z == 0.0:
        return limbs.axis_of(scene.limb, where)
    return limbs.direction_of(scene.limb, q, x, y, z)


@njit(_nrt=False)
def angle_between(first, second):
    """Angle between two directions of three numbers each [rad]."""
    ax, ay, az = first
    bx, by, bz = second
    cx, cy, cz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    return np.arctan2(np.sqrt(cx * cx + cy * cy + cz * cz), ax * bx + ay * by + az * bz)


@njit(_nrt=False)
def approach_excess(scene, where, q, b, t, poses):
    """Return the largest excess of the hand's angles to the approaches of target b at t [s].

    Parameters
    ----------
    where, q : place of the limb, (n,) ndarray
        The same posture.
    poses : (bodies, 12) ndarray
        Row b holds the body's pose.

    Returns
    -------
    float
        [rad]; -1 where the target has no approach.
    """
    excess = -1.0
    for i in range(approaches(scene, b)):
        toward = hand_direction(scene, where, q, b, i)
        angle = angle_between(approach_axis(scene, b, i, t, poses), toward)
        angle -= scene.bodies.rows[b, bodies.WITHIN + i * bodies.SECOND]
        excess = angle if i == 0 else max(excess, angle)
    return excess


@njit(_nrt=False)
def fastest_hand(scene):
    """Return a bound of the hand's speed [lengths/s]: its own limit, or the joints' if lower."""
    return min(limbs.hand_bound(scene.limb, scene.limits.joint_speed), scene.limits.speed)


@njit(_nrt=False)
def met_at(scene, q, t, catch, poses):
    """First of the targets within `catch` of the hand at joints q (n,) and time t [s]; or -1."""
    where = limbs.place(scene.limb, q)
    x, y, z = limbs.hand_of(scene.limb, where)
    for b in range(scene.bodies.rows.shape[0]):
        if scene.bodies.rows[b, bodies.PART] == bodies.HAND:
            if target_room(scene, b, x, y, z, t, poses) <= catch:
                if approach_excess(scene, where, q, b, t, poses) <= ANGLE:
                    return b
    return -1


@njit(_nrt=False)
def turn_wait(scene, where, q, b, t, rate, poses):
    """Bound from below the time [s] until the hand fits the approaches of target b; 0 if it does.

    The joints are at q (n,), and their rates are at most `rate` (n,).
    """
    excess = approach_excess(scene, where, q, b, t, poses)
    if excess <= ANGLE:
        return 0.0
    fast = limbs.axis_bound(scene.limb, rate) + bodies.top_spin(scene.bodies, b)
    return excess / fast if fast > 0.0 else 1e300


@njit
def first_meeting(scene, curve, since, until, catch, shortest, poses):
    """First moment of a move at which a target is within `catch` of the hand.

    Conservative advancement over the move in ``curve`` (dof, 4), see `arms.curves`, with steps of
    at least `shortest` [s].

    Returns
    -------
    time : float
        -1 without one [s].
    body : int
    """
    limb, span, t = scene.limb, until - since, since
    rate = np.zeros(limbs.dof(limb))
    for j in range(limbs.dof(limb)):
        most = abs(curve[j, 1]) + 2.0 * abs(curve[j, 2]) + 3.0 * abs(curve[j, 3])
        rate[j] = most / span if span > 0.0 else 0.0
    speed, joints = limbs.hand_bound(limb, rate), np.zeros(limbs.dof(limb))
    while True:
        s = (t - since) / span if span > 0.0 else 1.0
        on_curve(curve, s, joints)
        where = limbs.place(limb, joints)
        x, y, z = limbs.hand_of(limb, where)
        step = 1e300
        for b in range(scene.bodies.rows.shape[0]):
            if scene.bodies.rows[b, bodies.PART] == bodies.HAND:
                room = target_room(scene, b, x, y, z, t, poses) - catch
                wait = turn_wait(scene, where, joints, b, t, rate, poses)
                if room <= 0.0 and wait <= 0.0:
                    return t, b
                if room > 0.0:
                    fast = speed + scene.bodies.rows[b, bodies.TOP_SPEED]
                    wait = max(wait, room / fast if fast > 0.0 else 1e300)
                step = min(step, wait)
        if t >= until:
            return -1.0, -1
        t = min(t + max(step, shortest), until)


@njit(_nrt=False)
def may_be_met(scene, poses):
    """Return whether a target may come within reach of the hand at the bound of its speed.

    A necessary condition by conservative advancement, so False is certain.
    """
    limb, end = scene.limb, scene.limits.horizon
    far = limbs.reach_of(limb)
    x, y, z = limbs.hand_of(limb, limbs.place(limb, limb.start))
    speed = fastest_hand(scene)
    for b in range(scene.bodies.rows.shape[0]):
        if scene.bodies.rows[b, bodies.PART] != bodies.HAND:
            continue
        t, top = 0.0, scene.bodies.rows[b, bodies.TOP_SPEED]
        while t <= end:
            ring = target_room(scene, b, 0.0, 0.0, 0.0, t, poses) - scene.limits.grasp - far
            way = target_room(scene, b, x, y, z, t, poses) - scene.limits.grasp - speed * t
            wait = way / (top + speed)
            if ring > 0.0:
                wait = max(wait, ring / top if top > 0.0 else 1e300)
            if wait <= _CLOSE * end:
                return True
            t += wait
    return False
