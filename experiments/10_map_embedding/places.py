"""Clusters of memories by the places that encoders give them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from sklearn.metrics import adjusted_mutual_info_score

from experiments.clusters import (
    ASKED,
    TRIED,
    Experience,
    K,
    Tries,
    directions,
    k_means,
    shares,
    stability,
    transfers,
    tries,
)
from gcm_learn.dataset import Dataset
from gcm_learn.evaluation import Table
from gcm_learn.recall import Memory, Scale, TransferLabels, raw_features

PLACED = 3000  # memories that are clustered
COMPONENTS = 24  # of features of maps
REPEATS = 4  # samples whose clusterings are compared
ASKED_HERE = ASKED // 4  # situations on which memories are tried


def clusters_table(
    records: Dataset,
    labels: TransferLabels,
    memories: Mapping[str, Memory],
    maps: np.ndarray,
    seed: int,
) -> str:
    """Return what clusters of places agree with, and whether catches transfer within them."""
    some = experience(records, labels)
    found = tries(some, ASKED_HERE)
    raw = np.array([raw_features(r.situation) for r in some.records])
    places = {name: directions(memory.embeddings[:PLACED]) for name, memory in memories.items()}
    if seed == 1:
        places |= {"raw": Scale.of(raw)(raw), "components of features of maps": fewer(maps)}
    head = ["places by", *(f"AMI {name}" for name in some.labels), "stable: Rand",
            "transfers within", "across", "ratio"]  # fmt: skip
    lines = [[name, *cells(rows, some, found)] for name, rows in places.items()]
    note = (
        f"Seed {seed}: {len(some.records)} memories, {K}-means; transfer: {len(found.asked)} "
        f"situations of W and Q, {TRIED} random memories each, adapted and checked. AMI: adjusted "
        "mutual information, 0 is chance."
    )
    return f"{Table(head, lines)}\n\n{note}"


def experience(records: Dataset, labels: TransferLabels) -> Experience:
    """Return the first memories of the labels with their records."""
    kept = [r for r in records.where(split="train") if any(p.caught for p in r.plans.values())]
    kept = kept[:PLACED]
    named = {name: np.array([getattr(r, name) for r in kept]) for name in ("family", "stratum")}
    nothing = np.zeros((len(kept), 0))
    count = len(kept)
    return Experience(kept, labels.knots[:count], labels.goals[:count], named, nothing, nothing)


def fewer(maps: np.ndarray) -> np.ndarray:
    """Return principal components (n, COMPONENTS) of the first features of maps."""
    rows = maps[:PLACED] - maps[:PLACED].mean(axis=0)
    _, _, axes = np.linalg.svd(rows, full_matrices=False)
    components: np.ndarray = rows @ axes[:COMPONENTS].T
    return components


def cells(rows: np.ndarray, some: Experience, found: Tries) -> list[str]:
    """Return a line of the table for places (n, d)."""
    groups = k_means(rows, 0).labels_.astype(int)
    mutual = [f"{adjusted_mutual_info_score(v, groups):.2f}" for v in some.labels.values()]
    return [*mutual, f"{stability(rows, REPEATS)[0]:.2f}", *shares(transfers(found, groups))]
