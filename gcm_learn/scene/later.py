"""A situation seen some time later: the world has moved on, and perhaps the hand."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np

from gcm_learn.arms import JOINTS, Arm, SpatialArm, quaternion_of, rotation_of
from gcm_learn.errors import ArmKindError, SituationError
from gcm_learn.scene.packing import integrate_swing
from gcm_learn.situation import Body, Motion, Pendulum, PlanarQuadratic, Situation, SolidQuadratic

AnyKind = TypeVar("AnyKind", Situation[Arm], Situation[SpatialArm])

STEPS_PER_PERIOD = 2000  # of a swing, as packed bodies have it


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
    joints : (4,) sequence of float, optional
        How a spatial arm stands then [rad]; by default it has rested, which only one can that
        rests at t = 0.
    rates : (4,) sequence of float, optional
        Rates of its joints then [rad/s]; 0 by default.

    Returns
    -------
    Situation
        Its bodies go on as they would have; its horizon is shorter by t.
    """
    arm: Any = situation.arm
    if isinstance(arm, SpatialArm):
        if hand is not None:
            raise ArmKindError("hand: is of planar arms; a spatial one has joints")
        arm = _stands(arm, t, joints, rates)
    elif joints is not None or rates is not None:
        raise ArmKindError("joints, rates: are of spatial arms; a planar one has a hand")
    elif hand is not None:
        arm = replace(arm, hand=hand)
    bodies = tuple(_moved(body, t) for body in situation.bodies)
    return replace(situation, arm=arm, bodies=bodies, horizon=situation.horizon - t)


def _stands(
    arm: SpatialArm, t: float, joints: Sequence[float] | None, rates: Sequence[float] | None
) -> SpatialArm:
    """The arm with other joints and rates at t = 0."""
    if joints is None and rates is None and (t <= 0.0 or not any(arm.joint_rates or ())):
        return arm
    if joints is None:
        raise SituationError("joints", "are to be told of an arm that moves")
    if rates is None and arm.max_joint_acceleration is not None:
        rates = (0.0,) * JOINTS
    there: Any = tuple(joints)
    moving: Any = None if rates is None else tuple(rates)
    return replace(arm, joints=there, joint_rates=moving)


def _moved(body: Body, t: float) -> Body:
    motion = body.motion
    made: Motion
    if isinstance(motion, PlanarQuadratic):
        position, velocity = _flown(motion, t)
        angle = motion.angle + motion.spin * t
        made = replace(motion, position=position, velocity=velocity, angle=angle)
    elif isinstance(motion, SolidQuadratic):
        position, velocity = _flown(motion, t)
        made = replace(motion, position=position, velocity=velocity)
        if any(motion.spin):
            made = replace(made, orientation=_turned(motion, t))
    else:
        made = _swung(motion, t)
    return replace(body, motion=made)


def _flown(motion: PlanarQuadratic | SolidQuadratic, t: float) -> tuple[tuple, tuple]:
    """Position and velocity at t."""
    p, v, a = (np.array(x) for x in (motion.position, motion.velocity, motion.acceleration))
    return tuple((p + v * t + 0.5 * a * t * t).tolist()), tuple((v + a * t).tolist())


def _turned(motion: SolidQuadratic, t: float) -> tuple[float, float, float, float]:
    """Orientation at t: Rodrigues' formula for exp([spin t])."""
    spin = np.array(motion.spin)
    rate = float(np.linalg.norm(spin))
    if rate < 1e-150:  # its square is nothing
        return motion.orientation
    x, y, z = spin / rate
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turn = np.eye(3) + math.sin(rate * t) * cross + (1 - math.cos(rate * t)) * cross @ cross
    return quaternion_of(turn @ rotation_of(motion.orientation))


def _swung(motion: Pendulum, t: float) -> Pendulum:
    """The pendulum at t, its angle integrated as finely as where bodies are packed."""
    if t <= 0.0:
        return motion
    count = max(math.ceil(t * motion.fastest * STEPS_PER_PERIOD / (2.0 * math.pi)), 64) + 1
    table = integrate_swing(
        motion.angle, motion.rate, motion.gravity / motion.length, motion.damping,
        t / (count - 1), count,
    )  # fmt: skip
    return replace(motion, angle=float(table[-1, 0]), rate=float(table[-1, 1]))
