"""Answers under inexact perception: an episode of the closed loop."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from gcm_learn import execution
from gcm_learn.arms import PLANAR, kind_of
from gcm_learn.errors import SuiteError
from gcm_learn.evaluation.conditions import OWN, Condition
from gcm_learn.evaluation.entrants import Answer, Method, PlannerMethod
from gcm_learn.evaluation.judging import judged
from gcm_learn.evaluation.machine import spent
from gcm_learn.evaluation.sources import Case
from gcm_learn.motion import Movement
from gcm_learn.planners import Catch, Plan, in_words
from gcm_learn.processes import OutOfTime, time_limit

SEED = 0  # of the errors, the same for all entrants


class _Noted(execution.ExactPlant):
    """A plant that records the movement of its arm."""

    def __init__(self, situation: Any) -> None:
        super().__init__(situation)
        self._parts: list[tuple[np.ndarray, ...]] = []

    def follow(self, trajectory: Movement, until: float) -> None:
        """Let the world go on as `ExactPlant` does."""
        since = self.time
        super().follow(trajectory, until)
        inner = trajectory.time[(trajectory.time > since) & (trajectory.time < self.time)]
        time = np.concatenate([[since], inner, [self.time]])[bool(self._parts) :]
        if len(time) and self.time > since:
            hand = trajectory.hand_at(time)
            self._parts.append((time, hand, *trajectory.states_at(time)[:2]))

    def movement(self) -> Movement | None:
        """Return the movement so far; None if there was no time for any."""
        if not self._parts:
            return None
        time, hand, joints, rates = (
            np.concatenate(rows) for rows in zip(*self._parts, strict=True)
        )
        arm: Any = self.situation.arm
        if kind_of(arm) == PLANAR:
            return Movement.of_hand(arm, time, hand)
        limited = arm.max_joint_acceleration is not None
        return Movement(arm, time, joints, rates if limited else None)


def mind_of(method: Method) -> Any:
    """Return the agent of the closed loop that a method is.

    Raises
    ------
    SuiteError
    """
    if isinstance(method, PlannerMethod):
        return execution.Planning(method.planner)
    raise SuiteError(f"noise: {method.name!r} is no planner")


def seen(method: Method, case: Case, condition: Condition) -> dict[str, Any]:
    """Return the columns of an episode in which bodies are perceived with errors.

    A planner plans anew when its plan does not catch any more in the world as it is believed to be.
    """
    thinking = None if condition.thinking == OWN else float(condition.thinking)
    situation, plant, since = case.situation, _Noted(case.situation), spent()
    loop = execution.Loop(execution.Perception(condition.noise), thinking=thinking)
    try:
        with time_limit(condition.limit):
            course = execution.run_closed_loop(
                mind_of(method), plant, situation, loop, SEED, int(case.key[:8], 16)
            )
    except OutOfTime:
        return {"outcome": "error", "ms": 0.0, "reason": f"no end within {condition.limit:g} s"}
    except (Exception, SystemExit) as error:
        return {"outcome": "error", "ms": 0.0, "reason": in_words(error)}
    ms = 1e3 * (spent() - since) / max(len(course.thoughts), 1)
    charged = float(np.mean([thought.took for thought in course.thoughts] or [0.0]))
    outcome, moves = execution.OUTCOMES[course.outcome], plant.movement()
    *before, last = [Catch(catch.body, catch.time) for catch in course.catches] or [Catch("", 0.0)]
    caught = outcome == "caught"
    plan = Plan(
        situation.name, method.name, "caught" if caught else "unreachable", outcome, 0.0,
        last[1] if caught else None, last[0] if caught else None, trajectory=moves,
        on_the_way=tuple(before) if caught else (),
    )  # fmt: skip
    answer = Answer(outcome, ms, (plan,))
    return {"charged": charged} | judged(answer, situation, json.loads(case.text))
