"""Numbers of catches that end an episode, and that make it a success."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any, NamedTuple

from gcm_learn.execution.arena.kernels.world import CAUGHT, LATE
from gcm_learn.situation import AnySituation


class Catch(NamedTuple):
    """A target that was caught."""

    body: str
    """Name of the target."""
    time: float
    """[s]"""


class Wanted(NamedTuple):
    """Numbers of catches that a situation asks for."""

    most: int
    """An episode is over after so many."""
    least: int
    """At the horizon so many make it a success."""

    def at_horizon(self, count: int) -> int:
        """Return the outcome of an episode that had so many catches until the horizon."""
        return CAUGHT if count >= self.least else LATE


def wanted_of(situation: AnySituation, most: int | None = None) -> Wanted:
    """Return the numbers of catches that a situation asks for.

    Parameters
    ----------
    situation : Situation
    most : int, optional
        Ends an episode that asks for "most" of its targets; by default all of them do.
    """
    count = len(situation.targets)
    if situation.catch == "any":
        return Wanted(1, 1)
    return Wanted(count, count) if situation.catch == "all" else Wanted(most or count, 1)


def without(situation: Any, caught: Iterable[Catch]) -> Any:
    """Return a situation without targets that were caught, of which at least one is left."""
    names = {catch.body for catch in caught}
    if not names:
        return situation
    return replace(situation, bodies=tuple(b for b in situation.bodies if b.name not in names))
