"""Kernels for moving bodies: pose at a time, bounds on displacement, distances to solids.

Everything is in arm-plane coordinates: x and y lie in the arm's plane, z along its normal.  The
limb always lies in z = 0, and the z of a planar body never matters.  A pose is a row of
12 numbers: the centre (3) and the rotation body -> plane, row by row (9).

Kernels take whole arrays and a body's index, never a row: in numba a view costs two atomic counts,
more than a distance to a disc. Handing arrays on costs as much for each of them. So kernels that do
not allocate are compiled without counting (``_nrt=False``; numba refuses it where an array is
made).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.compiled import njit

DISC, POLYGON, SPHERE, BOX, CAPSULE, CYLINDER, CLOUD, MESH = range(8)
HAND, LIMB = 0, 1  # which part of the arm a body can touch: targets only meet the hand


# Columns of a body's row.  One array instead of a dozen keeps calls between kernels cheap.
KIND = 0  # DISC ... MESH; `shapes/choice.py` branches on it
PART = 1  # HAND or LIMB
SIZE = 2  # 3 columns, whose meaning is that of the shape
REACH = 5  # radius of the ball about the centre that holds the body
POSITION = 6  # 3: centre at t = 0, or pivot of a pendulum
VELOCITY = 9  # 3
ACCELERATION = 12  # 3
SPIN = 15  # 3: angular velocity [rad/s]
TURN = 18  # 9: rotation at t = 0, row by row
SWING = 27  # entry of `angles`, -1 for quadratic motion
HANG = 28  # distance from the pivot to the centre
DOWN = 29  # 3: direction of the cord at angle 0
SIDE = 32  # 3: direction of growing angle, axis x down
AXIS = 35  # 3: rotation axis
FIRST, LAST = 38, 39  # the body's polygon or tree is vertices[FIRST:LAST]
TOP_SPEED = 40  # bound on the speed of any point of the body within the horizon
APPROACH = 41  # 3: direction in the body's frame from which a target is caught; 0 if any will do
WITHIN = 44  # largest angle of the hand's direction to it [rad]
TOWARDS = 45  # 3: that direction in the frame of the hand's joint; 0 for the hand's axis
SECOND = 7  # columns from an approach to the second one of the same target
PIECES = 55  # number of pieces in the entry of `angles`; 0 for a pendulum
BALL = 56  # 1 if the body is all of the ball that holds it, so that no turn can be seen
HOLD = 57  # how long a target is held after its catch [s]; -1 where a touch will do
HOLD_SPEED = 58  # largest speed of the hand relative to it in the hold [lengths/s]
MARGIN, MARGIN_RATE = 59, 60  # distance to be kept from an obstacle at t = 0, and how it grows
COLUMNS = 61

# Numbers of a piece; from POSITION to TURN they are those of a body's row.  They lie in `angles`,
# two in a row: a table of their own would be one array more to hand on, which slows all kernels.
START = 0  # time from which it holds [s]; its own time counts from there
JUMP, JUMP_TURN = 1, 2  # distance and angle [rad] to the end of the piece before it
PIECE_COLUMNS = 28
PIECE_ROWS = PIECE_COLUMNS // 2


class Bodies(NamedTuple):
    """A situation's bodies as plain arrays, in arm-plane coordinates."""

    rows: np.ndarray  # (n, COLUMNS): one body a row
    vertices: np.ndarray  # (m, 2): polygon vertices and trees of all bodies
    angles: np.ndarray  # (k, m, 2): pendulum angle and rate on a regular time grid; or pieces
    angle_step: float  # time step of that grid [s]


def no_bodies() -> Bodies:
    """Return the arrays of a situation without bodies."""
    return Bodies(np.zeros((0, COLUMNS)), np.zeros((0, 2)), np.zeros((0, 2, 2)), 1.0)


@njit(_nrt=False, forceinline=True)
def of_row(bodies, b, p, column):
    """Return the number in a column of body b, a body of one quadratic law; p is not used."""
    return bodies.rows[b, column]


@njit(_nrt=False, forceinline=True)
def of_piece(bodies, b, p, column):
    """Return the number in a column of piece p of body b."""
    return bodies.angles[int(bodies.rows[b, SWING]), PIECE_ROWS * p + column // 2, column % 2]


@njit(_nrt=False, forceinline=True)
def _turn(number, bodies, b, p, t, out):
    """Write exp([spin t]) @ turn of a law into out[b, 3:12] (Rodrigues' formula).

    The law's numbers come from a function: `of_row` or `of_piece`.
    """
    wx, wy = number(bodies, b, p, SPIN), number(bodies, b, p, SPIN + 1)
    wz = number(bodies, b, p, SPIN + 2)
    rate = np.sqrt(wx * wx + wy * wy + wz * wz)
    if rate == 0.0:
        for k in range(9):
            out[b, 3 + k] = number(bodies, b, p, TURN + k)
        return
    x, y, z = wx / rate, wy / rate, wz / rate
    s, c = np.sin(rate * t), np.cos(rate * t)
    v = 1.0 - c
    r00, r01, r02 = c + x * x * v, x * y * v - z * s, x * z * v + y * s
    r10, r11, r12 = y * x * v + z * s, c + y * y * v, y * z * v - x * s
    r20, r21, r22 = z * x * v - y * s, z * y * v + x * s, c + z * z * v
    for k in range(3):
        q, u = number(bodies, b, p, TURN + k), number(bodies, b, p, TURN + 3 + k)
        w = number(bodies, b, p, TURN + 6 + k)
        out[b, 3 + k] = r00 * q + r01 * u + r02 * w
        out[b, 6 + k] = r10 * q + r11 * u + r12 * w
        out[b, 9 + k] = r20 * q + r21 * u + r22 * w


@njit(_nrt=False)
def rotate(bodies, b, t, out):
    """Write the rotation at time t [s] of body b, of one quadratic law, into out[b, 3:]."""
    _turn(of_row, bodies, b, 0, t, out)


@njit(_nrt=False)
def piece_at(bodies, b, t):
    """Return the piece of body b that holds at time t [s]."""
    low, high = 0, int(bodies.rows[b, PIECES]) - 1
    while low < high:
        middle = (low + high + 1) // 2
        if of_piece(bodies, b, middle, START) <= t:
            low = middle
        else:
            high = middle - 1
    return low


@njit(_nrt=False)
def _piece_pose(bodies, b, t, out):
    p = piece_at(bodies, b, t)
    since = t - of_piece(bodies, b, p, START)
    half = 0.5 * since * since
    for k in range(3):
        way = of_piece(bodies, b, p, VELOCITY + k) * since
        way += of_piece(bodies, b, p, ACCELERATION + k) * half
        out[b, k] = of_piece(bodies, b, p, POSITION + k) + way
    if bodies.rows[b, BALL] == 0.0:
        _turn(of_piece, bodies, b, p, since, out)


@njit(_nrt=False)
def turn_at(bodies, b, t, out):
    """Write the rotation of body b at t [s] into out[b, 3:], of spheres too.

    Row b of `out` holds the pose, which leaves it out for bodies that look the same from all sides.
    """
    if bodies.rows[b, PIECES] > 0.0:
        p = piece_at(bodies, b, t)
        _turn(of_piece, bodies, b, p, t - of_piece(bodies, b, p, START), out)
    elif bodies.rows[b, SWING] < 0.0:
        rotate(bodies, b, t, out)


@njit(_nrt=False)
def top_spin(bodies, b):
    """Bound the angular speed of body b within the horizon [rad/s]."""
    row, count = bodies.rows, int(bodies.rows[b, PIECES])
    if count == 0 and row[b, SWING] >= 0.0:
        return row[b, TOP_SPEED] / (row[b, HANG] + row[b, REACH])
    most = row[b, SPIN] ** 2 + row[b, SPIN + 1] ** 2 + row[b, SPIN + 2] ** 2
    for p in range(count):
        spin = of_piece(bodies, b, p, SPIN) ** 2
        spin += of_piece(bodies, b, p, SPIN + 1) ** 2 + of_piece(bodies, b, p, SPIN + 2) ** 2
        most = max(most, spin)
    return np.sqrt(most)


@njit(_nrt=False)
def swing_angle(bodies, b, t):
    """Angle of pendulum b at time t: cubic Hermite interpolation in its table."""
    table, step = bodies.angles, bodies.angle_step
    row = int(bodies.rows[b, SWING])
    k = min(max(int(t / step), 0), table.shape[1] - 2)
    s = (t - k * step) / step
    p, q = table[row, k, 0], table[row, k + 1, 0]
    dp, dq = table[row, k, 1] * step, table[row, k + 1, 1] * step
    s2, s3 = s * s, s * s * s
    start = p * (2 * s3 - 3 * s2 + 1) + dp * (s3 - 2 * s2 + s)
    return start + q * (3 * s2 - 2 * s3) + dq * (s3 - s2)


@njit(_nrt=False)
def swing_rate(bodies, b, t):
    """Rate of pendulum b at time t: the derivative of `swing_angle`."""
    table, step = bodies.angles, bodies.angle_step
    row = int(bodies.rows[b, SWING])
    k = min(max(int(t / step), 0), table.shape[1] - 2)
    s, way = (t - k * step) / step, table[row, k + 1, 0] - table[row, k, 0]
    first, last = table[row, k, 1], table[row, k + 1, 1]
    bend = 3.0 * way / step - 2.0 * first - last
    return first + s * (2.0 * bend + 3.0 * s * (first + last - 2.0 * way / step))


@njit(_nrt=False)
def _swing_pose(bodies, b, t, out):
    body = bodies.rows
    if body[b, PIECES] > 0.0:
        _piece_pose(bodies, b, t, out)
        return
    angle = swing_angle(bodies, b, t)
    s, c = np.sin(angle), np.cos(angle)
    for k in range(3):
        along = c * body[b, DOWN + k] + s * body[b, SIDE + k]
        out[b, k] = body[b, POSITION + k] + body[b, HANG] * along
        # Body axes: z along the cord, y along the rotation axis, x = y x z.
        out[b, 3 + 3 * k] = c * body[b, SIDE + k] - s * body[b, DOWN + k]
        out[b, 3 + 3 * k + 1] = body[b, AXIS + k]
        out[b, 3 + 3 * k + 2] = along


@njit(_nrt=False, forceinline=True)
def glide(bodies, b, t, poses):
    """Return the centre (3) at time t [s] of body b, of one quadratic law.

    `poses` is not written: it gives the signature of `swing`, for loops that call either.
    """
    rows, half = bodies.rows, 0.5 * t * t
    return (
        rows[b, POSITION] + rows[b, VELOCITY] * t + rows[b, ACCELERATION] * half,
        rows[b, POSITION + 1] + rows[b, VELOCITY + 1] * t + rows[b, ACCELERATION + 1] * half,
        rows[b, POSITION + 2] + rows[b, VELOCITY + 2] * t + rows[b, ACCELERATION + 2] * half,
    )


@njit(_nrt=False)
def swing(bodies, b, t, poses):
    """Return the centre (3) at t [s] of body b, of any other law; write its pose into `poses`."""
    _swing_pose(bodies, b, t, poses)
    return poses[b, 0], poses[b, 1], poses[b, 2]


@njit(_nrt=False, forceinline=True)
def centre_at(bodies, b, t, out):
    """Write body b's centre at time t [s] into out[b, :3]; for non-quadratic laws its whole pose.

    Returns whether `rotate` has still to write the rest of its pose.
    """
    if bodies.rows[b, SWING] >= 0.0:
        _swing_pose(bodies, b, t, out)
        return False
    out[b, 0], out[b, 1], out[b, 2] = glide(bodies, b, t, out)
    return bodies.rows[b, BALL] == 0.0


@njit(_nrt=False)
def pose_at(bodies, b, t, out):
    """Write body b's pose at time t [s] into out[b] (n, 12)."""
    if centre_at(bodies, b, t, out):
        rotate(bodies, b, t, out)


@njit(_nrt=False)
def poses_at(bodies, t, out):
    """Write every body's pose at time t into out (n, 12)."""
    for b in range(bodies.rows.shape[0]):
        pose_at(bodies, b, t, out)


@njit(_nrt=False, forceinline=True)
def top_speed(number, bodies, b, p, t0, t1):
    """Bound the speed of any point of body b between t0 and t1; see `_turn` for the numbers.

    The centre's speed is convex in time under constant acceleration, so its maximum over an
    interval is at one of the ends; rotation adds at most |spin| times the body's reach.
    """
    v0, v1, w = 0.0, 0.0, 0.0
    for k in range(3):
        velocity, faster = (
            number(bodies, b, p, VELOCITY + k),
            number(bodies, b, p, ACCELERATION + k),
        )
        v0 += (velocity + faster * t0) ** 2
        v1 += (velocity + faster * t1) ** 2
        w += number(bodies, b, p, SPIN + k) ** 2
    return np.sqrt(max(v0, v1)) + np.sqrt(w) * bodies.rows[b, REACH]


@njit(_nrt=False)
def drift(bodies, b, t0, t1):
    """Bound how far any point of body b and its margin travel between t0 and t1."""
    return _travel(bodies, b, t0, t1) + bodies.rows[b, MARGIN_RATE] * (t1 - t0)


@njit(_nrt=False)
def _travel(bodies, b, t0, t1):
    body = bodies.rows
    if body[b, SWING] >= 0.0:
        if body[b, PIECES] > 0.0:
            return _piece_drift(bodies, b, t0, t1)
        return body[b, TOP_SPEED] * (t1 - t0)
    return top_speed(of_row, bodies, b, 0, t0, t1) * (t1 - t0)


@njit(_nrt=False)
def _piece_drift(bodies, b, t0, t1):
    """Sum the bounds of all pieces between t0 and t1, and the gaps where they meet."""
    p, since, way = piece_at(bodies, b, t0), t0, 0.0
    while True:
        until = piece_end(bodies, b, p)
        last = until > t1
        until = min(until, t1)
        start = of_piece(bodies, b, p, START)
        way += top_speed(of_piece, bodies, b, p, since - start, until - start) * (until - since)
        if last:
            return way
        p, since = p + 1, until
        turned = of_piece(bodies, b, p, JUMP_TURN) * bodies.rows[b, REACH]
        way += of_piece(bodies, b, p, JUMP) + turned


@njit(_nrt=False)
def piece_end(bodies, b, p):
    """Return the time at which piece p of body b ends [s], infinite for the last."""
    if p + 1 == int(bodies.rows[b, PIECES]):
        return np.inf
    return of_piece(bodies, b, p + 1, START)


@njit(_nrt=False, forceinline=True)
def _velocity(number, bodies, b, p, t, place):
    """Velocity (3) of the point of body b at `place` (3), at t [s] of a law's own time."""
    half, (x, y, z) = 0.5 * t * t, place
    wx, wy, wz = (
        number(bodies, b, p, SPIN),
        number(bodies, b, p, SPIN + 1),
        number(bodies, b, p, SPIN + 2),
    )
    ax, ay, az = (
        number(bodies, b, p, ACCELERATION),
        number(bodies, b, p, ACCELERATION + 1),
        number(bodies, b, p, ACCELERATION + 2),
    )
    vx, vy, vz = (
        number(bodies, b, p, VELOCITY),
        number(bodies, b, p, VELOCITY + 1),
        number(bodies, b, p, VELOCITY + 2),
    )
    x -= number(bodies, b, p, POSITION) + vx * t + ax * half
    y -= number(bodies, b, p, POSITION + 1) + vy * t + ay * half
    z -= number(bodies, b, p, POSITION + 2) + vz * t + az * half
    return (
        vx + ax * t + wy * z - wz * y,
        vy + ay * t + wz * x - wx * z,
        vz + az * t + wx * y - wy * x,
    )


@njit(_nrt=False)
def velocity_by(bodies, b, p, t, place):
    """Velocity (3) at t [s] of the point of body b at `place` (3), by piece p of its law.

    Bodies without pieces have one law, whatever p is.
    """
    rows = bodies.rows
    if rows[b, SWING] < 0.0:
        return _velocity(of_row, bodies, b, 0, t, place)
    if rows[b, PIECES] > 0.0:
        return _velocity(of_piece, bodies, b, p, t - of_piece(bodies, b, p, START), place)
    rate = swing_rate(bodies, b, t)
    x, y, z = place[0] - rows[b, POSITION], place[1] - rows[b, POSITION + 1], place[2]
    z -= rows[b, POSITION + 2]
    wx, wy, wz = rate * rows[b, AXIS], rate * rows[b, AXIS + 1], rate * rows[b, AXIS + 2]
    return wy * z - wz * y, wz * x - wx * z, wx * y - wy * x


@njit(_nrt=False)
def spin_by(bodies, b, p, t):
    """Angular velocity (3) of body b at t [s], by piece p of its law; see `velocity_by`."""
    rows = bodies.rows
    if rows[b, SWING] < 0.0:
        return rows[b, SPIN], rows[b, SPIN + 1], rows[b, SPIN + 2]
    if rows[b, PIECES] > 0.0:
        return (
            of_piece(bodies, b, p, SPIN),
            of_piece(bodies, b, p, SPIN + 1),
            of_piece(bodies, b, p, SPIN + 2),
        )
    rate = swing_rate(bodies, b, t)
    return rate * rows[b, AXIS], rate * rows[b, AXIS + 1], rate * rows[b, AXIS + 2]
