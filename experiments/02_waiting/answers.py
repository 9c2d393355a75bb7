"""Every planner's answers to the same cases, judged by the referee of the tests."""

from __future__ import annotations

import json
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from experiments.common.judging import Referee, judged, outcome
from experiments.common.suite import STRATA, Case
from gcm_learn.planners import get_planner
from gcm_learn.storage import write_whole

PIECE = 100  # cases that are answered at once
PEER = "st-rrt-star"


def answers_of(
    config: dict[str, Any], cases: list[Case], folder: Path, workers: int
) -> list[dict[str, Any]]:
    """Return rows of outcomes; pieces that lie in the folder are not asked again."""
    folder.mkdir(parents=True, exist_ok=True)
    jobs = [(name, cases[k : k + PIECE]) for name in config["planners"] for k in _starts(cases)]
    few = config["on_few"]
    some = [c for s in STRATA for c in [c for c in cases if c.stratum == s][: few["per_stratum"]]]
    names = (*few["planners"], PEER)
    jobs += [(name, some[k : k + PIECE]) for name in names for k in _starts(some)]
    rows: list[dict[str, Any]] = []
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
            rows += [json.loads(line) for line in file.read_text("utf-8").splitlines()]
    return rows


def _starts(cases: list[Case]) -> range:
    return range(0, len(cases), PIECE)


def _answer(name: str, cases: list[Case], budgets_ms: list[int], file: Path) -> None:
    """Answer a piece of the cases and write it down (whole or not at all)."""
    planner, referee, rows = get_planner(name), Referee(), []
    planner.plan(cases[0].read())  # compiled code is loaded before anything is timed
    for case in cases:
        situation = case.read()
        if name == PEER:
            plans = planner.plan_anytime(situation, budgets_ms)
            found = {
                f"{PEER} {budget} ms": judged(plan, situation, referee, plan.planning_ms)
                for budget, plan in zip(budgets_ms, plans, strict=True)
            }
        else:
            found = {name: outcome(planner, situation, referee)}
        rows += [_about(case) | {"method": method} | row for method, row in found.items()]
    write_whole(file, "".join(json.dumps(row) + "\n" for row in rows))


def _about(case: Case) -> dict[str, Any]:
    """Return what a row says of a case: `oracle` is when the oracle's plan catches [s]."""
    return {
        "situation": case.index,
        "stratum": case.stratum,
        "family": case.family,
        "oracle": case.upper,
        "decided": case.decided,
    }
