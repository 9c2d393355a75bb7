"""One name for two planners: one of the plane and one of space."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

from gcm_learn.planners.deadline import Deadline
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

    @property
    def anytime(self) -> bool:
        """Whether both can be told by when to answer; see `Anytime`."""
        return all(getattr(planner, "anytime", False) for planner in (self.plane, self.space))

    def plan(
        self,
        situation: Any,
        bound: float | None = None,
        deadline: float | Deadline | None = None,
    ) -> Plan[Any]:
        """Answer a situation; a bound and a deadline are for planners that take them."""
        chosen: Any = self.space if situation.is_spatial else self.plane
        given = {"bound": bound, "deadline": deadline}
        return chosen.plan(situation, **{k: v for k, v in given.items() if v is not None})
