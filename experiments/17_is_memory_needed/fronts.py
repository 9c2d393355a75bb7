"""Fronts that answer first, and fallbacks that plan after them; thinking is charged.

A hybrid answers with what its front says, and asks its fallback where the front has no catch. So
each front and each fallback is asked once of a situation, and all pairs are put together from that.
"""

from __future__ import annotations

import json
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from experiments.common.judging import Referee
from experiments.common.questions import Question
from gcm_learn.evaluation.kinds import resting
from gcm_learn.planners import Planner, get_planner
from gcm_learn.scene import later
from gcm_learn.storage import write_whole

CHARGED = 0.02  # thinking [s]
BUDGET_MS = 15.0  # of ST-RRT*: with its opening and verification it is to be ready by 20 ms
FRONTS = {
    "learned": "recall", "raw": "recall-raw", "random": "recall-random",
    "splines": "splines-random",
}  # fmt: skip
FALLBACKS = {"gcm": "gcm", "marching": "marching", "layered": "layered", "ST-RRT*": "st-rrt-star"}


def planners() -> dict[str, Planner]:
    """Fronts and fallbacks by name."""
    found = {name: get_planner(known) for name, known in (FRONTS | FALLBACKS).items()}
    trees: Any = found["ST-RRT*"]
    return found | {"ST-RRT*": replace(trees, budget_ms=BUDGET_MS)}


def parts(
    file: Path, rows: Sequence[Question], referee: Referee, who: Mapping[str, Planner]
) -> list[dict[str, Any]]:
    """Answers of each to every situation as it is after 20 ms of rest; kept in a file."""
    if file.exists():
        return [json.loads(line) for line in file.read_text("utf-8").splitlines()]
    out = []
    for question in rows[:5]:
        for planner in who.values():
            planner.plan(question.situation)
    for question in rows:
        one: dict[str, Any] = {"stratum": question.stratum, "family": question.family}
        one["rests"] = resting(question.situation, CHARGED)
        after = later(question.situation, CHARGED)
        for name, planner in who.items():
            if not one["rests"]:
                one[name] = _asked(name, planner, after, referee)
        out.append(one)
    file.parent.mkdir(parents=True, exist_ok=True)
    write_whole(file, "".join(json.dumps(one) + "\n" for one in out))
    return out


def _asked(name: str, planner: Planner, situation: Any, referee: Referee) -> list[Any]:
    """Return if it catches, its processor time [ms], and if the referee finds fault."""
    began = time.process_time()
    plan = planner.plan(situation)
    ms = 1e3 * (time.process_time() - began)
    if name == "ST-RRT*":  # thinks in a process of its own
        ms = plan.planning_ms
    return [plan.caught, round(ms, 3), plan.caught and referee.broken(situation, plan)]


def hybrids(
    told: list[dict[str, Any]],
    fronts: Iterable[str] = FRONTS,
    fallbacks: Iterable[str] = FALLBACKS,
) -> dict[tuple[str, str], dict[str, np.ndarray]]:
    """By front and fallback: what is caught, and what is caught within 20 ms."""
    out = {}
    for front in ("none", *fronts):
        for fallback in fallbacks:
            rows = [_joined(one, front, fallback) for one in told]
            names = ("caught", "ready", "ms")
            out[front, fallback] = dict(
                zip(names, map(np.array, zip(*rows, strict=True)), strict=True)
            )
    return out


def _joined(one: dict[str, Any], front: str, fallback: str) -> tuple[bool, bool, float]:
    """Caught, caught and ready by then, processor time [ms]."""
    if one["rests"]:
        return one["rests"] == "caught", one["rests"] == "caught", 0.0
    first = [False, 0.0] if front == "none" else one[front]
    caught, ms = first[:2]
    if not caught:
        caught, more = one[fallback][:2]
        ms += more
    return caught, caught and ms <= 1e3 * CHARGED, ms
