"""Every planner's answers to the same cases, judged by the referee of the tests."""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from experiments.common.judging import Referee, judged, outcome
from experiments.common.outcomes import kept
from experiments.common.suite import STRATA, Case
from gcm_learn.planners import get_planner

PIECE = 100  # cases that are answered at once
PEER = "st-rrt-star"


def answers_of(
    config: dict[str, Any], cases: list[Case], folder: Path, workers: int
) -> list[dict[str, Any]]:
    """Return rows of outcomes; pieces that lie in the folder are not asked again."""
    jobs = [(name, cases[k : k + PIECE]) for name in config["planners"] for k in _starts(cases)]
    few = config["on_few"]
    some = [c for s in STRATA for c in [c for c in cases if c.stratum == s][: few["per_stratum"]]]
    names = (*few["planners"], PEER)
    jobs += [(name, some[k : k + PIECE]) for name in names for k in _starts(some)]
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        waiting = [
            pool.submit(_answered, name, piece, few["st_rrt_star_budgets_ms"], folder)
            for name, piece in jobs
        ]
        return [row for job in waiting for row in job.result()]


def _starts(cases: list[Case]) -> range:
    return range(0, len(cases), PIECE)


def _answered(
    name: str, cases: list[Case], budgets_ms: list[int], folder: Path
) -> list[dict[str, Any]]:
    """Return the outcomes of a piece of the cases, which the folder keeps."""
    file = folder / f"{name}_{cases[0].index:07d}_{len(cases)}.jsonl"
    return kept(file, partial(_answers, name, cases, budgets_ms))


def _answers(name: str, cases: list[Case], budgets_ms: list[int]) -> list[dict[str, Any]]:
    """Answer a piece of the cases."""
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
    return rows


def _about(case: Case) -> dict[str, Any]:
    """Return what a row says of a case: `oracle` is when the oracle's plan catches [s]."""
    return {
        "situation": case.index,
        "stratum": case.stratum,
        "family": case.family,
        "oracle": case.upper,
        "decided": case.decided,
    }
