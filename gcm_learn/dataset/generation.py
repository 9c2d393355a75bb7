"""Making a dataset: only the shards that are missing, by whatever hands there are."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from functools import partial
from typing import Any

from gcm_learn.dataset.folder import Folder
from gcm_learn.dataset.item import make_item, no_item, warmed
from gcm_learn.dataset.manifest import (
    Manifest,
    manifest_of,
    present,
    read_manifest,
    write_manifest,
)
from gcm_learn.dataset.separation import distance_of, twins_of
from gcm_learn.dataset.shards import ShardInfo, make_shard, write_shard
from gcm_learn.dataset.spec import DatasetSpec
from gcm_learn.errors import DatasetError
from gcm_learn.processes import ClusterCrew, Crew, Here, LocalCrew, cores

BETWEEN_MANIFESTS = 60.0  # [s]
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


def crew_for(folder: Folder, workers: int) -> Crew:
    """Return processes that reach a folder: others than this one, since items may crash."""
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
    """Make a shard whose processes died, item by item: one that kills its process is recorded."""
    work = partial(warmed, spec, partial(make_item, spec))
    with LocalCrew(1, ahead=1) as crew:
        records = list(crew.map(work, spec.indices(shard), partial(no_item, spec, error=DIED)))
    if len(records) > 1 and all(record.error == DIED for record in records):
        raise DatasetError("processes die before they make anything (memory?)")
    return write_shard(spec, shard, records, url)
