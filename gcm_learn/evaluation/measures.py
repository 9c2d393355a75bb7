"""Measures that PROTOCOL demands, from the rows of a comparison."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gcm_learn.evaluation.contest import DELAYS
from gcm_learn.evaluation.statistics import Interval, difference, mcnemar, wilson
from gcm_learn.evaluation.table import Results
from gcm_learn.planners import FAULTS

REACHABLE = ("L", "W", "Q")


@dataclass(frozen=True)
class Measures:
    """Of one method on some situations."""

    method: str
    count: int
    caught: Interval
    collisions: Interval
    forearm: float
    """Share in which the forearm touches an obstacle."""
    upper_arm: float
    """Share in which the upper arm does."""
    ratio: float
    """Median of the catch's time over the oracle's, where both catch."""
    length: float
    """Median path length of the hand at catches [forearm lengths]."""
    clearance: float
    """Median least clearance of catches [forearm lengths]."""
    peak_hand: float
    """Largest hand speed at catches [forearms/s]."""
    peak_joint: float
    """95 % quantile of the largest joint speed at catches [rad/s]."""
    latency: float
    """Median [ms]."""
    latency_95: float
    """95 % quantile [ms]."""
    charged: int
    """Situations for which thinking was charged."""
    broken: float
    """Share of catches that were promised and do not hold."""
    errors: float
    """Share in which the method failed, or did not end."""
    own: Interval | None
    """Catches if each thinking is charged; None if unmeasured."""


def measured(results: Results, method: str) -> Measures:
    """Measures of a method on the rows that there are of it."""
    mine = results.of_method(method)
    n, outcome = len(mine), mine["outcome"]
    caught, touched = outcome == "caught", outcome == "touched"
    end, earliest = mine["end"].astype(float), mine["earliest"].astype(float)
    both = caught & np.isfinite(earliest) & (earliest > 1e-3)
    joints = np.maximum(mine["peak_shoulder"].astype(float), mine["peak_elbow"].astype(float))
    charged = np.array([c is not None for c in mine["charged_own"]], dtype=bool)
    own = None
    if charged.any():
        own = wilson(int((mine["charged_own"][charged] == "caught").sum()), int(charged.sum()))
    return Measures(
        method=method,
        count=n,
        caught=wilson(int(caught.sum()), n),
        collisions=wilson(int(touched.sum()), n),
        forearm=float(np.mean(mine["part"] == "forearm")) if n else float("nan"),
        upper_arm=float(np.mean(mine["part"] == "upper arm")) if n else float("nan"),
        ratio=_median(end[both] / earliest[both]),
        length=_median(mine["length"].astype(float)[caught]),
        clearance=_median(mine["clearance"].astype(float)[caught]),
        peak_hand=_quantile(mine["peak_hand"].astype(float)[caught], 1.0),
        peak_joint=_quantile(joints[caught], 0.95),
        latency=_median(mine["latency_ms"]),
        latency_95=_quantile(mine["latency_ms"], 0.95),
        charged=int(charged.sum()),
        broken=float(np.mean(outcome == "broken")) if n else float("nan"),
        errors=float(np.mean(outcome == "error")) if n else float("nan"),
        own=own,
    )


def charged_curve(results: Results, method: str) -> list[Interval]:
    """Shares of catches over `DELAYS`; empty if they were not measured."""
    mine = results.of_method(method)
    curve = []
    for delay in DELAYS:
        outcome = mine[f"charged_{round(1e3 * delay)}"]
        there = np.array([o is not None for o in outcome], dtype=bool)
        if not there.any():
            return []
        curve.append(wilson(int((outcome[there] == "caught").sum()), int(there.sum())))
    return curve


def declines(results: Results, method: str) -> Interval:
    """Share of unreachable situations that pass without a touch or a failure of the method."""
    mine = results.of_method(method)
    mine = mine.where(mine["stratum"] == "U")
    wrong = np.isin(mine["outcome"].astype(str), ("touched", *FAULTS))
    return wilson(int((~wrong).sum()), len(mine))


@dataclass(frozen=True)
class Pair:
    """Two methods on the same situations."""

    first: str
    second: str
    difference: Interval
    """Of catch rates, first less second."""
    only_first: int
    only_second: int
    p: float
    """McNemar's exact test."""


def pairs(results: Results, reference: str) -> list[Pair]:
    """Every method against one of them, on reachable situations."""
    reachable = results.where(np.isin(results["stratum"].astype(str), REACHABLE))
    there = reachable.of_method(reference)
    out = []
    for name in results.methods:
        if name == reference or not len(there):
            continue
        mine = reachable.of_method(name)
        first, second = mine["outcome"] == "caught", there["outcome"] == "caught"
        b, c, p = mcnemar(first, second)
        delta = difference(first, second, mine["family"])
        out.append(Pair(name, reference, delta, b, c, p))
    return out


def _median(values: np.ndarray) -> float:
    return _quantile(values, 0.5)


def _quantile(values: np.ndarray, q: float) -> float:
    finite = values[np.isfinite(values)]
    return float(np.quantile(finite, q)) if len(finite) else float("nan")
