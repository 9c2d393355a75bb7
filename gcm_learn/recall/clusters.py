"""Clusters of remembered catches, and whether catches hold in the situations of others.

Clusters are those of k-means. Where no number is given, that with the largest mean silhouette is
taken (Rousseeuw, Journal of Computational and Applied Mathematics 20, 1987).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Any, NamedTuple

import numpy as np

from gcm_learn import seeding
from gcm_learn.errors import MissingExtraError, RecallError, UnknownNameError
from gcm_learn.maps import CognitiveMap
from gcm_learn.recall.adaptation import DEFAULT
from gcm_learn.recall.embedding import KEYS, embed, map_encoder
from gcm_learn.recall.index import LearnedIndex, RawIndex
from gcm_learn.recall.kinds import MEMORIES
from gcm_learn.recall.planners import shipped_memory, stored_keys
from gcm_learn.recall.store import Memory

MOST, STARTS, SEEN = 16, 4, 2000  # clusters and starts that are tried, catches that judge them
ASKED, TRIED = 300, 100  # situations at most, and catches tried on each
DRAWS = 500  # bootstrap samples of the situations
BY = ("map", "trace", "raw")
Told = Callable[[int], None]
Maps = Iterable[CognitiveMap]


class Clusters(NamedTuple):
    """Catches of a memory in clusters, which are numbered from 1 on, the largest first."""

    memory: Memory
    by: str
    places: np.ndarray
    """(n, d): of the catches."""
    labels: np.ndarray
    """(n,): number of each one's cluster."""
    medoids: np.ndarray
    """(k,): catch nearest to each cluster's mean."""
    silhouette: float
    """Mean: 0 for no clusters, 1 for clusters far apart."""


def cluster(
    memory: Memory, by: str = "map", *, maps: Maps | None = None,
    count: int | None = None, seed: int = 0, progress: Told = lambda done: None,
) -> Clusters:  # fmt: skip
    """Put the catches of a memory into clusters.

    Parameters
    ----------
    memory : Memory
    by : {"map", "trace", "raw"}
        Embeddings of maps or of movements by trained encoders, or raw parameters of situations.
    maps : iterable of CognitiveMap, optional
        Of the catches; where they are needed and missing, they are made.
    count : int, optional
        Clusters; by default that number of 2 to 16 with the largest mean silhouette.
    seed : int
    progress : callable
        Called with the number of maps embedded since the last call.
    """
    try:
        from sklearn.cluster import KMeans
        from sklearn.metrics import silhouette_score
    except ModuleNotFoundError:
        raise MissingExtraError("clusters", "scikit-learn", "learn") from None
    if by not in BY:
        raise UnknownNameError.among("by", by, BY)
    places = _places(memory, by, maps, progress) if len(memory) else np.zeros((0, 1))
    most = min(len(np.unique(places, axis=0)), len(memory) - 1)
    if not 2 <= (count or min(2, most)) <= most:
        raise RecallError(f"count: {len(memory)} catches make from 2 to {most} clusters")
    best, seen = (-np.inf, np.zeros(0, int)), seeding.rng(seed).permutation(len(places))[:SEEN]
    for k in range(2, min(most, MOST) + 1) if count is None else [count]:
        groups = KMeans(k, n_init=STARTS, random_state=seed).fit_predict(places)
        best = max(best, (silhouette_score(places[seen], groups[seen]), groups), key=lambda x: x[0])
    labels = 1 + np.argsort(np.argsort(-np.bincount(best[1]), kind="stable"))[best[1]]
    medoids = [_medoid(places, np.flatnonzero(labels == k)) for k in range(1, labels.max() + 1)]
    return Clusters(memory, by, places, labels, np.array(medoids), float(best[0]))


def _medoid(places: np.ndarray, members: np.ndarray) -> int:
    away = np.linalg.norm(places[members] - places[members].mean(axis=0), axis=1)
    return int(members[np.argmin(away)])


def _places(memory: Memory, by: str, maps: Maps | None, progress: Told) -> np.ndarray:
    """Return places (n, d) of catches: directions of embeddings, or scaled parameters."""
    if by == "raw":
        return memory.refiled(RawIndex.fit(memory.situations())).embeddings[:, :-1]
    index, keys = memory.index, None
    if by == "map":
        folder = map_encoder(memory.kind)
        index = LearnedIndex.load(folder)
        keys = None if maps else stored_keys(folder / KEYS, index.key, memory.digest)
        if keys is None:
            made = maps or map(MEMORIES.of(memory.kind).map_of, memory.situations())
            keys = embed(_counted(made, progress), index.encoder)
    elif not isinstance(index, LearnedIndex) or index.encoder.config.memory != "trace":
        keys = memory.refiled(shipped_memory("recall", memory.kind).index).embeddings
    rows = memory.embeddings if keys is None else keys
    return rows / np.maximum(np.linalg.norm(rows, axis=1, keepdims=True), 1e-12)


def _counted(maps: Maps, progress: Told) -> Iterator[CognitiveMap]:
    for made in maps:
        yield made
        progress(1)


class CrossTries(NamedTuple):
    """Random catches of a memory, adapted to the situations of others."""

    asked: np.ndarray
    """(m,): catches whose situations are asked about."""
    tried: np.ndarray
    """(m, t): catches that are tried on each."""
    holds: np.ndarray
    """(m, t) bool: True where one catches."""

    def shares(self, labels: np.ndarray, where: Any = True) -> np.ndarray:
        """Return the share of tries between catches of equal label (n,) that catch.

        Shares of bootstrap samples of the situations follow it (1 + DRAWS,), NaN without tries.
        A mask (m,) says which situations count.
        """
        same = (labels[self.tried] == labels[self.asked][:, None]) & np.reshape(where, (-1, 1))
        same &= self.tried != self.asked[:, None]
        m = len(self.asked)
        drawn = seeding.rng(0).multinomial(m, np.full(m, 1.0 / max(m, 1)), DRAWS)
        weights = np.vstack([np.ones(m, int), drawn])
        held, tries = (weights @ part.sum(axis=1) for part in (same & self.holds, same))
        return np.where(tries > 0, held / np.maximum(tries, 1), np.nan)


def cross_tries(memory: Memory, seed: int = 0, progress: Told = lambda done: None) -> CrossTries:
    """Try 100 random catches on each of at most 300 situations that no straight line solves."""
    rng, kind = seeding.rng(seed, 1), MEMORIES.of(memory.kind)
    asked = rng.permutation(np.flatnonzero(np.array(memory.strata) != "L"))[:ASKED]
    tried = rng.integers(len(memory), size=(len(asked), TRIED))
    holds = np.zeros(tried.shape, bool)
    for row, k in enumerate(asked.tolist()):
        tries = kind.tries(kind.problem(memory.situation(k), "transfer"), DEFAULT)
        holds[row] = tries.catch_times(memory.knots, memory.goals, tried[row]) >= 0.0
        progress(1)
    return CrossTries(asked, tried, holds)
