"""One step of the arena: where the hand gets, what it meets on the way, what it is rewarded.

Whether a target is caught or the limb touched between the beginning and the end of a step is
decided by the functions that verify plans (`least_distance`, `first_catch`), on the same segment.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.collision.sweep import least_distance
from gcm_learn.compiled import njit
from gcm_learn.envs.nearness import MOMENT_COLUMNS, stays_away, stays_free
from gcm_learn.motion.interception import first_catch
from gcm_learn.motion.verification import PARTS, joint_turns, nearest_to_shoulder
from gcm_learn.scene.bodies import COLUMNS, Bodies
from gcm_learn.scene.limb import elbow_of
from gcm_learn.scene.scene import Limb, Limits, Scene

HAND_VELOCITY, JOINT_VELOCITY = 0, 1  # what an action is
RUNNING, CAUGHT, TOUCHED, LATE = range(4)  # how an episode stands
CATCH, TOUCH, HASTE, GUIDE = range(4)  # terms of the reward
TERMS = 4

# Columns of an arm's row.
RHO, SPEED, THICKNESS, FLOOR, GRASP, HORIZON, NEAR, FAR, TURN_1, TURN_2, START = range(11)
INSTANT, ANGLE_STEP = 11, 12  # resolutions in time: of catches, of tables of pendulums [s]
ARM_COLUMNS = 13

# Columns of a body's row that the arena adds.
LONG = COLUMNS  # 3: the longest axis in the body's own frame, see `own_axis`
ROW_COLUMNS = COLUMNS + 3

_SLACK = 1.0 - 2e-9  # against rounding of the speed limits
_JOINT_SLACK = 1.01  # joint speeds vary within the pieces on which they are measured
_HALVINGS = 12  # of a step that the arm cannot make
MOMENTS = 6  # that can be looked at at once
_ANY = 1e9  # resolution of clearance: whether the limb touches is exact whatever it is


class World(NamedTuple):
    """Many situations in their canonical form, one after the other."""

    rows: np.ndarray  # (m, ROW_COLUMNS): all bodies
    vertices: np.ndarray  # (v, 2): of all bodies
    angles: np.ndarray  # (p, g, 2): of all pendulums, the shorter tables filled up
    first: np.ndarray  # (s + 1,) int64: rows of situation k are first[k]:first[k + 1]
    arms: np.ndarray  # (s, ARM_COLUMNS)
    fields: np.ndarray  # (s or 0, n, n) float32: time to go as share of the horizon, see `guidance`


class State(NamedTuple):
    """Where many arms are, each in a situation of the world."""

    place: np.ndarray  # (e,) int64: situation
    hand: np.ndarray  # (e, 2), canonical coordinates of t = 0 [forearm lengths]
    time: np.ndarray  # (e,) [s]


class Desk(NamedTuple):
    """Room to work in, for one arm after the other."""

    time: np.ndarray  # (2,): when the hand moves [s]
    way: np.ndarray  # (2, 2): from where to where
    poses: np.ndarray  # (n, 12): n is the most bodies that a situation has
    moments: np.ndarray  # (MOMENTS, MOMENT_COLUMNS): see `nearness`
    gaps: np.ndarray  # (n, 3): see `observation`


@njit
def desk_for(world, state, first, last):
    """Room for arms first to last - 1."""
    most = 1
    for e in range(first, last):
        s = state.place[e]
        most = max(most, world.first[s + 1] - world.first[s])
    moments = np.empty((MOMENTS, MOMENT_COLUMNS))
    return Desk(np.empty(2), np.empty((2, 2)), np.zeros((most, 12)), moments, np.empty((most, 3)))


@njit
def bodies_of(world, s):
    """The bodies of situation s, as all kernels of situations want them."""
    rows = world.rows[world.first[s] : world.first[s + 1]]
    return Bodies(rows, world.vertices, world.angles, world.arms[s, ANGLE_STEP])


@njit
def scene_of(world, s):
    """Situation s, as all kernels of situations want it; its elbow is on the right."""
    arms = world.arms
    limb = Limb(
        arms[s, RHO], 1.0, arms[s, NEAR], arms[s, FAR], arms[s, THICKNESS], arms[s, START], 0.0
    )
    limits = Limits(
        arms[s, SPEED], arms[s, TURN_1], arms[s, TURN_2], arms[s, GRASP], arms[s, HORIZON]
    )
    return Scene(bodies_of(world, s), limb, limits)


@njit(_nrt=False)
def _wish(arms, s, x, y, span, first, second, control, joint_rate):
    """Where the hand would be after `span` seconds, whatever the limits."""
    if control == HAND_VELOCITY:
        size = max(np.sqrt(first * first + second * second), 1.0)
        step = arms[s, SPEED] * _SLACK * span / size
        r = np.sqrt(x * x + y * y)
        ux, uy = (x / r, y / r) if r > 1e-12 else (1.0, 0.0)
        return x + step * (first * ux - second * uy), y + step * (first * uy + second * ux)
    rho = arms[s, RHO]
    ex, ey = elbow_of(x, y, rho, 1.0)
    shoulder = np.arctan2(ey, ex)
    elbow = np.arctan2(ex * (y - ey) - ey * (x - ex), ex * (x - ex) + ey * (y - ey))
    rate_1 = arms[s, TURN_1] if arms[s, TURN_1] > 0.0 else joint_rate * arms[s, SPEED]
    rate_2 = arms[s, TURN_2] if arms[s, TURN_2] > 0.0 else joint_rate * arms[s, SPEED]
    shoulder += min(max(first, -1.0), 1.0) * rate_1 * span
    elbow = min(max(elbow + min(max(second, -1.0), 1.0) * rate_2 * span, 0.0), np.pi)
    both = shoulder + elbow
    return rho * np.cos(shoulder) + np.cos(both), rho * np.sin(shoulder) + np.sin(both)


@njit
def _too_fast(arms, s, span, way):
    """How many times too fast a joint would have to be; at most 1 is allowed."""
    if arms[s, TURN_1] <= 0.0:
        return 0.0
    turns = joint_turns(way, arms[s, RHO], 1.0, PARTS)
    first = turns[0, 0] * _JOINT_SLACK / (arms[s, TURN_1] * span)
    return max(first, turns[0, 1] * _JOINT_SLACK / (arms[s, TURN_2] * span))


@njit
def reach_out(arms, s, x, y, span, first, second, control, joint_rate, way):
    """Write into `way` (2, 2) how far the hand gets from (x, y) within the limits.

    A wish outside the ring ends on its rim; a step that is too long, turns a joint too fast or
    leads through the ring's hole is shortened, keeping its direction.
    """
    nx, ny = _wish(arms, s, x, y, span, first, second, control, joint_rate)
    r = np.sqrt(nx * nx + ny * ny)
    if r > arms[s, FAR]:
        nx, ny = nx * arms[s, FAR] / r, ny * arms[s, FAR] / r
    longest = arms[s, SPEED] * _SLACK * span
    length = np.sqrt((nx - x) ** 2 + (ny - y) ** 2)
    share = min(longest / length, 1.0) if length > 0.0 else 0.0
    near = min(arms[s, NEAR], np.sqrt(x * x + y * y) * (1.0 - 1e-10))
    way[0, 0], way[0, 1] = x, y
    for _ in range(_HALVINGS):
        way[1, 0], way[1, 1] = x + share * (nx - x), y + share * (ny - y)
        if nearest_to_shoulder(way) < near:
            share *= 0.5
            continue
        excess = _too_fast(arms, s, span, way)
        if excess <= 1.0:
            return
        share *= 0.999 / excess
    way[1, 0], way[1, 1] = x, y


@njit
def advance(world, state, e, first, second, control, joint_rate, dt, desk):
    """Move arm e on by a step and judge it.

    Parameters
    ----------
    first, second : float
        The action.
    desk : Desk
        Room for what is worked out on the way.

    Returns
    -------
    int
        RUNNING, CAUGHT, TOUCHED or LATE; the state is that at the end of the step, or at the
        catch or touch.
    """
    s, arms, time, way = state.place[e], world.arms, desk.time, desk.way
    x, y, t = state.hand[e, 0], state.hand[e, 1], state.time[e]
    end = t + dt
    if end > arms[s, HORIZON] - 1e-9:
        end = arms[s, HORIZON]
    reach_out(arms, s, x, y, end - t, first, second, control, joint_rate, way)
    time[0], time[1] = t, end
    scene = scene_of(world, s)
    bodies = scene.bodies
    outcome, rho, floor = RUNNING, arms[s, RHO], arms[s, FLOOR]
    if not stays_away(bodies, time, way, arms[s, GRASP]):
        met, _ = first_catch(bodies, time, way, arms[s, GRASP], arms[s, INSTANT])
        if met >= 0.0:
            outcome = CAUGHT
            _shorten(time, way, met)
    if not stays_free(bodies, time, way, rho, floor, desk.moments, desk.poses):
        distance, when = least_distance(scene, time, way, floor, _ANY)
        if distance <= floor:
            outcome = TOUCHED
            _shorten(time, way, when)
    if outcome == RUNNING and end >= arms[s, HORIZON]:
        outcome = LATE
    state.hand[e, 0], state.hand[e, 1], state.time[e] = way[1, 0], way[1, 1], time[1]
    return outcome


@njit(_nrt=False)
def _shorten(time, way, end):
    """End a segment earlier."""
    share = (end - time[0]) / (time[1] - time[0]) if time[1] > time[0] else 0.0
    for k in range(2):
        way[1, k] = way[0, k] + share * (way[1, k] - way[0, k])
    time[1] = end


@njit(_nrt=False)
def time_to_go(world, s, x, y):
    """Time to go as a share of the horizon, from the situation's field; 1 where it is not known."""
    n = world.fields.shape[1]
    pitch = 0.5 * n / world.arms[s, FAR]  # the field's lattice reaches from rim to rim
    fx, fy = x * pitch + 0.5 * n - 0.5, y * pitch + 0.5 * n - 0.5
    fx, fy = min(max(fx, 0.0), n - 1.001), min(max(fy, 0.0), n - 1.001)
    ix, iy = int(fx), int(fy)
    fx -= ix
    fy -= iy
    low = (1.0 - fx) * world.fields[s, iy, ix] + fx * world.fields[s, iy, ix + 1]
    high = (1.0 - fx) * world.fields[s, iy + 1, ix] + fx * world.fields[s, iy + 1, ix + 1]
    return (1.0 - fy) * low + fy * high


@njit
def step(world, state, e, actions, control, joint_rate, dt, weights, discount, outcomes, rewards,
         desk):  # fmt: skip
    """One step of arm e.

    Parameters
    ----------
    actions : (arms, 2) ndarray
    weights : (TERMS,) ndarray
        Of the terms of the reward.
    discount : float
        Of the guide's potential, that of the learner.
    outcomes, rewards : (arms,) int64, (arms, TERMS) ndarray
        Row e is written.
    """
    s = state.place[e]
    guided = world.fields.shape[0] > 0 and weights[GUIDE] != 0.0
    before = time_to_go(world, s, state.hand[e, 0], state.hand[e, 1]) if guided else 0.0
    since = state.time[e]
    first, second = float(actions[e, 0]), float(actions[e, 1])
    outcome = advance(world, state, e, first, second, control, joint_rate, dt, desk)
    outcomes[e] = outcome
    rewards[e, CATCH] = weights[CATCH] if outcome == CAUGHT else 0.0
    rewards[e, TOUCH] = -weights[TOUCH] if outcome == TOUCHED else 0.0
    share = (state.time[e] - since) / world.arms[s, HORIZON]
    rewards[e, HASTE] = -weights[HASTE] * share
    rewards[e, GUIDE] = 0.0
    if guided:  # the potential of what comes after the end is 0, or the optimum would change
        after = 0.0
        if outcome == RUNNING:
            after = time_to_go(world, s, state.hand[e, 0], state.hand[e, 1])
        rewards[e, GUIDE] = weights[GUIDE] * (before - discount * after)
