"""One step of a planar arm: end of the hand, catch or collision on the way, reward.

The functions that verify plans (`least_distance`, `first_catch`) find catches and collisions
within a step, on the same segment.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.arms.planar_limb import elbow_of
from gcm_learn.collision.sweep import least_distance
from gcm_learn.compiled import njit
from gcm_learn.execution.arena.kernels.hands.nearness import stays_away, stays_free
from gcm_learn.execution.arena.kernels.hands.observation import observe
from gcm_learn.execution.arena.kernels.hands.scene import FAR, HORIZON, scene_of, workspace_for
from gcm_learn.execution.arena.kernels.world import (
    CAUGHT,
    COLLIDED,
    GUIDE,
    HAND_VELOCITY,
    LATE,
    RUNNING,
    Options,
    State,
    Told,
    World,
    pay,
    rules_in,
)
from gcm_learn.motion.interception import first_catch
from gcm_learn.motion.verification import PARTS, joint_turns, nearest_to_shoulder
from gcm_learn.planners import CATCH_STEP

_JOINT_SLACK = 1.01  # joint speeds vary within the pieces on which they are measured
_HALVINGS = 12  # of a step that the arm cannot make
_ANY = 1e9  # resolution of clearance: whether the limb touches is exact whatever it is


@njit(_nrt=False)
def _wish(scene, speed, x, y, span, first, second, options):
    """Return the place of the hand after `span` seconds without any limits."""
    if options.control == HAND_VELOCITY:
        size = max(np.sqrt(first * first + second * second), 1.0)
        step = speed * span / size
        r = np.sqrt(x * x + y * y)
        ux, uy = (x / r, y / r) if r > 1e-12 else (1.0, 0.0)
        return x + step * (first * ux - second * uy), y + step * (first * uy + second * ux)
    rho, limits = scene.limb.rho, scene.limits
    ex, ey = elbow_of(x, y, rho, 1.0)
    shoulder = np.arctan2(ey, ex)
    elbow = np.arctan2(ex * (y - ey) - ey * (x - ex), ex * (x - ex) + ey * (y - ey))
    free = options.joint_rate * limits.speed
    rate_1 = limits.shoulder if limits.shoulder < np.inf else free
    rate_2 = limits.elbow if limits.elbow < np.inf else free
    shoulder += min(max(first, -1.0), 1.0) * rate_1 * span
    elbow = min(max(elbow + min(max(second, -1.0), 1.0) * rate_2 * span, 0.0), np.pi)
    both = shoulder + elbow
    return rho * np.cos(shoulder) + np.cos(both), rho * np.sin(shoulder) + np.sin(both)


@njit
def _too_fast(scene, span, hand):
    """Return the fastest joint's speed as a share of its limit; at most 1 is allowed."""
    limits = scene.limits
    if limits.shoulder == np.inf or span <= 0.0:
        return 0.0
    turns = joint_turns(hand, scene.limb.rho, 1.0, PARTS)
    first = turns[0, 0] * _JOINT_SLACK / (limits.shoulder * span)
    return max(first, turns[0, 1] * _JOINT_SLACK / (limits.elbow * span))


@njit
def reach_out(scene, rules, span, first, second, options, hand):
    """Write into hand[1] how far the hand gets from hand[0] in `span` [s] within the limits.

    A wish outside the ring ends on its rim. A step is shortened, keeping its direction, if it is
    too long, turns a joint too fast or leads through the ring's hole.
    """
    limb, x, y = scene.limb, hand[0, 0], hand[0, 1]
    nx, ny = _wish(scene, rules.speed, x, y, span, first, second, options)
    r = np.sqrt(nx * nx + ny * ny)
    if r > limb.far:
        nx, ny = nx * limb.far / r, ny * limb.far / r
    length = np.sqrt((nx - x) ** 2 + (ny - y) ** 2)
    share = min(rules.speed * span / length, 1.0) if length > 0.0 else 0.0
    near = min(limb.near, np.sqrt(x * x + y * y) * (1.0 - 1e-10))
    for _ in range(_HALVINGS):
        hand[1, 0], hand[1, 1] = x + share * (nx - x), y + share * (ny - y)
        if nearest_to_shoulder(hand) < near:
            share *= 0.5
            continue
        excess = _too_fast(scene, span, hand)
        if excess <= 1.0:
            return
        share *= 0.999 / excess
    hand[1, 0], hand[1, 1] = x, y


@njit
def advance(world, state, e, first, second, options, workspace):
    """Move arm e by one step; return the outcome.

    Parameters
    ----------
    first, second : float
        The action.
    workspace : Workspace

    Returns
    -------
    int
        RUNNING, CAUGHT, COLLIDED or LATE; the state is that at the end of the step, or at the
        catch or collision.
    """
    s, time, hand = state.place[e], workspace.time, workspace.hand
    scene, rules = scene_of(world, s), rules_in(world, s)
    horizon = scene.limits.horizon
    hand[0, 0], hand[0, 1], time[0] = state.hand[e, 0], state.hand[e, 1], state.time[e]
    time[1] = time[0] + options.dt
    if time[1] > horizon - 1e-9:
        time[1] = horizon
    end = time[1]
    reach_out(scene, rules, end - time[0], first, second, options, hand)
    outcome = RUNNING
    if not stays_away(scene.bodies, time, hand, rules.catch):
        met, body = first_catch(scene.bodies, time, hand, rules.catch, CATCH_STEP * rules.instant)
        if met >= 0.0:
            outcome = CAUGHT
            state.caught[e, body] = met
            _shorten(time, hand, met)
    if not stays_free(scene, time, hand, rules.touch, workspace.moments, workspace.poses):
        distance, when = least_distance(scene, time, hand, rules.touch, _ANY)
        if distance <= rules.touch:
            outcome = COLLIDED
            _shorten(time, hand, when)
            state.caught[e] = -1.0
    if outcome == RUNNING and end >= horizon:
        outcome = LATE
    state.hand[e, 0], state.hand[e, 1], state.time[e] = hand[1, 0], hand[1, 1], time[1]
    return outcome


@njit(_nrt=False)
def _shorten(time, hand, end):
    """End a segment earlier."""
    share = (end - time[0]) / (time[1] - time[0]) if time[1] > time[0] else 0.0
    for k in range(2):
        hand[1, k] = hand[0, k] + share * (hand[1, k] - hand[0, k])
    time[1] = end


@njit(_nrt=False)
def time_to_go(world, s, x, y):
    """Return the time to go from (x, y) as a share of the horizon; 1 where the field knows none."""
    n = world.fields.shape[1]
    pitch = 0.5 * n / world.limbs[s, FAR]  # the field's lattice reaches from rim to rim
    fx, fy = x * pitch + 0.5 * n - 0.5, y * pitch + 0.5 * n - 0.5
    fx, fy = min(max(fx, 0.0), n - 1.001), min(max(fy, 0.0), n - 1.001)
    ix, iy = int(fx), int(fy)
    fx -= ix
    fy -= iy
    low = (1.0 - fx) * world.fields[s, iy, ix] + fx * world.fields[s, iy, ix + 1]
    high = (1.0 - fx) * world.fields[s, iy + 1, ix] + fx * world.fields[s, iy + 1, ix + 1]
    return (1.0 - fy) * low + fy * high


@njit
def step(world, state, e, actions, options, told, workspace):
    """Make one step of arm e; write its outcome and reward terms.

    Parameters
    ----------
    actions : (arms, 2) ndarray
    options : Options
        The discount is that of the learner, for the guide's potential.
    told : Told
        Row e of outcomes and terms is written.
    workspace : Workspace
    """
    s, weights = state.place[e], options.weights
    guided = world.fields.shape[0] > 0 and weights[GUIDE] != 0.0
    before = time_to_go(world, s, state.hand[e, 0], state.hand[e, 1]) if guided else 0.0
    since = state.time[e]
    first, second = float(actions[e, 0]), float(actions[e, 1])
    outcome = advance(world, state, e, first, second, options, workspace)
    after = 0.0
    if guided and outcome == RUNNING:
        after = time_to_go(world, s, state.hand[e, 0], state.hand[e, 1])
    share = (state.time[e] - since) / world.limits[s, HORIZON]
    catches = 1.0 if outcome == CAUGHT else 0.0
    pay(told, e, outcome, catches, share, weights, before - options.discount * after)


@njit(nogil=True)
def observe_all(world, state, chosen, options, out):
    """Write the observations of the arms `chosen` (k,) into their rows of `out`."""
    worlds, states, how = World(*world), State(*state), Options(*options)
    workspace = workspace_for(worlds, states, 0, states.place.size)
    for k in range(chosen.size):
        observe(worlds, states, chosen[k], how, out, workspace)


@njit(nogil=True)
def play(world, state, actions, options, told, first, last):
    """Make a step of arms first to last - 1, and observe."""
    worlds, states, how, out = World(*world), State(*state), Options(*options), Told(*told)
    workspace = workspace_for(worlds, states, first, last)
    for e in range(first, last):
        step(worlds, states, e, actions, how, out, workspace)
        observe(worlds, states, e, how, out.observations, workspace)
