"""Fan of a spatial arm: 30 commands around the straight command, and the results of each.

Commands of joints, in shares of their greatest speeds, are vectors in four dimensions. The fan has
a frame there. Its first vectors are the straight command, the command that moves only the elbow,
and the command that moves the hand outward. The last one is orthogonal to these. The straight
command turned towards the other three by some angles gives the rays. Two more rays are half of
it, and rest.
"""

from __future__ import annotations

import itertools

import numpy as np

from gcm_learn.arms.limbs import dof, hand_of, jacobian, place, still
from gcm_learn.collision.postures import gap_to
from gcm_learn.compiled import njit
from gcm_learn.execution.arena.kernels.joints.meeting import AIM_ROW
from gcm_learn.scene.bodies import REACH, centre_at

FRAME = 16  # numbers of the frame: four unit vectors, the straight command first
RAY = 3  # numbers of a ray
TIMES = np.array([0.06, 0.15, 0.3, 0.5, 0.8, 1.2])  # at which a ray is sampled [units of time]
ROOM = 0.15  # clearances beyond are alike [reaches]
_GAP = 1.0  # the same of gaps to the target [reaches]
_INDEPENDENT = 0.2  # share of a vector that must be left when others are taken out of it


def _directions() -> np.ndarray:
    """Rays (30, 4) in the frame: straight, turned by 30 to 120 degrees, back, half, rest."""
    sides = [s * np.eye(3)[k] for k in range(3) for s in (1.0, -1.0)]
    corners = [np.array(c) / np.sqrt(3.0) for c in itertools.product((1.0, -1.0), repeat=3)]
    rows = [np.array([1.0, 0.0, 0.0, 0.0])]
    for angle, ways in ((30, sides), (60, sides + corners), (90, sides)):
        turn = np.radians(angle)
        rows += [np.append(np.cos(turn), np.sin(turn) * way) for way in ways]
    rows += [np.array([-1.0, 0.0, 0.0, 0.0]), np.array([1.0, 0.0, 0.0, 0.0]), np.zeros(4)]
    return np.array(rows)


DIRECTIONS = _directions()
COMMANDS, COMMAND = DIRECTIONS.shape  # rays, and numbers of a command
STRAIGHT, HALF, REST = 0, COMMANDS - 2, COMMANDS - 1


@njit(_nrt=False)
def command_of(row, aim, frame, ray, out):
    """Write the command (4,) of a ray, from the aim and the fan's frame in an observation.

    Parameters
    ----------
    row : (width,) ndarray
    aim, frame : int
        Where they begin.
    """
    if ray == STRAIGHT or ray >= HALF:
        share = 1.0 if ray == STRAIGHT else (0.5 if ray == HALF else 0.0)
        for j in range(4):
            out[j] = share * row[aim + j]
        return
    top = 0.0
    for j in range(4):
        out[j] = 0.0
        for i in range(4):
            out[j] += DIRECTIONS[ray, i] * row[frame + 4 * i + j]
        top = max(top, abs(out[j]))
    for j in range(4):
        out[j] /= top


@njit
def commands_of(observations, aim, frame, rays, out):
    """Write the commands (n, 4) of rays (n,) under observations (n, width)."""
    for k in range(rays.size):
        command_of(observations[k], aim, frame, rays[k], out[k])


@njit(_nrt=False)
def _across(a, row, at, out):
    """Write a vector orthogonal to three vectors (4,): rows of `a`, or in `row` from `at` on."""
    for j in range(4):
        p, q, r = (j + 1) % 4, (j + 2) % 4, (j + 3) % 4
        if at >= 0:
            x0, x1, x2 = row[at + p], row[at + q], row[at + r]
            y0, y1, y2 = row[at + 4 + p], row[at + 4 + q], row[at + 4 + r]
            z0, z1, z2 = row[at + 8 + p], row[at + 8 + q], row[at + 8 + r]
        else:
            x0, x1, x2 = a[0, p], a[0, q], a[0, r]
            y0, y1, y2 = a[1, p], a[1, q], a[1, r]
            z0, z1, z2 = a[2, p], a[2, q], a[2, r]
        whole = (
            x0 * (y1 * z2 - y2 * z1) - x1 * (y0 * z2 - y2 * z0) + x2 * (y0 * z1 - y1 * z0)
        )  # fmt: skip
        out[j] = whole if j % 2 == 0 else -whole


@njit(_nrt=False)
def _lay_frame(view, posture, e, row, at):
    """Write the frame of the fan: orthonormal, by Gram and Schmidt."""
    limb, limits, slopes = view.scene.limb, view.scene.limits, view.jacobian
    aim, elbow, outward, unit = view.rates[AIM_ROW], view.rates[0], view.rates[1], view.rates[2]
    for j in range(dof(limb)):
        view.joints[1, j] = posture[e, j]
    hx, hy, hz = hand_of(limb, place(limb, view.joints[1]))
    jacobian(limb, view.joints[1], slopes)
    for j in range(dof(limb)):
        for i in range(3):
            slopes[i, j] *= limits.joint_speed[j]
        outward[j] = slopes[0, j] * hx + slopes[1, j] * hy + slopes[2, j] * hz
    _across(slopes, row, -1, elbow)
    count = 0
    for k in range(7):
        for j in range(4):
            unit[j] = 1.0 if j == k - 3 else 0.0
        one = aim if k == 0 else (elbow if k == 1 else (outward if k == 2 else unit))
        if count < 3 and _add(one, row, at, count):
            count += 1
    _across(slopes, row, at, unit)
    for j in range(4):
        row[at + 12 + j] = unit[j]


@njit(_nrt=False)
def _add(vector, row, at, count):
    """Add a vector's part orthogonal to the frame's first `count`; False if it is too small."""
    size = np.sqrt(vector[0] ** 2 + vector[1] ** 2 + vector[2] ** 2 + vector[3] ** 2)
    if size < 1e-9:
        return False
    for j in range(4):
        vector[j] /= size
    for i in range(count):
        along = 0.0
        for j in range(4):
            along += vector[j] * row[at + 4 * i + j]
        for j in range(4):
            vector[j] -= along * row[at + 4 * i + j]
    size = np.sqrt(vector[0] ** 2 + vector[1] ** 2 + vector[2] ** 2 + vector[3] ** 2)
    if size < _INDEPENDENT:
        return False
    for j in range(4):
        row[at + 4 * count + j] = vector[j] / size
    return True


@njit(_nrt=False)
def tell_fan(view, time, posture, e, body, aim, row, at):
    """Write the frame of the fan, then the free time, clearance and target gap of every ray.

    Parameters
    ----------
    view : View
        The aim is in its rates, and is lost.
    time : float
        [s]
    posture : (arms, 2 dof) ndarray
    e : int
        The arm.
    body : int
        The target that can be met first.
    aim : int
        Where in the row the straight command is.
    row : (width,) ndarray
        FRAME numbers and RAY for each command are written, from `at` on.
    """
    _lay_frame(view, posture, e, row, at)
    jacobian(view.scene.limb, view.joints[1], view.jacobian)
    for ray in range(COMMANDS):
        _look(view, time, posture, e, body, aim, ray, row, at)


@njit(_nrt=False)
def _look(view, time, posture, e, body, aim, ray, row, at):
    """Write the free time of a ray, its clearance until then, and its least gap to the target."""
    scene, unit, rates = view.scene, view.reach / view.pace, view.rates[0]
    limb = scene.limb
    bodies, poses, which = scene.bodies, view.desk.poses, view.desk.obstacles
    command_of(row, aim, at, ray, rates)
    _slow_down(view, rates)
    free, room, gap = 0.0, ROOM * view.reach, _GAP * view.reach
    for k in range(TIMES.size):
        after = TIMES[k] * unit
        now = min(time + after, scene.limits.horizon)
        _turn(scene, posture, e, rates, after, view.joints[1])
        where = place(limb, view.joints[1])
        least = room + view.rules.touch
        for i in range(which.size):
            found, _ = gap_to(limb, where, still(limb), bodies, which[i], now, 0.0, least, poses)
            least = min(least, found)
        if least <= view.rules.touch:
            room = 0.0
            break
        room, free = least - view.rules.touch, TIMES[k]
        if body >= 0:
            centre_at(bodies, body, now, poses)
            hx, hy, hz = hand_of(limb, where)
            x, y, z = poses[body, 0] - hx, poses[body, 1] - hy, poses[body, 2] - hz
            away = np.sqrt(x * x + y * y + z * z) - bodies.rows[body, REACH] - view.rules.catch
            gap = min(gap, away)
    to = at + FRAME + RAY * ray
    row[to], row[to + 1], row[to + 2] = free, room / view.reach, gap / view.reach


@njit(_nrt=False)
def _slow_down(view, rates):
    """Make a command (dof,) rates [rad/s], none of which makes the hand too fast."""
    limits, slopes, n = view.scene.limits, view.jacobian, dof(view.scene.limb)
    x = y = z = 0.0
    for j in range(n):
        rates[j] *= limits.joint_speed[j]
        x, y = x + slopes[0, j] * rates[j], y + slopes[1, j] * rates[j]
        z += slopes[2, j] * rates[j]
    speed = np.sqrt(x * x + y * y + z * z)
    if speed > limits.speed:
        for j in range(n):
            rates[j] *= limits.speed / speed


@njit(_nrt=False)
def _turn(scene, posture, e, rates, after, out):
    """Write the joints (dof,) `after` so long of going to rates (dof,) and then with them."""
    limb, limits, n = scene.limb, scene.limits, dof(scene.limb)
    for j in range(n):
        q, v = posture[e, j], posture[e, n + j]
        if limits.joint_acceleration[j] == np.inf:
            way = rates[j] * after
        else:
            ramp = min(abs(rates[j] - v) / limits.joint_acceleration[j], after)
            gain = np.sign(rates[j] - v) * limits.joint_acceleration[j] * ramp
            way = v * after + gain * (after - 0.5 * ramp)
        out[j] = min(max(q + way, limb.low[j]), limb.high[j])
