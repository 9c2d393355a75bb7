"""Observations of spatial arms: compiled code, and the table of its numbers.

All is a function of the scene, the time, the joints and their rates. Vectors are in the frame of
the arm's base, the shoulder at the origin, lengths in the arm's reach. In the unit of time the
fastest hand makes a reach, and velocities are in its speed. So arms of other sizes and speeds look
the same. Rates of joints are in their own greatest ones.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.arms.limbs import dof
from gcm_learn.arms.spatial_limb import limb_at
from gcm_learn.collision.postures import body_distance
from gcm_learn.compiled import njit
from gcm_learn.execution.arena.kernels.joints.fan import tell_fan
from gcm_learn.execution.arena.kernels.joints.meeting import (
    AIM_ROW,
    aim_along,
    first_meeting_in_view,
)
from gcm_learn.execution.arena.kernels.joints.nearness import (
    centre_motion,
    limb_velocity,
    nearest_on_bone,
    point_velocity,
)
from gcm_learn.execution.arena.kernels.world import EXTREME
from gcm_learn.motion.joint_interception import target_room
from gcm_learn.scene.bodies import REACH, centre_at, pose_at
from gcm_learn.scene.shapes.choice import inner_radius

ARM, TARGET, OBSTACLE = 35, 30, 20  # numbers of the arm, the target, an obstacle
MEETING_AT = ARM + 21  # place of the direction of the first meeting, three numbers
AIM = ARM + 26  # place of the command that leads straight there, a number for each joint
MOMENTS = (0.5, 1.0, 2.0)  # units of time after which the target's place is observed
AHEAD = (0.5, 1.0)  # units of time after which obstacles are observed
_EXACTLY = 0.5  # farther than this [reaches], distances are those of the balls that hold bodies


@njit(_nrt=False, forceinline=True)
def _put(row, k, value):
    row[k] = min(max(value, -EXTREME), EXTREME)


@njit(_nrt=False, forceinline=True)
def _put_vector(row, k, x, y, z, unit):
    """Write the vector (x, y, z) in a unit."""
    _put(row, k, x / unit)
    _put(row, k + 1, y / unit)
    _put(row, k + 2, z / unit)


@njit
def observe(view, time, posture, e, options, row):
    """Write the observation of an arm into a row.

    Parameters
    ----------
    view : View
        Of its situation; overwritten but for the situation.
    time : float
        [s]
    posture : (arms, 2 dof) ndarray
        Row `e` has the arm's joints [rad] and their rates [rad/s].
    options : Options
    row : (width,) ndarray
    """
    for j in range(dof(view.scene.limb)):
        view.joints[0, j] = posture[e, j]
    place = limb_at(view.scene.limb, view.joints[0])
    _tell_arm(view, time, posture, e, place, options.dt, row)
    target = _tell_target(view, time, posture, e, place, row)
    ahead = (_ahead(view, 0), _ahead(view, 1))
    if options.fan:
        at = ARM + TARGET + options.slots * OBSTACLE
        tell_fan(view, time, posture, e, target, place, AIM, row, at)
    _tell_obstacles(view, time, posture, e, place, ahead, options.slots, row)


@njit(_nrt=False)
def _tell_arm(view, time, posture, e, place, dt, row):
    limb, limits = view.scene.limb, view.scene.limits
    ex, ey, ez, hx, hy, hz = place
    unit, n = view.reach / view.pace, dof(limb)
    ends, sizes = 2 * n + 6, 6 * n + 6
    for j in range(n):
        q, top = posture[e, j], limits.joint_speed[j]
        _put(row, j, q)
        _put(row, n + j, posture[e, n + j] / top)
        _put(row, ends + j, q - limb.low[j])
        _put(row, ends + n + j, limb.high[j] - q)
        _put(row, ends + 2 * n + j, top * unit)
        _put(row, ends + 3 * n + j, top / limits.joint_acceleration[j] / unit)
    _put_vector(row, 2 * n, hx, hy, hz, view.reach)
    _put_vector(row, 2 * n + 3, ex, ey, ez, view.reach)
    row[sizes] = limb.rho / view.reach
    _put(row, sizes + 1, limb.thickness / view.reach)
    _put(row, sizes + 2, view.rules.catch / view.reach)
    _put(row, sizes + 3, (limits.horizon - time) / unit)
    _put(row, sizes + 4, dt / unit)


@njit(_nrt=False)
def _tell_target(view, time, posture, e, place, row):
    """Write the target that can be met first, and where; the aim at it is left in the view.

    Returns
    -------
    int
        Which body it is.
    """
    scene, reach, poses = view.scene, view.reach, view.desk.poses
    _, _, _, hx, hy, hz = place
    unit = reach / view.pace
    first = first_meeting_in_view(view, time, posture, e)
    b = first.body
    vx, vy, vz, ax, ay, az = centre_motion(scene.bodies, b, time, poses)
    _put_vector(row, ARM + 3, vx, vy, vz, view.pace)
    _put_vector(row, ARM + 6, ax, ay, az, view.pace / unit)
    for k in range(3):
        later = min(time + MOMENTS[k] * unit, scene.limits.horizon)
        centre_at(scene.bodies, b, later, poses)
        x, y, z = poses[b, 0] - hx, poses[b, 1] - hy, poses[b, 2] - hz
        _put_vector(row, ARM + 9 + 3 * k, x, y, z, reach)
    row[ARM + 18] = scene.bodies.rows[b, REACH] / reach
    away = target_room(scene, b, hx, hy, hz, time, poses) - view.rules.catch
    _put(row, ARM + 19, away / reach)
    _put_vector(row, ARM, poses[b, 0] - hx, poses[b, 1] - hy, poses[b, 2] - hz, reach)
    row[ARM + 20] = 1.0 if first.found else 0.0
    wx, wy, wz = first.x - hx, first.y - hy, first.z - hz
    _put_vector(row, MEETING_AT, wx, wy, wz, reach)
    _put(row, ARM + 24, (first.time - time) / unit)
    _put(row, ARM + 25, np.sqrt(first.x**2 + first.y**2 + first.z**2) / reach)
    way = max(np.sqrt(wx * wx + wy * wy + wz * wz), 1e-12)
    aim_along(view, posture, e, wx / way, wy / way, wz / way)
    for j in range(dof(scene.limb)):
        row[AIM + j] = view.rates[AIM_ROW, j]
    return b


@njit(_nrt=False)
def _ahead(view, k):
    """Elbow and hand of a limb that follows its aim until moment k ahead."""
    limb, limits, unit = view.scene.limb, view.scene.limits, view.reach / view.pace
    for j in range(dof(limb)):
        turn = view.rates[AIM_ROW, j] * limits.joint_speed[j] * AHEAD[k] * unit
        view.joints[1, j] = min(max(view.joints[0, j] + turn, limb.low[j]), limb.high[j])
    return limb_at(limb, view.joints[1])


@njit(_nrt=False)
def _tell_obstacles(view, time, posture, e, place, ahead, slots, row):
    """Write the `slots` obstacles that are nearest to the limb now."""
    bodies, which, gaps = view.scene.bodies, view.desk.obstacles, view.gaps
    enough, at = _EXACTLY * view.reach, ARM + TARGET
    for k in range(which.size):
        gaps[k], _ = body_distance(bodies, which[k], time, place, 0.0, 0.0, enough, view.desk.poses)
    n = dof(view.scene.limb)
    for j in range(n):
        view.rates[0, j] = posture[e, n + j]
    for _ in range(slots):
        nearest = 0
        for k in range(1, which.size):
            if gaps[k] < gaps[nearest]:
                nearest = k
        if which.size == 0 or gaps[nearest] >= 1e300:
            for k in range(at, at + OBSTACLE):
                row[k] = 0.0
        else:
            _tell_obstacle(view, which[nearest], time, place, ahead, row, at)
            gaps[nearest] = 1e300
        at += OBSTACLE


@njit(_nrt=False)
def _tell_obstacle(view, b, time, place, ahead, row, at):
    bodies, poses, reach = view.scene.bodies, view.desk.poses, view.reach
    ex, ey, ez, hx, hy, hz = place
    pose_at(bodies, b, time, poses)
    cx, cy, cz = poses[b, 0], poses[b, 1], poses[b, 2]
    s, x, y, z = nearest_on_bone(bodies, b, poses, (0.0, 0.0, 0.0), (ex, ey, ez))
    u, v, w, px = nearest_on_bone(bodies, b, poses, (ex, ey, ez), (hx, hy, hz))
    forearm = v * v + w * w + px * px <= x * x + y * y + z * z
    if forearm:
        s, x, y, z = u, v, w, px
        px, py, pz = ex + s * (hx - ex), ey + s * (hy - ey), ez + s * (hz - ez)
    else:
        px, py, pz = s * ex, s * ey, s * ez
    row[at] = 1.0
    _put_vector(row, at + 1, px, py, pz, reach)
    _put_vector(row, at + 4, x, y, z, reach)
    _put(row, at + 7, (np.sqrt(x * x + y * y + z * z) - view.rules.touch) / reach)
    vx, vy, vz = point_velocity(bodies, b, time, poses, px + x, py + y, pz + z)
    elbow = (ex, ey, ez)
    lx, ly, lz = limb_velocity(view.joints[0], view.rates[0], elbow, px, py, pz, forearm)
    _put_vector(row, at + 8, vx - lx, vy - ly, vz - lz, view.pace)
    _put_vector(row, at + 11, cx - hx, cy - hy, cz - hz, reach)
    _put(row, at + 14, bodies.rows[b, REACH] / reach)
    _put(row, at + 15, inner_radius(bodies, b) / reach)
    for k in range(2):
        later = min(time + AHEAD[k] * reach / view.pace, view.scene.limits.horizon)
        row[at + 16 + k] = _room(view, b, later, place)
        row[at + 18 + k] = _room(view, b, later, ahead[k])


@njit(_nrt=False)
def _room(view, b, time, place):
    """Return how far a limb (elbow, hand) is from touching body b at a time [s] [reaches]."""
    enough = _EXACTLY * view.reach
    room, _ = body_distance(
        view.scene.bodies, b, time, place, 0.0, 0.0, enough, view.desk.poses
    )  # fmt: skip
    return min((room - view.rules.touch) / view.reach, EXTREME)
