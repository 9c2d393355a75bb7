"""Situations of arms with a body."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from gcm_learn.arms import SPATIAL, SpatialArm
from gcm_learn.errors import PhysicsError
from gcm_learn.execution.arena.pool import Pool, of_one_kind
from gcm_learn.execution.body.bodies import body_for
from gcm_learn.execution.body.motors import with_motor_limits
from gcm_learn.situation import ArmBody, Situation


def pool_with_bodies(
    situations: Sequence[Situation[SpatialArm]], body: ArmBody | str | Path | None = None
) -> Pool:
    """Pack situations of arms with mass.

    Arms without limits of acceleration get the limits of their motors.

    Parameters
    ----------
    situations : sequence of Situation
        Each must begin with a limb that touches nothing.
    body : ArmBody, str or Path, optional
        As `body_for` has it.

    Raises
    ------
    ArenaError, PhysicsError
        With the name of the first that does not, or whose arm has no body.
    """
    of_one_kind(situations, SPATIAL)
    bodies = tuple(_body_of(situation, body) for situation in situations)
    limited = [with_motor_limits(s, b) for s, b in zip(situations, bodies, strict=True)]
    return replace(Pool.of(limited, SPATIAL), bodies=bodies)


def _body_of(situation: Situation[SpatialArm], given: ArmBody | str | Path | None) -> ArmBody:
    try:
        return body_for(situation.arm, given)
    except PhysicsError as error:
        raise PhysicsError(f"situation {situation.name!r}: {error}") from None
