"""Many situations packed side by side, and where arms are in them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from gcm_learn.arms import PlanarLimb
from gcm_learn.compiled import njit
from gcm_learn.execution.nearness import MOMENT_COLUMNS
from gcm_learn.motion.rules import Rules
from gcm_learn.recall import own_axis
from gcm_learn.scene import Limits, Scene
from gcm_learn.scene.bodies import COLUMNS, FIRST, LAST, SWING, Bodies

HAND_VELOCITY, JOINT_VELOCITY = 0, 1  # what an action is
RUNNING, CAUGHT, COLLIDED, LATE = range(4)  # how an episode stands

# Columns of a body's row that a world adds.
LONG = COLUMNS  # 3: the longest axis in the body's own frame, see `own_axis`
ROW_COLUMNS = COLUMNS + 3

# Columns of a world's limbs and limits.
FAR, HORIZON = PlanarLimb._fields.index("far"), Limits._fields.index("horizon")

MOMENTS = 6  # that can be looked at at once


class World(NamedTuple):
    """Many situations in their canonical form, one after the other."""

    rows: np.ndarray  # (m, ROW_COLUMNS): all bodies
    vertices: np.ndarray  # (v, 2): of all bodies
    angles: np.ndarray  # (p, g, 2): of all pendulums, the shorter tables filled up
    angle_steps: np.ndarray  # (s,): resolution of these tables [s]
    first: np.ndarray  # (s + 1,) int64: rows of situation k are first[k]:first[k + 1]
    limbs: np.ndarray  # (s, 7): columns are the fields of `Limb`
    limits: np.ndarray  # (s, 5): those of `Limits`
    rules: np.ndarray  # (s, 4): those of `Rules`
    fields: np.ndarray  # (s or 0, n, n) float32: time to go as share of the horizon, see `guidance`


class State(NamedTuple):
    """Where many arms are, each in a situation of the world."""

    place: np.ndarray  # (e,) int64: situation
    hand: np.ndarray  # (e, 2), canonical coordinates of t = 0 [forearm lengths]
    time: np.ndarray  # (e,) [s]


class Options(NamedTuple):
    """Settings as kernels want them, see `settings`."""

    control: int  # HAND_VELOCITY or JOINT_VELOCITY
    joint_rate: float
    dt: float
    weights: np.ndarray  # (4,)
    discount: float
    slots: int
    fan: bool


class Told(NamedTuple):
    """What steps write, a row for each arm."""

    outcomes: np.ndarray  # (e,) int64: RUNNING, CAUGHT, COLLIDED or LATE
    terms: np.ndarray  # (e, 4): of the reward
    observations: np.ndarray  # (e, width) float32


class Workspace(NamedTuple):
    """Buffers for what is worked out for one arm after the other."""

    time: np.ndarray  # (2,): when the hand moves [s]
    hand: np.ndarray  # (2, 2): from where to where
    poses: np.ndarray  # (n, 12): n is the most bodies that a situation has
    moments: np.ndarray  # (MOMENTS, MOMENT_COLUMNS): see `nearness`
    gaps: np.ndarray  # (n, 3): see `observation`


@njit
def workspace_for(world, state, first, last):
    """Buffers for arms first to last - 1."""
    most = 1
    for e in range(first, last):
        s = state.place[e]
        most = max(most, world.first[s + 1] - world.first[s])
    moments, gaps = np.empty((MOMENTS, MOMENT_COLUMNS)), np.empty((most, 3))
    return Workspace(np.empty(2), np.empty((2, 2)), np.zeros((most, 12)), moments, gaps)


@njit
def scene_of(world, s):
    """Situation s, as all kernels of situations want it."""
    rows = world.rows[world.first[s] : world.first[s + 1]]
    bodies = Bodies(rows, world.vertices, world.angles, world.angle_steps[s])
    a, b = world.limbs, world.limits
    limb = PlanarLimb(a[s, 0], a[s, 1], a[s, 2], a[s, 3], a[s, 4], a[s, 5], a[s, 6])
    return Scene(bodies, limb, Limits(b[s, 0], b[s, 1], b[s, 2], b[s, 3], b[s, 4]))


@njit(_nrt=False)
def rules_in(world, s):
    """What movements keep in situation s."""
    a = world.rules
    return Rules(a[s, 0], a[s, 1], a[s, 2], a[s, 3])


def world_of(scenes: Sequence[Scene], rules: Sequence[Rules]) -> World:
    """Pack scenes side by side.

    Parameters
    ----------
    scenes : sequence of Scene
        Of situations in their canonical form.
    rules : sequence of Rules
    """
    return World(
        **side_by_side([scene.bodies for scene in scenes]),
        limbs=np.array([scene.limb for scene in scenes], dtype=float),
        limits=np.array([scene.limits for scene in scenes], dtype=float),
        rules=np.array(rules, dtype=float),
        fields=np.zeros((0, 2, 2), dtype=np.float32),
    )


def side_by_side(packed: Sequence[Bodies]) -> dict[str, np.ndarray]:
    """Bodies of many situations; indices into vertices and pendulums move along.

    Returns
    -------
    dict
        What `World` says of them, by its names.
    """
    longest = max(b.angles.shape[1] for b in packed)
    angles = np.zeros((sum(len(b.angles) for b in packed), longest, 2))
    rows, first = [], [0]
    corners, swings = 0, 0
    for bodies in packed:
        row = np.zeros((len(bodies.rows), ROW_COLUMNS))
        row[:, :LONG] = bodies.rows
        row[:, LONG:] = [own_axis(bodies, b) for b in range(len(row))]
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
