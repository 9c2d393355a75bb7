"""Holds: after a catch the hand stays at the target for a time, moving as fast as the target."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.arms import limbs
from gcm_learn.arms.curves import hermite, on_curve, rate_of
from gcm_learn.compiled import njit
from gcm_learn.motion.joint_interception import ANGLE, approach_excess, approaches, target_room
from gcm_learn.motion.joint_verification import bends_of
from gcm_learn.motion.rules import CATCH_SAFETY
from gcm_learn.scene import bodies

KEPT, LOST, SLIPPED, TURNED = range(4)
SLIP = 2e-7  # of relative speeds, relative and absolute; the contract grants 1e-6
_NARROWEST = 1e-9  # span that is checked before a promise counts as broken [s]
_ANY = 1e100  # relative speed of a touch
_MORE = 1.1  # times the differences in a pendulum's table bound its derivatives


class Bounds(NamedTuple):
    """Bounds over a move and a piece of the target's law."""

    speed: float  # of the hand [lengths/s]
    force: float  # acceleration of the hand
    jolt: float  # third derivative of the hand
    turn: float  # angular speed of hand and target together [rad/s]
    spin: float  # of the target [rad/s]
    swing: tuple[float, float]  # first two derivatives of a pendulum's rate


@njit(_nrt=False)
def relative_velocity(scene, b, p, t, curve, span, share, work):
    """Velocity (3) of the hand in excess of that of the target where the hand is.

    Parameters
    ----------
    b, p : int
        Target, and the piece of its law that holds.
    t : float
        When [s].
    curve, span, share : (n, 4) ndarray, float, float
        Move of the joints, how long it takes [s], and how much of it is over at t.
    work : Work
        Gets joints and Jacobian.

    Returns
    -------
    velocity : tuple of 3 floats
    place : tuple of 3 floats
        Of the hand.
    """
    limb = scene.limb
    on_curve(curve, share, work.joints)
    place = limbs.hand_of(limb, limbs.place(limb, work.joints))
    limbs.jacobian(limb, work.joints, work.jacobian)
    ux, uy, uz = bodies.velocity_by(scene.bodies, b, p, t, place)
    vx, vy, vz = -ux, -uy, -uz
    for j in range(work.joints.size):
        rate = rate_of(curve, j, share) / span
        vx += work.jacobian[0, j] * rate
        vy += work.jacobian[1, j] * rate
        vz += work.jacobian[2, j] * rate
    return (vx, vy, vz), place


class Work(NamedTuple):
    """Arrays for questions about holds."""

    joints: np.ndarray  # (n,)
    jacobian: np.ndarray  # (3, n)
    rates: np.ndarray  # (n,): largest of a move [rad/s]
    poses: np.ndarray  # (bodies, 12)


@njit
def work_of(scene):
    """Return the arrays for questions about holds in a scene."""
    n = limbs.dof(scene.limb)
    poses = np.zeros((scene.bodies.rows.shape[0], 12))
    return Work(np.zeros(n), np.zeros((3, n)), np.zeros(n), poses)


@njit(_nrt=False)
def _bounds_of(scene, b, curve, span, work):
    """Bound how a move changes the hand's velocity and direction."""
    limb = scene.limb
    far = limbs.lever(limb)
    rates, bends, jolts = bends_of(curve, work.rates)
    rates, bends, jolts = rates / span, bends / span**2, jolts / span**3
    for j in range(work.rates.size):
        work.rates[j] /= span
    spin, swing = bodies.top_spin(scene.bodies, b), (0.0, 0.0)
    turn = limbs.axis_bound(limb, work.rates) + spin
    if scene.bodies.rows[b, bodies.SWING] >= 0.0 and scene.bodies.rows[b, bodies.PIECES] == 0.0:
        swing = _swing_changes(scene.bodies, b)
    jolt = far * (rates**3 + 3.0 * rates * bends + jolts)
    return Bounds(far * rates, far * (rates**2 + bends), jolt, turn, spin, swing)


@njit(_nrt=False)
def _law_bend(scene, b, p, place, half, bounds):
    """Bound the second derivative of the target's velocity at the hand within `half` [s].

    Parameters
    ----------
    place : tuple of 3 floats
        Hand in the middle of that time.
    """
    laws, rows, spin = scene.bodies, scene.bodies.rows, bounds.spin
    if rows[b, bodies.SWING] < 0.0 or rows[b, bodies.PIECES] > 0.0:
        if spin == 0.0:
            return 0.0
        fall = 0.0
        for k in range(3):
            if rows[b, bodies.PIECES] > 0.0:
                fall += bodies.of_piece(laws, b, p, bodies.ACCELERATION + k) ** 2
            else:
                fall += rows[b, bodies.ACCELERATION + k] ** 2
        return spin * (bounds.force + np.sqrt(fall))
    away = bounds.speed * half
    for k in range(3):
        away += abs(place[k] - rows[b, bodies.POSITION + k])
    first, second = bounds.swing
    return second * away + 2.0 * first * bounds.speed + spin * bounds.force


@njit(_nrt=False)
def _swing_changes(laws, b):
    """Bound the first two derivatives of a pendulum's rate, by differences in its table."""
    table, row, step = laws.angles, int(laws.rows[b, bodies.SWING]), laws.angle_step
    first, second = 0.0, 0.0
    for k in range(table.shape[1] - 1):
        change = table[row, k + 1, 1] - table[row, k, 1]
        first = max(first, abs(change))
        if k > 0:
            second = max(second, abs(change - (table[row, k, 1] - table[row, k - 1, 1])))
    return _MORE * first / step, _MORE * second / step**2


@njit(_nrt=False)
def _faults_at(scene, b, t, limits, work):
    """Return distance and angle beyond their allowed values, at the joints in `work`."""
    where = limbs.place(scene.limb, work.joints)
    x, y, z = limbs.hand_of(scene.limb, where)
    room = target_room(scene, b, x, y, z, t, work.poses) - limits[0]
    turned = approach_excess(scene, where, work.joints, b, t, work.poses) - ANGLE
    return room, turned


@njit(_nrt=False)
def part_fault(scene, b, p, since, curve, span, ends, limits, work):
    """First promise of a hold that is broken in a part of a move, or KEPT.

    Between two instants the relative velocity strays from a straight line by at most an eighth of
    the width squared times a bound of its second derivative. The relative speed bounds how fast
    distances change, the relative turning how fast angles do.

    Parameters
    ----------
    since : float
        When the move begins [s].
    ends : tuple of 2 floats
        When the part begins and ends [s].
    limits : tuple of 2 floats
        Largest distance and relative speed.
    """
    bounds, top = _bounds_of(scene, b, curve, span, work), limits[1] * (1.0 + SLIP) + SLIP
    t, width, turns = ends[0], ends[1] - ends[0], approaches(scene, b) > 0
    first, _ = relative_velocity(scene, b, p, t, curve, span, (t - since) / span, work)
    fast, (room, turned) = np.sqrt(_square(first)), _faults_at(scene, b, t, limits, work)
    while True:
        later = min(t + width, ends[1])
        second, place = relative_velocity(
            scene, b, p, later, curve, span, (later - since) / span, work
        )
        fast_later = np.sqrt(_square(second))
        room_later, turned_later = _faults_at(scene, b, later, limits, work)
        if max(fast, fast_later) > top:
            return SLIPPED
        if max(room, room_later) > 0.0:
            return LOST
        if max(turned, turned_later) > 0.0:
            return TURNED
        took = later - t
        bend = bounds.jolt + _law_bend(scene, b, p, place, took, bounds)
        fine = max(fast, fast_later) + 0.125 * took * took * bend <= top
        fine = fine and max(room, room_later) + 0.5 * took * top <= 0.0
        if turns:
            fine = fine and max(turned, turned_later) + 0.5 * took * bounds.turn <= 0.0
        if fine:
            if later >= ends[1]:
                return KEPT
            t, width = later, 2.0 * width
            fast, room, turned = fast_later, room_later, turned_later
        elif took <= _NARROWEST:  # neither broken nor proven: the limits are kept to a hair
            return SLIPPED
        else:
            width = 0.5 * took


@njit(_nrt=False)
def _square(v):
    return v[0] * v[0] + v[1] * v[1] + v[2] * v[2]


@njit(_nrt=False)
def hold_fault_on(scene, b, since, until, curve, span, begin, limits, work):
    """First promise that is broken in a move, from `since` to `until` [s]; law by law.

    `begin` is when the move begins [s]; for the others see `part_fault`.
    """
    laws, t, p = scene.bodies, since, 0
    pieces = int(laws.rows[b, bodies.PIECES])
    if pieces > 0:
        p = bodies.piece_at(laws, b, t)
    while True:
        end = until
        if pieces > 0:
            end = min(end, bodies.piece_end(laws, b, p))
        fault = part_fault(scene, b, p, begin, curve, span, (t, end), limits, work)
        if fault != KEPT or end >= until:
            return fault
        t, p = end, p + 1


@njit(_nrt=False)
def _fault_before(scene, b, t, curve, span, begin, limits, work):
    """Return the fault under the motion law that ends at t [s]; SLIPPED if none ends there."""
    laws = scene.bodies
    p = bodies.piece_at(laws, b, t) if laws.rows[b, bodies.PIECES] > 0.0 else 0
    if p == 0 or bodies.of_piece(laws, b, p, bodies.START) < t:
        return SLIPPED
    return part_fault(scene, b, p - 1, begin, curve, span, (t, t), limits, work)


@njit(_nrt=False)
def hold_limits(scene, b):
    """Largest distance and relative speed of a hold, less a hair."""
    grasp = scene.limits.grasp - 0.5 * CATCH_SAFETY * scene.limb.length
    return grasp, scene.bodies.rows[b, bodies.HOLD_SPEED]


@njit
def catch_fault(scene, b, since, until, time, joints, rates):
    """First promise that is broken from the catch at `since` until `until` [s], or KEPT.

    A touch has to be within the grasp and the approach at its instant alone. A hold of 0 s at a
    bounce needs the target's velocity before the bounce, or that after it.
    """
    work, (grasp, speed) = work_of(scene), hold_limits(scene, b)
    curve = np.zeros((joints.shape[1], 4))
    if scene.bodies.rows[b, bodies.HOLD] < 0.0:
        speed = _ANY
    for k in range(time.size - 1):
        begin, end = max(time[k], since), min(time[k + 1], until)
        if begin > end or (begin == end and since < until):
            continue
        span = time[k + 1] - time[k]
        hermite(joints[k], rates[k], joints[k + 1], rates[k + 1], span, curve)
        fault = hold_fault_on(scene, b, begin, end, curve, span, time[k], (grasp, speed), work)
        if fault == SLIPPED and since == until:
            fault = _fault_before(scene, b, since, curve, span, time[k], (grasp, speed), work)
        if fault != KEPT or since == until:
            return fault
    return KEPT
