"""Statistics of shares: over seeds and situations, and over many tests."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.evaluation import Interval
from gcm_learn.seeding import rng

DRAWS = 2000


class Gap(NamedTuple):
    """A difference of two shares."""

    interval: Interval
    p: float
    """Of the exact test of McNemar; over seeds the largest."""


def hierarchical(values: np.ndarray, share: float = 0.95) -> Interval:
    """Mean of values (seeds, situations) with its interval: both are drawn again.

    Situations are the same for all seeds, so a draw of situations holds for all that are drawn.
    """
    source, (seeds, count) = rng(0, *values.shape), values.shape
    means = np.empty(DRAWS)
    for k in range(DRAWS):
        some = values[source.integers(seeds, size=seeds)].mean(axis=0)
        means[k] = some[source.integers(count, size=count)].mean()
    low, high = np.quantile(means, [0.5 - share / 2, 0.5 + share / 2])
    return Interval(float(values.mean()), float(low), float(high))


def told(found: Interval) -> str:
    """A share with its interval [%]."""
    return "{:.1f} ({:.0f}–{:.0f})".format(*(100 * one for one in found))


def points(found: Interval) -> str:
    """A difference with its interval [points]."""
    return "{:+.1f} ({:+.1f} to {:+.1f})".format(*(100 * one for one in found))
