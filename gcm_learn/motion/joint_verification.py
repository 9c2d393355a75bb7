"""Verification of movements in the joints, at every instant of their curves."""

from __future__ import annotations

import numpy as np

from gcm_learn.arms.curves import hermite, line, on_curve
from gcm_learn.arms.limbs import dof, hand_of, hand_rate, lever, place
from gcm_learn.collision.postures import desk_of, distance_at, least_on
from gcm_learn.compiled import njit
from gcm_learn.motion.joint_interception import ANGLE, approach_excess, target_room
from gcm_learn.motion.rules import CATCH_SAFETY

NOTHING, ELSEWHERE, LATE, RANGE, JOINT, FORCED, FAST, MISSED, TOUCHED = range(9)
TOLERANCE = 1e-7  # relative, of limits; the contract grants 1e-6
RESOLUTION = 2e-4  # the reported clearance is at most this above the true one [forearms]
_ROUNDING = 1e-13  # of joints, where a range ends at 0 [rad]
_GLANCES = 4  # at a move, for a distance to begin with
_NEAR_ENOUGH = 1e-4  # share of a move at which that is good enough
_NARROWEST = 1e-12  # share of a piece that is checked before its hand counts as too fast


@njit
def judge(scene, touch, time, joints, rates, body):
    """Return the first broken promise or NOTHING, the least distance, and when [s].

    Parameters
    ----------
    touch : float
        Distance of bones and obstacles that is not enough.
    time : (n,) ndarray
    joints : (n, dof) ndarray
    rates : (n, dof) ndarray
        (0, dof) where joints are linear between samples.
    body : int
        The target that is caught at the end; -1 if that is no catch.
    """
    desk, last = desk_of(scene), time.size - 1
    fault = _fault_at_ends(scene, time, joints, rates, body, desk)
    if fault != NOTHING:
        return fault, 0.0, time[last]
    for k in range(last):
        _piece(time, joints, rates, k, desk.curve)
        fault = piece_fault(scene, desk.curve, time[k + 1] - time[k], desk.joints)
        if fault != NOTHING:
            return fault, 0.0, time[k]
    best, when = _rather_near(scene, time, joints, rates, desk)
    if best <= touch:  # the search finds the first touch, not the worst
        best, when = 1e300, 0.0
    for k in range(max(last, 1)):
        until = min(k + 1, last)
        if until == k:  # a catch at t = 0
            line(joints[0], joints[0], desk.curve)
        else:
            _piece(time, joints, rates, k, desk.curve)
        found, t = least_on(
            scene, time[k], time[until], touch, RESOLUTION * scene.limb.length, best, desk
        )
        if t >= 0.0:
            best, when = found, t
        if best <= touch:
            break
    return TOUCHED if best <= touch else NOTHING, best, when


@njit
def _rather_near(scene, time, joints, rates, desk):
    """Return a nearly least distance of limb and obstacles, to bound the search, and its time [s].

    The distance is the smallest at some instants of every move, refined around the best instant.
    """
    best, when, at, share = 1e300, 0.0, 0, 0.0
    for k in range(time.size - 1):
        _piece(time, joints, rates, k, desk.curve)
        for i in range(_GLANCES):
            s = (i + 1.0) / _GLANCES
            found, t = _glance(scene, time, k, s, desk)
            if found < best:
                best, when, at, share = found, t, k, s
    if best == 1e300:
        return best, when
    _piece(time, joints, rates, at, desk.curve)
    width = 0.5 / _GLANCES
    while width > _NEAR_ENOUGH:
        middle = share
        for side in (-1.0, 1.0):
            s = min(max(middle + side * width, 0.0), 1.0)
            found, t = _glance(scene, time, at, s, desk)
            if found < best:
                best, when, share = found, t, s
        width *= 0.5
    return best, when


@njit(_nrt=False)
def _glance(scene, time, k, s, desk):
    """Distance of limb and obstacles at share s of move k, which is in ``desk.curve``; when [s]."""
    t = time[k] + s * (time[k + 1] - time[k])
    on_curve(desk.curve, s, desk.joints)
    return distance_at(scene, desk.joints, t, desk), t


@njit(_nrt=False)
def _piece(time, joints, rates, k, curve):
    """Write the move between samples k and k + 1 into `curve` (dof, 4)."""
    if rates.shape[0] == 0:
        line(joints[k], joints[k + 1], curve)
    else:
        hermite(joints[k], rates[k], joints[k + 1], rates[k + 1], time[k + 1] - time[k], curve)


@njit(_nrt=False)
def _fault_at_ends(scene, time, joints, rates, body, desk):
    """Check that a movement begins where the arm is, and ends at the target in time."""
    limb, last = scene.limb, time.size - 1
    for j in range(dof(limb)):
        if time[0] != 0.0 or joints[0, j] != limb.start[j]:
            return ELSEWHERE
        if rates.shape[0] > 0 and rates[0, j] != limb.rates[j]:
            return ELSEWHERE
        if not limb.low[j] <= joints[0, j] <= limb.high[j]:
            return RANGE
    if body < 0:
        return NOTHING
    if time[last] > scene.limits.horizon:
        return LATE
    q = joints[last]
    where = place(limb, q)
    x, y, z = hand_of(limb, where)
    away = target_room(scene, body, x, y, z, time[last], desk.poses)
    if away > scene.limits.grasp - 0.5 * CATCH_SAFETY * limb.length:
        return MISSED
    if approach_excess(scene, where, q, body, time[last], desk.poses) > 2.0 * ANGLE:
        return MISSED
    if last == 0 and rates.shape[0] > 0 and _starts_too_fast(scene, joints[0], rates[0], desk):
        return FAST
    return NOTHING


@njit(_nrt=False)
def _starts_too_fast(scene, joints, rates, desk):
    """Return whether the hand is too fast at t = 0, in a movement of one sample."""
    limb, curve = scene.limb, desk.curve
    for j in range(dof(limb)):
        curve[j, 0], curve[j, 1], curve[j, 2], curve[j, 3] = joints[j], rates[j], 0.0, 0.0
    speed = hand_rate(limb, curve, 0.0, desk.joints)
    return speed > scene.limits.speed * (1.0 + TOLERANCE)


@njit(_nrt=False)
def piece_fault(scene, curve, span, q):
    """First limit that the move in `curve` breaks in `span` [s]; `q` (dof,) is overwritten."""
    limb, limits = scene.limb, scene.limits
    for j in range(dof(limb)):
        low, high = _extremes(curve, j)
        below, above = TOLERANCE * abs(limb.low[j]), TOLERANCE * abs(limb.high[j])
        if low < limb.low[j] - below - _ROUNDING or high > limb.high[j] + above + _ROUNDING:
            return RANGE
        if _top_rate(curve, j) > limits.joint_speed[j] * span * (1.0 + TOLERANCE):
            return JOINT
        most = limits.joint_acceleration[j] * (1.0 + TOLERANCE) * span * span
        first, second = 2.0 * curve[j, 2], 2.0 * curve[j, 2] + 6.0 * curve[j, 3]
        if max(abs(first), abs(second)) > most:
            return FORCED
    if limits.speed != np.inf:
        if hand_too_fast(limb, curve, limits.speed * span * (1.0 + TOLERANCE), q):
            return FAST
    return NOTHING


@njit(_nrt=False)
def _extremes(curve, j):
    """Smallest and largest angle of joint j over a move."""
    a, b, c, d = curve[j, 0], curve[j, 1], curve[j, 2], curve[j, 3]
    low, high = min(a, a + b + c + d), max(a, a + b + c + d)
    if c == 0.0 and d == 0.0:
        return low, high
    square = c * c - 3.0 * b * d
    if square >= 0.0:  # where the rate b + 2 c s + 3 d s^2 is 0; in the form that never cancels
        root = -(c + np.copysign(np.sqrt(square), c))
        for s in (root / (3.0 * d) if d != 0.0 else -1.0, b / root if root != 0.0 else -1.0):
            if 0.0 < s < 1.0:
                angle = a + s * (b + s * (c + s * d))
                low, high = min(low, angle), max(high, angle)
    return low, high


@njit(_nrt=False)
def _top_rate(curve, j):
    """Return the largest rate of joint j over a move, per share of the move."""
    b, c, d = curve[j, 1], curve[j, 2], curve[j, 3]
    top = max(abs(b), abs(b + 2.0 * c + 3.0 * d))
    s = -c / (3.0 * d) if d != 0.0 else -1.0
    return max(top, abs(b + c * s)) if 0.0 < s < 1.0 else top


@njit(_nrt=False)
def bends_of(curve, top):
    """Sums over joints of the largest first, second and third derivative in a move, per share.

    `top` (n,) gets the largest rates of the joints.
    """
    rates, bends, jolts = 0.0, 0.0, 0.0
    for j in range(top.size):
        top[j] = _top_rate(curve, j)
        rates += top[j]
        bends += max(abs(2.0 * curve[j, 2]), abs(2.0 * curve[j, 2] + 6.0 * curve[j, 3]))
        jolts += 6.0 * abs(curve[j, 3])
    return rates, bends, jolts


@njit(_nrt=False)
def hand_too_fast(limb, curve, most, q):
    """Return whether the hand's way per share of a move exceeds `most` anywhere.

    Between the ends of a span the hand's velocity strays from a straight line.  It strays by at
    most an eighth of the width squared times a bound of the second derivative.  Each derivative
    turns the arm once more, or is of one joint alone.
    """
    far = lever(limb)
    rates, bends, jolts = bends_of(curve, q)
    if far * rates <= most:
        return False
    change = 0.125 * far * (rates**3 + 3.0 * rates * bends + jolts)
    s, width, before = 0.0, 1.0, hand_rate(limb, curve, 0.0, q)
    while s < 1.0 - _NARROWEST:
        after = hand_rate(limb, curve, s + width, q)
        if max(before, after) > most or width < _NARROWEST:
            return True
        if max(before, after) + change * width * width <= most:
            s, before, width = s + width, after, 2.0 * width
        else:
            width *= 0.5
        width = min(width, 1.0 - s)
    return False
