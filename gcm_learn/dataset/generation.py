"""Making a dataset: only the shards that are missing; twins are removed, distances measured."""

from __future__ import annotations

import os
import time
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from gcm_learn.dataset.folder import Folder
from gcm_learn.dataset.item import make_item, no_item, warmed
from gcm_learn.dataset.manifest import Manifest, manifest_of, present, read_manifest, write_manifest
from gcm_learn.dataset.record import rows_of
from gcm_learn.dataset.shards import ShardInfo, file_of, make_shard, read_columns, write_shard
from gcm_learn.dataset.spec import DatasetSpec
from gcm_learn.dataset.splits import lot_of
from gcm_learn.errors import DatasetError
from gcm_learn.processes import ClusterCrew, Crew, Here, LocalCrew, cores

SAMPLE = 3  # salt of the lot that decides which test records are measured
MOST = 2000  # of them
QUANTILES = (0.01, 0.1, 0.5)


def twins_of(folder: Folder, names: Sequence[str]) -> list[int]:
    """Return the indices of twins of earlier items: turned, mirrored or listed otherwise."""
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
    """Yield the columns of each shard in turn, without failed items."""
    for name in names:
        table = read_columns(folder, name, [*columns, "error"])
        yield table.filter(table["error"].is_null()).select(columns)


BETWEEN_MANIFESTS = 60.0  # [s]
MOST_SAMPLED = 200  # records of an estimate
SAMPLED = 4.0  # [s] for them
DIED = "the process that made it died"


def generate(
    spec: DatasetSpec,
    out: str | os.PathLike[str],
    workers: int | None = None,
    *,
    part: tuple[int, int] = (0, 1),
    cluster: str | None = None,
    progress: Callable[[int], None] = lambda records: None,
) -> Manifest:
    """Make the shards of a dataset that are not there yet.

    Stopped at any time and by any means, it goes on from there when it is called again.

    Parameters
    ----------
    spec : DatasetSpec
    out : path-like
        Folder, or a URL that fsspec understands.
    workers : int, optional
        Processes on this machine; by default one for each core that this one may use.
    part : (int, int)
        (i, n): make only every n-th shard, beginning with the i-th (job arrays).
    cluster : str, optional
        Address of a Dask scheduler, whose workers are used instead of local processes.
    progress : callable
        Told the number of records that are new.

    Returns
    -------
    dict
        The manifest, which is also written; ``manifest["complete"]`` says whether every shard is
        there.
    """
    folder = Folder(out)
    folder.make()
    mine = range(part[0], spec.shards, part[1])
    infos = present(folder, spec, range(spec.shards))
    runs: list[dict[str, Any]] = list((read_manifest(folder) or {}).get("runs", ()))
    missing = (shard for shard in mine if shard not in infos)
    progress(sum(infos[shard].rows for shard in mine if shard in infos))
    workers = workers or cores()
    hands = {"cluster": cluster} if cluster else {"workers": workers}
    crew = ClusterCrew(cluster) if cluster else crew_for(folder, workers)
    if len(infos) < spec.shards:  # readers before the first shard see what is planned
        write_manifest(folder, manifest_of(folder, spec, infos, runs))
    began = told = time.monotonic()
    fresh: set[int] = set()
    run: dict[str, Any] = {"records": 0, "seconds": 0.0, **hands}
    work = partial(warmed, spec, partial(make_shard, spec, url=folder.url))
    with crew:
        for _, info in crew.results(work, missing, partial(make_alone, spec, url=folder.url)):
            infos[info.shard] = info
            fresh.add(info.shard)
            run["records"] += info.rows
            run["seconds"] = round(time.monotonic() - began, 1)
            progress(info.rows)
            if time.monotonic() - told > BETWEEN_MANIFESTS:
                told = time.monotonic()
                write_manifest(folder, manifest_of(folder, spec, infos, [*runs, run], fresh))
                fresh.clear()
    return _finish(folder, spec, infos, [*runs, run] if run["records"] else runs, fresh)


class Estimate(NamedTuple):
    """Number of missing records, their time [s] and size [bytes], and number of records sampled."""

    records: int
    seconds: float
    bytes: float
    asked: int


def estimate(
    spec: DatasetSpec,
    out: str | os.PathLike[str],
    workers: int | None = None,
    *,
    part: tuple[int, int] = (0, 1),
    least: int = 1,
) -> Estimate | None:
    """Make some missing records for `SAMPLED` seconds, keep none, and scale time and size up.

    Nothing is estimated if fewer than `least` records are missing.
    """
    folder = Folder(out)
    mine = range(part[0], spec.shards, part[1])
    there = present(folder, spec, mine)
    missing = [k for shard in mine if shard not in there for k in spec.indices(shard)]
    if len(missing) < least:
        return None
    spread = missing[:: max(len(missing) // MOST_SAMPLED, 1)]
    with LocalCrew(1) as crew:
        ((count, seconds, size),) = crew.map(
            partial(warmed, spec, partial(_sampled, spec)), [spread]
        )
    scale, hands = len(missing) / count, min(workers or cores(), cores(), len(mine) - len(there))
    return Estimate(len(missing), scale * seconds / hands, scale * size, count)


def _sampled(spec: DatasetSpec, indices: list[int]) -> tuple[int, float, int]:
    """Return how many items were made within `SAMPLED`, their time [s] and size [bytes]."""
    began, records = time.monotonic(), []
    for k in indices:
        records.append(make_item(spec, k))
        if time.monotonic() - began > SAMPLED:
            break
    spent, info = time.monotonic() - began, ShardInfo(0, len(records), spec.digest, "")
    return len(records), spent, len(file_of(spec, rows_of(spec, records), info))


def crew_for(folder: Folder, workers: int) -> Crew:
    """Return local processes, since items may crash; this process if no other has the files."""
    return LocalCrew(workers) if folder.shared else Here()


def _finish(
    folder: Folder,
    spec: DatasetSpec,
    infos: dict[int, ShardInfo],
    runs: list[dict[str, Any]],
    fresh: set[int],
) -> Manifest:
    if len(infos) < spec.shards:  # other parts may be under way, or ready by now
        infos = present(folder, spec, range(spec.shards))
    manifest = manifest_of(folder, spec, infos, runs, fresh)
    if manifest["complete"]:
        folder.sweep()
        before = read_manifest(folder)
        if before is not None and before["hash"] == manifest["hash"] and "distance" in before:
            manifest |= {name: before[name] for name in ("twins", "distance")}
        else:
            names = [shard["name"] for shard in manifest["shards"]]
            twins = twins_of(folder, names)
            manifest["twins"] = {"removed": twins}
            manifest["distance"] = distance_of(folder, spec, names, twins)
    write_manifest(folder, manifest)
    return manifest


def make_alone(spec: DatasetSpec, shard: int, url: str) -> ShardInfo:
    """Make a shard whose process died, item by item; record the items that kill their process."""
    work = partial(warmed, spec, partial(make_item, spec))
    with LocalCrew(1, ahead=1) as crew:
        records = list(crew.map(work, spec.indices(shard), partial(no_item, spec, error=DIED)))
    if len(records) > 1 and all(record.error == DIED for record in records):
        raise DatasetError("processes die before they make anything (memory?)")
    return write_shard(spec, shard, records, url)
