"""Observations of planar arms: compiled code, and the counts of observed numbers.

All numbers are dimensionless: lengths in forearms, velocities in hand speeds, times as the way that
the hand can make in them. Vectors are in the frame of the moment, in which the hand is on the x
axis and the elbow on the right. So situations that are turned, mirrored or slowed down look the
same. Everything follows from the situation at t = 0 and the laws of motion.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.arms.planar_limb import elbow_of
from gcm_learn.compiled import njit
from gcm_learn.execution.arena.kernels.hands import nearness
from gcm_learn.execution.arena.kernels.hands.scene import MOMENTS, scene_of
from gcm_learn.execution.arena.kernels.world import EXTREME, LONG, rules_in
from gcm_learn.scene.bodies import (
    ACCELERATION,
    BALL,
    HAND,
    PART,
    REACH,
    SPIN,
    SWING,
    TOP_SPEED,
    VELOCITY,
    glide,
    pose_at,
    swing,
)

ARM, TARGET, OBSTACLE = 10, 17, 20  # numbers of the arm, the target, an obstacle
MEETING = ARM + 14  # place of the direction of the meeting, two numbers
LEAST, LATE, NOW = range(3)  # of an obstacle on the straight way: least distance, when, at first
_INSTANTS = 16  # at which an interception is looked for
_BISECTIONS = 6
_FARTHEST = 2.0  # observed distances are cut at this


class HandMoment(NamedTuple):
    """Moment of an observation."""

    x: float  # hand, in canonical coordinates of t = 0
    y: float
    t: float  # [s]
    c: float  # direction of the hand, which is the x axis of the observation
    s: float


class HandMeeting(NamedTuple):
    """About when and where a straight way from the hand first meets a target."""

    time: float  # the horizon if there is none [s]
    found: bool
    x: float  # the target's centre then
    y: float


@njit(forceinline=True)
def _missing(scene, catch, radius, view, wait, place):
    """Return the distance that a hand lacks to a target at a place (3) after `wait` seconds.

    At most 0 if it can; else hand and target need at least the time in which both together travel
    that far.
    """
    px, py, pz = place
    pz = abs(pz)
    if pz > radius:
        return pz - radius
    reach = np.sqrt(radius * radius - pz * pz) + catch
    way = np.sqrt((px - view.x) ** 2 + (py - view.y) ** 2)
    away = way - reach - scene.limits.speed * wait
    r = np.sqrt(px * px + py * py)
    return max(away, r - scene.limb.far - reach, scene.limb.near - reach - r)


@njit(_nrt=False, forceinline=True)
def _meeting_by(centre, scene, catch, b, view, poses):
    """Return the meeting with body b; the function `centre` places it: `glide` or `swing`."""
    bodies, since, end = scene.bodies, view.t, scene.limits.horizon
    radius = bodies.rows[b, REACH]
    step = (end - since) / _INSTANTS
    stride = max((scene.limits.speed + bodies.rows[b, TOP_SPEED]) * step, 1e-9)
    k, before = 0, since
    while k <= _INSTANTS:
        t = since + step * k
        missing = _missing(scene, catch, radius, view, t - since, centre(bodies, b, t, poses))
        if missing <= 0.0:
            low, high = before, t
            for _ in range(_BISECTIONS if k > 0 else 0):
                t = 0.5 * (low + high)
                place = centre(bodies, b, t, poses)
                if _missing(scene, catch, radius, view, t - since, place) <= 0.0:
                    high = t
                else:
                    low = t
            px, py, _ = centre(bodies, b, high, poses)
            return HandMeeting(high, True, px, py)
        before = t
        k += max(int(missing / stride), 1)
    px, py, _ = centre(bodies, b, end, poses)
    return HandMeeting(end, False, px, py)


@njit(_nrt=False)
def meeting_with(scene, catch, b, view, poses):
    """Return the meeting with target b.

    Approximate: 16 instants and a few bisections, with balls for bodies.
    """
    if scene.bodies.rows[b, SWING] >= 0.0:
        return _meeting_by(swing, scene, catch, b, view, poses)
    return _meeting_by(glide, scene, catch, b, view, poses)


@njit(_nrt=False, forceinline=True)
def _put(row, k, value):
    row[k] = min(max(value, -EXTREME), EXTREME)


@njit(_nrt=False, forceinline=True)
def _put_turned(row, k, view, x, y):
    """Write the vector (x, y), turned into the frame of the moment."""
    _put(row, k, view.c * x + view.s * y)
    _put(row, k + 1, view.c * y - view.s * x)


@njit
def observe(world, state, e, options, out, workspace):
    """Write the observation of arm e into row e of `out`."""
    s, row, poses = state.place[e], out[e], workspace.poses
    scene, rules = scene_of(world, s), rules_in(world, s)
    x, y = state.hand[e, 0], state.hand[e, 1]
    r = np.sqrt(x * x + y * y)
    c, sn = (x / r, y / r) if r > 1e-12 else (1.0, 0.0)
    view = HandMoment(x, y, state.time[e], c, sn)
    _tell_arm(scene, rules, view, options.dt, row)
    target, first = _first_meeting(scene, rules.catch, view, poses)
    _tell_target(scene, rules.catch, target, view, first, poses, row)
    _look_ahead(scene, view, first, workspace)
    at = _tell_obstacles(scene, rules.touch, view, options.slots, workspace, row)
    if options.fan:
        dx, dy = first.x - x, first.y - y
        length = np.sqrt(dx * dx + dy * dy)
        dx, dy = (dx / length, dy / length) if length > 1e-9 else (c, sn)
        nearness.tell_fan(scene, rules.touch, view, dx, dy, poses, row, at)


@njit(_nrt=False)
def _first_meeting(scene, catch, view, poses):
    """Return the target that can be met first, and the meeting."""
    target, first = -1, HandMeeting(1e300, False, view.x, view.y)
    for b in range(scene.bodies.rows.shape[0]):
        if scene.bodies.rows[b, PART] != HAND:
            continue
        new = meeting_with(scene, catch, b, view, poses)
        sooner = new.found == first.found and new.time < first.time
        if target < 0 or (new.found and not first.found) or sooner:
            target, first = b, new
    return target, first


@njit(_nrt=False)
def _tell_arm(scene, rules, view, dt, row):
    rho, speed = scene.limb.rho, scene.limits.speed
    ex, ey = elbow_of(view.x, view.y, rho, 1.0)
    row[0] = np.sqrt(view.x * view.x + view.y * view.y)
    row[1] = rho
    _put_turned(row, 2, view, ex, ey)
    row[4] = scene.limb.thickness
    _put(row, 5, rules.catch)
    _put(row, 6, speed * (scene.limits.horizon - view.t))
    _put(row, 7, speed * dt)
    # Slow joints count, fast ones are as good as no limit.
    row[8] = 1.0 / (1.0 + scene.limits.shoulder / speed)
    row[9] = 1.0 / (1.0 + scene.limits.elbow / speed)


@njit(_nrt=False)
def _swing_motion(bodies, b, t, poses):
    """Velocity (3) and acceleration (2) of a body that swings, by differences."""
    h = 1e-3
    x0, y0, z0 = swing(bodies, b, t, poses)
    x1, y1, z1 = swing(bodies, b, t + h, poses)
    x2, y2, _ = swing(bodies, b, t + 2.0 * h, poses)
    swing(bodies, b, t, poses)
    ax, ay = (x2 - 2.0 * x1 + x0) / h**2, (y2 - 2.0 * y1 + y0) / h**2
    return (x1 - x0) / h, (y1 - y0) / h, (z1 - z0) / h, ax, ay


@njit(_nrt=False, forceinline=True)
def _tell_motion(scene, b, view, poses, row, at):
    """Write velocity (3) and acceleration (2) of body b."""
    body, t, speed = scene.bodies.rows, view.t, scene.limits.speed
    if body[b, SWING] < 0.0:
        vx = body[b, VELOCITY] + body[b, ACCELERATION] * t
        vy = body[b, VELOCITY + 1] + body[b, ACCELERATION + 1] * t
        vz = body[b, VELOCITY + 2] + body[b, ACCELERATION + 2] * t
        ax, ay = body[b, ACCELERATION], body[b, ACCELERATION + 1]
    else:
        vx, vy, vz, ax, ay = _swing_motion(scene.bodies, b, t, poses)
    _put_turned(row, at, view, vx / speed, vy / speed)
    _put(row, at + 2, abs(vz / speed))
    _put_turned(row, at + 3, view, ax / speed**2, ay / speed**2)


@njit(_nrt=False)
def _tell_target(scene, catch, b, view, first, poses, row):
    bodies, speed = scene.bodies, scene.limits.speed
    if bodies.rows[b, SWING] >= 0.0:
        pose_at(bodies, b, view.t, poses)
    else:
        poses[b, 0], poses[b, 1], poses[b, 2] = glide(bodies, b, view.t, poses)
    dx, dy = poses[b, 0] - view.x, poses[b, 1] - view.y
    _put_turned(row, ARM, view, dx, dy)
    _put(row, ARM + 2, abs(poses[b, 2]))
    _tell_motion(scene, b, view, poses, row, ARM + 3)
    row[ARM + 8] = bodies.rows[b, REACH]
    _put(row, ARM + 9, np.sqrt(dx * dx + dy * dy) - bodies.rows[b, REACH] - catch)
    row[ARM + 10] = 1.0 if first.found else 0.0
    _put(row, ARM + 11, speed * (first.time - view.t))
    wx, wy = first.x - view.x, first.y - view.y
    _put_turned(row, ARM + 12, view, wx, wy)
    length = max(np.sqrt(wx * wx + wy * wy), 1e-9)
    _put_turned(row, ARM + 14, view, wx / length, wy / length)
    _put(row, ARM + 16, np.sqrt(first.x * first.x + first.y * first.y))


@njit(_nrt=False)
def _look_ahead(scene, view, first, workspace):
    """Find how near each obstacle comes to the limb on the straight way to the meeting, and when.

    Written into the workspace's `gaps`, for each body LEAST, LATE and NOW; LEAST of targets is
    1e300.
    """
    bodies, far, rho = scene.bodies, scene.limb.far, scene.limb.rho
    moments, gaps = workspace.moments, workspace.gaps
    x, y, t, gx, gy = view.x, view.y, view.t, first.x, first.y
    r = np.sqrt(gx * gx + gy * gy)
    if r > far:
        gx, gy = gx * far / r, gy * far / r
    # A target that is not met in time is approached as fast as the hand can.
    length = max(np.sqrt((gx - x) ** 2 + (gy - y) ** 2), 1e-9)
    share = min(scene.limits.speed * (first.time - t) / length, 1.0)
    for k in range(MOMENTS):
        f = k / (MOMENTS - 1)
        hx, hy = x + f * share * (gx - x), y + f * share * (gy - y)
        nearness.place_limb(moments, k, t + f * (first.time - t), hx, hy, rho)
    n, vague = bodies.rows.shape[0], 0
    for b in range(n):
        gaps[b, LEAST] = 1e300
        if bodies.rows[b, PART] == HAND:
            continue
        if nearness.follow(bodies, b, MOMENTS, moments):
            _note(b, moments, gaps)
        else:
            gaps[b, LEAST], vague = -1.0, vague + 1
    for b in range(n if vague > 0 else 0):
        if gaps[b, LEAST] < 0.0:
            nearness.exactly(bodies, b, MOMENTS, moments, workspace.poses, True)
            _note(b, moments, gaps)


@njit(_nrt=False, forceinline=True)
def _note(b, moments, gaps):
    """Write the least gap of body b over all moments, its moment (0 to 1), and the first gap."""
    least, late = 1e300, 0
    for k in range(MOMENTS):
        room = max(moments[k, nearness.ROOM], 0.0)
        if room < least:
            least, late = room, k
    gaps[b, LEAST], gaps[b, LATE] = least, late / (MOMENTS - 1)
    gaps[b, NOW] = max(moments[0, nearness.ROOM], 0.0)


@njit(_nrt=False)
def _tell_obstacles(scene, floor, view, slots, workspace, row):
    """Write the `slots` obstacles that come nearest; return the index in `row` after them."""
    moments, gaps = workspace.moments, workspace.gaps
    ex, ey = moments[0, nearness.ELBOW_X], moments[0, nearness.ELBOW_Y]
    for k in range(2):  # moments of a limb that rests
        later = min(view.t + 0.3 * (k + 1) / scene.limits.speed, scene.limits.horizon)
        moments[k, nearness.TIME], moments[k, nearness.HAND_X], moments[k, nearness.HAND_Y] = (
            later,
            view.x,
            view.y,
        )
        moments[k, nearness.ELBOW_X], moments[k, nearness.ELBOW_Y] = ex, ey
    at = ARM + TARGET
    for _ in range(slots):
        b = 0
        for other in range(1, scene.bodies.rows.shape[0]):
            if gaps[other, LEAST] < gaps[b, LEAST]:
                b = other
        if gaps[b, LEAST] >= 1e300:
            for k in range(at, at + OBSTACLE):
                row[k] = 0.0
        else:
            _tell_obstacle(scene, floor, b, view, workspace, row, at)
            gaps[b, LEAST] = 1e300
        at += OBSTACLE
    return at


@njit(_nrt=False)
def _tell_obstacle(scene, floor, b, view, workspace, row, at):
    bodies, speed, poses = scene.bodies, scene.limits.speed, workspace.poses
    moments, gaps = workspace.moments, workspace.gaps
    if bodies.rows[b, BALL] > 0.0 and bodies.rows[b, SWING] < 0.0:
        poses[b, 0], poses[b, 1], poses[b, 2] = glide(bodies, b, view.t, poses)
    else:
        pose_at(bodies, b, view.t, poses)
    row[at] = 1.0
    _put_turned(row, at + 1, view, poses[b, 0] - view.x, poses[b, 1] - view.y)
    _put(row, at + 3, abs(poses[b, 2]))
    _tell_motion(scene, b, view, poses, row, at + 4)
    row[at + 9] = bodies.rows[b, REACH]
    ax, ay, az = bodies.rows[b, LONG], bodies.rows[b, LONG + 1], bodies.rows[b, LONG + 2]
    dx = poses[b, 3] * ax + poses[b, 4] * ay + poses[b, 5] * az
    dy = poses[b, 6] * ax + poses[b, 7] * ay + poses[b, 8] * az
    dx, dy = view.c * dx + view.s * dy, view.c * dy - view.s * dx
    length = np.sqrt(dx * dx + dy * dy)
    # Twice the angle: an axis has no head.
    _put(row, at + 10, (dx * dx - dy * dy) / length if length > 0.0 else 0.0)
    _put(row, at + 11, 2.0 * dx * dy / length if length > 0.0 else 0.0)
    _put(row, at + 12, bodies.rows[b, SPIN + 2] / speed * length)
    row[at + 13] = min(gaps[b, NOW] - floor, _FARTHEST)
    row[at + 14] = min(gaps[b, LEAST] - floor, _FARTHEST)
    row[at + 15] = gaps[b, LATE]
    row[at + 16] = 1.0 if gaps[b, LEAST] <= floor else 0.0
    if not nearness.follow(bodies, b, 2, moments):
        nearness.exactly(bodies, b, 2, moments, poses, False)
    for k in range(2):  # how near it comes to a limb that rests
        row[at + 17 + k] = min(max(moments[k, nearness.ROOM], 0.0) - floor, _FARTHEST)
    row[at + 19] = np.sqrt(moments[1, nearness.X] ** 2 + moments[1, nearness.Y] ** 2)
