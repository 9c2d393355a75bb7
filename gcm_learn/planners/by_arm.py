"""One name for planners of several kinds of arms."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

from gcm_learn.arms import ByKind, Kind
from gcm_learn.planners.plan import Deadline, Plan


class ByArm:
    """Planners under one name, of which the situation's kind of arm chooses.

    Parameters
    ----------
    name : str
        Name under which all are registered.
    places : ByKind of str
        Place of each planner's factory.
    make : callable
        Make the planner of a place; called once for each, when it is needed.
    """

    def __init__(self, name: str, places: ByKind[str], make: Callable[[str], Any]) -> None:
        self.name, self._places, self._make = name, places, cache(make)
        places.who = f"planner {name!r}"

    @property
    def anytime(self) -> bool:
        """True if all planners take a deadline; see `Anytime`."""
        made = map(self._make, self._places.entries())
        return all(getattr(planner, "anytime", False) for planner in made)

    def takes(self, kind: Kind) -> bool:
        """Return whether there is a planner for arms of a kind."""
        return self._places.takes(kind)

    def for_arm(self, situation: Any) -> Any:
        """Return the planner for a situation's kind of arm."""
        return self._make(self._places.of(situation))

    def plan(
        self,
        situation: Any,
        bound: float | None = None,
        deadline: float | Deadline | None = None,
    ) -> Plan:
        """Answer a situation; a bound and a deadline are for planners that take them."""
        given = {"bound": bound, "deadline": deadline}
        known = {k: v for k, v in given.items() if v is not None}
        return self.for_arm(situation).plan(situation, **known)
