"""Actors as planners: what they would do is tried out with the predictor, and verified."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gcm_learn import artifacts, seeding
from gcm_learn.arms import PLANAR, Arm, ByKind, Kind
from gcm_learn.errors import PolicyError, UnknownNameError
from gcm_learn.execution import ARENAS, CAUGHT, OUTCOMES, Pool, pool_for, way_of
from gcm_learn.motion import Failure, Movement, refine
from gcm_learn.planners import Attempt, Problem, SpatialProblem, checked
from gcm_learn.policies.actor import FILES, Acting, Actor
from gcm_learn.situation import AnySituation, situation_to_json
from gcm_learn.storage import content_number

TRIES = 20  # as many as paths are checked by planners that recall


_FILES = ByKind({a.kind: FILES[a.name] for a in ARENAS.values() if a.followed}, who="no policy")


def actor_names(kind: Kind = PLANAR) -> list[str]:
    """Return the folders of the models that hold an actor for a kind of arm."""
    return list(artifacts.models(_FILES.of(kind)))


def actor_folder(name: str) -> Path:
    """Return the folder of a trained actor; raise PolicyError if it is missing."""
    folder = next(filter(None, (artifacts.model(name, file) for file in _FILES.entries())), None)
    if folder is None:
        make = f"gcm-learn train policy CONFIG --out {artifacts.own('models') / name}"
        raise PolicyError(artifacts.missing("models", f"trained policy {name!r}", make))
    return folder


def shipped_actor(name: str) -> Actor:
    """Return the actor in a folder of the models; raise PolicyError if it is missing."""
    return Actor.load(actor_folder(name))


def all_actor_names() -> list[str]:
    """Return the names of all trained actors."""
    return [name for kind in _FILES for name in actor_names(kind)]


def is_actor(folder: Path) -> bool:
    """Return whether a folder holds a trained actor."""
    return any((folder / file).is_file() for file in _FILES.entries())


def acted(actor: Acting, situation: AnySituation) -> tuple[str, Movement, int]:
    """Play an episode; return its outcome, the movement, and the number of steps."""
    table = ByKind({actor.kind: actor.settings}, who="the policy")
    pool = pool_for(table.of(situation), [situation])
    episodes = actor.play(pool, np.zeros(1, np.int64))
    time, posture = episodes.path(0)
    way = _KINDS.of(actor.kind).way(situation.arm, time, pool.frames[0].original(posture))
    return OUTCOMES[int(episodes.outcomes[0])], way, int(episodes.steps[0])


def tried_out(name: str) -> ActorPlanner | None:
    """Return the planner ``clone@20``, an actor that is tried out so often; ``clone`` is once.

    Returns None for other names.

    Raises
    ------
    UnknownNameError
        If no number of tries comes after the @.
    """
    bare, at, tries = name.partition("@")
    if bare not in all_actor_names():
        return None
    if at and (not tries.isdigit() or int(tries) < 1):
        raise UnknownNameError(f"policy {name!r}: after @ comes a number of tries")
    return ActorPlanner(shipped_actor(bare), name, int(tries or 1))


@dataclass(frozen=True)
class ActorPlanner:
    """Tries an actor out: its most likely path first, then drawn ones; the earliest that holds."""

    actor: Acting
    name: str
    tries: int = TRIES
    seed: int = 0

    def takes(self, kind: Kind) -> bool:
        """Return whether the actor moves arms of a kind."""
        return kind is self.actor.kind

    def plan(self, situation: AnySituation) -> Any:
        """Answer a situation with an arm of the actor's kind."""
        begun: ByKind[_Kind] = ByKind({self.actor.kind: _KINDS.of(self.actor.kind)})
        begun.who = f"policy {self.name!r}"
        kind = begun.of(situation)
        problem = kind.problem(situation, self.name)
        answer = problem.early_answer(**kind.promises)
        if answer is not None:
            return answer
        settings = self.actor.settings
        pool = settings.prepared(pool_for(settings, [situation]))
        targets = [i for i, body in enumerate(situation.bodies) if body.role == "target"]
        for time, posture in self._caught(pool, pool.situations[0]):
            way = kind.way(situation.arm, time, pool.frames[0].original(posture))
            for index in targets:
                plan, _ = checked(problem, Attempt(way, index))
                if plan is not None:
                    return plan
        return problem.answer(Failure.NO_VALID_ROLLOUT.with_numbers(count=self.tries))

    def _caught(
        self, pool: Pool, situation: AnySituation
    ) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Yield the paths that catch in a pool's only situation, the earliest catch first."""
        found = [self.actor.play(pool, np.zeros(1, np.int64))]
        if self.tries > 1:
            source = seeding.rng(self.seed, _number(situation))
            drawn = np.zeros(self.tries - 1, np.int64)
            found.append(self.actor.play(pool, drawn, source))
        paths = [
            (float(e.times[arm]), e, arm)
            for e in found
            for arm in np.flatnonzero(e.outcomes == CAUGHT)
        ]
        for _, episodes, arm in sorted(paths, key=lambda found: found[0]):
            yield episodes.path(int(arm))


def _refined_way(arm: Arm, time: np.ndarray, hand: np.ndarray) -> Movement:
    """Return the trajectory of a hand that begins exactly at its place, with more samples."""
    hand[0] = arm.hand
    time, hand = refine(arm, time, hand)
    return Movement.of_hand(arm, time, hand)


@dataclass(frozen=True)
class _Kind:
    """Parts of an actor's planning that differ by kind of arm."""

    problem: Callable[[Any, str], Any]
    promises: dict[str, bool]
    """Limits that the arena keeps, of which the problem should know."""
    way: Callable[[Any, np.ndarray, np.ndarray], Any]
    """Movement of an arm from times and postures."""


_KINDS = ByKind(
    {PLANAR: _Kind(Problem, {}, _refined_way)},
    default=_Kind(SpatialProblem, {"keeps_acceleration": True}, way_of),
)


def _number(situation: AnySituation) -> int:
    """Return a number that follows from the situation alone."""
    text = json.dumps(situation_to_json(situation), sort_keys=True)
    return content_number(text.encode(), 6)
