"""Situations packed side by side, the state of the arms in them, and rewards: for every kind."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from gcm_learn.compiled import njit
from gcm_learn.motion.rules import Rules
from gcm_learn.scene import LIMB, PART, Scene
from gcm_learn.scene.bodies import COLUMNS, FIRST, LAST, SWING, Bodies
from gcm_learn.scene.shapes.choice import long_axis

HAND_VELOCITY, JOINT_VELOCITY = 0, 1  # meanings of an action
RUNNING, CAUGHT, COLLIDED, LATE = range(4)  # states of an episode
EXTREME = 10.0  # largest number of an observation

MOST, LEAST = range(2)  # columns of a world's `wanted`
GONE = -1  # part of the arm that a caught target can touch: none

# Columns that a world adds to a body's row.
LONG = COLUMNS  # 3: the longest axis in the body's own frame, see `long_axis`
ROW_COLUMNS = COLUMNS + 3


class World(NamedTuple):
    """Many situations as flat arrays, each in the frame of its arm."""

    rows: np.ndarray  # (m, ROW_COLUMNS): all bodies
    vertices: np.ndarray  # (v, 2): of all bodies
    angles: np.ndarray  # (p, g, 2): of all pendulums, the shorter tables filled up
    angle_steps: np.ndarray  # (s,): resolution of these tables [s]
    first: np.ndarray  # (s + 1,) int64: rows of situation k are first[k]:first[k + 1]
    obstacles: np.ndarray  # (o,) int64: rows of their situation that the limb must not touch
    begin: np.ndarray  # (s + 1,) int64: those of situation k are begin[k]:begin[k + 1]
    limbs: np.ndarray  # (s, k): rows of the limbs
    limits: np.ndarray  # (s, k): fields of the limits likewise
    rules: np.ndarray  # (s, 4): fields of `Rules`
    pace: np.ndarray  # (s,): fastest that a hand can be [lengths/s]
    fields: np.ndarray  # (s or 0, n, n) float32: time to go as share of the horizon, see `guidance`
    wanted: np.ndarray  # (s, 2) int64: catches that end an episode, fewest of a success; `Wanted`


class State(NamedTuple):
    """State of many arms, each in a situation of the world."""

    place: np.ndarray  # (e,) int64: situation
    posture: np.ndarray  # (e, k): the hand itself; of other arms joints, then their rates
    hand: np.ndarray  # (e, 2 or 3), in the frame of t = 0 or of the base [lengths]
    time: np.ndarray  # (e,) [s]
    caught: np.ndarray  # (e, b): when each body was caught [s]; -1 for bodies that were not


class Options(NamedTuple):
    """Settings in the form of kernels, see `settings`."""

    dt: float
    weights: np.ndarray  # (4,)
    discount: float
    slots: int
    fan: bool
    control: int = JOINT_VELOCITY
    joint_rate: float = 0.0


class Told(NamedTuple):
    """Results of a step, a row for each arm."""

    outcomes: np.ndarray  # (e,) int64: RUNNING, CAUGHT, COLLIDED or LATE
    terms: np.ndarray  # (e, 4): of the reward
    observations: np.ndarray  # (e, width) float32


@njit
def bodies_in(world, s):
    """Return the bodies of situation s."""
    rows = world.rows[world.first[s] : world.first[s + 1]]
    return Bodies(rows, world.vertices, world.angles, world.angle_steps[s])


@njit(_nrt=False)
def rules_in(world, s):
    """Return the rules of movements in situation s."""
    a = world.rules
    return Rules(a[s, 0], a[s, 1], a[s, 2], a[s, 3])


@njit(_nrt=False)
def count_caught(state, e):
    """Return how many targets arm e has caught."""
    count = 0
    for b in range(state.caught.shape[1]):
        if state.caught[e, b] >= 0.0:
            count += 1
    return count


def fields_in_rows(scenes: Sequence[Scene]) -> np.ndarray:
    """Return the limbs of scenes as rows (s, k), their fields one after the other."""
    return np.array([np.hstack(scene.limb) for scene in scenes], dtype=float)


def world_of(
    scenes: Sequence[Scene],
    rules: Sequence[Rules],
    pace: Sequence[float],
    rows: Callable[[Sequence[Scene]], np.ndarray] = fields_in_rows,
    wanted: Sequence[tuple[int, int]] | None = None,
) -> World:
    """Pack scenes of one kind of arm into a `World`.

    Parameters
    ----------
    scenes : sequence of Scene
    rules : sequence of Rules
    pace : sequence of float
        Fastest that each hand can be [lengths/s].
    rows : callable
        Rows (s, k) of the limbs, from the scenes.
    wanted : sequence of (int, int), optional
        Numbers of catches, see `Wanted`; by default one catch is enough.
    """
    which = [np.flatnonzero(scene.bodies.rows[:, PART] == LIMB) for scene in scenes]
    return World(
        **_side_by_side([scene.bodies for scene in scenes]),
        obstacles=np.concatenate(which).astype(np.int64),
        begin=np.cumsum([0, *map(len, which)]),
        limbs=rows(scenes),
        limits=np.array([np.hstack(scene.limits) for scene in scenes], dtype=float),
        rules=np.array(rules, dtype=float),
        pace=np.array(pace, dtype=float),
        fields=np.zeros((0, 2, 2), dtype=np.float32),
        wanted=np.array(wanted or [(1, 1)] * len(scenes), dtype=np.int64),
    )


def _side_by_side(packed: Sequence[Bodies]) -> dict[str, np.ndarray]:
    """Return the bodies of many situations as fields of `World`.

    Indices into vertices and tables are shifted accordingly.
    """
    longest = max(b.angles.shape[1] for b in packed)
    angles = np.zeros((sum(len(b.angles) for b in packed), longest, 2))
    rows, first = [], [0]
    corners, swings = 0, 0
    for bodies in packed:
        row = np.zeros((len(bodies.rows), ROW_COLUMNS))
        row[:, :LONG] = bodies.rows
        row[:, LONG:] = [long_axis(bodies, b) for b in range(len(row))]
        row[:, [FIRST, LAST]] += corners
        row[row[:, SWING] >= 0.0, SWING] += swings
        angles[swings : swings + len(bodies.angles), : bodies.angles.shape[1]] = bodies.angles
        rows.append(row)
        corners, swings = corners + len(bodies.vertices), swings + len(bodies.angles)
        first.append(first[-1] + len(row))
    return {
        "rows": np.vstack(rows),
        "vertices": np.vstack([bodies.vertices for bodies in packed]),
        "angles": angles,
        "angle_steps": np.array([float(bodies.angle_step) for bodies in packed]),
        "first": np.array(first),
    }


CATCH, TOUCH, HASTE, GUIDE = range(4)  # terms of the reward
TERMS = 4


@njit(_nrt=False)
def pay(told, e, outcome, catches, share, weights, nearer):
    """Write the outcome of a step of arm e, and the terms of its reward.

    Parameters
    ----------
    told : Told
    catches : float
        Catches of the step, as a share of those that end an episode.
    share : float
        Of the horizon that the step took.
    weights : (4,) ndarray
    nearer : float
        Potential before the step less the discounted one after it. The potential after an end is
        0, or the optimum would change.
    """
    terms = told.terms
    told.outcomes[e] = outcome
    terms[e, CATCH] = weights[CATCH] * catches
    terms[e, TOUCH] = -weights[TOUCH] if outcome == COLLIDED else 0.0
    terms[e, HASTE] = -weights[HASTE] * share
    terms[e, GUIDE] = weights[GUIDE] * nearer


@njit(_nrt=False, forceinline=True)
def put(row, k, value):
    """Write a number."""
    row[k] = min(max(value, -EXTREME), EXTREME)


@njit(_nrt=False, forceinline=True)
def put_vector(row, k, x, y, z, unit):
    """Write the vector (x, y, z) in a unit."""
    put(row, k, x / unit)
    put(row, k + 1, y / unit)
    put(row, k + 2, z / unit)
