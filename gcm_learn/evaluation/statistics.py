"""Paired statistics of catches."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from gcm_learn.seeding import rng

DRAWS = 2000  # of a bootstrap
FEW = 100  # fewer situations are not drawn again within groups: small groups hardly vary
SMALLEST = 1e-99  # least reported probability; smaller ones are not accurate


class Interval(NamedTuple):
    """A share or difference with its 95 % interval."""

    value: float
    low: float
    high: float


def wilson(hits: int, n: int) -> Interval:
    """A share with the score interval of Wilson (1927)."""
    from scipy.stats import binomtest  # takes a second to load

    if n == 0:
        return Interval(float("nan"), 0.0, 1.0)
    low, high = binomtest(hits, n).proportion_ci(method="wilson")
    return Interval(hits / n, float(low), float(high))


def chance(p: float) -> str:
    """Return a probability as text."""
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
    from scipy.stats import binomtest  # takes a second to load

    b, c = int(np.sum(first & ~second)), int(np.sum(second & ~first))
    return b, c, float(binomtest(b, b + c).pvalue) if b + c else 1.0


def holm(chances: Sequence[float]) -> list[float]:
    """Chances of several comparisons, corrected for how many there are (Holm 1979)."""
    out, highest = [0.0] * len(chances), 0.0
    for rank, k in enumerate(np.argsort(chances, kind="stable").tolist()):
        highest = max(highest, min(1.0, (len(chances) - rank) * chances[k]))
        out[k] = highest
    return out


def difference(
    first: np.ndarray, second: np.ndarray, groups: np.ndarray, seed: int = 0
) -> Interval:
    """Return the mean of first - second with its 95 % interval.

    From 100 pairs on by a bootstrap that is stratified, which scipy's is not. Of fewer, the score
    interval of Newcombe for shares, and a bootstrap that is not stratified for other numbers.

    Parameters
    ----------
    first, second : (n,) ndarray
        Paired.
    groups : (n,) ndarray
        Situations are drawn with replacement within each group, e.g. family.
    seed : int
    """
    first, second = np.asarray(first), np.asarray(second)
    if len(first) < FEW:
        if first.dtype == second.dtype == bool:
            return _newcombe(first, second)
        groups = np.zeros(len(first))
    delta = first.astype(float) - second.astype(float)
    source, total = rng(seed), np.zeros(DRAWS)
    for group in np.unique(groups.astype(str)):
        mine = delta[groups.astype(str) == group]
        rows = source.integers(len(mine), size=(DRAWS, len(mine)))
        total += mine[rows].sum(axis=1)
    low, high = np.quantile(total / len(delta), [0.025, 0.975])
    return Interval(float(delta.mean()), float(low), float(high))


def hierarchical(values: np.ndarray, share: float = 0.95) -> Interval:
    """Return the mean over seeds with its interval, by resampling both seeds and situations.

    A draw of situations holds for all seeds, since situations are the same for all of them.

    Parameters
    ----------
    values : (seeds, n) ndarray
    share : float
        Coverage of the interval.
    """
    source, (seeds, count) = rng(0, *values.shape), values.shape
    means = np.empty(DRAWS)
    for k in range(DRAWS):
        some = values[source.integers(seeds, size=seeds)].mean(axis=0)
        means[k] = some[source.integers(count, size=count)].mean()
    low, high = np.quantile(means, [0.5 - share / 2, 0.5 + share / 2])
    return Interval(float(values.mean()), float(low), float(high))


def _newcombe(first: np.ndarray, second: np.ndarray) -> Interval:
    """Difference of paired shares (n,) by method 10 of Newcombe, Statistics in Medicine 17, 2635.

    It joins both Wilson intervals by how much the pairs agree.
    """
    n, p, q = (
        len(first),
        wilson(int(first.sum()), len(first)),
        wilson(int(second.sum()), len(first)),
    )
    both, neither = int(np.sum(first & second)), int(np.sum(~first & ~second))
    only = int(np.sum(first & ~second)) * int(np.sum(second & ~first))
    agree = float(both * neither - only)
    if agree > 0:
        agree = max(agree - n / 2, 0.0)  # for continuity
    spread = np.sqrt(float(first.sum() * second.sum() * (~first).sum() * (~second).sum()))
    phi = agree / spread if spread > 0.0 else 0.0

    def reach(one: float, other: float) -> float:
        return float(np.sqrt(max(one**2 - 2.0 * phi * one * other + other**2, 0.0)))

    delta = p.value - q.value
    low = delta - reach(p.value - p.low, q.high - q.value)
    return Interval(delta, low, delta + reach(p.high - p.value, q.value - q.low))
