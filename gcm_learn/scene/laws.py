"""Motion laws: their packing into arrays and their continuation from a later time."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, TypeVar

import numpy as np

from gcm_learn import arms
from gcm_learn.compiled import njit
from gcm_learn.errors import ArmKindError, SituationError
from gcm_learn.scene import bodies as k
from gcm_learn.situation import (
    Body,
    Pendulum,
    Piece,
    Piecewise,
    PlanarQuadratic,
    Sampled,
    Situation,
    SolidQuadratic,
)

STEPS_PER_PERIOD = 2000  # Hermite error about (2 pi / 2000)^4 / 384, i.e. 3e-13 rad


def swing_tables(
    swings: list[Pendulum], horizon: float, least: int = 64
) -> tuple[float, np.ndarray]:
    """Integrate every pendulum on one time grid of at least `least` entries.

    Returns
    -------
    step : float
        Time step of the grid [s].
    angles : (k, m, 2) ndarray
        Angle [rad] and rate [rad/s].
    """
    if not swings:
        return 1.0, np.zeros((0, 2, 2))
    fastest = max(m.fastest for m in swings)
    wanted = int(np.ceil(horizon * fastest * STEPS_PER_PERIOD / (2 * np.pi))) + 2
    count = max(wanted, least)
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


Tables = list[Any]
"""Entries of `Bodies.angles`: pendulums, or lists of pieces."""


class WorldFrame(NamedTuple):
    """Transformation from the world's coordinates to the arm's."""

    turn: np.ndarray | None  # (3, 3) world -> arm; None where it is not turned
    origin: list[float]  # (3,) in the world

    def turned(self, vector: Sequence[float]) -> list[float]:
        """Return a vector of the world in the arm's coordinates.

        Most arms are not turned, and numpy takes long for three numbers.
        """
        if self.turn is None:
            x, y, z = vector
            return [x + 0.0, y + 0.0, z + 0.0]  # as a product: without negative zeros
        seen: list[float] = (self.turn @ vector).tolist()
        return seen

    def placed(self, point: Sequence[float]) -> list[float]:
        """Return a point of the world in the arm's coordinates."""
        return self.turned([a - b for a, b in zip(point, self.origin, strict=True)])


@dataclass(frozen=True)
class PackedLaw:
    """Functions of one motion law.

    Parameters
    ----------
    place : callable
        Writes a motion, seen in a frame, into a body's row and the tables.
    later : callable
        Maps a motion and a time [s] to the motion from then on.
    """

    place: Callable[[list[float], Tables, Any, WorldFrame], None]
    later: Callable[[Any, float], Any]


def _place_planar(
    row: list[float], tables: Tables, motion: PlanarQuadratic, frame: WorldFrame
) -> None:
    row[k.POSITION : k.POSITION + 2] = motion.position
    row[k.VELOCITY : k.VELOCITY + 2] = motion.velocity
    row[k.ACCELERATION : k.ACCELERATION + 2] = motion.acceleration
    row[k.SPIN + 2] = motion.spin
    c, s = math.cos(motion.angle), math.sin(motion.angle)
    row[k.TURN : k.TURN + 9] = (c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0)


def _place_solid(
    row: list[float], tables: Tables, motion: SolidQuadratic, frame: WorldFrame
) -> None:
    row[k.POSITION : k.POSITION + 3] = frame.placed(motion.position)
    row[k.VELOCITY : k.VELOCITY + 3] = frame.turned(motion.velocity)
    row[k.ACCELERATION : k.ACCELERATION + 3] = frame.turned(motion.acceleration)
    row[k.SPIN : k.SPIN + 3] = frame.turned(motion.spin)
    rotation = arms.rotation_of(motion.orientation)
    turn = rotation + 0.0 if frame.turn is None else frame.turn @ rotation
    row[k.TURN : k.TURN + 9] = turn.ravel().tolist()


def _place_swing(row: list[float], tables: Tables, motion: Pendulum, frame: WorldFrame) -> None:
    row[k.SWING] = len(tables)
    tables.append(motion)
    row[k.POSITION : k.POSITION + 3] = frame.placed(motion.pivot)
    row[k.HANG] = motion.hang_distance
    row[k.DOWN : k.DOWN + 3] = frame.turned(motion.down)
    row[k.SIDE : k.SIDE + 3] = frame.turned(np.cross(motion.axis, motion.down).tolist())
    row[k.AXIS : k.AXIS + 3] = frame.turned(motion.axis)


def _place_pieces(
    row: list[float], tables: Tables, motion: Piecewise | Sampled, frame: WorldFrame
) -> None:
    starts, position, velocity, acceleration, orientation, spin = motion.arrays
    row[k.SWING], row[k.PIECES] = len(tables), len(starts)
    turn = arms.rotations_of(orientation)
    rows = np.zeros((len(starts), k.PIECE_COLUMNS))
    rows[:, k.START] = starts
    span = np.diff(starts)[:, None]
    ends = position[:-1] + velocity[:-1] * span + 0.5 * acceleration[:-1] * span * span
    rows[1:, k.JUMP] = np.linalg.norm(ends - position[1:], axis=1)
    rows[1:, k.JUMP_TURN] = _angles_between(arms.turned_by(spin[:-1] * span) @ turn[:-1], turn[1:])
    view = np.eye(3) if frame.turn is None else frame.turn
    rows[:, k.POSITION : k.POSITION + 3] = (position - frame.origin) @ view.T
    rows[:, k.VELOCITY : k.VELOCITY + 3] = velocity @ view.T
    rows[:, k.ACCELERATION : k.ACCELERATION + 3] = acceleration @ view.T
    rows[:, k.SPIN : k.SPIN + 3] = spin @ view.T
    rows[:, k.TURN : k.TURN + 9] = (view @ turn).reshape(-1, 9)
    tables.append(rows)
    law = slice(k.POSITION, k.TURN + 9)
    row[law] = rows[0, law].tolist()  # for readers of t = 0 only


def _angles_between(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Return the angles (n,) [rad] between rotations (n, 3, 3)."""
    off = np.linalg.norm(first.transpose(0, 2, 1) @ second - np.eye(3), axis=(1, 2))
    return 2.0 * np.arcsin(np.minimum(off / math.sqrt(8.0), 1.0))  # off = 2 sqrt(2) sin(angle / 2)


def _planar_later(motion: PlanarQuadratic, t: float) -> PlanarQuadratic:
    position, velocity = _flown(motion, t)
    angle = motion.angle + motion.spin * t
    return replace(motion, position=position, velocity=velocity, angle=angle)


def _solid_later(motion: SolidQuadratic, t: float) -> SolidQuadratic:
    position, velocity = _flown(motion, t)
    made = replace(motion, position=position, velocity=velocity)
    return replace(made, orientation=_turned(motion, t)) if any(motion.spin) else made


def _swing_later(motion: Pendulum, t: float) -> Pendulum:
    """Return the pendulum from t on; its angle is integrated as finely as in `swing_tables`."""
    if t <= 0.0:
        return motion
    count = max(math.ceil(t * motion.fastest * STEPS_PER_PERIOD / (2.0 * math.pi)), 64) + 1
    table = integrate_swing(
        motion.angle, motion.rate, motion.gravity / motion.length, motion.damping,
        t / (count - 1), count,
    )  # fmt: skip
    return replace(motion, angle=float(table[-1, 0]), rate=float(table[-1, 1]))


def _pieces_later(motion: Piecewise, t: float) -> Piecewise:
    now = motion.at(t)
    first = Piece(0.0, _solid_later(now.motion, t - now.start))
    others = (Piece(piece.start - t, piece.motion) for piece in motion.pieces if piece.start > t)
    return Piecewise.unchecked((first, *others))


def _samples_later(motion: Sampled, t: float) -> Sampled:
    start, law = motion.at(t)
    now = _solid_later(law, t - start)
    ahead = [i for i, time in enumerate(motion.times) if time > t]
    turns = motion.orientations
    return Sampled(
        (0.0, *(motion.times[i] - t for i in ahead)),
        (now.position, *(motion.positions[i] for i in ahead)),
        None if turns is None else (now.orientation, *(turns[i] for i in ahead)),
    )


def _flown(motion: PlanarQuadratic | SolidQuadratic, t: float) -> tuple[tuple, tuple]:
    """Return position and velocity at t."""
    p, v, a = (np.array(x) for x in (motion.position, motion.velocity, motion.acceleration))
    return tuple((p + v * t + 0.5 * a * t * t).tolist()), tuple((v + a * t).tolist())


def _turned(motion: SolidQuadratic, t: float) -> tuple[float, float, float, float]:
    """Return the orientation at t: Rodrigues' formula for exp([spin t])."""
    spin = np.array(motion.spin)
    rate = float(np.linalg.norm(spin))
    if rate < 1e-150:  # its square is nothing
        return motion.orientation
    x, y, z = spin / rate
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turn = np.eye(3) + math.sin(rate * t) * cross + (1 - math.cos(rate * t)) * cross @ cross
    return arms.quaternion_of(turn @ arms.rotation_of(motion.orientation))


LAWS: dict[type, PackedLaw] = {
    PlanarQuadratic: PackedLaw(_place_planar, _planar_later),
    SolidQuadratic: PackedLaw(_place_solid, _solid_later),
    Pendulum: PackedLaw(_place_swing, _swing_later),
    Piecewise: PackedLaw(_place_pieces, _pieces_later),
    Sampled: PackedLaw(_place_pieces, _samples_later),
}


AnyKind = TypeVar("AnyKind", Situation[arms.Arm], Situation[arms.Chain])


def later(
    situation: AnyKind,
    t: float,
    hand: tuple[float, float] | None = None,
    *,
    joints: Sequence[float] | None = None,
    rates: Sequence[float] | None = None,
) -> AnyKind:
    """The situation `t` seconds later.

    Parameters
    ----------
    situation : Situation
    t : float
        From 0 to less than the horizon [s].
    hand : (2,) tuple of float, optional
        Where the hand of a planar arm is then; by default it has rested.
    joints : (dof,) sequence of float, optional
        Posture then of an arm that moves in its joints [rad or lengths]; by default that of t = 0,
        which requires an arm that rests there.
    rates : (dof,) sequence of float, optional
        Rates of its joints then [rad/s]; 0 by default.

    Returns
    -------
    Situation
        Its bodies go on as they would have; its horizon is shorter by t.
    """
    arm: Any = situation.arm
    if not isinstance(arm, arms.Arm):
        if hand is not None:
            raise ArmKindError("hand: is of planar arms; others have joints")
        arm = _stands(arm, t, joints, rates)
    elif joints is not None or rates is not None:
        raise ArmKindError("joints, rates: are of spatial arms; a planar one has a hand")
    elif hand is not None:
        arm = replace(arm, hand=hand)
    bodies = bodies_later(situation.bodies, t)
    return replace(situation, arm=arm, bodies=bodies, horizon=situation.horizon - t)


def bodies_later(bodies: Iterable[Body], t: float) -> tuple[Body, ...]:
    """Return the bodies with motions that begin `t` seconds later."""
    return tuple(_later(body, t) for body in bodies)


def _later(body: Body, t: float) -> Body:
    motion, margin = LAWS[type(body.motion)].later(body.motion, t), body.margin
    if margin is not None:
        margin = replace(margin, now=margin.now + margin.rate * t)
    return replace(body, motion=motion, margin=margin)


def _stands(
    arm: Any, t: float, joints: Sequence[float] | None, rates: Sequence[float] | None
) -> Any:
    """The arm with other joints and rates at t = 0."""
    if joints is None and rates is None and (t <= 0.0 or not any(arm.joint_rates or ())):
        return arm
    if joints is None:
        raise SituationError("joints", "are needed of an arm that moves")
    if rates is None and arm.max_joint_acceleration is not None:
        rates = (0.0,) * len(arm.joints)
    there: Any = tuple(joints)
    moving: Any = None if rates is None else tuple(rates)
    return replace(arm, joints=there, joint_rates=moving)
