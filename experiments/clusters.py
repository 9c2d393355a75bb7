"""Clusters of catches by their places, and transfer within and across them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from sklearn.cluster import KMeans
from sklearn.metrics import adjusted_mutual_info_score, adjusted_rand_score

from gcm_learn import seeding
from gcm_learn.dataset import Record
from gcm_learn.evaluation import Table
from gcm_learn.recall import MEMORIES, Adaptation

K = 16  # clusters of k-means
REPEATS = 8  # resamples whose clusterings are compared
ASKED, TRIED = 1500, 120  # situations that need more than a straight line; memories tried on each
REST = -1  # HDBSCAN: in no cluster
Transfer = tuple[float, float, float, float, float]


class Experience(NamedTuple):
    """Catches and what is known of them."""

    records: list[Record]
    traces: np.ndarray
    goals: np.ndarray
    labels: dict[str, np.ndarray]
    """Family, stratum and others (n,) str by name."""
    hand: np.ndarray
    """(n, k): numbers of the hand at t = 0 and of the arm."""
    end: np.ndarray
    """(n, m): also where and when the catch is, with squares and products."""


def directions(rows: np.ndarray) -> np.ndarray:
    """Rows of length 1: what an inner product orders by, whoever asks."""
    return rows / np.maximum(np.linalg.norm(rows, axis=1, keepdims=True), 1e-12)


def k_means(rows: np.ndarray, seed: int) -> KMeans:
    """Fitted centres."""
    return KMeans(K, n_init=4, random_state=seed).fit(rows)


def stability(rows: np.ndarray, repeats: int = REPEATS) -> tuple[float, float]:
    """Mean adjusted Rand index and mutual information of k-means on bootstrap samples."""
    fits = []
    for k in range(repeats):
        sample = seeding.rng(8, k).integers(len(rows), size=len(rows))
        fits.append(k_means(rows[sample], k).predict(rows.astype(rows[sample].dtype)))
    pairs = [(a, b) for k, a in enumerate(fits) for b in fits[:k]]
    rand = np.mean([adjusted_rand_score(a, b) for a, b in pairs])
    return float(rand), float(np.mean([adjusted_mutual_info_score(a, b) for a, b in pairs]))


class Tries(NamedTuple):
    """Memories tried on situations of others."""

    asked: np.ndarray  # (m,)
    tried: np.ndarray  # (m, t)
    holds: np.ndarray  # (m, t) bool


def times(some: Experience, index: int, rows: np.ndarray) -> np.ndarray:
    """Catch times (m,) of some memories on the situation of a record, negative without a catch."""
    situation = some.records[index].situation
    kind = MEMORIES.of(situation)
    tried = kind.tries(kind.problem(situation, "transfer"), Adaptation())
    found: np.ndarray = tried.catch_times(some.traces, some.goals, rows)
    return found


def tries(some: Experience, most: int = ASKED) -> Tries:
    """Try random memories on at most so many situations that a straight line does not catch."""
    rng = seeding.rng(10)
    hard = rng.permutation(np.flatnonzero(some.labels["stratum"] != "L"))[:most]
    tried = rng.integers(len(some.records), size=(len(hard), TRIED))
    holds = [times(some, i, row) >= 0.0 for i, row in zip(hard.tolist(), tried, strict=True)]
    return Tries(hard, tried, np.array(holds) & (tried != hard[:, None]))


def transfers(found: Tries, clusters: np.ndarray) -> Transfer:
    """Share of tries that hold within a cluster and across; the ratio and its interval."""
    same = clusters[found.tried] == clusters[found.asked][:, None]
    if clusters.dtype.kind == "i":
        same &= clusters[found.tried] != REST
    counts = np.stack(
        [(found.holds & same).sum(1), same.sum(1), (found.holds & ~same).sum(1), (~same).sum(1)]
    )
    ratios = []
    for k in range(500):
        draw = seeding.rng(11, k).integers(counts.shape[1], size=counts.shape[1])
        a, b, c, d = counts[:, draw].sum(axis=1)
        ratios.append((a / max(b, 1)) / max(c / max(d, 1), 1e-9))
    a, b, c, d = counts.sum(axis=1)
    low, high = np.percentile(ratios, [2.5, 97.5])
    within, across = a / max(b, 1), c / max(d, 1)
    return float(within), float(across), float(within / across), float(low), float(high)


def shares(transfer: Transfer) -> list[str]:
    """Return the cells about transfer within and across groups."""
    within, across, ratio, low, high = transfer
    return [f"{100 * within:.1f} %", f"{100 * across:.1f} %", f"{ratio:.2f} ({low:.2f}–{high:.2f})"]


def shared(what: str, some: Experience, found: Tries) -> str:
    """Return the table of transfer where two memories or catches share a label, and where not."""
    head = [f"what two {what} share", "transfers where they do", "where not", "ratio"]
    labels = some.labels.items()
    return str(Table(head, [[name, *shares(transfers(found, values))] for name, values in labels]))
