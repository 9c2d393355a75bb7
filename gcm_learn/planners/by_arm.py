"""One name for two planners: one of the plane and one of space."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

from gcm_learn.planners.plan import Plan, Planner


class SpacePlanner(Protocol):
    """Anything that plans for spatial arms."""

    @property
    def name(self) -> str:
        """Name under which it is registered."""

    def plan(self, situation: Any) -> Plan[Any]:
        """Answer a situation."""


@dataclass(frozen=True)
class ByArm:
    """Lets the situation's arm decide who plans."""

    plane: Planner
    space: SpacePlanner

    takes_space: ClassVar[bool] = True

    @property
    def name(self) -> str:
        """Name under which both are registered."""
        return self.plane.name

    def plan(self, situation: Any, bound: float | None = None) -> Plan[Any]:
        """Answer a situation; catches after a bound [s] do not count, if the planner takes one."""
        chosen: Any = self.space if situation.is_spatial else self.plane
        return chosen.plan(situation) if bound is None else chosen.plan(situation, bound=bound)
