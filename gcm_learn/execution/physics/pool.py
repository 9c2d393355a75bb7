"""Situations of arms with a body."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from gcm_learn.arms import SpatialArm
from gcm_learn.errors import PhysicsError
from gcm_learn.execution.physics.bodies import body_for
from gcm_learn.execution.physics.motors import with_motor_limits
from gcm_learn.execution.pool import SpatialPool
from gcm_learn.execution.settings import SpatialSettings
from gcm_learn.situation import ArmBody, Situation, spatial


@dataclass(frozen=True)
class PhysicalPool(SpatialPool):
    """Situations in which arms with mass begin; under the limits of acceleration of their motors,
    where they have none of their own.
    """

    bodies: tuple[ArmBody, ...]
    """Of the arms."""

    @classmethod
    def of(
        cls,
        situations: Sequence[Situation[SpatialArm]],
        body: ArmBody | str | Path | None = None,
    ) -> PhysicalPool:
        """Pack situations.

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
        found = [spatial(situation, "the arena in space") for situation in situations]
        bodies = [_body_of(situation, body) for situation in found]
        limited = [with_motor_limits(s, b) for s, b in zip(found, bodies, strict=True)]
        packed = SpatialPool.of(limited)
        return cls(packed.situations, packed.world, tuple(bodies))

    def prepared(self, settings: SpatialSettings) -> PhysicalPool:
        """The same: what has mass stops as it can."""
        return self

    def part(self, chosen: Sequence[int] | np.ndarray) -> PhysicalPool:
        """Some of the situations, packed anew."""
        rows = [int(i) for i in chosen]
        made = SpatialPool.of([self.situations[i] for i in rows])
        return replace(self, situations=made.situations, world=made.world,
                       bodies=tuple(self.bodies[i] for i in rows))  # fmt: skip


def _body_of(situation: Situation[SpatialArm], given: ArmBody | str | Path | None) -> ArmBody:
    try:
        return body_for(situation.arm, given)
    except PhysicsError as error:
        raise PhysicsError(f"situation {situation.name!r}: {error}") from None
