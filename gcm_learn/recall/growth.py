"""A memory that grows with experience: what it could not recall is planned anew and remembered.

As in Thunder (Coleman, Sucan, Moll, Okada and Correll, ICRA 2015), what is already covered is not
stored, so the memory grows ever more slowly, and is filled with what is hard.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace

from gcm_learn.planners.plan import Plan, Planner
from gcm_learn.planners.registry import get_planner
from gcm_learn.recall.planners import RecallPlanner, Recollection
from gcm_learn.recall.store import Forgotten, Memory
from gcm_learn.recall.waypoints import trace_of
from gcm_learn.situation import Situation


@dataclass(frozen=True)
class Coverage:
    """When a situation counts as covered by what is remembered."""

    slack: float = math.inf
    """A recalled catch may come this share later than the planned one. Infinite: any recalled catch
    covers, and no planning is needed to know; -1: none does, and all catches are remembered."""

    def covers(self, recalled: Plan, planned: Plan | None) -> bool:
        """Whether a recalled catch makes the planned one superfluous."""
        if not recalled.caught or recalled.catch_time is None:
            return False
        if planned is None or planned.catch_time is None:
            return True
        return recalled.catch_time <= planned.catch_time * (1.0 + self.slack)


@dataclass(frozen=True)
class Step:
    """The state of a memory after an experience."""

    experience: int
    """Situations met so far."""
    size: int
    """Memories."""
    recalled: bool
    """Whether this situation was caught from memory, before anything was learned from it."""
    caught: bool
    """Whether it was caught at all."""


@dataclass(frozen=True)
class Curve:
    """What experience did to a memory."""

    steps: list[Step] = field(default_factory=list)

    @property
    def sizes(self) -> list[int]:
        """Memories after every experience."""
        return [step.size for step in self.steps]

    def recall_rate(self, first: int = 0, last: int | None = None) -> float:
        """Share of what was caught at all that was caught from memory, over some experiences."""
        some = [step for step in self.steps[first:last] if step.caught]
        return sum(step.recalled for step in some) / len(some) if some else math.nan


def grow(
    memory: Memory,
    situations: Iterable[Situation],
    planner: str | Planner = "layered",
    covered: Coverage | None = None,
    *,
    recall: RecallPlanner | None = None,
    most: int | None = None,
    forget: Forgotten = "least used",
    progress: Callable[[int], None] = lambda done: None,
) -> Curve:
    """Meet situations one after the other; remember what was not covered.

    Parameters
    ----------
    memory : Memory
        Grows in place.
    situations : iterable of Situation
    planner : str or Planner
        Solves what memory does not.
    covered : Coverage, optional
        What need not be remembered; by default everything that is recalled.
    recall : RecallPlanner, optional
        How is recalled; its memory is replaced by this one.
    most : int, optional
        Entries at most.
    forget : {"least used", "oldest", "random"}
        What is forgotten first if there are more, see `Memory.forget_to`.
    progress : callable
        Called with the number of situations met since the last call.

    Returns
    -------
    Curve
    """
    rule = Coverage() if covered is None else covered
    solver = get_planner(planner) if isinstance(planner, str) else planner
    how = RecallPlanner(memory) if recall is None else replace(recall, memory=memory)
    curve = Curve()
    for situation in situations:
        found = how.recollect(situation)
        caught = _learned(memory, situation, found, solver, rule)
        if most is not None and len(memory) > most:
            memory.forget_to(most, forget, seed=len(curve.steps))
        step = Step(len(curve.steps) + 1, len(memory), found.plan.caught, caught)
        curve.steps.append(step)
        progress(1)
    return curve


def _learned(
    memory: Memory, situation: Situation, found: Recollection, solver: Planner, rule: Coverage
) -> bool:
    """Remember a situation's catch unless it is covered; whether there is a catch."""
    if found.memory is not None:
        memory.used(found.memory)
    if found.plan.status == "start_blocked":
        return False
    if found.plan.caught and math.isinf(rule.slack):
        return True
    planned = solver.plan(situation)
    if planned.caught and not rule.covers(found.plan, planned):
        memory.add([situation], [trace_of(situation, planned)])
    return planned.caught or found.plan.caught
