"""Actors as planners: what they would do is tried out with the predictor, and verified."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, overload

import numpy as np

from gcm_learn import artifacts, seeding
from gcm_learn.arms import PLANAR, SPATIAL, Kind, SpatialArm
from gcm_learn.errors import PolicyError
from gcm_learn.execution import CAUGHT, AnyPool, Pool, SpatialPool, SpatialSettings, way_of
from gcm_learn.motion import Failure, SpatialTrajectory, Trajectory, refine
from gcm_learn.planners import AnyPlan, Attempt, Plan, Problem, SpatialProblem, checked
from gcm_learn.policies.actor import FILE, FILES, Actor
from gcm_learn.situation import (
    AnySituation,
    Situation,
    canonical,
    planar,
    situation_to_json,
    spatial,
)
from gcm_learn.storage import content_number

TRIES = 20  # as many as paths are checked by planners that recall


def actor_names(space: bool = False) -> list[str]:
    """Folders of the models that hold an actor for arms in the plane, or in space."""
    return list(artifacts.models(FILES[SpatialSettings] if space else FILE))


def actor_folder(name: str) -> Path:
    """The folder of a trained actor; raises PolicyError if there is none."""
    folder = artifacts.model(name, FILE) or artifacts.model(name, FILES[SpatialSettings])
    if folder is None:
        make = f"gcm-learn train-policy CONFIG --out {artifacts.own('models') / name}"
        raise PolicyError(artifacts.missing("models", f"trained policy {name!r}", make))
    return folder


def shipped_actor(name: str) -> Actor:
    """The actor in a folder of the models; raises PolicyError if there is none."""
    return Actor.load(actor_folder(name))


@dataclass(frozen=True)
class ActorPlanner:
    """Tries an actor out: its most likely path first, then drawn ones; the earliest that holds."""

    actor: Actor
    name: str
    tries: int = TRIES
    seed: int = 0

    def takes(self, kind: Kind) -> bool:
        """Return whether the actor moves arms of a kind."""
        return kind == (SPATIAL if self.actor.in_space else PLANAR)

    @overload
    def plan(self, situation: Situation) -> Plan: ...
    @overload
    def plan(self, situation: Situation[SpatialArm]) -> Plan[SpatialTrajectory]: ...
    def plan(self, situation: AnySituation) -> AnyPlan:
        """Answer a situation with an arm of the actor's kind."""
        who = f"policy {self.name!r}"
        if self.actor.in_space:
            return self._in_space(spatial(situation, who))
        return self._in_plane(planar(situation, who))

    def _in_plane(self, situation: Situation) -> Plan:
        problem = Problem(situation, self.name)
        answer = problem.early_answer()
        if answer is not None:
            return answer
        turned, frame = canonical(situation)
        settings: Any = self.actor.settings
        for time, hand in self._caught(Pool.of([turned]).prepared(settings), turned):
            plan = self._verified(problem, time, frame.original(hand))
            if plan is not None:
                return plan
        return problem.answer(Failure.NO_VALID_ROLLOUT.with_numbers(count=self.tries))

    def _in_space(self, situation: Situation[SpatialArm]) -> Plan[SpatialTrajectory]:
        problem = SpatialProblem(situation, self.name)
        answer = problem.early_answer(keeps_acceleration=True)
        if answer is not None:
            return answer
        for time, posture in self._caught(SpatialPool.of([situation]), situation):
            way = way_of(situation.arm, time, posture)
            for index, body in enumerate(situation.bodies):
                if body.role == "target":
                    plan, _ = checked(problem, Attempt(way, index))
                    if plan is not None:
                        return plan
        return problem.answer(Failure.NO_VALID_ROLLOUT.with_numbers(count=self.tries))

    def _caught(
        self, pool: AnyPool, situation: AnySituation
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

    def _verified(self, problem: Problem, time: np.ndarray, hand: np.ndarray) -> Plan | None:
        """The path as a plan, if it holds with any target."""
        arm = problem.situation.arm
        hand[0] = arm.hand
        time, hand = refine(arm, time, hand)
        path = Trajectory.of_hand(time, hand, arm.upper_arm, arm.elbow)
        for index, body in enumerate(problem.situation.bodies):
            if body.role == "target":
                plan, _ = checked(problem, Attempt(path, index))
                if plan is not None:
                    return plan
        return None


def _number(situation: AnySituation) -> int:
    """A number that follows from the situation alone."""
    text = json.dumps(situation_to_json(situation), sort_keys=True)
    return content_number(text.encode(), 6)
