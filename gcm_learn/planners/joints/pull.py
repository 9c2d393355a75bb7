"""Postures pulled to a target until the hand catches it."""

from __future__ import annotations

import numpy as np

from gcm_learn.arms.limbs import dof, hand_of, jacobian, place, spins
from gcm_learn.collision.distance import point_distance
from gcm_learn.compiled import njit
from gcm_learn.motion import joint_interception
from gcm_learn.planners.joints.least_rates import solved
from gcm_learn.planners.joints.moves import HAIR, time_of
from gcm_learn.scene.bodies import SECOND, WITHIN, pose_at

ROUNDS = 16  # of pulling a hand to a target
DEPTH = 1e-4  # how far into the catch it is pulled [forearms]
PROBE = 1e-5  # finite difference for the direction of a target [forearms]
LONGEST_PULL = 0.5  # of a joint in one round [rad]
DAMPING = 1e-6  # share of the curvature of distance and angle, against singular postures


@njit(_nrt=False)
def slope_at(study, b, x, y, z, t):
    """Slope of the signed distance to body b at the point (x, y, z) and t [s], by differences."""
    pose_at(study.scene.bodies, b, t, study.desk.poses)
    return _slope(study, b, x, y, z)


@njit(_nrt=False)
def _slope(study, b, x, y, z):
    """Return the slope of the signed distance to body b in its known pose, by differences."""
    bodies, poses, probe = study.scene.bodies, study.desk.poses, PROBE * study.scene.limb.length
    nx = point_distance(bodies, poses, b, x + probe, y, z)
    nx -= point_distance(bodies, poses, b, x - probe, y, z)
    ny = point_distance(bodies, poses, b, x, y + probe, z)
    ny -= point_distance(bodies, poses, b, x, y - probe, z)
    nz = point_distance(bodies, poses, b, x, y, z + probe)
    nz -= point_distance(bodies, poses, b, x, y, z - probe)
    return 0.5 * nx / probe, 0.5 * ny / probe, 0.5 * nz / probe


@njit(_nrt=False)
def pulled(study, b, t, q):
    """Turn joints q (n,), within ``study.low`` and ``study.high``, until the hand catches body b.

    Newton's method on the signed distance of hand and target, in the metric of the joints' speeds.
    Returns whether it succeeds.
    """
    scene, low, high, slopes = study.scene, study.low, study.high, study.jacobian
    limb, rate, poses = scene.limb, scene.limits.joint_speed, study.desk.poses
    pulled_so = _pulled_along(study, b, t, q)
    if pulled_so >= 0:
        return pulled_so == 1
    pose_at(scene.bodies, b, t, poses)
    for _ in range(ROUNDS):
        x, y, z = hand_of(limb, place(limb, q))
        room = point_distance(scene.bodies, poses, b, x, y, z) - study.catch
        if room <= 0.0:
            return True
        nx, ny, nz = _slope(study, b, x, y, z)
        jacobian(limb, q, slopes)
        size, most = 0.0, 0.0
        for j in range(dof(limb)):
            slope = nx * slopes[0, j] + ny * slopes[1, j] + nz * slopes[2, j]
            if (q[j] <= low[j] and slope > 0.0) or (q[j] >= high[j] and slope < 0.0):
                slope = 0.0
            slopes[0, j] = slope * rate[j] * rate[j]
            size += slopes[0, j] * slope
            most = max(most, abs(slopes[0, j]))
        if size <= 1e-12 * limb.length * limb.length * rate[0] * rate[0]:
            return False
        pull = min((room + DEPTH * limb.length) / size, LONGEST_PULL / most)
        for j in range(dof(limb)):
            q[j] = min(max(q[j] - pull * slopes[0, j], low[j]), high[j])
    return False


@njit(_nrt=False)
def _pulled_along(study, b, t, q):
    """Turn joints q (n,) until the hand catches body b from its approaches; see `pulled`.

    Newton's method on distance and angles together, damped; joints that would leave their box are
    held for a round.  Returns 1 for success, 0 for failure, -1 for a target without approach.
    """
    scene, poses, system = study.scene, study.desk.poses, study.system
    limb, angles = scene.limb, joint_interception.approaches(scene, b)
    if angles == 0:
        return -1
    pose_at(scene.bodies, b, t, poses)
    for _ in range(2 * ROUNDS):
        where = place(limb, q)
        x, y, z = hand_of(limb, where)
        room = point_distance(scene.bodies, poses, b, x, y, z) - study.catch
        far = joint_interception.approach_excess(scene, where, q, b, t, poses)
        if room <= 0.0 and far <= 0.5 * joint_interception.ANGLE:
            return 1
        nx, ny, nz = _slope(study, b, x, y, z)
        jacobian(limb, q, study.jacobian)
        for j in range(dof(limb)):
            a = study.jacobian[:, j]
            study.slopes[0, j] = nx * a[0] + ny * a[1] + nz * a[2]
        system[0, 6] = room + DEPTH * limb.length if room > 0.0 else 0.0
        spins(limb, q, study.turns)
        for i in range(angles):
            system[1 + i, 6] = _turn_wanted(study, where, q, b, i, t)
        if not _stepped(study, 1 + angles, q):
            return 0
    return 0


@njit(_nrt=False)
def _turn_wanted(study, where, q, b, i, t):
    """Return the angle to turn the hand to approach i of body b; write its slope to `slopes`."""
    scene = study.scene
    within = scene.bodies.rows[b, WITHIN + i * SECOND]
    axis = joint_interception.approach_axis(scene, b, i, t, study.desk.poses)
    hand = joint_interception.hand_direction(scene, where, q, b, i)
    (ax, ay, az), (bx, by, bz) = axis, hand
    ex, ey, ez = by * az - bz * ay, bz * ax - bx * az, bx * ay - by * ax
    sine = np.sqrt(max(ex * ex + ey * ey + ez * ez, 1e-12))
    for j in range(q.size):
        w = study.turns[:, j]
        study.slopes[1 + i, j] = -(w[0] * ex + w[1] * ey + w[2] * ez) / sine
    excess = joint_interception.angle_between(axis, hand) - within
    return excess + min(0.1 * within, 0.02) if excess > 0.0 else 0.0


@njit(_nrt=False)
def _stepped(study, count, q):
    """Step joints q (n,) to lessen distance and angles, `count` in all; False without a step.

    Both are in column 6 of ``study.system``, their slopes in the first rows of ``study.slopes``.
    """
    low, high, n, rate = study.low, study.high, q.size, study.scene.limits.joint_speed
    slopes, system, free, step = study.slopes, study.system, study.slopes[3], study.slopes[4]
    wanted = system[0, 6], system[1, 6], system[2, 6]
    for j in range(n):
        free[j] = 1.0
    for _ in range(2):
        for a in range(count):
            system[a, 6] = wanted[a]
            for c in range(count):
                total = 0.0
                for j in range(n):
                    total += rate[j] * rate[j] * free[j] * slopes[a, j] * slopes[c, j]
                system[a, c] = total
            system[a, a] = system[a, a] * (1.0 + DAMPING) + 1e-30
        if not solved(system, count):
            return False
        most, held = 0.0, False
        for j in range(n):
            total = 0.0
            for a in range(count):
                total += slopes[a, j] * system[a, 7]
            step[j] = -rate[j] * rate[j] * free[j] * total
            if (q[j] <= low[j] and step[j] < 0.0) or (q[j] >= high[j] and step[j] > 0.0):
                free[j], held, step[j] = 0.0, True, 0.0
            most = max(most, abs(step[j]))
        if not held:
            break
    if most == 0.0:
        return False
    share = min(1.0, LONGEST_PULL / most)
    for j in range(n):
        q[j] = min(max(q[j] + share * step[j], low[j]), high[j])
    return True


@njit(_nrt=False)
def box(study, q, span):
    """Write the joints that a straight move from q (dof,) can reach in a time into low and high.

    A hair less, so that by `time_of` no joint is too slow.
    """
    limb, rate, span = study.scene.limb, study.scene.limits.joint_speed, span * (1.0 - 2.0 * HAIR)
    for j in range(q.size):
        study.low[j] = max(limb.low[j], q[j] - rate[j] * span)
        study.high[j] = min(limb.high[j], q[j] + rate[j] * span)


@njit(_nrt=False)
def met_from(study, q, since, b, p, t):
    """Write the joints near p (dof,) that catch body b at t [s] into ``study.goal``.

    They are such that a straight move from joints q (dof,) gets there in time.

    Parameters
    ----------
    since : float
        When that begins at the earliest [s].

    Returns
    -------
    pieces : int
        Of the move, which has been timed; 0 if there is none.
    """
    goal = study.goal
    box(study, q, t - since)
    for j in range(q.size):
        goal[j] = min(max(p[j], study.low[j]), study.high[j])
    if not pulled(study, b, t, goal):
        return 0
    took, pieces = time_of(study, q, goal)
    return pieces if took <= t - since else 0
