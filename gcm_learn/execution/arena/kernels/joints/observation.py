"""Observations of arms that move in their joints: compiled code and counts of numbers.

All is a function of the scene, the time, the joints and their rates. Vectors are in the frame of
the arm's base, lengths in the arm's reach. In the unit of time the fastest hand makes a reach, and
velocities are in its speed. So arms of other sizes and speeds look the same. Rates of joints are in
their own greatest ones.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.arms.chain_limb import place_axes
from gcm_learn.arms.limbs import dof, hand_of, place
from gcm_learn.compiled import njit
from gcm_learn.execution.arena.kernels.joints import chains, meeting
from gcm_learn.execution.arena.kernels.joints.nearness import centre_motion
from gcm_learn.execution.arena.kernels.joints.scene import view_in, views_for
from gcm_learn.execution.arena.kernels.joints.stepping import step
from gcm_learn.execution.arena.kernels.world import (
    EXTREME,
    Options,
    State,
    Told,
    World,
    pay,
    put,
    put_vector,
)
from gcm_learn.motion.joint_interception import target_room
from gcm_learn.scene.bodies import REACH, centre_at, piece_at, pose_at, velocity_by
from gcm_learn.scene.shapes.choice import inner_radius

ARM, TARGET, OBSTACLE = 35, 30, 20  # numbers of a spatial arm, its target, an obstacle
AIM = ARM + 26  # place of the command that leads a spatial arm straight to the target
UNTIL_AIM = AIM - ARM  # numbers of a target before that command, which has one for each joint
MOMENTS = (0.5, 1.0, 2.0)  # units of time after which the target's place is observed
AHEAD = (0.5, 1.0)  # units of time after which obstacles are observed
_EXACTLY = 0.5  # farther than this [reaches], distances are those of the balls that hold bodies


@njit(_nrt=False, forceinline=True)
def arm_numbers(limb):
    """Count of the numbers of the arm."""
    return 6 * dof(limb) + 6 + chains.shape_numbers(limb) + chains.size_numbers(limb)


@njit(_nrt=False, forceinline=True)
def target_numbers(limb):
    """Count of the numbers of the target."""
    return UNTIL_AIM + dof(limb) + chains.approach_numbers(limb)


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
    limb = view.scene.limb
    for j in range(dof(limb)):
        view.joints[0, j] = posture[e, j]
    where = place(limb, view.joints[0])
    _tell_arm(view, time, posture, e, where, options.dt, row)
    target = _tell_target(view, time, posture, e, where, row)
    ahead = _ahead(view, 0), _ahead(view, 1)
    first = arm_numbers(limb)
    if options.fan:
        at = first + target_numbers(limb) + options.slots * OBSTACLE
        chains.tell_fan(limb, view, time, posture, e, target, first + UNTIL_AIM, row, at)
    _tell_obstacles(view, time, posture, e, where, ahead, options.slots, row)


@njit(_nrt=False)
def _tell_arm(view, time, posture, e, where, dt, row):
    limb, limits = view.scene.limb, view.scene.limits
    hx, hy, hz = hand_of(limb, where)
    unit, n = view.reach / view.pace, dof(limb)
    ends = 2 * n + 3 + chains.shape_numbers(limb)
    sizes = ends + 4 * n
    for j in range(n):
        q, top = posture[e, j], limits.joint_speed[j]
        put(row, j, q)
        put(row, n + j, posture[e, n + j] / top)
        put(row, ends + j, q - limb.low[j])
        put(row, ends + n + j, limb.high[j] - q)
        put(row, ends + 2 * n + j, top * unit)
        put(row, ends + 3 * n + j, top / limits.joint_acceleration[j] / unit)
    put_vector(row, 2 * n, hx, hy, hz, view.reach)
    chains.tell_shape(limb, where, view.reach, row, 2 * n + 3)
    chains.tell_sizes(limb, where, view.rules.touch, view.reach, row, sizes)
    rest = sizes + chains.size_numbers(limb)
    put(row, rest, view.rules.catch / view.reach)
    put(row, rest + 1, (limits.horizon - time) / unit)
    put(row, rest + 2, dt / unit)


@njit(_nrt=False)
def _tell_target(view, time, posture, e, where, row):
    """Write the target that can be met first and its meeting; leave the aim at it in the view.

    Returns
    -------
    int
        Index of the target among the bodies.
    """
    scene, reach, poses = view.scene, view.reach, view.desk.poses
    at, n = arm_numbers(scene.limb), dof(scene.limb)
    hx, hy, hz = hand_of(scene.limb, where)
    unit = reach / view.pace
    first = meeting.first_meeting_in_view(view, time, posture, e)
    b = first.body
    vx, vy, vz, ax, ay, az = centre_motion(scene.bodies, b, time, poses)
    put_vector(row, at + 3, vx, vy, vz, view.pace)
    put_vector(row, at + 6, ax, ay, az, view.pace / unit)
    for k in range(3):
        later = min(time + MOMENTS[k] * unit, scene.limits.horizon)
        centre_at(scene.bodies, b, later, poses)
        x, y, z = poses[b, 0] - hx, poses[b, 1] - hy, poses[b, 2] - hz
        put_vector(row, at + 9 + 3 * k, x, y, z, reach)
    row[at + 18] = scene.bodies.rows[b, REACH] / reach
    away = target_room(scene, b, hx, hy, hz, time, poses) - view.rules.catch
    put(row, at + 19, away / reach)
    put_vector(row, at, poses[b, 0] - hx, poses[b, 1] - hy, poses[b, 2] - hz, reach)
    row[at + 20] = 1.0 if first.found else 0.0
    wx, wy, wz = first.x - hx, first.y - hy, first.z - hz
    put_vector(row, at + 21, wx, wy, wz, reach)
    put(row, at + 24, (first.time - time) / unit)
    put(row, at + 25, np.sqrt(first.x**2 + first.y**2 + first.z**2) / reach)
    way = max(np.sqrt(wx * wx + wy * wy + wz * wz), 1e-12)
    meeting.aim_along(view, posture, e, wx / way, wy / way, wz / way)
    for j in range(n):
        row[at + UNTIL_AIM + j] = view.rates[meeting.AIM_ROW, j]
    chains.tell_approach(
        scene.limb, where, view.joints[0], scene, b, time, poses, row, at + UNTIL_AIM + n
    )
    return b


@njit(_nrt=False)
def _ahead(view, k):
    """Return the place of the limb after following its aim until moment k ahead."""
    limb, limits, unit = view.scene.limb, view.scene.limits, view.reach / view.pace
    for j in range(dof(limb)):
        turn = view.rates[meeting.AIM_ROW, j] * limits.joint_speed[j] * AHEAD[k] * unit
        view.joints[1, j] = min(max(view.joints[0, j] + turn, limb.low[j]), limb.high[j])
    return place(chains.beside(limb, view.own, k), view.joints[1])


@njit(_nrt=False)
def _tell_obstacles(view, time, posture, e, where, ahead, slots, row):
    """Write the `slots` obstacles that are nearest to the limb now."""
    limb, which, gaps = view.scene.limb, view.desk.obstacles, view.gaps
    at, n = arm_numbers(limb) + target_numbers(limb), dof(limb)
    enough = _EXACTLY * view.reach
    for k in range(which.size):
        gaps[k] = chains.gap_of(
            limb, where, view.scene.bodies, which[k], time, enough, view.desk.poses
        )
    for j in range(n):
        view.rates[0, j] = posture[e, n + j]
    place_axes(limb, view.joints[0])
    for _ in range(slots):
        nearest = 0
        for k in range(1, which.size):
            if gaps[k] < gaps[nearest]:
                nearest = k
        if which.size == 0 or gaps[nearest] >= 1e300:
            for k in range(at, at + OBSTACLE):
                row[k] = 0.0
        else:
            _tell_obstacle(view, which[nearest], time, where, ahead, row, at)
            gaps[nearest] = 1e300
        at += OBSTACLE


@njit(_nrt=False)
def _tell_obstacle(view, b, time, where, ahead, row, at):
    bodies, poses, limb, reach = view.scene.bodies, view.desk.poses, view.scene.limb, view.reach
    hx, hy, hz = hand_of(limb, where)
    pose_at(bodies, b, time, poses)
    cx, cy, cz = poses[b, 0], poses[b, 1], poses[b, 2]
    i, px, py, pz, x, y, z, radius = chains.nearest_point(limb, where, bodies, b, poses)
    row[at] = 1.0
    put_vector(row, at + 1, px, py, pz, reach)
    put_vector(row, at + 4, x, y, z, reach)
    put(row, at + 7, (np.sqrt(x * x + y * y + z * z) - radius - view.rules.touch) / reach)
    vx, vy, vz = velocity_by(bodies, b, piece_at(bodies, b, time), time, (px + x, py + y, pz + z))
    joints, rates = view.joints[0], view.rates[0]
    lx, ly, lz = chains.point_velocity_on(limb, where, i, joints, rates, px, py, pz)
    put_vector(row, at + 8, vx - lx, vy - ly, vz - lz, view.pace)
    put_vector(row, at + 11, cx - hx, cy - hy, cz - hz, reach)
    put(row, at + 14, bodies.rows[b, REACH] / reach)
    put(row, at + 15, inner_radius(bodies, b) / reach)
    for k in range(2):
        later = min(time + AHEAD[k] * reach / view.pace, view.scene.limits.horizon)
        row[at + 16 + k] = _room(view, limb, b, later, where)
        row[at + 18 + k] = _room(view, chains.beside(limb, view.own, k), b, later, ahead[k])


@njit(_nrt=False, forceinline=True)
def _room(view, limb, b, time, where):
    """Return how far a limb at a place is from touching body b at a time [s] [reaches]."""
    enough = _EXACTLY * view.reach
    room = chains.gap_of(limb, where, view.scene.bodies, b, time, enough, view.desk.poses)
    return min((room - view.rules.touch) / view.reach, EXTREME)


@njit(nogil=True)
def observe_all(world, state, chosen, options, out):
    """Write the observations of the arms `chosen` (k,) into their rows of `out`.

    Worlds come as plain tuples here and below, so that a call is quick.
    """
    worlds, states, how = World(*world), State(*state), Options(*options)
    room = views_for(worlds, states, 0, states.place.size)
    for k in range(chosen.size):
        e = chosen[k]
        view = view_in(worlds, states, e, room)
        observe(view, states.time[e], states.posture, e, how, out[e])
        hand = hand_of(view.scene.limb, place(view.scene.limb, view.joints[0]))
        states.hand[e, 0], states.hand[e, 1], states.hand[e, 2] = hand


@njit(nogil=True)
def play(world, state, actions, options, told, first, last):
    """Make a step of arms first to last - 1, and observe."""
    worlds, states, how, out = World(*world), State(*state), Options(*options), Told(*told)
    room = views_for(worlds, states, first, last)
    for e in range(first, last):
        view = step(worlds, states, e, actions, how, out, room)
        row = out.observations[e]
        observe(view, states.time[e], states.posture, e, how, row)


@njit(nogil=True)
def ways_to_go(world, state, out):
    """Write the guide's potential of every arm."""
    worlds, states = World(*world), State(*state)
    room = views_for(worlds, states, 0, states.place.size)
    for e in range(states.place.size):
        view = view_in(worlds, states, e, room)
        out[e] = meeting.way_to_go(view, states.time[e], states.posture, e)


@njit(nogil=True)
def settle(told, catches, weights, shares, nearer):
    """Pay every arm for a step that a plant with mass made.

    Parameters
    ----------
    told : Told
        As a plain tuple, with the outcomes.
    catches : (e,) ndarray
        Of the step, as shares of those that end the episodes.
    weights : (4,) ndarray
    shares : (e,) ndarray
        Of the horizons that the step took.
    nearer : (e,) ndarray
        See `pay`.
    """
    out = Told(*told)
    for e in range(shares.size):
        pay(out, e, out.outcomes[e], catches[e], shares[e], weights, nearer[e])
