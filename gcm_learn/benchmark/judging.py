"""Verdicts on answers, by the referee alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from gcm_learn.benchmark.cases import Case
from gcm_learn.referee import judge

CAUGHT, BROKEN, ERROR = "caught", "broken", "error"


@dataclass(frozen=True)
class Judged:
    """An answer as it counts."""

    outcome: str
    """caught, unreachable, start_blocked, broken or error."""
    ms: float
    """Processor time [ms]."""
    nodes: int
    catch_time: float | None
    """[s]"""
    complaints: Sequence[str] = ()
    targets: int = 0
    """Targets that are caught."""


def judged(case: Case, answer: Mapping[str, Any]) -> Judged:
    """Judge an answer of a result file.

    Parameters
    ----------
    case : Case
    answer : mapping
        With `ms`, `nodes`, `fault` and `solution`.

    Returns
    -------
    Judged
        A broken promise is no catch.
    """
    solution, fault = answer["solution"], answer["fault"]
    if fault == ERROR:
        return Judged(ERROR, answer["ms"], 0, None, (str(answer.get("message", "")),))
    complaints = [str(c) for c in judge(case.given, solution, case.models)]
    if fault == BROKEN or complaints:
        told = complaints or [str(solution.get("message", ""))]
        return Judged(BROKEN, answer["ms"], answer["nodes"], None, told)
    status = solution["status"]
    time = solution["catch_time"] if status == CAUGHT else None
    targets = max(len(solution.get("catches", ())), 1) if status == CAUGHT else 0
    return Judged(status, answer["ms"], answer["nodes"], time, targets=targets)
