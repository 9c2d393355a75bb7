"""Methods: planners by name, actors that act as they go, actors that are tried out first."""

from __future__ import annotations

import time as clock
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from gcm_learn.arms import ByKind, Kind
from gcm_learn.errors import UnknownNameError
from gcm_learn.execution import OUTCOMES, pool_for, way_of
from gcm_learn.motion import Movement
from gcm_learn.planners import (
    FAULTS,
    LIMIT,
    Planner,
    acts,
    found,
    get_planner,
    in_words,
    instance,
    is_registered,
    name_of,
    plan_with,
    takes,
)
from gcm_learn.policies import (
    Acting,
    all_actor_names,
    own_policy,
    shipped_actor,
)
from gcm_learn.processes import OutOfTime, time_limit
from gcm_learn.situation import AnySituation

CLOCKED = ("st-rrt-star",)  # plan for a given time, in a process of their own


@dataclass(frozen=True)
class Result:
    """Result for one situation."""

    outcome: str
    """caught, declined (nothing was done), touched, late or start_blocked; of methods from
    outside also broken (a promise) or error."""
    latency: float
    """Thinking before the hand moves [ms of processor time]; of actors, that of one step."""
    trajectory: Movement | None
    """Movement of the arm in the situation's own coordinates, or None."""
    clearance: float | None = None
    """[forearm lengths, or the unit of a spatial arm]"""
    reason: str = ""
    """Reason why a method from outside broke its promise, or failed."""


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
        reason = plan.message if plan.status in FAULTS else ""
        return Result(outcome, latency, plan.trajectory, plan.clearance, reason)


@dataclass(frozen=True)
class ActorMethod:
    """Acts step by step, its most likely action each time, and unverified."""

    name: str
    actor: Acting
    limit: float | None = None
    """Of a policy from outside: time on the wall for an episode [s]; its errors cost a result."""

    def takes(self, kind: Kind) -> bool:
        """Return whether the actor moves arms of a kind."""
        return kind is self.actor.kind

    def run(self, situation: AnySituation) -> Result:
        """Play an episode."""
        since = clock.process_time()
        if self.limit is None:
            return self._played(situation, since)
        try:
            with time_limit(self.limit):
                return self._played(situation, since)
        except OutOfTime:
            reason = f"no end within {self.limit:g} s"
        except (Exception, SystemExit) as error:
            reason = in_words(error)
        spent = 1e3 * (clock.process_time() - since)
        return Result("error", spent, None, reason=f"the policy fails: {reason}")

    def _played(self, situation: AnySituation, since: float) -> Result:
        table = ByKind({self.actor.kind: self.actor.settings}, who=f"policy {self.name!r}")
        pool = pool_for(table.of(situation), [situation])
        episodes = self.actor.play(pool, np.zeros(1, np.int64))
        latency = 1e3 * (clock.process_time() - since) / max(int(episodes.steps[0]), 1)
        time, posture = episodes.path(0)
        path = way_of(situation.arm, time, pool.frames[0].original(posture))
        return Result(OUTCOMES[int(episodes.outcomes[0])], latency, path)


def get_method(given: str | Any, name: str = "", limit: float | None = LIMIT) -> Method:
    """Return a method by name, by reference, or from an object.

    Parameters
    ----------
    given : str or object
        A planner (``layered``), a folder of models with an actor (``clone``), such an actor
        whose path is tried out N times and verified before it moves (``clone@20``), or
        anything else of `planners.get_planner`.  Policies act unverified here.
    name : str, optional
        Name of the method; by default what was given, or the object's name.
    limit : float, optional
        Time on the wall for each answer of a method from outside [s].

    Raises
    ------
    UnknownNameError
        With the known names.
    """
    told = name or (given if isinstance(given, str) else name_of(given))
    if isinstance(given, str) and given in all_actor_names():
        return ActorMethod(told, shipped_actor(given))
    made = _made(given, told)
    if isinstance(made, Acting):
        return ActorMethod(told, made, limit)
    try:
        return PlannerMethod(told, get_planner(made, name=told, limit=limit))
    except UnknownNameError as error:
        if not error.known:
            raise
        known = [*error.known, *all_actor_names()]
        raise UnknownNameError.among("policy", given, known) from error


def _made(given: Any, told: str) -> Any:
    """Return a policy, a planner from outside, or the name of a registered planner."""
    made = given
    if isinstance(given, str):
        made = None if is_registered(given) else found(given)
        if made is None:
            return given
    made = instance(made, told)
    if isinstance(made, Path) or (acts(made) and not isinstance(made, Acting)):
        return own_policy(made, told)
    return made
