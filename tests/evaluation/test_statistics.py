"""Statistics, against values that can be looked up."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gcm_learn.evaluation.statistics import (
    chance,
    difference,
    hierarchical,
    holm,
    mcnemar,
    wilson,
)
from gcm_learn.seeding import rng as rng_of


def test_wilson_is_that_of_the_books():
    value, low, high = wilson(81, 263)  # the example of Newcombe, Statistics in Medicine 17 (1998)
    assert value == pytest.approx(0.3080, abs=1e-4)
    assert (low, high) == pytest.approx((0.2553, 0.3662), abs=1e-4)
    assert wilson(0, 10).low == 0.0 and wilson(10, 10).high == pytest.approx(1.0)
    assert math.isnan(wilson(0, 0).value)


def test_holm_asks_more_of_the_smallest_chance_and_keeps_the_order():
    assert holm([0.01, 0.04, 0.03]) == pytest.approx([0.03, 0.06, 0.06])
    assert holm([0.6, 0.9]) == [1.0, 1.0]
    assert holm([]) == []


def test_mcnemar_is_the_binomial_test_of_what_differs():
    first = np.array([True] * 9 + [False] * 2 + [True] * 50)
    second = np.array([False] * 9 + [True] * 2 + [True] * 50)
    b, c, p = mcnemar(first, second)
    tail = sum(math.comb(11, i) for i in range(3)) / 2**11
    assert (b, c) == (9, 2) and p == pytest.approx(2 * tail)
    assert mcnemar(second, first)[2] == pytest.approx(p)
    assert mcnemar(first, first) == (0, 0, 1.0)


def test_the_interval_covers_as_often_as_it_says(rng):
    groups = np.repeat(["a", "b"], 60)
    covered = 0
    for trial in range(60):
        first = rng.random(120) < np.where(groups == "a", 0.9, 0.4)
        second = rng.random(120) < np.where(groups == "a", 0.7, 0.4)
        d = difference(first, second, groups, seed=trial)
        assert d.low <= d.value <= d.high
        covered += d.low <= 0.1 <= d.high
    assert covered >= 51


def test_strata_of_a_group_are_never_mixed():
    """A difference that is the same within each group has no spread."""
    groups = np.repeat(["a", "b"], 50)
    first = groups == "a"
    d = difference(first, np.zeros(100, bool), groups)
    assert d == (0.5, 0.5, 0.5)


def test_probabilities_are_told_as_people_write_them():
    assert [chance(p) for p in (0.25, 0.0004, 0.0)] == ["0.250", "4e-04", "< 1e-99"]


def test_pairs_stay_together(rng):
    """What lifts both the same is no difference, however much it varies."""
    numbers, alone = rng.normal(size=200), np.zeros(200)
    assert difference(numbers > 0.0, numbers > 0.0, alone) == (0.0, 0.0, 0.0)
    assert difference(numbers + 0.1, numbers, alone) == pytest.approx((0.1, 0.1, 0.1))


@pytest.mark.parametrize("seed", range(3))
def test_bootstraps_are_as_wide_as_theory_says(seed):
    """Large groups of unequal size and share: 1.96 deviations of a sum of binomials, both ways."""
    groups = np.repeat(["a", "b"], [400, 1600])
    hits = rng_of(seed).random(2000) < np.where(groups == "a", 0.5, 0.2)
    variance = sum(np.sum(groups == g) * hits[groups == g].var() for g in "ab")
    half = 1.96 * np.sqrt(variance) / len(hits)
    found = difference(hits, np.zeros(2000), groups, seed)
    assert found.value == hits.mean()
    assert found.high - found.value == pytest.approx(half, rel=0.12)
    assert found.value - found.low == pytest.approx(half, rel=0.12)


def test_a_few_pairs_have_the_interval_of_the_books():
    """An example of Newcombe, Statistics in Medicine 17 (1998): of 50 pairs 36, 12, 2 and 0."""
    first = np.repeat([True, True, False, False], (36, 12, 2, 0))
    second = np.repeat([True, False, True, False], (36, 12, 2, 0))
    found = difference(first, second, np.arange(50))
    assert found == pytest.approx((0.2, 0.0569, 0.3404), abs=1e-4)


def test_a_few_pairs_never_have_an_interval_of_no_width():
    """Nor one that leaves 0 out where the exact test says that chance would do."""
    first = np.array([True] * 20 + [False] * 2)
    families = np.arange(22) // 2
    found = difference(first, np.ones(22, bool), families)
    assert found.low < -0.2 and found.high > 0.0 and mcnemar(first, np.ones(22, bool))[2] == 0.5
    alike = difference(first, first, families)
    assert alike.low < 0.0 < alike.high


def test_intervals_of_few_pairs_cover_as_often_as_they_say(rng):
    covered = 0
    for _ in range(400):
        draws = rng.random(30)
        first, second = draws < 0.9, (draws < 0.6) | (rng.random(30) < 0.2)
        d = difference(first, second, np.zeros(30))
        covered += d.low <= 0.9 - (0.6 + 0.4 * 0.2) <= d.high
    assert 0.93 * 400 < covered


@pytest.mark.parametrize("varies", ["seeds", "situations"])
def test_seeds_and_situations_both_make_an_interval_wide(varies):
    """Values that vary with one of them only: 1.96 deviations of the mean of so many."""
    numbers = rng_of(3).normal(size=12 if varies == "seeds" else 300)
    shape = (len(numbers), 300) if varies == "seeds" else (5, len(numbers))
    values = np.broadcast_to(numbers[:, None] if varies == "seeds" else numbers, shape)
    found, half = hierarchical(values), 1.96 * numbers.std() / np.sqrt(len(numbers))
    assert found.value == pytest.approx(numbers.mean())
    assert found.high - found.value == pytest.approx(half, rel=0.15)
    assert found.value - found.low == pytest.approx(half, rel=0.15)
    narrow = hierarchical(values, 0.5)
    assert narrow.high - narrow.low == pytest.approx(2 * half * 0.674 / 1.96, rel=0.15)
