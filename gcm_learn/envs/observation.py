"""What an arm is told at every step: compiled code, and the table of its numbers.

All numbers are dimensionless: lengths in forearms, velocities in hand speeds, times as the way that
the hand can make in them. Vectors are in the frame of the moment, in which the hand is on the x
axis and the elbow on the right, so situations that are turned, mirrored or slowed down look the
same. Everything follows from the situation at t = 0 and the laws of motion.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from gcm_learn.arm.kinematics import elbow_of
from gcm_learn.envs.kernels import (
    FAR,
    FLOOR,
    GRASP,
    HORIZON,
    NEAR,
    RHO,
    SPEED,
    THICKNESS,
    TURN_1,
    bodies_of,
    step_all,
)
from gcm_learn.memory.features import long_axis
from gcm_learn.situation.kernels import (
    ACCELERATION,
    DISC,
    HAND,
    KIND,
    PART,
    POSITION,
    REACH,
    SPIN,
    SWING,
    TOP_SPEED,
    VELOCITY,
    arm_distance,
    pose_at,
    segment_point2,
)

ARM, TARGET, OBSTACLE, RAY = 10, 17, 20, 2  # numbers of the arm, the target, an obstacle, a ray
RAYS = 25  # of a fan: directions, the first to the meeting with the target, and last to rest
REACHES = np.array([0.06, 0.12, 0.2, 0.3, 0.45, 0.65, 0.9])  # ways along a ray [forearm lengths]
_LOOKS = 5  # instants on the straight way to the target
_INSTANTS = 16  # at which an interception is looked for
_BISECTIONS = 6
_CLOSE = 0.15  # nearer than this, bodies count instead of the balls that hold them
_FARTHEST = 2.0  # distances are told up to this
_EXTREME = 10.0  # no number is larger


@njit(cache=True, forceinline=True)
def _centre(bodies, b, t, poses):
    """Put the centre of body b at time t into its pose; the rotation only if it comes with it."""
    body = bodies.rows
    if body[b, SWING] >= 0.0:
        pose_at(bodies, b, t, poses)
        return
    half = 0.5 * t * t
    for k in range(3):
        start = body[b, POSITION + k]
        poses[b, k] = start + body[b, VELOCITY + k] * t + body[b, ACCELERATION + k] * half


@njit(cache=True, forceinline=True)
def _missing(bodies, b, t, since, x, y, speed, grasp, near, far, poses):
    """What is missing for a hand that leaves (x, y) at `since` to be at target b at t.

    At most 0 if it can; else hand and target need at least the time in which both together travel
    that far.
    """
    _centre(bodies, b, t, poses)
    px, py, pz = poses[b, 0], poses[b, 1], abs(poses[b, 2])
    reach = bodies.rows[b, REACH]
    if pz > reach:
        return pz - reach
    reach = np.sqrt(reach * reach - pz * pz) + grasp
    away = np.sqrt((px - x) ** 2 + (py - y) ** 2) - reach - speed * (t - since)
    r = np.sqrt(px * px + py * py)
    return max(away, r - far - reach, near - reach - r)


@njit(cache=True)
def meeting(bodies, b, since, x, y, arms, s, poses):
    """About when and where a straight way from (x, y) first meets target b: (time, found).

    A look at 16 instants and a few bisections, with balls for bodies: good enough to be told.
    The pose of b is left at that time, or at the horizon if there is none.
    """
    end, speed, grasp = arms[s, HORIZON], arms[s, SPEED], arms[s, GRASP]
    near, far = arms[s, NEAR], arms[s, FAR]
    step = (end - since) / _INSTANTS
    stride = max((speed + bodies.rows[b, TOP_SPEED]) * step, 1e-9)
    k, before = 0, since
    while k <= _INSTANTS:
        t = since + step * k
        missing = _missing(bodies, b, t, since, x, y, speed, grasp, near, far, poses)
        if missing <= 0.0:
            low, high = before, t
            for _ in range(_BISECTIONS if k > 0 else 0):
                middle = 0.5 * (low + high)
                if _missing(bodies, b, middle, since, x, y, speed, grasp, near, far, poses) <= 0.0:
                    high = middle
                else:
                    low = middle
            _centre(bodies, b, high, poses)
            return high, True
        before = t
        k += max(int(missing / stride), 1)
    _centre(bodies, b, end, poses)
    return end, False


@njit(cache=True, forceinline=True)
def _put(out, e, k, value):
    out[e, k] = min(max(value, -_EXTREME), _EXTREME)


@njit(cache=True, forceinline=True)
def _put_turned(out, e, k, c, s, x, y):
    """Write the vector (x, y), turned into the frame of the moment."""
    _put(out, e, k, c * x + s * y)
    _put(out, e, k + 1, c * y - s * x)


@njit(cache=True, forceinline=True)
def _limb_gap(bodies, b, t, poses, hx, hy, ex, ey, enough):
    """Distance of the limb to body b at time t, or to its ball while that is far.

    Bodies whose ball is not nearer than `enough` are not looked at any closer.
    """
    _centre(bodies, b, t, poses)
    x, y, z = poses[b, 0], poses[b, 1], poses[b, 2]
    d2 = min(segment_point2(x, y, ex, ey, hx, hy), segment_point2(x, y, 0.0, 0.0, ex, ey))
    room = np.sqrt(d2 + z * z) - bodies.rows[b, REACH]
    if room > _CLOSE or room >= enough or bodies.rows[b, KIND] == DISC:
        return max(room, 0.0)
    pose_at(bodies, b, t, poses)
    return arm_distance(bodies, poses, b, hx, hy, ex, ey)


@njit(cache=True)
def observe(world, state, e, slots, fan, dt, out):
    """Write what arm e is told into row e of `out`."""
    s, arms = state.place[e], world.arms
    x, y, t = state.hand[e, 0], state.hand[e, 1], state.time[e]
    bodies = bodies_of(world, s)
    n = bodies.rows.shape[0]
    poses = np.zeros((n, 12))
    r = np.sqrt(x * x + y * y)
    c, sn = (x / r, y / r) if r > 1e-12 else (1.0, 0.0)
    _tell_arm(arms, s, e, x, y, t, c, sn, dt, out)
    target, when, found, gx, gy = -1, 1e300, False, x, y
    for b in range(n):
        if bodies.rows[b, PART] != HAND:
            continue
        at, hit = meeting(bodies, b, t, x, y, arms, s, poses)
        if target < 0 or (hit and not found) or (hit == found and at < when):
            target, when, found = b, at, hit
            gx, gy = poses[b, 0], poses[b, 1]
    _tell_target(bodies, target, arms, s, e, t, x, y, c, sn, when, found, gx, gy, poses, out)
    gap, late, now = np.full(n, 1e300), np.zeros(n), np.zeros(n)
    _look_ahead(bodies, arms, s, t, x, y, when, gx, gy, gap, late, now, poses)
    for slot in range(slots):
        at = ARM + TARGET + slot * OBSTACLE
        b = int(np.argmin(gap))
        if gap[b] >= 1e300:
            for k in range(OBSTACLE):
                out[e, at + k] = 0.0
            continue
        _tell_obstacle(bodies, b, arms, s, e, at, t, x, y, c, sn, gap[b], late[b], now[b], poses,
                       out)  # fmt: skip
        gap[b] = 1e300
    if fan:
        dx, dy = gx - x, gy - y
        length = np.sqrt(dx * dx + dy * dy)
        dx, dy = (dx / length, dy / length) if length > 1e-9 else (c, sn)
        at = ARM + TARGET + slots * OBSTACLE
        _tell_fan(bodies, arms, s, e, t, x, y, dx, dy, at, poses, out)


@njit(cache=True)
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


@njit(cache=True)
def _motion(bodies, b, t, speed, c, sn, poses, out, e, at):
    """Write velocity (3) and acceleration (2) of body b, by differences if it swings."""
    body = bodies.rows
    if body[b, SWING] < 0.0:
        vx = (body[b, VELOCITY] + body[b, ACCELERATION] * t) / speed
        vy = (body[b, VELOCITY + 1] + body[b, ACCELERATION + 1] * t) / speed
        vz = (body[b, VELOCITY + 2] + body[b, ACCELERATION + 2] * t) / speed
        ax, ay = body[b, ACCELERATION] / speed**2, body[b, ACCELERATION + 1] / speed**2
    else:
        h = 1e-3
        x0, y0, z0 = poses[b, 0], poses[b, 1], poses[b, 2]
        pose_at(bodies, b, t + h, poses)
        x1, y1, z1 = poses[b, 0], poses[b, 1], poses[b, 2]
        pose_at(bodies, b, t + 2.0 * h, poses)
        vx, vy, vz = (x1 - x0) / h / speed, (y1 - y0) / h / speed, (z1 - z0) / h / speed
        ax = (poses[b, 0] - 2.0 * x1 + x0) / (h * speed) ** 2
        ay = (poses[b, 1] - 2.0 * y1 + y0) / (h * speed) ** 2
        pose_at(bodies, b, t, poses)
    _put_turned(out, e, at, c, sn, vx, vy)
    _put(out, e, at + 2, abs(vz))
    _put_turned(out, e, at + 3, c, sn, ax, ay)


@njit(cache=True)
def _tell_target(bodies, b, arms, s, e, t, x, y, c, sn, when, found, gx, gy, poses, out):
    at, speed = ARM, arms[s, SPEED]
    _centre(bodies, b, t, poses)
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


@njit(cache=True)
def _look_ahead(bodies, arms, s, t, x, y, when, gx, gy, gap, late, now, poses):
    """How near each obstacle comes to the limb on the straight way to the meeting, and when."""
    far, rho = arms[s, FAR], arms[s, RHO]
    r = np.sqrt(gx * gx + gy * gy)
    if r > far:
        gx, gy = gx * far / r, gy * far / r
    # A target that is not met in time is approached as fast as the hand can.
    share = min(
        arms[s, SPEED] * (when - t) / max(np.sqrt((gx - x) ** 2 + (gy - y) ** 2), 1e-9), 1.0
    )
    for look in range(_LOOKS + 1):
        f = look / _LOOKS
        hx, hy = x + f * share * (gx - x), y + f * share * (gy - y)
        ex, ey = elbow_of(hx, hy, rho, 1.0)
        for b in range(bodies.rows.shape[0]):
            if bodies.rows[b, PART] == HAND:
                continue
            d = _limb_gap(bodies, b, t + f * (when - t), poses, hx, hy, ex, ey, gap[b])
            if look == 0:
                now[b] = d
            if d < gap[b]:
                gap[b], late[b] = d, f


@njit(cache=True)
def _tell_obstacle(bodies, b, arms, s, e, at, t, x, y, c, sn, gap, late, now, poses, out):
    speed, floor = arms[s, SPEED], arms[s, FLOOR]
    pose_at(bodies, b, t, poses)
    out[e, at] = 1.0
    _put_turned(out, e, at + 1, c, sn, poses[b, 0] - x, poses[b, 1] - y)
    _put(out, e, at + 3, abs(poses[b, 2]))
    _motion(bodies, b, t, speed, c, sn, poses, out, e, at + 4)
    out[e, at + 9] = bodies.rows[b, REACH]
    dx, dy = long_axis(bodies, b, poses)
    dx, dy = c * dx + sn * dy, c * dy - sn * dx
    length = np.sqrt(dx * dx + dy * dy)
    # Twice the angle: an axis has no head.
    _put(out, e, at + 10, (dx * dx - dy * dy) / length if length > 0.0 else 0.0)
    _put(out, e, at + 11, 2.0 * dx * dy / length if length > 0.0 else 0.0)
    _put(out, e, at + 12, bodies.rows[b, SPIN + 2] / speed * length)
    out[e, at + 13] = min(now - floor, _FARTHEST)
    out[e, at + 14] = min(gap - floor, _FARTHEST)
    out[e, at + 15] = late
    out[e, at + 16] = 1.0 if gap <= floor else 0.0
    ex, ey = elbow_of(x, y, arms[s, RHO], 1.0)
    for k in range(2):  # how near it comes to a limb that rests
        later = min(t + 0.3 * (k + 1) / speed, arms[s, HORIZON])
        gap = _limb_gap(bodies, b, later, poses, x, y, ex, ey, 1e300)
        out[e, at + 17 + k] = min(gap - floor, _FARTHEST)
    out[e, at + 19] = np.sqrt(poses[b, 0] ** 2 + poses[b, 1] ** 2)


@njit(cache=True)
def _tell_fan(bodies, arms, s, e, t, x, y, c, sn, at, poses, out):
    """For every ray how far the hand can go before the limb touches, and how near it comes.

    The first ray is in direction (c, sn), the others follow counter-clockwise.
    """
    n, reaches = bodies.rows.shape[0], REACHES.size
    speed, floor, rho, horizon = arms[s, SPEED], arms[s, FLOOR], arms[s, RHO], arms[s, HORIZON]
    table = np.zeros((reaches * n, 12))  # poses of all bodies, instant by instant
    for j in range(reaches):
        for b in range(n):
            if bodies.rows[b, PART] != HAND:
                pose_at(bodies, b, min(t + REACHES[j] / speed, horizon), poses)
                for i in range(12):
                    table[j * n + b, i] = poses[b, i]
    for ray in range(RAYS):
        way, least, last = REACHES[reaches - 1], 0.5, 0.0
        phi = 2.0 * np.pi * ray / (RAYS - 1)
        dx, dy = np.cos(phi), np.sin(phi)
        dx, dy = c * dx - sn * dy, sn * dx + c * dy
        if ray == RAYS - 1:
            dx, dy = 0.0, 0.0
        for j in range(reaches):
            hx, hy = x + REACHES[j] * dx, y + REACHES[j] * dy
            r = np.sqrt(hx * hx + hy * hy)
            if r > arms[s, FAR] or r < arms[s, NEAR]:
                way = last
                break
            ex, ey = elbow_of(hx, hy, rho, 1.0)
            room = 0.5
            for b in range(n):
                if bodies.rows[b, PART] == HAND:
                    continue
                i = j * n + b
                px, py, pz = table[i, 0], table[i, 1], table[i, 2]
                d2 = segment_point2(px, py, ex, ey, hx, hy)
                d2 = min(d2, segment_point2(px, py, 0.0, 0.0, ex, ey))
                gap = np.sqrt(d2 + pz * pz) - bodies.rows[b, REACH] - floor
                if gap >= room:
                    continue
                if bodies.rows[b, KIND] != DISC:
                    for q in range(12):
                        poses[b, q] = table[i, q]
                    gap = arm_distance(bodies, poses, b, hx, hy, ex, ey) - floor
                room = min(room, gap)
            if room <= 0.0:
                way, least = last, 0.0
                break
            least, last = min(least, room), REACHES[j]
        out[e, at + RAY * ray], out[e, at + RAY * ray + 1] = way, least


@njit(cache=True)
def observe_all(world, state, chosen, slots, fan, dt, out):
    """Write what the arms `chosen` (k,) are told into their rows of `out`."""
    for k in range(chosen.size):
        observe(world, state, chosen[k], slots, fan, dt, out)


@njit(cache=True)
def play_all(
    world, state, actions, control, joint_rate, dt, weights, discount, slots, fan, outcomes,
    rewards, out,
):  # fmt: skip
    """`step_all`, then `observe` every arm: one call instead of two."""
    step_all(world, state, actions, control, joint_rate, dt, weights, discount, outcomes, rewards)
    for e in range(state.place.size):
        observe(world, state, e, slots, fan, dt, out)
