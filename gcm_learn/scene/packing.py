"""Situations as arrays for kernels, and the packing of records into these arrays."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from gcm_learn.arms import PLANAR, ByKind, kind_of
from gcm_learn.compiled import njit
from gcm_learn.scene import bodies as k
from gcm_learn.scene.bodies import Bodies
from gcm_learn.scene.laws import LAWS, Tables, WorldFrame, swing_tables
from gcm_learn.scene.shapes.choice import entry_of
from gcm_learn.situation import AnySituation, Pendulum, arm_frame


class Limits(NamedTuple):
    """Limits of a movement, as the situation gives them."""

    speed: float  # of the hand [forearms/s]
    shoulder: float  # of the joints [rad/s], infinite where there is no limit
    elbow: float
    grasp: float  # signed distance of hand and target at which it is caught [forearms]
    horizon: float  # last moment at which a catch counts [s]


class JointLimits(NamedTuple):
    """Limits of a movement in the joints; infinite where the situation gives none."""

    joint_speed: np.ndarray  # (n,) [rad/s; lengths/s of prismatic joints]
    joint_acceleration: np.ndarray  # (n,) [the same per second]
    speed: float  # of the hand [lengths/s]
    grasp: float  # signed distance of hand and target at which it is caught [lengths]
    horizon: float  # last moment at which a catch counts [s]


class Scene(NamedTuple):
    """A situation, packed once and handed from kernel to kernel.

    A planar arm has a `PlanarLimb` with `Limits`, other arms a limb of their kind with
    `JointLimits`.
    """

    bodies: Bodies
    limb: Any  # of the kind of the arm
    limits: Any  # Limits or JointLimits


_UNTURNED = np.eye(3)
AFTER = 4.0
"""Time after the last hold in which an arm comes to rest [s]."""


def pack(situation: AnySituation, until: float | None = None) -> Scene:
    """Pack a situation into arrays and numbers, in coordinates of the arm's plane or base.

    Parameters
    ----------
    situation : Situation
    until : float, optional
        Last moment at which bodies are asked for; by default the horizon, and after it the time
        for holds and stops [s].

    Returns
    -------
    Scene
    """
    names = tuple(body.name for body in situation.bodies)
    limb = kind_of(situation).pack(situation.arm, names)
    limits = _LIMITS.of(situation)(situation)
    return Scene(pack_bodies(situation, until), limb, limits)


def _limits(situation: Any) -> Limits:
    arm, horizon = situation.arm, situation.horizon
    shoulder, elbow = arm.max_joint_speed or (math.inf, math.inf)
    return Limits(arm.max_hand_speed, shoulder, elbow, arm.grasp, horizon)


def _joint_limits(situation: Any) -> JointLimits:
    arm = situation.arm
    count = len(arm.joints)
    acceleration = arm.max_joint_acceleration or (math.inf,) * count
    speed = math.inf if arm.max_hand_speed is None else arm.max_hand_speed
    return JointLimits(
        np.array(arm.max_joint_speed), np.array(acceleration), speed, arm.grasp, situation.horizon
    )


_LIMITS: ByKind[Callable[[Any], Any]] = ByKind({PLANAR: _limits}, default=_joint_limits)


def pack_bodies(situation: AnySituation, until: float | None = None) -> Bodies:
    """Pack a situation's bodies into arrays, in coordinates of the arm's plane or base.

    Parameters
    ----------
    situation : Situation
        Solids are turned into the frame (plane.x, plane.y, plane normal) of a planar arm, or that
        of a spatial arm's base.
    until : float, optional
        See `pack`.

    Returns
    -------
    Bodies
        Arrays indexed as ``situation.bodies``.
    """
    turn, shoulder = arm_frame(situation)
    view = WorldFrame(None if (turn == _UNTURNED).all() else turn, shoulder.tolist())
    made: list[list[float]] = []  # lists, because writing into parts of arrays takes longer
    corners: list[Any] = [np.zeros((0, 2))]
    count = 0
    tables: Tables = []
    for body in situation.bodies:
        motion, shape, row = body.motion, body.shape, [0.0] * k.COLUMNS
        entry = entry_of(shape)
        row[k.KIND], row[k.BALL] = entry.number, entry.is_ball
        row[k.PART] = k.HAND if body.role == "target" else k.LIMB
        row[k.SIZE : k.SIZE + 3] = entry.sizes(shape)
        row[k.REACH] = shape.bounding_radius
        for asked, at in zip(body.approach, (0, k.SECOND), strict=False):
            row[k.APPROACH + at : k.APPROACH + at + 3] = asked.axis
            row[k.WITHIN + at] = asked.within
            row[k.TOWARDS + at : k.TOWARDS + at + 3] = asked.hand or (0.0, 0.0, 0.0)
        if body.margin is not None:
            row[k.MARGIN], row[k.MARGIN_RATE] = body.margin.now, body.margin.rate
        row[k.HOLD] = -1.0
        if body.hold is not None:
            row[k.HOLD], row[k.HOLD_SPEED] = body.hold.seconds, body.hold.relative_speed
        row[k.SWING] = -1.0
        LAWS[type(motion)].place(row, tables, motion, view)
        if entry.is_ball and not body.approach and body.hold is None:  # no spin can be seen
            row[k.SPIN : k.SPIN + 3] = (0.0, 0.0, 0.0)
            if row[k.PIECES]:
                tables[-1][:, k.SPIN : k.SPIN + 3] = 0.0
        row[k.FIRST] = row[k.LAST] = count
        if len(given := entry.vertices(shape)):
            corners.append(given)
            row[k.LAST] = count = count + len(given)
        made.append(row)
    rows = np.array(made, dtype=float).reshape(-1, k.COLUMNS)
    end = _end_of(situation) if until is None else until
    step, angles = _tables_of(tables, end)
    packed = Bodies(rows, np.concatenate(corners), angles, step)
    _bound_speeds(packed, end)
    return packed


def _end_of(situation: Any) -> float:
    """Return the time until which planned movements may go on [s]."""
    holds = [body.hold.seconds for body in situation.targets if body.hold is not None]
    goes_on = holds or situation.end == "rest"
    return float(situation.horizon + (max(holds, default=0.0) + AFTER if goes_on else 0.0))


def _tables_of(tables: Tables, horizon: float) -> tuple[float, np.ndarray]:
    """Return step and `angles` of pendulums and pieces; tables of pieces end in zeros."""
    swings = [table for table in tables if isinstance(table, Pendulum)]
    pieces = [k.PIECE_ROWS * len(table) for table in tables if not isinstance(table, Pendulum)]
    step, angles = swing_tables(swings, horizon, max([64, *pieces]))
    if not pieces:
        return step, angles
    length = angles.shape[1] if swings else max(pieces)
    result, swung = np.zeros((len(tables), length, 2)), iter(angles)
    for entry, table in zip(result, tables, strict=True):
        rows = next(swung) if isinstance(table, Pendulum) else table.reshape(-1, 2)
        entry[: len(rows)] = rows
    return step, result


def pose(situation: AnySituation, index: int, t: float) -> tuple[np.ndarray, np.ndarray]:
    """Pose of one body at time t.

    Parameters
    ----------
    situation : Situation
    index : int
        Position in ``situation.bodies``.
    t : float
        Time [s], within the horizon for pendulums.

    Returns
    -------
    centre : (3,) ndarray
        In arm-plane coordinates, where z = 0 is the arm's plane, or those of the base.
    rotation : (3, 3) ndarray
        Body frame to the same frame; the columns are the body's axes.
    """
    bodies = pack_bodies(situation)
    poses = np.zeros((len(situation.bodies), 12))
    poses[index, 3:] = np.eye(3).ravel()  # discs and spheres leave it so
    k.pose_at(bodies, index, t, poses)
    return poses[index, :3].copy(), poses[index, 3:].reshape(3, 3).copy()


@njit
def _bound_speeds(bodies, horizon):
    """Fill in bounds on the speed of each body's points and margin during [0, horizon]."""
    rows = bodies.rows
    for b in range(rows.shape[0]):
        if rows[b, k.SWING] < 0.0:
            rows[b, k.TOP_SPEED] = k.top_speed(k.of_row, bodies, b, 0, 0.0, horizon)
        elif rows[b, k.PIECES] > 0.0:
            for p in range(int(rows[b, k.PIECES])):
                start = k.of_piece(bodies, b, p, k.START)
                if start <= horizon:
                    span = min(k.piece_end(bodies, b, p), horizon) - start
                    fast = k.top_speed(k.of_piece, bodies, b, p, 0.0, span)
                    rows[b, k.TOP_SPEED] = max(rows[b, k.TOP_SPEED], fast)
        else:
            rate, swing = 0.0, int(rows[b, k.SWING])
            for i in range(bodies.angles.shape[1]):
                rate = max(rate, abs(bodies.angles[swing, i, 1]))
            reach = rows[b, k.HANG] + rows[b, k.REACH]
            rows[b, k.TOP_SPEED] = rate * (1.0 + 1e-6) * reach
        rows[b, k.TOP_SPEED] += rows[b, k.MARGIN_RATE]
