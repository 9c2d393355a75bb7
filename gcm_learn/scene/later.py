"""Situations some time later, and pieces of motion in a time that runs backwards."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np

from gcm_learn.arms import Arm, Chain, SpatialArm
from gcm_learn.errors import ArmKindError, SituationError
from gcm_learn.scene import bodies as k
from gcm_learn.scene.bodies import Bodies, pose_at
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


def reverse_pieces(bodies: Bodies, rows: np.ndarray, angles: np.ndarray, end: float) -> None:
    """Write the pieces of bodies for which at t happens what happens at end - t.

    Parameters
    ----------
    bodies : Bodies
    rows : (n, COLUMNS) ndarray
        Rows of the reversed bodies; those of bodies with pieces are renewed.
    angles : (k, m, 2) ndarray
        Their tables; the entries of bodies with pieces are renewed.
    end : float
        Time at which the reversed motion begins [s].
    """
    for b in np.flatnonzero(rows[:, k.PIECES] > 0.0):
        entry, count = int(rows[b, k.SWING]), int(rows[b, k.PIECES])
        mine = bodies.angles[entry, : k.PIECE_ROWS * count].reshape(count, -1)
        mine = mine[(mine[:, k.START] < end) | (mine[:, k.START] == 0.0)]
        until = np.append(mine[1:, k.START], end)
        jumps = np.vstack([mine[1:, k.JUMP : k.JUMP_TURN + 1], np.zeros((1, 2))])
        turned = (_reversed(piece, t) for piece, t in zip(mine, until, strict=True))
        backwards = np.array(list(turned))[::-1].copy()
        backwards[:, k.START] = end - until[::-1]
        backwards[:, k.JUMP : k.JUMP_TURN + 1] = jumps[::-1]
        rows[b, k.PIECES] = len(mine)
        rows[b, k.POSITION : k.TURN + 9] = backwards[0, k.POSITION : k.TURN + 9]
        angles[entry] = 0.0
        angles[entry, : k.PIECE_ROWS * len(mine)] = backwards.reshape(-1, 2)


def _reversed(piece: np.ndarray, until: float) -> np.ndarray:
    """Return a piece as it runs from its end back to its start."""
    span = until - piece[k.START]
    row = np.zeros((1, k.COLUMNS))
    row[0, k.SWING] = -1.0
    row[0, k.POSITION : k.TURN + 9] = piece[k.POSITION : k.TURN + 9]
    poses = np.zeros((1, 12))
    pose_at(k.no_bodies()._replace(rows=row), 0, span, poses)
    made = piece.copy()
    made[k.POSITION : k.POSITION + 3], made[k.TURN : k.TURN + 9] = poses[0, :3], poses[0, 3:]
    speed = piece[k.VELOCITY : k.VELOCITY + 3] + span * piece[k.ACCELERATION : k.ACCELERATION + 3]
    made[k.VELOCITY : k.VELOCITY + 3] = -speed
    made[k.SPIN : k.SPIN + 3] *= -1.0
    return made
