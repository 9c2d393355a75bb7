"""Shards made by the workers of a Dask cluster."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from functools import lru_cache

from gcm_learn.dataset.shards import ShardInfo, make_shard
from gcm_learn.dataset.spec import DatasetSpec, spec_to_json
from gcm_learn.dataset.spec_file import spec_from_json
from gcm_learn.dataset.warming import warm_up
from gcm_learn.errors import DatasetError

RETRIES = 5  # of a shard whose workers die or raise
AHEAD = 2  # shards that wait for each thread of the cluster


def cluster_results(
    spec: DatasetSpec, url: str, shards: Iterable[int], address: str
) -> Iterator[ShardInfo]:
    """Make shards on a Dask cluster, one task each; they come as they are ready.

    Parameters
    ----------
    spec : DatasetSpec
    url : str
        Folder of the dataset, under a name that means the same to all workers.
    shards : iterable of int
    address : str
        Of the scheduler: ``tcp://host:port``.
    """
    try:
        from distributed import Client, as_completed
    except ImportError:
        raise DatasetError(
            "--cluster needs dask and distributed: pip install 'gcm_learn[cluster]'"
        ) from None
    try:
        client = Client(address, set_as_default=False)
    except (OSError, ValueError) as error:
        raise DatasetError(f"{address}: no scheduler answers ({error})") from None
    with client:
        coming = iter(shards)
        window = as_completed()
        for _ in range(AHEAD * max(sum(client.nthreads().values()), 1)):
            shard = next(coming, None)
            if shard is None:
                break
            window.add(_submit(client, spec, url, shard))
        for future in window:
            yield future.result()
            shard = next(coming, None)
            if shard is not None:
                window.add(_submit(client, spec, url, shard))


def _submit(client: object, spec: DatasetSpec, url: str, shard: int) -> object:
    return client.submit(  # type: ignore[attr-defined]
        warm_and_make, spec, shard, url, retries=RETRIES, pure=False
    )


def warm_and_make(spec: DatasetSpec, shard: int, url: str) -> ShardInfo:
    """Make a shard in a process that may be new."""
    _warm_once(json.dumps(spec_to_json(spec)))
    return make_shard(spec, shard, url)


@lru_cache(maxsize=8)
def _warm_once(spec: str) -> None:
    warm_up(spec_from_json(json.loads(spec)))
