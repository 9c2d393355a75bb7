"""Shards made by the workers of a Dask cluster."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from functools import lru_cache
from typing import Any

from gcm_learn.dataset.shards import ShardInfo, make_shard
from gcm_learn.dataset.spec import DatasetSpec, spec_to_json
from gcm_learn.dataset.spec_file import spec_from_json
from gcm_learn.dataset.warming import warm_up
from gcm_learn.errors import DatasetError

STRIKES = 3  # times that a shard may fail on the cluster before it is made here, item by item
CONNECT = 30  # [s] until the scheduler must have answered
AHEAD = 2  # shards that wait for each thread of the cluster


def cluster_results(
    spec: DatasetSpec,
    url: str,
    shards: Iterable[int],
    address: str,
    alone: Callable[[int], ShardInfo],
) -> Iterator[ShardInfo]:
    """Make shards on a Dask cluster, one task each; they come as they are ready.

    A worker that dies or leaves costs what it was at: the scheduler gives its shards to others.

    Parameters
    ----------
    spec : DatasetSpec
    url : str
        Folder of the dataset, under a name that means the same to all workers.
    shards : iterable of int
    address : str
        Of the scheduler: ``tcp://host:port``.
    alone : callable
        Makes a shard here, after it has failed there `STRIKES` times.
    """
    client, as_completed = _connected(address)
    strikes: Counter[int] = Counter()
    with client:
        coming, window = iter(shards), as_completed(loop=client.loop)
        running: dict[Any, int] = {}

        def submit(shard: int | None) -> None:
            if shard is not None:
                future = client.submit(warm_and_make, spec, shard, url, pure=False)
                running[future] = shard
                window.add(future)

        for _ in range(AHEAD * max(sum(client.nthreads().values()), 1)):
            submit(next(coming, None))
        for future in window:
            shard = running.pop(future)
            if future.status == "finished":
                yield future.result()
            elif future.status == "cancelled":
                raise DatasetError(f"{address}: the cluster has gone away")
            else:
                strikes[shard] += 1
                if strikes[shard] < STRIKES:
                    submit(shard)
                    continue
                yield alone(shard)
            submit(next(coming, None))


def _connected(address: str) -> tuple[Any, Any]:
    """A client of the scheduler, and what gives its results as they come."""
    try:
        from distributed import Client, as_completed
    except ImportError:
        raise DatasetError(
            "--cluster needs dask and distributed: pip install 'gcm_learn[cluster]'"
        ) from None
    try:
        return Client(address, set_as_default=False, timeout=CONNECT), as_completed
    except (OSError, ValueError) as error:
        raise DatasetError(f"{address}: no scheduler answers ({error})") from None


def warm_and_make(spec: DatasetSpec, shard: int, url: str) -> ShardInfo:
    """Make a shard in a process that may be new."""
    _warm_once(json.dumps(spec_to_json(spec)))
    return make_shard(spec, shard, url)


@lru_cache(maxsize=8)
def _warm_once(spec: str) -> None:
    warm_up(spec_from_json(json.loads(spec)))
