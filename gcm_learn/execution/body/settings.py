"""Settings of arms with mass."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from gcm_learn.errors import ArenaError
from gcm_learn.execution.arena.pool import Pool, of_one_kind
from gcm_learn.execution.arena.settings import SpatialSettings
from gcm_learn.execution.body.model import STEP


@dataclass(frozen=True)
class PhysicalSettings(SpatialSettings):
    """Settings of arms with mass, with the defaults of ``CatchArmPhysics-v0``."""

    control: Literal["joint", "torque"] = "joint"
    """Actions are rates of the joints, which motors servo, or torques."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.control not in ("joint", "torque"):
            raise ArenaError(f"control: {self.control!r} is not one of joint, torque")
        if abs(self.dt / STEP - round(self.dt / STEP)) > 1e-9:
            raise ArenaError(f"dt: must be whole steps of physics, of {STEP} s (got {self.dt!r})")

    @property
    def pushed(self) -> bool:
        """As `ArenaSettings` has it."""
        return self.control == "torque"

    @property
    def width(self) -> int:
        """Length of an observation."""
        return super().width + (2 * self.commands if self.pushed else 0)

    @property
    def straight(self) -> int:
        """Index of the command that leads straight to the target."""
        return self.width - self.commands if self.pushed else super().straight

    def prepared(self, pool: Pool) -> Pool:
        """Return the pool, whose arms stop as well as they can; refuse arms without mass."""
        of_one_kind(pool.situations[:1], self.kind)
        if not pool.bodies:
            raise ArenaError("situations: the arms of the pool have no bodies")
        return pool
