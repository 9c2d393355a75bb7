"""Is what is tested new?  Twins are found and removed, and the rest is measured."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

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
    """Measure how far test records are from their nearest training records.

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
    tests, total = _tests(folder, spec, names, twins)
    nearest = {structure: np.full(len(t[0]), np.inf) for structure, t in tests.items()}
    neighbour = {structure: np.full(len(t[0]), -1) for structure, t in tests.items()}
    for structure, indices, numbers in _groups(folder, names, twins, lambda s: s == "train"):
        if structure in tests:
            away = _distances(tests[structure][1], numbers)
            best = away.argmin(axis=1)
            least = away[np.arange(len(away)), best]
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


def _distances(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Distances (m, n) between rows (m, p) and (n, p), free of cancellation."""
    out = np.zeros((len(a), len(b)))
    for column in range(a.shape[1]):
        out += (a[:, column, None] - b[None, :, column]) ** 2
    return np.sqrt(out, out=out)


def _tests(
    folder: Folder, spec: DatasetSpec, names: Sequence[str], twins: Sequence[int]
) -> tuple[dict[str, tuple[np.ndarray, np.ndarray]], int]:
    """A sample of the test records by structure, (indices, parameters) each; how many there are."""
    parts: dict[str, list[tuple[np.ndarray, np.ndarray]]] = defaultdict(list)
    for structure, indices, numbers in _groups(folder, names, twins, _is_test):
        parts[structure].append((indices, numbers))
    found = [int(k) for part in parts.values() for indices, _ in part for k in indices]
    chosen = sorted(found, key=lambda k: lot_of(spec.seed, k, SAMPLE))[:MOST]
    joined = {s: tuple(map(np.concatenate, zip(*part, strict=True))) for s, part in parts.items()}
    kept = {s: np.isin(indices, chosen) for s, (indices, _) in joined.items()}
    sample = {s: (i[kept[s]], n[kept[s]]) for s, (i, n) in joined.items() if kept[s].any()}
    return sample, len(found)


def _is_test(split: str) -> bool:
    return split not in ("train", "validation")


def _groups(
    folder: Folder, names: Sequence[str], twins: Sequence[int], wanted: Callable[[str], bool]
) -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
    """Structure, indices (m,) and parameters (m, p) of records, shard by shard."""
    for table in _tables(folder, names, ["index", "split", "structure", "parameters"]):
        good = ~np.isin(table["index"].to_numpy(), twins)
        good &= np.array([wanted(split) for split in table["split"].to_pylist()], dtype=bool)
        part = table.filter(pa.array(good))
        for structure in part["structure"].unique().to_pylist():
            rows = part.filter(pc.equal(part["structure"], structure))
            numbers = pc.list_flatten(rows["parameters"]).to_numpy()
            yield structure, rows["index"].to_numpy(), numbers.reshape(len(rows), -1).astype(float)


def _tables(folder: Folder, names: Sequence[str], columns: list[str]) -> Iterator[pa.Table]:
    """Columns of one shard after the other, without failed items."""
    for name in names:
        table = read_columns(folder, name, [*columns, "error"])
        yield table.filter(table["error"].is_null()).select(columns)
