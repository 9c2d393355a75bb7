"""Is what is tested new?  Twins are found and removed, and the rest is measured."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import pyarrow as pa

from gcm_learn.dataset.folder import Folder
from gcm_learn.dataset.shards import read_columns
from gcm_learn.dataset.spec import DatasetSpec
from gcm_learn.dataset.splits import lot_of

SAMPLE = 3  # salt of the lot that decides which test records are measured
MOST = 2000  # of them
QUANTILES = (0.01, 0.1, 0.5)


def twins_of(folder: Folder, names: Sequence[str]) -> list[int]:
    """Items that are a twin of one with a smaller index: turned, mirrored or listed otherwise."""
    indices, keys = [], []
    for table in _tables(folder, names, ["index", "twin_key"]):
        indices.append(table["index"].to_numpy())
        keys.append(table["twin_key"].to_numpy())
    index, key = np.concatenate(indices), np.concatenate(keys)
    order = np.lexsort((index, key))
    again = np.flatnonzero(key[order][1:] == key[order][:-1]) + 1
    return sorted(int(k) for k in index[order][again])


def distance_of(
    folder: Folder, spec: DatasetSpec, names: Sequence[str], twins: Sequence[int]
) -> dict[str, Any]:
    """How far test records are from their nearest training records.

    Parameters
    ----------
    folder : Folder
    spec : DatasetSpec
    names : sequence of str
        The shards.
    twins : sequence of int
        Items that do not count.

    Returns
    -------
    dict
        Distances are Euclidean over the parameters of canonical situations [forearm lengths];
        situations of different structure (kinds and number of bodies) are not comparable. Of a
        large dataset a random sample of the test records is measured, against all training
        records. `pair` are the two items that are nearest to each other.
    """
    away = set(twins)
    tests, total = _tests(folder, spec, names, away)
    nearest = {structure: np.full(len(t[0]), np.inf) for structure, t in tests.items()}
    neighbour = {structure: np.full(len(t[0]), -1) for structure, t in tests.items()}
    for table in _tables(folder, names, ["index", "split", "structure", "parameters"]):
        for structure, indices, numbers in _groups(table, "train", away):
            if structure in tests:
                d2 = _squared(tests[structure][1], numbers)
                best = d2.argmin(axis=1)
                least = np.sqrt(np.maximum(d2[np.arange(len(d2)), best], 0.0))
                closer = least < nearest[structure]
                nearest[structure][closer] = least[closer]
                neighbour[structure][closer] = indices[best[closer]]
    every = np.concatenate([*nearest.values(), np.zeros(0)])
    known = np.isfinite(every)
    out: dict[str, Any] = {
        "test_records": total,
        "measured": len(every),
        "comparable": int(known.sum()),
        "smallest": None,
    }
    if known.any():
        test = np.concatenate([t[0] for t in tests.values()])
        train = np.concatenate(list(neighbour.values()))
        k = int(every.argmin())
        out["smallest"] = round(float(every[k]), 6)
        out["pair"] = [int(test[k]), int(train[k])]
        values = np.quantile(every[known], QUANTILES)
        names_of = (f"{q:.0%}" for q in QUANTILES)
        out["quantiles"] = {n: round(float(v), 4) for n, v in zip(names_of, values, strict=True)}
    return out


def _squared(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Squared distances (m, n) between rows (m, p) and (n, p), free of cancellation."""
    out = np.zeros((len(a), len(b)))
    for column in range(a.shape[1]):
        out += (a[:, column, None] - b[None, :, column]) ** 2
    return out


def _tests(
    folder: Folder, spec: DatasetSpec, names: Sequence[str], away: set[int]
) -> tuple[dict[str, tuple[np.ndarray, np.ndarray]], int]:
    """A sample of the test records by structure, (indices, parameters) each; how many there are."""
    found = []
    for table in _tables(folder, names, ["index", "split"]):
        split = table["split"].to_pylist()
        index = table["index"].to_pylist()
        found += [k for k, s in zip(index, split, strict=True) if _is_test(s) and k not in away]
    chosen = set(sorted(found, key=lambda k: lot_of(spec.seed, k, SAMPLE))[:MOST])
    parts: dict[str, list[tuple[np.ndarray, np.ndarray]]] = defaultdict(list)
    for table in _tables(folder, names, ["index", "split", "structure", "parameters"]):
        for structure, indices, numbers in _groups(table, "test", away):
            keep = np.isin(indices, list(chosen))
            if keep.any():
                parts[structure].append((indices[keep], numbers[keep]))
    joined = {
        structure: (np.concatenate([i for i, _ in p]), np.vstack([n for _, n in p]))
        for structure, p in parts.items()
    }
    return joined, len(found)


def _is_test(split: str) -> bool:
    return split not in ("train", "validation")


def _groups(
    table: pa.Table, role: str, away: set[int]
) -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
    """Structure, indices (m,) and parameters (m, p) of a shard's training or test records."""
    index, split = table["index"].to_pylist(), table["split"].to_pylist()
    structure = table["structure"].to_pylist()
    numbers = table["parameters"].combine_chunks()
    rows: dict[str, list[int]] = defaultdict(list)
    for k, (i, s) in enumerate(zip(index, split, strict=True)):
        if (_is_test(s) if role == "test" else s == role) and i not in away:
            rows[structure[k]].append(k)
    for name, places in rows.items():
        vectors = np.array([numbers[k].values.to_numpy() for k in places], dtype=float)
        yield name, np.array([index[k] for k in places]), vectors


def _tables(folder: Folder, names: Sequence[str], columns: list[str]) -> Iterator[pa.Table]:
    """Columns of one shard after the other, without failed items."""
    for name in names:
        table = read_columns(folder, name, [*columns, "error"])
        yield table.filter(table["error"].is_null()).select(columns)
