"""Clusters of catches, and tries of catches in each other's situations."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("sklearn")

from gcm_learn import artifacts
from gcm_learn.errors import GcmError
from gcm_learn.recall import CrossTries, LearnedIndex, cluster
from tests.recall.conftest import memory_by
from tests.refusals import refusal

SIZES = (40, 25, 12)


@pytest.fixture(scope="module")
def index():
    """Return the shipped index, which places movements."""
    return LearnedIndex.load(artifacts.shipped("models") / "encoder")


def blobs(index, sizes=SIZES):
    """Return a memory of groups of directions that lie far apart, mixed, and whose they are."""
    rng = np.random.default_rng(0)
    groups = rng.permutation(np.repeat(np.arange(len(sizes)), sizes))
    centres = 5.0 * np.eye(index.dim)[: len(sizes)]
    places = centres[groups] + rng.normal(0.0, 0.2, (len(groups), index.dim))
    knots = np.zeros((len(groups), 24, 4), np.float32)
    return memory_by(index, places, knots, np.zeros((len(groups), 2), np.float32)), groups


def test_groups_that_lie_apart_are_found_the_largest_first(index):
    memory, groups = blobs(index)
    found = cluster(memory, "trace", seed=3)
    assert np.array_equal(found.labels, groups + 1)
    assert found.silhouette > 0.7
    for number, medoid in enumerate(found.medoids, 1):
        mine = found.places[found.labels == number]
        square = ((mine[:, None] - mine) ** 2).sum(axis=2).mean(axis=1)
        assert np.array_equal(found.places[medoid], mine[np.argmin(square)])


def test_their_number_can_be_given(index):
    memory, groups = blobs(index)
    every = [cluster(memory, "trace", count=k).silhouette for k in (2, 4)]
    assert max(every) < cluster(memory, "trace").silhouette
    one, again = (cluster(memory, "trace", count=2, seed=1) for _ in range(2))
    assert set(one.labels) == {1, 2}
    assert all(len(set(one.labels[groups == g])) == 1 for g in range(3))
    assert np.array_equal(one.labels, again.labels)


@pytest.mark.parametrize(
    ("sizes", "by", "count", "said"),
    [
        (SIZES, "trace", 1, "count: 77 catches make from 2 to 76 clusters"),
        (SIZES, "trace", 77, "from 2 to 76"),
        ((2,), "trace", None, "count: 2 catches make from 2 to 1 clusters"),
        ((0,), "raw", None, "count: 0 catches"),
        (SIZES, "path", None, "by: "),
    ],
)
def test_what_cannot_be_clustered_is_refused(index, sizes, by, count, said):
    assert said in refusal(GcmError, cluster, blobs(index, sizes)[0], by, count=count)


def test_shares_are_of_tries_between_two_of_one_label():
    rng = np.random.default_rng(1)
    n, m, t = 30, 12, 20
    tries = CrossTries(
        rng.permutation(n)[:m], rng.integers(n, size=(m, t)), rng.random((m, t)) < 0.5
    )
    labels, where = rng.integers(3, size=n), rng.random(m) < 0.7
    pairs = [
        tries.holds[i, j]
        for i in np.flatnonzero(where)
        for j in range(t)
        if tries.tried[i, j] != tries.asked[i]
        and labels[tries.tried[i, j]] == labels[tries.asked[i]]
    ]
    share, *draws = tries.shares(labels, where)
    assert share == pytest.approx(np.mean(pairs))
    low, high = np.percentile(draws, [2.5, 97.5])
    assert low < share < high
    assert np.isnan(tries.shares(np.arange(n))).all()  # no two catches share a label
