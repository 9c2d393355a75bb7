"""One name for planners of several kinds of arms."""

from __future__ import annotations

from typing import Any

from gcm_learn.arms import ByKind, Kind
from gcm_learn.planners.deadline import Deadline
from gcm_learn.planners.plan import Plan


class ByArm:
    """Planners under one name, of which the situation's kind of arm chooses.

    Parameters
    ----------
    name : str
        Name under which all are registered.
    planners : ByKind of planner
    """

    def __init__(self, name: str, planners: ByKind[Any]) -> None:
        self.name, self._planners = name, planners
        planners.who = f"planner {name!r}"

    @property
    def anytime(self) -> bool:
        """True if all planners take a deadline; see `Anytime`."""
        return all(getattr(planner, "anytime", False) for planner in self._planners.entries())

    def takes(self, kind: Kind) -> bool:
        """Return whether there is a planner for arms of a kind."""
        return self._planners.takes(kind)

    def plan(
        self,
        situation: Any,
        bound: float | None = None,
        deadline: float | Deadline | None = None,
    ) -> Plan:
        """Answer a situation; a bound and a deadline are for planners that take them."""
        given = {"bound": bound, "deadline": deadline}
        chosen = self._planners.of(situation)
        return chosen.plan(situation, **{k: v for k, v in given.items() if v is not None})
