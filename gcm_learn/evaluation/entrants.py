"""Entrants: planners, policies and other methods that answer situations, under distinct names."""

from __future__ import annotations

import inspect
import pickle
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

from gcm_learn import planners, policies
from gcm_learn.arms import Kind, kind_of
from gcm_learn.errors import SuiteError, UnknownNameError
from gcm_learn.evaluation.machine import spent
from gcm_learn.processes import OutOfTime, time_limit
from gcm_learn.recall import MANIFEST, Memory, with_memory
from gcm_learn.situation import AnySituation, planar
from gcm_learn.storage import content_hash

WORDS = {"unreachable": "declined"}  # of outcomes, for a plan's status


class Answer(NamedTuple):
    """Answer to a situation as the method claims it, before the referee judges."""

    outcome: str
    """Of caught, declined, start_blocked, touched, late, broken and error."""
    ms: float
    """Processor time before the arm moves [ms]; of actors, that of one step."""
    plans: tuple[planners.Plan, ...] = ()
    """The plan; of an actor that catches, one for each target that it may have caught."""
    reason: str = ""
    """Reason of a broken promise or an error."""


@dataclass(frozen=True)
class PlannerMethod:
    """A planner: a catch is promised before the arm moves."""

    name: str
    planner: planners.Planner

    def check(self, situation: AnySituation) -> None:
        """Raise ArmKindError unless the planner takes the arm."""
        planners.taken(self.planner, situation)

    def answer(self, situation: AnySituation) -> Answer:
        """Return the planner's plan for the situation as an answer."""
        plan = planners.plan_with(self.planner, situation)
        reason = plan.message if plan.status in planners.FAULTS else ""
        return Answer(WORDS.get(plan.status, plan.status), 0.0, (plan,), reason)


@dataclass(frozen=True)
class ActorMethod:
    """A policy: it takes its most likely action at each step and promises no catch beforehand."""

    name: str
    actor: policies.Acting

    def takes(self, kind: Kind) -> bool:
        """Return whether the actor moves arms of a kind."""
        return kind is self.actor.kind

    def check(self, situation: AnySituation) -> None:
        """Raise ArmKindError unless the actor moves the arm."""
        if not self.takes(kind_of(situation)):
            planar(situation, f"policy {self.name!r}")

    def answer(self, situation: AnySituation) -> Answer:
        """Let the policy act for one episode; return the outcome and the movement."""
        since = spent()
        outcome, moves, steps = policies.acted(self.actor, situation)
        ms = 1e3 * (spent() - since) / max(steps, 1)
        names = [target.name for target in situation.targets] if outcome == "caught" else [None]
        status: Any = "caught" if outcome == "caught" else "unreachable"
        plans = tuple(
            planners.Plan(
                situation.name, self.name, status, outcome, 0.0,
                moves.duration if body else None, body, trajectory=moves)
            for body in names
        )  # fmt: skip
        return Answer(outcome, ms, plans)


Method = PlannerMethod | ActorMethod


@dataclass(frozen=True, eq=False)
class Held:
    """An object that stays in this process; equal to itself only."""

    given: Any


@dataclass(frozen=True)
class Entrant:
    """Entrant of a comparison, in the form that is sent to processes."""

    name: str
    """Name in the sheet."""
    source: str | bytes | Held
    """A name or a reference, a pickled object, or an object of this process."""
    seed: int = 0
    """Of the training, where one name stands for several trainings."""
    known: str = ""
    """Name and content: answers of another version do not count."""

    def method(self, limit: float | None = planners.LIMIT) -> Method:
        """Return the method that answers for this entrant.

        Raises
        ------
        SuiteError, UnknownNameError
            If an object cannot be unpickled here, or there is no such name.
        """
        source: Any = self.source
        if isinstance(source, Held):
            source = source.given
        elif isinstance(source, bytes):
            try:
                source = pickle.loads(source)
            except Exception as error:
                raise SuiteError(_stays(self.name, planners.in_words(error))) from None
        return get_method(source, self.name, limit)


@lru_cache(maxsize=64)
def method_of(entrant: Entrant, limit: float) -> Method:
    """Return the method of an entrant, made once in this process."""
    return entrant.method(limit)


def asked(method: Method, situation: AnySituation, limit: float) -> Answer:
    """Return a method's answer within a time limit [s]; an exception becomes an answer `error`."""
    since, reason = spent(), ""
    own = isinstance(method, PlannerMethod) and hasattr(method.planner, "limit")  # of `Outside`
    try:
        with time_limit(None if own else limit):
            answer = method.answer(situation)
        return answer if answer.ms else answer._replace(ms=1e3 * (spent() - since))
    except OutOfTime:
        reason = f"no answer within {limit:g} s"
    except (Exception, SystemExit) as error:
        reason = planners.in_words(error)
    return Answer("error", 1e3 * (spent() - since), reason=reason)


def entrants_of(given: Sequence[Any], *, alone: bool = True) -> list[Entrant]:
    """Return entrants under distinct names.

    Parameters
    ----------
    given : sequence of Entrant, str or object
        See `get_method`; an object is named by its `name`.
    alone : bool
        If false, other processes do the work, and objects have to be pickled.

    Raises
    ------
    SuiteError
        If an object cannot be sent to other processes.
    """
    made: list[Entrant] = []
    for item in given:
        if isinstance(item, Entrant):
            name, seed, item = item.name, item.seed, item.source
            item = item.given if isinstance(item, Held) else item
        else:
            name, seed = (
                _distinct(item if isinstance(item, str) else planners.name_of(item), made),
                0,
            )
        made.append(Entrant(name, _source(item, name, alone), seed, _known(item)))
    return made


def _distinct(name: str, made: Sequence[Entrant]) -> str:
    """Return the name, with a number added if another entrant already has this name."""
    taken, found, count = {entrant.name for entrant in made}, name, 1
    while found in taken:
        count += 1
        found = f"{name} ({count})"
    return found


def _known(item: Any) -> str:
    """Return a text that identifies an entrant's version, by a hash of its content or file."""
    if isinstance(item, bytes):
        return content_hash(item)[:16]
    folder = Path(item.rpartition("@")[2] or item) if isinstance(item, str) else None
    if folder is not None and (folder / MANIFEST).is_file():
        return f"{item} {content_hash((folder / MANIFEST).read_bytes())[:16]}"
    if isinstance(item, str):
        planners.found(item)  # imported, so that its file is known
        return planners.source_of(item)
    home = item if inspect.isroutine(item) or isinstance(item, type) else type(item)
    try:
        code = inspect.getsource(home)
    except (OSError, TypeError):
        code = ""
    return f"{planners.source_of(item)} {content_hash(code)[:16]}"


def _source(item: Any, name: str, alone: bool) -> str | bytes | Held:
    if isinstance(item, bytes):
        return item
    if isinstance(item, str):
        return planners.absolute(item)
    if alone:
        return Held(item)
    home = item if isinstance(item, type) else type(item)
    typed_in = getattr(item, "__module__", home.__module__) == "__main__"
    if typed_in and not hasattr(sys.modules["__main__"], "__file__"):
        raise SuiteError(_stays(name, "it was defined in an interactive session"))
    try:
        return pickle.dumps(item)
    except Exception as error:
        raise SuiteError(_stays(name, planners.in_words(error))) from None


def _stays(name: str, why: str) -> str:
    return (
        f"{name!r} cannot be sent to worker processes ({why}): "
        "give it as path.py:name, or ask for one worker"
    )


def get_method(given: Any, name: str = "", limit: float | None = planners.LIMIT) -> Method:
    """Return the method of a planner, policy or object, given by name, by reference or directly.

    Parameters
    ----------
    given : str or object
        A planner (``search``); a planner with a memory in a folder (``recall@DIR``); an actor by
        the name of its model, its folder or the `model.zip` in it (``clone``), which acts
        unverified; an actor whose path is tried out N times and verified before it moves
        (``clone@20``); or anything else of `planners.get_planner`.
    name : str, optional
        By default what was given, or the object's name.
    limit : float, optional
        Time on the wall for each answer of a planner from outside [s].

    Raises
    ------
    UnknownNameError
        With the known names.
    """
    told = name or (given if isinstance(given, str) else planners.name_of(given))
    if isinstance(given, str):
        actor = None if planners.is_registered(given) else policies.found_actor(given)
        if actor is not None:
            return ActorMethod(told, actor)
        planner, _, folder = given.partition("@")
        if planners.is_registered(planner) and (Path(folder) / MANIFEST).is_file():
            return PlannerMethod(told, with_memory(planner, Memory.load(folder)))
    made = _made(given, told)
    if isinstance(made, policies.Acting):
        return ActorMethod(told, made)
    try:
        return PlannerMethod(told, planners.get_planner(made, name=told, limit=limit))
    except UnknownNameError as error:
        if not error.known:
            raise
        known = [*error.known, *policies.all_actor_names()]
        raise UnknownNameError.among("entrant", given, known) from error


def _made(given: Any, told: str) -> Any:
    """Return a policy, a planner from outside, or the name of a registered planner."""
    made = given
    if isinstance(given, str):
        made = None if planners.is_registered(given) else planners.found(given)
        if made is None:
            return given
    made = planners.instance(made, told)
    if isinstance(made, Path) or (planners.acts(made) and not isinstance(made, policies.Acting)):
        return policies.own_policy(made, told)
    return made


def summary(entrant: Entrant) -> str:
    """Describe an entrant in one line, by its `summary` or the first line of its docstring."""
    source = entrant.source.given if isinstance(entrant.source, Held) else entrant.source
    if not isinstance(source, str):
        words = getattr(source, "summary", "") or inspect.getdoc(source) or ""
        return str(words).strip().partition("\n")[0]
    bare, _, tries = source.partition("@")
    words = planners.summary_of(bare)
    if not words and bare in policies.all_actor_names():
        words = f"network that acts step by step ({policies.actor_folder(bare).name})"
    if tries.isdigit():
        words += f"; tried out {tries} times and verified before the arm moves"
    elif tries:
        words += f"; with the memory in {tries}"
    return words or f"of {Path(source).name}"
