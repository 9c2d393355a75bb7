"""One step of an arm in its joints: end of the joints, catch or collision on the way, reward.

The functions that verify plans (`first_meeting`, `least_on`) find catches and collisions within a
step, on the same curve. The curve is a straight line in the joints, or the cubic from rates to
rates under limits of acceleration.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.arms.curves import hermite, line, on_curve
from gcm_learn.arms.limbs import dof, hand_of, hand_rate, place
from gcm_learn.collision.postures import least_on
from gcm_learn.compiled import njit
from gcm_learn.execution.arena.kernels.joints.chains import brakes_slowly
from gcm_learn.execution.arena.kernels.joints.meeting import way_to_go
from gcm_learn.execution.arena.kernels.joints.nearness import SOFTER, lay, wish
from gcm_learn.execution.arena.kernels.joints.scene import view_in
from gcm_learn.execution.arena.kernels.world import (
    CAUGHT,
    COLLIDED,
    GONE,
    GUIDE,
    LATE,
    LEAST,
    MOST,
    RUNNING,
    count_caught,
    pay,
)
from gcm_learn.motion.joint_interception import first_meeting
from gcm_learn.motion.joint_verification import NOTHING, hand_too_fast, piece_fault
from gcm_learn.scene import PART, Scene

_TRIES = 12  # halvings of how much of a wish the hand's speed allows
_SHORTEST = 1e-3  # share of a step that is no step of its own before the horizon
_ANY = 1e300  # resolution of distance: whether the limb touches is exact whatever it is
_CURVATURE = 0.2  # how far a parabola rises above three of its points, and a half for what is none
_SLOWER = 1e-4  # share of the hand's speed that is not used, so that its check is quick


@njit(_nrt=False)
def stays_slow(scene, speed, end, rates, span, room):
    """Return whether the hand keeps its speed limit on a step and while braking after the step.

    Parameters
    ----------
    end, rates : (dof,) ndarray
        After the step.
    room : View
        Its desk has the curve of the step.
    """
    limb, limits = scene.limb, scene.limits
    if hand_too_fast(limb, room.desk.curve, speed * span, room.desk.joints):
        return False
    if limits.joint_acceleration[0] == np.inf:
        return True
    return brakes_slowly(limb, scene, speed, end, rates, span, room.own)


@njit(_nrt=False)
def _slowed(scene, speed, span, rates, curve, work):
    """Scale the rates (dof,) of a step so that the hand keeps its speed limit."""
    limb = scene.limb
    before, middle = hand_rate(limb, curve, 0.0, work), hand_rate(limb, curve, 0.5, work)
    after = hand_rate(limb, curve, 1.0, work)
    top = max(before, middle, after) + _CURVATURE * abs(before - 2.0 * middle + after)
    share = min(speed * span * (1.0 - _SLOWER) / top, 1.0) if top > 0.0 else 1.0
    for j in range(dof(limb)):
        rates[j] *= share


@njit(_nrt=False)
def reach_out(scene, speed, posture, e, command, span, end, room):
    """Work out where the joints of an arm get in `span` [s] within the limits.

    Parameters
    ----------
    speed : float
        That the hand keeps [lengths/s].
    posture : (arms, 2 dof) ndarray
        Row `e` is that of the arm.
    command : (arms, dof) ndarray
        Likewise, in greatest joint speeds.
    end : (dof,) ndarray
        Gets the joints.
    room : View
        Its first rates get those after the step, its desk the curve.
    """
    rates, wanted, rest, curve = room.rates[0], room.rates[1], room.rates[2], room.desk.curve
    wish(scene, posture, e, command, span, rates)
    lay(scene, posture, e, rates, span, end, curve)
    if speed == np.inf or stays_slow(scene, speed, end, rates, span, room):
        return
    free = scene.limits.joint_acceleration[0] == np.inf
    if free:
        _slowed(scene, speed, span, rates, curve, room.desk.joints)
        lay(scene, posture, e, rates, span, end, curve)
        if stays_slow(scene, speed, end, rates, span, room):
            return
    n = dof(scene.limb)
    for j in range(n):
        wanted[j] = rates[j]
        most = scene.limits.joint_acceleration[j] * span * (1.0 - SOFTER)
        v = posture[e, n + j]
        rest[j] = 0.0 if free else min(max(0.0, v - most), v + most)
    low, high = 0.0, 1.0
    for _ in range(_TRIES):
        share = 0.5 * (low + high)
        for j in range(n):
            rates[j] = rest[j] + share * (wanted[j] - rest[j])
        lay(scene, posture, e, rates, span, end, curve)
        if stays_slow(scene, speed, end, rates, span, room):
            low = share
        else:
            high = share
    for j in range(n):
        rates[j] = rest[j] + low * (wanted[j] - rest[j])
    lay(scene, posture, e, rates, span, end, curve)


@njit
def advance(world, view, state, e, command, dt):
    """Move arm e by one step; return the outcome.

    Parameters
    ----------
    view : View
        Of the arm's situation; targets that are caught on the way are gone from it.
    command : (arms, dof) ndarray

    Returns
    -------
    int
        RUNNING, CAUGHT, COLLIDED or LATE; the state is that at the end of the step, or at the
        last catch that is asked for or the collision.
    """
    scene, rules, desk = view.scene, view.rules, view.desk
    horizon, since = scene.limits.horizon, state.time[e]
    if since >= horizon:  # it is held
        return LATE
    until = since + dt
    if until > horizon - _SHORTEST * dt:
        until = horizon
    over = until >= horizon
    end, rates = view.joints[0], view.rates[0]
    reach_out(scene, rules.speed, state.posture, e, command, until - since, end, view)
    outcome, s = RUNNING, state.place[e]
    left = max(world.wanted[s, MOST] - count_caught(state, e), 1)
    while left > 0:
        met, body = first_meeting(
            scene, desk.curve, since, until, rules.catch, rules.instant, desk.poses
        )  # fmt: skip
        if met < 0.0:
            break
        left -= 1
        state.caught[e, body] = met
        if left > 0:
            scene.bodies.rows[body, PART] = GONE  # of the view's own rows
        else:
            outcome = CAUGHT
            _cut(scene, state, e, met - since, until - since, view)
            until = met
    distance, when = least_on(scene, since, until, rules.touch, _ANY, _ANY, desk)
    if distance <= rules.touch:
        outcome = COLLIDED
        _cut(scene, state, e, when - since, until - since, view)
        until = when
        for b in range(scene.bodies.rows.shape[0]):
            if state.caught[e, b] > when:
                state.caught[e, b] = -1.0
    if outcome == RUNNING and over:
        outcome = CAUGHT if count_caught(state, e) >= world.wanted[s, LEAST] else LATE
    n = dof(scene.limb)
    for j in range(n):
        state.posture[e, j], state.posture[e, n + j] = end[j], rates[j]
    state.time[e] = until
    hand = hand_of(scene.limb, place(scene.limb, end))
    state.hand[e, 0], state.hand[e, 1], state.hand[e, 2] = hand
    return outcome


@njit(_nrt=False)
def _cut(scene, state, e, took, span, view):
    """Cut the step of `span` [s] in the view after `took` [s]: its end, rates and curve."""
    curve, end, rates = view.desk.curve, view.joints[0], view.rates[0]
    n = dof(scene.limb)
    s = took / span if span > 0.0 else 0.0
    on_curve(curve, s, end)
    if scene.limits.joint_acceleration[0] == np.inf:
        line(state.posture[e, :n], end, curve)
        return
    for j in range(n):
        rates[j] = curve[j, 1] + s * (2.0 * curve[j, 2] + s * 3.0 * curve[j, 3])
        rates[j] /= span
    hermite(state.posture[e, :n], state.posture[e, n:], end, rates, took, curve)


@njit
def step(world, state, e, commands, options, told, room):
    """Make one step of arm e; write its outcome and reward terms.

    Parameters
    ----------
    commands : (arms, dof) ndarray
        In greatest joint speeds.
    options : Options
    told : Told
        Row e of outcomes and terms is written.
    room : View
        Of any situation.

    Returns
    -------
    View
        Of the arm's situation, in the buffers of `room`.
    """
    s, since = state.place[e], state.time[e]
    view, had = view_in(world, state, e, room), count_caught(state, e)
    guided = options.weights[GUIDE] != 0.0
    before = way_to_go(view, since, state.posture, e) if guided else 0.0
    outcome = advance(world, view, state, e, commands, options.dt)
    after = 0.0
    if guided and outcome == RUNNING:
        after = way_to_go(view, state.time[e], state.posture, e)
    share = (state.time[e] - since) / view.scene.limits.horizon
    catches = (count_caught(state, e) - had) / world.wanted[s, MOST]
    pay(told, e, outcome, catches, share, options.weights, before - options.discount * after)
    return view


def can_stop(scene: Scene, speed: float, dt: float) -> bool:
    """Return whether an arm keeps its limits if it brakes from t = 0 on.

    Parameters
    ----------
    scene : Scene
    speed : float
        Limit of the hand's speed [lengths/s].
    dt : float
        A step [s].
    """
    return bool(_can_stop(scene, speed, dt)) if scene.limb.rates.any() else True


@njit
def _can_stop(scene, speed, dt):
    limb, limits, n = scene.limb, scene.limits, dof(scene.limb)
    posture, curve, end, work = (
        np.empty((1, 2 * n)),
        np.zeros((dof(limb), 4)),
        np.empty(n),
        np.empty(n),
    )
    posture[0, :n], posture[0, n:] = limb.start, limb.rates
    rates, none, longest = np.empty(n), np.zeros((1, n)), 0.0
    for j in range(n):
        longest = max(longest, abs(limb.rates[j]) / limits.joint_acceleration[j])
    for _ in range(int(longest / dt) + 2):
        wish(scene, posture, 0, none, dt, rates)
        lay(scene, posture, 0, rates, dt, end, curve)
        if piece_fault(scene, curve, dt, work) != NOTHING:
            return False
        posture[0, :n], posture[0, n:] = end, rates
    return np.abs(rates).max() == 0.0
