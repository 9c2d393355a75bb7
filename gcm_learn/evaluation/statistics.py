"""Paired statistics of catches."""

from __future__ import annotations

from math import lgamma, log
from typing import NamedTuple

import numpy as np

from gcm_learn.seeding import rng

Z = 1.959964  # of a two-sided 95 % interval
DRAWS = 2000  # of a bootstrap
SMALLEST = 1e-99  # probability that is told; what is smaller is not worked out to that accuracy


class Interval(NamedTuple):
    """A share or difference with its 95 % interval."""

    value: float
    low: float
    high: float


def wilson(hits: int, n: int) -> Interval:
    """A share with the score interval of Wilson (1927)."""
    if n == 0:
        return Interval(float("nan"), 0.0, 1.0)
    p, z2 = hits / n, Z * Z
    middle = (p + z2 / (2 * n)) / (1 + z2 / n)
    half = Z / (1 + z2 / n) * np.sqrt(p * (1 - p) / n + z2 / (4 * n * n))
    return Interval(p, max(float(middle - half), 0.0), min(float(middle + half), 1.0))


def stratified(hits: np.ndarray, groups: np.ndarray) -> Interval:
    """A share with its bootstrap interval, resampled within groups.

    Parameters
    ----------
    hits : (n,) ndarray of bool
    groups : (n,) ndarray
        Group of each, e.g. family.
    """
    source, total = rng(0, len(hits)), np.zeros(DRAWS)
    for group in np.unique(groups):
        here = hits[groups == group]
        total += source.binomial(len(here), here.mean(), size=DRAWS)
    low, high = np.percentile(total / len(hits), [2.5, 97.5])
    return Interval(float(hits.mean()), float(low), float(high))


def chance(p: float) -> str:
    """A probability as it is written."""
    if p < SMALLEST:
        return f"< {SMALLEST:.0e}"
    return f"{p:.3f}" if p >= 1e-3 else f"{p:.0e}"


def mcnemar(first: np.ndarray, second: np.ndarray) -> tuple[int, int, float]:
    """The exact test of McNemar (1947) for pairs.

    Parameters
    ----------
    first, second : (n,) ndarray of bool
        Whether each caught, situation by situation.

    Returns
    -------
    only_first, only_second : int
        Situations that only one of them caught.
    p : float
        Two-sided probability of such a split if both were equally good.
    """
    b, c = int(np.sum(first & ~second)), int(np.sum(second & ~first))
    n = b + c
    if n == 0:
        return 0, 0, 1.0
    k = np.arange(min(b, c) + 1)
    logs = [lgamma(n + 1) - lgamma(i + 1) - lgamma(n - i + 1) - n * log(2.0) for i in k]
    return b, c, float(min(1.0, 2.0 * np.exp(logs).sum()))


def difference(
    first: np.ndarray, second: np.ndarray, groups: np.ndarray, seed: int = 0
) -> Interval:
    """Mean of first - second with its bootstrap interval, stratified.

    Parameters
    ----------
    first, second : (n,) ndarray
        Paired.
    groups : (n,) ndarray
        Situations are drawn with replacement within each group, e.g. family.
    seed : int
    """
    delta = np.asarray(first, float) - np.asarray(second, float)
    source, total = rng(seed), np.zeros(DRAWS)
    for group in np.unique(groups.astype(str)):
        mine = delta[groups.astype(str) == group]
        rows = source.integers(len(mine), size=(DRAWS, len(mine)))
        total += mine[rows].sum(axis=1)
    low, high = np.quantile(total / len(delta), [0.025, 0.975])
    return Interval(float(delta.mean()), float(low), float(high))
