"""Methods: planners by name, actors that act as they go, actors that are tried out first."""

from __future__ import annotations

import time as clock
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from gcm_learn.arms import ByKind, Kind
from gcm_learn.errors import UnknownNameError
from gcm_learn.execution import ARENAS, OUTCOMES, pool_for, way_of
from gcm_learn.motion import Movement
from gcm_learn.planners import Planner, get_planner, plan_with, takes
from gcm_learn.policies import Actor, ActorPlanner, actor_names, shipped_actor
from gcm_learn.situation import AnySituation

CLOCKED = ("st-rrt-star",)  # plan for a given time, in a process of their own


@dataclass(frozen=True)
class Result:
    """Result for one situation."""

    outcome: str
    """caught, declined (nothing was done), touched, late or start_blocked."""
    latency: float
    """Thinking before the hand moves [ms of processor time]; of actors, that of one step."""
    trajectory: Movement | None
    """Movement of the arm in the situation's own coordinates, or None."""
    clearance: float | None = None
    """[forearm lengths, or the unit of a spatial arm]"""


class Method(Protocol):
    """Anything that can be compared."""

    @property
    def name(self) -> str:
        """Name under which it was requested."""

    def takes(self, kind: Kind) -> bool:
        """Return whether it takes arms of a kind."""

    def run(self, situation: AnySituation) -> Result:
        """Do it."""


@dataclass(frozen=True)
class PlannerMethod:
    """Plans, then does what was planned: a verified plan comes out as planned."""

    name: str
    planner: Planner

    def takes(self, kind: Kind) -> bool:
        """Return whether the planner takes arms of a kind."""
        return takes(self.planner, kind)

    def run(self, situation: AnySituation) -> Result:
        """Plan."""
        since = clock.process_time()
        plan = plan_with(self.planner, situation)
        latency = 1e3 * (clock.process_time() - since)
        if self.name in CLOCKED:
            latency = plan.planning_ms
        outcome = {"caught": "caught", "unreachable": "declined"}.get(plan.status, plan.status)
        return Result(outcome, latency, plan.trajectory, plan.clearance)


@dataclass(frozen=True)
class ActorMethod:
    """Acts step by step, its most likely action each time, and unverified."""

    name: str
    actor: Actor

    def takes(self, kind: Kind) -> bool:
        """Return whether the actor moves arms of a kind."""
        return kind is self.actor.kind

    def run(self, situation: AnySituation) -> Result:
        """Play an episode."""
        since = clock.process_time()
        table = ByKind({self.actor.kind: self.actor.settings}, who=f"policy {self.name!r}")
        pool = pool_for(table.of(situation), [situation])
        episodes = self.actor.play(pool, np.zeros(1, np.int64))
        latency = 1e3 * (clock.process_time() - since) / max(int(episodes.steps[0]), 1)
        time, posture = episodes.path(0)
        path = way_of(situation.arm, time, pool.frames[0].original(posture))
        return Result(OUTCOMES[int(episodes.outcomes[0])], latency, path)


def _actors() -> list[str]:
    """Return the names of all trained actors."""
    kinds = dict.fromkeys(arena.kind for arena in ARENAS.values())
    return [name for kind in kinds for name in actor_names(kind)]


def get_method(name: str) -> Method:
    """A method by name.

    Parameters
    ----------
    name : str
        A planner (``layered``), a folder of models with an actor (``clone``), or such an actor
        whose path is tried out N times and verified before it moves (``clone@20``).

    Raises
    ------
    UnknownNameError
        With the known names.
    """
    bare, _, tries = name.partition("@")
    if bare in _actors():
        actor = shipped_actor(bare)
        if not tries:
            return ActorMethod(name, actor)
        if not tries.isdigit() or int(tries) < 1:
            raise UnknownNameError(f"policy {name!r}: after @ comes a number of tries")
        return PlannerMethod(name, ActorPlanner(actor, name, int(tries)))
    try:
        return PlannerMethod(name, get_planner(name))
    except UnknownNameError as error:
        known = [*error.known, *_actors()]
        raise UnknownNameError.among("policy", name, known) from error
