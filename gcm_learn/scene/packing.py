"""From a situation's records to the arrays that kernels read."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from gcm_learn.arms import PLANAR, Arm, ByKind, kind_of, rotation_of
from gcm_learn.compiled import njit
from gcm_learn.scene import bodies as k
from gcm_learn.scene.bodies import Bodies
from gcm_learn.scene.scene import JointLimits, Limits, Scene
from gcm_learn.situation import (
    AnySituation,
    Box,
    Capsule,
    Cylinder,
    Disc,
    Pendulum,
    PlanarQuadratic,
    Polygon,
    SolidQuadratic,
    Sphere,
    arm_frame,
)

_KIND = {
    Disc: k.DISC,
    Polygon: k.POLYGON,
    Sphere: k.SPHERE,
    Box: k.BOX,
    Capsule: k.CAPSULE,
    Cylinder: k.CYLINDER,
}
_UNTURNED = np.eye(3)
_SWING_STEPS_PER_PERIOD = 2000  # Hermite error about (2 pi / 2000)^4 / 384, i.e. 3e-13 rad


def pack(situation: AnySituation) -> Scene:
    """Pack a situation into arrays and numbers, in coordinates of the arm's plane or base.

    Parameters
    ----------
    situation : Situation

    Returns
    -------
    Scene
    """
    names = tuple(body.name for body in situation.bodies)
    limb = kind_of(situation).pack(situation.arm, names)
    limits = _LIMITS.of(situation)(situation.arm, situation.horizon)
    return Scene(pack_bodies(situation), limb, limits)


def _limits(arm: Arm, horizon: float) -> Limits:
    shoulder, elbow = arm.max_joint_speed or (math.inf, math.inf)
    return Limits(arm.max_hand_speed, shoulder, elbow, arm.grasp, horizon)


def joint_limits(arm: Any, horizon: float) -> JointLimits:
    """Return the limits of an arm that moves in its joints."""
    count = len(arm.joints)
    acceleration = arm.max_joint_acceleration or (math.inf,) * count
    speed = math.inf if arm.max_hand_speed is None else arm.max_hand_speed
    return JointLimits(
        np.array(arm.max_joint_speed), np.array(acceleration), speed, arm.grasp, horizon
    )


_LIMITS: ByKind[Callable[[Any, float], Any]] = ByKind({PLANAR: _limits}, default=joint_limits)


def pack_bodies(situation: AnySituation) -> Bodies:
    """Pack a situation's bodies into arrays, in arm-plane coordinates or those of the base.

    Parameters
    ----------
    situation : Situation
        Solids are turned into the frame (plane.x, plane.y, plane normal) of a planar arm, or that
        of a spatial arm's base.

    Returns
    -------
    Bodies
        Arrays indexed as ``situation.bodies``.
    """
    turn, shoulder = arm_frame(situation)
    frame = None if (turn == _UNTURNED).all() else turn
    origin = shoulder.tolist()
    made: list[list[float]] = []  # lists, because writing into parts of arrays takes longer
    vertices: list[tuple[float, float]] = []
    swings: list[Pendulum] = []
    for body in situation.bodies:
        motion, shape, row = body.motion, body.shape, [0.0] * k.COLUMNS
        row[k.KIND] = _KIND[type(shape)]
        row[k.PART] = k.HAND if body.role == "target" else k.LIMB
        row[k.SIZE : k.SIZE + 3] = _size(shape)
        row[k.REACH] = shape.bounding_radius
        row[k.SWING] = -1.0
        if isinstance(motion, Pendulum):
            row[k.SWING] = len(swings)
            swings.append(motion)
            _place_swing(row, motion, frame, origin)
        elif isinstance(motion, SolidQuadratic):
            _place_solid(row, motion, frame, origin)
        else:
            _place_planar(row, motion)
        if isinstance(shape, Disc | Sphere):  # nobody can see them spin
            row[k.SPIN : k.SPIN + 3] = (0.0, 0.0, 0.0)
        row[k.FIRST] = len(vertices)
        vertices.extend(shape.vertices if isinstance(shape, Polygon) else ())
        row[k.LAST] = len(vertices)
        made.append(row)
    rows = np.array(made, dtype=float).reshape(-1, k.COLUMNS)
    step, angles = _swing_tables(swings, situation.horizon)
    _bound_speeds(rows, angles, situation.horizon)
    return Bodies(rows, np.array(vertices, dtype=float).reshape(-1, 2), angles, step)


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


def _place_planar(row: list[float], motion: PlanarQuadratic) -> None:
    row[k.POSITION : k.POSITION + 2] = motion.position
    row[k.VELOCITY : k.VELOCITY + 2] = motion.velocity
    row[k.ACCELERATION : k.ACCELERATION + 2] = motion.acceleration
    row[k.SPIN + 2] = motion.spin
    c, s = math.cos(motion.angle), math.sin(motion.angle)
    row[k.TURN : k.TURN + 9] = (c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0)


def _turned(frame: np.ndarray | None, vector: Sequence[float]) -> list[float]:
    """A vector of the world in the arm's coordinates; `frame` is None where they are not turned.

    Mostly they are not, and numpy takes long for three numbers.
    """
    if frame is None:
        x, y, z = vector
        return [x + 0.0, y + 0.0, z + 0.0]  # as a product: without negative zeros
    seen: list[float] = (frame @ vector).tolist()
    return seen


def _placed(
    frame: np.ndarray | None, origin: Sequence[float], point: Sequence[float]
) -> list[float]:
    """A point of the world in the arm's coordinates."""
    return _turned(frame, [a - b for a, b in zip(point, origin, strict=True)])


def _place_solid(
    row: list[float], motion: SolidQuadratic, frame: np.ndarray | None, origin: Sequence[float]
) -> None:
    row[k.POSITION : k.POSITION + 3] = _placed(frame, origin, motion.position)
    row[k.VELOCITY : k.VELOCITY + 3] = _turned(frame, motion.velocity)
    row[k.ACCELERATION : k.ACCELERATION + 3] = _turned(frame, motion.acceleration)
    row[k.SPIN : k.SPIN + 3] = _turned(frame, motion.spin)
    rotation = rotation_of(motion.orientation)
    turn = rotation + 0.0 if frame is None else frame @ rotation
    row[k.TURN : k.TURN + 9] = turn.ravel().tolist()


def _place_swing(
    row: list[float], motion: Pendulum, frame: np.ndarray | None, origin: Sequence[float]
) -> None:
    row[k.POSITION : k.POSITION + 3] = _placed(frame, origin, motion.pivot)
    row[k.HANG] = motion.hang_distance
    row[k.DOWN : k.DOWN + 3] = _turned(frame, motion.down)
    row[k.SIDE : k.SIDE + 3] = _turned(frame, np.cross(motion.axis, motion.down).tolist())
    row[k.AXIS : k.AXIS + 3] = _turned(frame, motion.axis)


def _size(shape: object) -> tuple[float, float, float]:
    if isinstance(shape, Disc | Sphere):
        return (shape.radius, 0.0, 0.0)
    if isinstance(shape, Capsule | Cylinder):
        return (shape.radius, shape.half_length, 0.0)
    if isinstance(shape, Box):
        return shape.half_extents
    return (0.0, 0.0, 0.0)


@njit
def _bound_speeds(rows, angles, horizon):
    """Fill in the largest speed of any point of each body during [0, horizon]."""
    for b in range(rows.shape[0]):
        early, late, spin = 0.0, 0.0, 0.0
        for i in range(3):
            velocity = rows[b, k.VELOCITY + i]
            early += velocity**2
            late += (velocity + rows[b, k.ACCELERATION + i] * horizon) ** 2
            spin += rows[b, k.SPIN + i] ** 2
        # Speed is convex in time under constant acceleration: its maximum is at an end.
        rows[b, k.TOP_SPEED] = np.sqrt(max(early, late)) + np.sqrt(spin) * rows[b, k.REACH]
        if rows[b, k.SWING] >= 0.0:
            rate = np.abs(angles[int(rows[b, k.SWING]), :, 1]).max() * (1.0 + 1e-6)
            rows[b, k.TOP_SPEED] = rate * (rows[b, k.HANG] + rows[b, k.REACH])


def _swing_tables(swings: list[Pendulum], horizon: float) -> tuple[float, np.ndarray]:
    """Integrate every pendulum on one time grid: (step [s], (k, m, 2) angle and rate)."""
    if not swings:
        return 1.0, np.zeros((0, 2, 2))
    fastest = max(m.fastest for m in swings)
    wanted = int(np.ceil(horizon * fastest * _SWING_STEPS_PER_PERIOD / (2 * np.pi))) + 2
    count = max(wanted, 64)
    step = horizon / (count - 2)
    tables = [
        integrate_swing(m.angle, m.rate, m.gravity / m.length, m.damping, step, count)
        for m in swings
    ]
    return step, np.array(tables)


@njit
def integrate_swing(angle, rate, stiffness, damping, step, count):
    """Integrate angle'' = -stiffness sin(angle) - damping angle' by classical Runge-Kutta.

    Returns
    -------
    (count, 2) ndarray
        Angle [rad] and rate [rad/s] at 0, step, 2 step, ...
    """
    out = np.empty((count, 2))
    out[0, 0], out[0, 1] = angle, rate
    for i in range(1, count):
        k1 = -stiffness * np.sin(angle) - damping * rate
        r2 = rate + 0.5 * step * k1
        k2 = -stiffness * np.sin(angle + 0.5 * step * rate) - damping * r2
        r3 = rate + 0.5 * step * k2
        k3 = -stiffness * np.sin(angle + 0.5 * step * r2) - damping * r3
        r4 = rate + step * k3
        k4 = -stiffness * np.sin(angle + step * r3) - damping * r4
        angle += step * (rate + 2.0 * r2 + 2.0 * r3 + r4) / 6.0
        rate += step * (k1 + 2.0 * k2 + 2.0 * k3 + k4) / 6.0
        out[i, 0], out[i, 1] = angle, rate
    return out
