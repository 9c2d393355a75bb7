"""Situations some time later."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any, TypeVar

from gcm_learn.arms import Arm, Chain, SpatialArm
from gcm_learn.errors import ArmKindError, SituationError
from gcm_learn.scene.laws import LAWS
from gcm_learn.situation import Body, Situation

AnyKind = TypeVar("AnyKind", Situation[Arm], Situation[SpatialArm], Situation[Chain])


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
        Posture of an arm that moves in its joints then [rad or lengths]; by default it has rested,
        which only one can that rests at t = 0.
    rates : (dof,) sequence of float, optional
        Rates of its joints then [rad/s]; 0 by default.

    Returns
    -------
    Situation
        Its bodies go on as they would have; its horizon is shorter by t.
    """
    arm: Any = situation.arm
    if not isinstance(arm, Arm):
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
    """Return bodies `t` seconds later, as they go on then."""
    return tuple(
        replace(body, motion=LAWS[type(body.motion)].later(body.motion, t)) for body in bodies
    )


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
