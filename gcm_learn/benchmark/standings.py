"""Standings: the measures of methods on one suite, side by side."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gcm_learn.benchmark.cases import Loaded
from gcm_learn.benchmark.judging import BROKEN, CAUGHT, ERROR, Judged, judged
from gcm_learn.errors import SuiteError
from gcm_learn.evaluation import Interval, holm, mcnemar, wilson

BUDGETS_MS = (1.0, 10.0, 20.0, 100.0, 1000.0)
"""Thinking times at which catches are counted [ms, calibrated]."""
UNREACHABLE = "U"


@dataclass(frozen=True)
class Standing:
    """Measures of a method on a suite."""

    method: str
    caught: Interval
    """Share of the situations that are not U."""
    within: tuple[float, ...]
    """The same share, by `BUDGETS_MS`."""
    strata: Mapping[str, tuple[int, int]]
    """Catches and situations by stratum; of U, situations without a catch, rightly."""
    median_ms: float
    """Of all answers [ms, calibrated]."""
    ratio: float
    """Catch time over the earliest of all methods, on average over its catches; NaN if several
    targets are wanted, since a later catch may then be one more."""
    broken: int
    errors: int
    nodes: float
    """Mean of all answers."""
    p: float
    """Of McNemar's test against the first, corrected by Holm; NaN for the first. Where several
    targets are wanted, a situation counts for the method that catches more of them."""
    targets: float
    """Share of all targets that are wanted, each for itself."""
    times_ms: tuple[float, ...]
    """Thinking times of the catches that count, in order [ms, calibrated]."""
    answers: int


Run = tuple[Mapping[str, Any], Mapping[str, Any]]
"""A result, and one of its runs."""


def runs_by_suite(results: Sequence[Mapping[str, Any]]) -> dict[str, list[Run]]:
    """Return the runs of results by the name of their suite."""
    found: dict[str, list[Run]] = {}
    for result in results:
        for run in result["runs"]:
            found.setdefault(run["suite"], []).append((result, run))
    return found


def standings(suite: Loaded, runs: Sequence[Run]) -> list[Standing]:
    """Judge all answers again and return the methods, the best first.

    All targets count in suites that ask for several.

    Raises
    ------
    SuiteError
        If a run has another hash, or other situations.
    """
    for result, run in runs:
        _check(suite, result["method"], run)
    names = _distinct([str(result["method"]) for result, _ in runs])
    verdicts = [
        [judged(case, answer) for case, answer in zip(suite.cases, run["answers"], strict=True)]
        for _, run in runs
    ]
    factors = [float(result["calibration"]["factor"]) for result, _ in runs]
    scores = [_scores(suite, found) for found in verdicts]
    order = sorted(range(len(runs)), key=lambda k: (-int(scores[k].sum()), names[k]))
    first = scores[order[0]]
    chances = holm([mcnemar(first > scores[k], scores[k] > first)[2] for k in order[1:]])
    best = _earliest(verdicts)
    return [
        _standing(suite, names[k], verdicts[k], factors[k], best, p)
        for k, p in zip(order, [float("nan"), *chances], strict=True)
    ]


def _check(suite: Loaded, method: str, run: Mapping[str, Any]) -> None:
    if run["sha256"] != suite.sha256:
        raise SuiteError(
            f"{method}: suite {suite.name!r} has hash {run['sha256'][:16]}, "
            f"and the others have {suite.sha256[:16]}"
        )
    given, asked = [a["name"] for a in run["answers"]], [case.name for case in suite.cases]
    if given != asked:
        first = next((a for a, b in zip(asked, given, strict=False) if a != b), "the last ones")
        raise SuiteError(f"{method}: suite {suite.name!r}: the answer to {first} is missing")


def _distinct(names: Sequence[str]) -> list[str]:
    """Return the names, with a number where one is there again."""
    seen: dict[str, int] = {}
    made = []
    for name in names:
        seen[name] = seen.get(name, 0) + 1
        made.append(name if seen[name] == 1 else f"{name} ({seen[name]})")
    return made


def _scores(suite: Loaded, found: Sequence[Judged]) -> np.ndarray:
    """Return what counts in each situation: targets where several are wanted, else catches."""
    if not asks_for_several(suite):
        return _hits(suite, found)
    return np.array([one.targets for one in found])[_counted(suite)]


def _hits(suite: Loaded, found: Sequence[Judged]) -> np.ndarray:
    """Return which of the situations that count are caught."""
    return np.array([one.outcome == CAUGHT for one in found])[_counted(suite)]


def _counted(suite: Loaded) -> np.ndarray:
    """Return which of the situations count."""
    return np.array([case.item.stratum != UNREACHABLE for case in suite.cases])


def _earliest(verdicts: Sequence[Sequence[Judged]]) -> np.ndarray:
    """Return the earliest catch of each situation [s]; infinite without any."""
    times = [[np.inf if v.catch_time is None else v.catch_time for v in row] for row in verdicts]
    return np.array(times).min(axis=0)


def _standing(
    suite: Loaded, method: str, found: Sequence[Judged], factor: float, best: np.ndarray, p: float
) -> Standing:
    hits = _hits(suite, found)
    counted = [v for v, c in zip(found, suite.cases, strict=True) if c.item.stratum != UNREACHABLE]
    times = sorted(factor * one.ms for one in counted if one.outcome == CAUGHT)
    count = len(counted)
    ratios = [] if asks_for_several(suite) else _ratios(found, best)
    return Standing(
        method=method,
        caught=wilson(int(hits.sum()), count),
        within=tuple(sum(t <= budget for t in times) / max(count, 1) for budget in BUDGETS_MS),
        strata=_strata(suite, found),
        median_ms=float(np.median([factor * one.ms for one in found])),
        ratio=float(np.mean(ratios)) if ratios else float("nan"),
        broken=sum(one.outcome == BROKEN for one in found),
        errors=sum(one.outcome == ERROR for one in found),
        nodes=float(np.mean([one.nodes for one in found])),
        p=p,
        targets=sum(one.targets for one in counted) / max(_wanted(suite), 1),
        times_ms=tuple(times),
        answers=len(found),
    )


def _ratios(found: Sequence[Judged], best: np.ndarray) -> list[float]:
    """Return catch times over the earliest ones; beside a catch at t = 0 only another one has."""
    pairs = [(one.catch_time, first) for one, first in zip(found, best.tolist(), strict=True)]
    return [
        1.0 if time == first else time / first
        for time, first in pairs
        if time is not None and (first > 0.0 or time == first)
    ]


def _wanted(suite: Loaded) -> int:
    """Return how many targets are wanted in the situations that count."""
    return sum(
        _several(case.given) or 1 for case in suite.cases if case.item.stratum != UNREACHABLE
    )


def asks_for_several(suite: Loaded) -> bool:
    """Return whether a situation of a suite asks for several catches."""
    return any(_several(case.given) for case in suite.cases)


def _several(given: Mapping[str, Any]) -> int:
    """Return how many targets a situation wants, 0 if it wants one of them."""
    if given.get("catch", "any") == "any":
        return 0
    return sum(body["role"] == "target" for body in given["bodies"])


def _strata(suite: Loaded, found: Sequence[Judged]) -> dict[str, tuple[int, int]]:
    """Count right answers and situations by stratum, in the order of the suite."""
    counts: dict[str, tuple[int, int]] = {}
    for case, one in zip(suite.cases, found, strict=True):
        stratum = case.item.stratum
        wanted = ("unreachable", "start_blocked") if stratum == UNREACHABLE else (CAUGHT,)
        right, total = counts.get(stratum, (0, 0))
        counts[stratum] = (right + (one.outcome in wanted), total + 1)
    return counts
