"""What an arm is told at every step: compiled code, and the table of its numbers.

All numbers are dimensionless: lengths in forearms, velocities in hand speeds, times as the way that
the hand can make in them. Vectors are in the frame of the moment, in which the hand is on the x
axis and the elbow on the right, so situations that are turned, mirrored or slowed down look the
same. Everything follows from the situation at t = 0 and the laws of motion.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.compiled import njit
from gcm_learn.envs.fan import tell_fan
from gcm_learn.envs.kernels import (
    FAR,
    FLOOR,
    GRASP,
    HORIZON,
    LONG,
    MOMENTS,
    NEAR,
    RHO,
    SPEED,
    THICKNESS,
    TURN_1,
    State,
    World,
    bodies_of,
    desk_for,
    step,
)
from gcm_learn.envs.nearness import (
    ELBOW_X,
    ELBOW_Y,
    HAND_X,
    HAND_Y,
    ROOM,
    TIME,
    X,
    Y,
    exactly,
    follow,
    place_limb,
)
from gcm_learn.scene.bodies import (
    ACCELERATION,
    DISC,
    HAND,
    KIND,
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
from gcm_learn.scene.limb import elbow_of

ARM, TARGET, OBSTACLE = 10, 17, 20  # numbers of the arm, the target, an obstacle
LEAST, LATE, NOW = range(3)  # of an obstacle on the straight way: least distance, when, at first
_INSTANTS = 16  # at which an interception is looked for
_BISECTIONS = 6
_FARTHEST = 2.0  # distances are told up to this
_EXTREME = 10.0  # no number is larger


@njit(forceinline=True)
def _missing(px, py, pz, radius, wait, x, y, speed, grasp, near, far):
    """What is missing for a hand at (x, y) to be at a target at p after `wait` seconds.

    At most 0 if it can; else hand and target need at least the time in which both together travel
    that far.
    """
    pz = abs(pz)
    if pz > radius:
        return pz - radius
    reach = np.sqrt(radius * radius - pz * pz) + grasp
    away = np.sqrt((px - x) ** 2 + (py - y) ** 2) - reach - speed * wait
    r = np.sqrt(px * px + py * py)
    return max(away, r - far - reach, near - reach - r)


@njit(_nrt=False, forceinline=True)
def _meeting_by(centre, bodies, b, since, x, y, arms, s, poses):
    """`meeting` of a body whose centre is found by a function: `glide` or `swing`."""
    end, speed, grasp = arms[s, HORIZON], arms[s, SPEED], arms[s, GRASP]
    near, far, radius = arms[s, NEAR], arms[s, FAR], bodies.rows[b, REACH]
    step = (end - since) / _INSTANTS
    stride = max((speed + bodies.rows[b, TOP_SPEED]) * step, 1e-9)
    k, before = 0, since
    while k <= _INSTANTS:
        t = since + step * k
        px, py, pz = centre(bodies, b, t, poses)
        missing = _missing(px, py, pz, radius, t - since, x, y, speed, grasp, near, far)
        if missing <= 0.0:
            low, high = before, t
            for _ in range(_BISECTIONS if k > 0 else 0):
                t = 0.5 * (low + high)
                px, py, pz = centre(bodies, b, t, poses)
                if _missing(px, py, pz, radius, t - since, x, y, speed, grasp, near, far) <= 0.0:
                    high = t
                else:
                    low = t
            px, py, _ = centre(bodies, b, high, poses)
            return high, True, px, py
        before = t
        k += max(int(missing / stride), 1)
    px, py, _ = centre(bodies, b, end, poses)
    return end, False, px, py


@njit(_nrt=False)
def meeting(bodies, b, since, x, y, arms, s, poses):
    """About when and where a straight way from (x, y) first meets target b.

    A look at 16 instants and a few bisections, with balls for bodies: good enough to be told.

    Returns
    -------
    time : float
        The horizon if there is none [s].
    found : bool
    px, py : float
        Where the target is then.
    """
    if bodies.rows[b, SWING] >= 0.0:
        return _meeting_by(swing, bodies, b, since, x, y, arms, s, poses)
    return _meeting_by(glide, bodies, b, since, x, y, arms, s, poses)


@njit(_nrt=False, forceinline=True)
def _put(out, e, k, value):
    out[e, k] = min(max(value, -_EXTREME), _EXTREME)


@njit(_nrt=False, forceinline=True)
def _put_turned(out, e, k, c, s, x, y):
    """Write the vector (x, y), turned into the frame of the moment."""
    _put(out, e, k, c * x + s * y)
    _put(out, e, k + 1, c * y - s * x)


@njit
def observe(world, state, e, slots, fan, dt, out, desk):
    """Write what arm e is told into row e of `out`."""
    s, arms = state.place[e], world.arms
    x, y, t = state.hand[e, 0], state.hand[e, 1], state.time[e]
    bodies, poses, gaps = bodies_of(world, s), desk.poses, desk.gaps
    n = bodies.rows.shape[0]
    r = np.sqrt(x * x + y * y)
    c, sn = (x / r, y / r) if r > 1e-12 else (1.0, 0.0)
    _tell_arm(arms, s, e, x, y, t, c, sn, dt, out)
    target, when, found, gx, gy = -1, 1e300, False, x, y
    for b in range(n):
        if bodies.rows[b, PART] != HAND:
            continue
        at, hit, px, py = meeting(bodies, b, t, x, y, arms, s, poses)
        if target < 0 or (hit and not found) or (hit == found and at < when):
            target, when, found, gx, gy = b, at, hit, px, py
    _tell_target(bodies, target, arms, s, e, t, x, y, c, sn, when, found, gx, gy, poses, out)
    _look_ahead(bodies, arms, s, t, x, y, when, gx, gy, desk.moments, gaps, poses)
    ex, ey = desk.moments[0, ELBOW_X], desk.moments[0, ELBOW_Y]
    for k in range(2):  # moments of a limb that rests, for what is told of obstacles
        later = min(t + 0.3 * (k + 1) / arms[s, SPEED], arms[s, HORIZON])
        desk.moments[k, TIME], desk.moments[k, HAND_X], desk.moments[k, HAND_Y] = later, x, y
        desk.moments[k, ELBOW_X], desk.moments[k, ELBOW_Y] = ex, ey
    for slot in range(slots):
        at, b = ARM + TARGET + slot * OBSTACLE, 0
        for other in range(1, n):
            if gaps[other, LEAST] < gaps[b, LEAST]:
                b = other
        if gaps[b, LEAST] >= 1e300:
            out[e, at : at + OBSTACLE] = 0.0
            continue
        _tell_obstacle(bodies, b, arms, s, e, at, t, x, y, c, sn, desk.moments, gaps, poses, out)
        gaps[b, LEAST] = 1e300
    if fan:
        dx, dy = gx - x, gy - y
        length = np.sqrt(dx * dx + dy * dy)
        dx, dy = (dx / length, dy / length) if length > 1e-9 else (c, sn)
        at = ARM + TARGET + slots * OBSTACLE
        tell_fan(bodies, arms, s, e, t, x, y, dx, dy, at, poses, out)


@njit(_nrt=False)
def _tell_arm(arms, s, e, x, y, t, c, sn, dt, out):
    rho, speed = arms[s, RHO], arms[s, SPEED]
    ex, ey = elbow_of(x, y, rho, 1.0)
    out[e, 0] = np.sqrt(x * x + y * y)
    out[e, 1] = rho
    _put_turned(out, e, 2, c, sn, ex, ey)
    out[e, 4] = arms[s, THICKNESS]
    _put(out, e, 5, arms[s, GRASP])
    _put(out, e, 6, speed * (arms[s, HORIZON] - t))
    _put(out, e, 7, speed * dt)
    for k in range(2):  # slow joints count, fast ones are as good as no limit
        limit = arms[s, TURN_1 + k]
        out[e, 8 + k] = 1.0 / (1.0 + limit / speed) if limit > 0.0 else 0.0


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
def _motion(bodies, b, t, speed, c, sn, poses, out, e, at):
    """Write velocity (3) and acceleration (2) of body b."""
    body = bodies.rows
    if body[b, SWING] < 0.0:
        vx = body[b, VELOCITY] + body[b, ACCELERATION] * t
        vy = body[b, VELOCITY + 1] + body[b, ACCELERATION + 1] * t
        vz = body[b, VELOCITY + 2] + body[b, ACCELERATION + 2] * t
        ax, ay = body[b, ACCELERATION], body[b, ACCELERATION + 1]
    else:
        vx, vy, vz, ax, ay = _swing_motion(bodies, b, t, poses)
    _put_turned(out, e, at, c, sn, vx / speed, vy / speed)
    _put(out, e, at + 2, abs(vz / speed))
    _put_turned(out, e, at + 3, c, sn, ax / speed**2, ay / speed**2)


@njit(_nrt=False)
def _tell_target(bodies, b, arms, s, e, t, x, y, c, sn, when, found, gx, gy, poses, out):
    at, speed = ARM, arms[s, SPEED]
    if bodies.rows[b, SWING] >= 0.0:
        pose_at(bodies, b, t, poses)
    else:
        poses[b, 0], poses[b, 1], poses[b, 2] = glide(bodies, b, t, poses)
    dx, dy = poses[b, 0] - x, poses[b, 1] - y
    _put_turned(out, e, at, c, sn, dx, dy)
    _put(out, e, at + 2, abs(poses[b, 2]))
    _motion(bodies, b, t, speed, c, sn, poses, out, e, at + 3)
    out[e, at + 8] = bodies.rows[b, REACH]
    _put(out, e, at + 9, np.sqrt(dx * dx + dy * dy) - bodies.rows[b, REACH] - arms[s, GRASP])
    out[e, at + 10] = 1.0 if found else 0.0
    _put(out, e, at + 11, speed * (when - t))
    wx, wy = gx - x, gy - y
    _put_turned(out, e, at + 12, c, sn, wx, wy)
    length = max(np.sqrt(wx * wx + wy * wy), 1e-9)
    _put_turned(out, e, at + 14, c, sn, wx / length, wy / length)
    _put(out, e, at + 16, np.sqrt(gx * gx + gy * gy))


@njit(_nrt=False)
def _look_ahead(bodies, arms, s, t, x, y, when, gx, gy, moments, gaps, poses):
    """How near each obstacle comes to the limb on the straight way to the meeting, and when.

    Written into `gaps`, for each body LEAST, LATE and NOW; LEAST of targets is 1e300.
    """
    far, rho = arms[s, FAR], arms[s, RHO]
    r = np.sqrt(gx * gx + gy * gy)
    if r > far:
        gx, gy = gx * far / r, gy * far / r
    # A target that is not met in time is approached as fast as the hand can.
    share = min(
        arms[s, SPEED] * (when - t) / max(np.sqrt((gx - x) ** 2 + (gy - y) ** 2), 1e-9), 1.0
    )
    for k in range(MOMENTS):
        f = k / (MOMENTS - 1)
        hx, hy = x + f * share * (gx - x), y + f * share * (gy - y)
        place_limb(moments, k, t + f * (when - t), hx, hy, rho)
    n, vague = bodies.rows.shape[0], 0
    for b in range(n):
        gaps[b, LEAST] = 1e300
        if bodies.rows[b, PART] == HAND:
            continue
        if follow(bodies, b, MOMENTS, moments):
            _note(b, moments, gaps)
        else:
            gaps[b, LEAST], vague = -1.0, vague + 1
    for b in range(n if vague > 0 else 0):
        if gaps[b, LEAST] < 0.0:
            exactly(bodies, b, MOMENTS, moments, poses, True)
            _note(b, moments, gaps)


@njit(_nrt=False, forceinline=True)
def _note(b, moments, gaps):
    """Write the least room of all moments, when it is, and that of the first."""
    least, late = 1e300, 0
    for k in range(MOMENTS):
        room = max(moments[k, ROOM], 0.0)
        if room < least:
            least, late = room, k
    gaps[b, LEAST], gaps[b, LATE] = least, late / (MOMENTS - 1)
    gaps[b, NOW] = max(moments[0, ROOM], 0.0)


@njit(_nrt=False)
def _tell_obstacle(bodies, b, arms, s, e, at, t, x, y, c, sn, moments, gaps, poses, out):
    speed, floor, gap = arms[s, SPEED], arms[s, FLOOR], gaps[b, LEAST]
    if bodies.rows[b, KIND] == DISC and bodies.rows[b, SWING] < 0.0:
        poses[b, 0], poses[b, 1], poses[b, 2] = glide(bodies, b, t, poses)
    else:
        pose_at(bodies, b, t, poses)
    out[e, at] = 1.0
    _put_turned(out, e, at + 1, c, sn, poses[b, 0] - x, poses[b, 1] - y)
    _put(out, e, at + 3, abs(poses[b, 2]))
    _motion(bodies, b, t, speed, c, sn, poses, out, e, at + 4)
    out[e, at + 9] = bodies.rows[b, REACH]
    ax, ay, az = bodies.rows[b, LONG], bodies.rows[b, LONG + 1], bodies.rows[b, LONG + 2]
    dx = poses[b, 3] * ax + poses[b, 4] * ay + poses[b, 5] * az
    dy = poses[b, 6] * ax + poses[b, 7] * ay + poses[b, 8] * az
    dx, dy = c * dx + sn * dy, c * dy - sn * dx
    length = np.sqrt(dx * dx + dy * dy)
    # Twice the angle: an axis has no head.
    _put(out, e, at + 10, (dx * dx - dy * dy) / length if length > 0.0 else 0.0)
    _put(out, e, at + 11, 2.0 * dx * dy / length if length > 0.0 else 0.0)
    _put(out, e, at + 12, bodies.rows[b, SPIN + 2] / speed * length)
    out[e, at + 13] = min(gaps[b, NOW] - floor, _FARTHEST)
    out[e, at + 14] = min(gap - floor, _FARTHEST)
    out[e, at + 15] = gaps[b, LATE]
    out[e, at + 16] = 1.0 if gap <= floor else 0.0
    if not follow(bodies, b, 2, moments):
        exactly(bodies, b, 2, moments, poses, False)
    for k in range(2):  # how near it comes to a limb that rests
        out[e, at + 17 + k] = min(max(moments[k, ROOM], 0.0) - floor, _FARTHEST)
    out[e, at + 19] = np.sqrt(moments[1, X] ** 2 + moments[1, Y] ** 2)


@njit(nogil=True)
def observe_all(world, state, chosen, slots, fan, dt, out):
    """Write what the arms `chosen` (k,) are told into their rows of `out`.

    World and state come as plain tuples: of named ones, finding the types takes as long as a step.
    """
    worlds, states = World(*world), State(*state)
    desk = desk_for(worlds, states, 0, states.place.size)
    for k in range(chosen.size):
        observe(worlds, states, chosen[k], slots, fan, dt, out, desk)


@njit(nogil=True)
def play(
    world, state, actions, control, joint_rate, dt, weights, discount, slots, fan, outcomes,
    rewards, out, first, last,
):  # fmt: skip
    """Arms first to last - 1 make a step and are told of it; tuples as of `observe_all`."""
    worlds, states = World(*world), State(*state)
    desk = desk_for(worlds, states, first, last)
    for e in range(first, last):
        step(worlds, states, e, actions, control, joint_rate, dt, weights, discount, outcomes,
             rewards, desk)  # fmt: skip
        observe(worlds, states, e, slots, fan, dt, out, desk)
