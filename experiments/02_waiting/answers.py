"""Every planner's answers to the same cases, judged by the referee of the tests."""

from __future__ import annotations

import json
import math
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from experiments.common.suite import STRATA, Case
from gcm_learn.planners import Plan, get_planner
from tests.referee import judge

PIECE = 100  # cases that are answered at once
PEER = "st-rrt-star"


@dataclass(frozen=True)
class Answer:
    """What a planner made of a case."""

    planner: str
    index: int
    """Of the case."""
    caught: bool
    catch_time: float
    """[s]; infinite if not caught."""
    planning_ms: float
    broken: bool
    """Whether the referee finds fault with what was reported as caught."""


def answers_of(
    config: dict[str, Any], cases: list[Case], folder: Path, workers: int
) -> dict[str, list[Answer]]:
    """Answers by planner, in the order of the cases; pieces that lie in the folder are kept."""
    folder.mkdir(parents=True, exist_ok=True)
    jobs = [(name, cases[k : k + PIECE]) for name in config["planners"] for k in _starts(cases)]
    few = config["on_few"]
    some = [c for s in STRATA for c in [c for c in cases if c.stratum == s][: few["per_stratum"]]]
    names = (*few["planners"], PEER)
    jobs += [(name, some[k : k + PIECE]) for name in names for k in _starts(some)]
    out: dict[str, list[Answer]] = {}
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        waiting = []
        for name, piece in jobs:
            file = folder / f"{name}_{piece[0].index:07d}_{len(piece)}.jsonl"
            job = None
            if not file.exists():
                job = pool.submit(_answer, name, piece, few["st_rrt_star_budgets_ms"], file)
            waiting.append((name, job, file))
        for name, job, file in waiting:
            if job is not None:
                job.result()
                print(f"{name}: {file.name}", flush=True)
            for line in file.read_text().splitlines():
                answer = Answer(**json.loads(line))
                out.setdefault(answer.planner, []).append(answer)
    return out


def _starts(cases: list[Case]) -> range:
    return range(0, len(cases), PIECE)


def _answer(name: str, cases: list[Case], budgets_ms: list[int], file: Path) -> None:
    """Answer a piece of the cases and write it down (whole or not at all)."""
    planner = get_planner(name)
    planner.plan(cases[0].read())  # compiled code is loaded before anything is timed
    lines = []
    for case in cases:
        situation = case.read()
        if name == PEER:
            plans = planner.plan_anytime(situation, budgets_ms)
            named = [(f"{PEER} {b} ms", p) for b, p in zip(budgets_ms, plans, strict=True)]
        else:
            named = [(name, planner.plan(situation))]
        lines += [json.dumps(asdict(_judged(n, case, situation, p))) for n, p in named]
    temporary = file.with_suffix(".tmp")
    temporary.write_text("\n".join(lines) + "\n")
    temporary.replace(file)


def _judged(name: str, case: Case, situation: Any, plan: Plan) -> Answer:
    """An answer, after the referee has looked at the catch."""
    # The referee samples time: what it complains of has to stand a closer look.
    broken = plan.caught and all(judge(situation, plan, n).complaints for n in (1000, 8000))
    time = math.inf if plan.catch_time is None else plan.catch_time
    return Answer(name, case.index, plan.caught, time, plan.planning_ms, broken)
