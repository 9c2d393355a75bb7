"""Actors as planners: what they would do is tried out with the predictor, and verified."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gcm_learn import artifacts, seeding
from gcm_learn.errors import PolicyError
from gcm_learn.execution import CAUGHT, Pool
from gcm_learn.motion import Failure, Trajectory, refine
from gcm_learn.planners import Attempt, Plan, Problem, checked
from gcm_learn.policies.actor import FILE, Actor
from gcm_learn.situation import Situation, canonical, situation_to_json
from gcm_learn.storage import content_number

TRIES = 20  # as many as paths are checked by planners that recall


def actor_names() -> list[str]:
    """Folders of the models that hold an actor."""
    return list(artifacts.models(FILE))


def actor_folder(name: str) -> Path:
    """The folder of a trained actor; raises PolicyError if there is none."""
    folder = artifacts.model(name, FILE)
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

    def plan(self, situation: Situation) -> Plan:
        """Answer a situation."""
        problem = Problem(situation, self.name)
        answer = problem.early_answer()
        if answer is not None:
            return answer
        turned, frame = canonical(situation)
        settings: Any = self.actor.settings
        pool, here = Pool.of([turned]).prepared(settings), np.zeros(1, np.int64)
        found = [self.actor.play(pool, here)]
        if self.tries > 1:
            source = seeding.rng(self.seed, _number(turned))
            drawn = np.zeros(self.tries - 1, np.int64)
            found.append(self.actor.play(pool, drawn, source))
        paths = [
            (float(e.times[arm]), e, arm)
            for e in found
            for arm in np.flatnonzero(e.outcomes == CAUGHT)
        ]
        for _, episodes, arm in sorted(paths, key=lambda found: found[0]):
            time, hand = episodes.path(int(arm))
            plan = self._verified(problem, time, frame.original(hand))
            if plan is not None:
                return plan
        return problem.answer(Failure.NO_VALID_ROLLOUT.with_numbers(count=self.tries))

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


def _number(situation: Situation) -> int:
    """A number that follows from the situation alone."""
    text = json.dumps(situation_to_json(situation), sort_keys=True)
    return content_number(text.encode(), 6)
