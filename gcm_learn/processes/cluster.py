"""Work done by the workers of a Dask cluster."""

from __future__ import annotations

import threading
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from types import TracebackType
from typing import Any, Self

from gcm_learn import compiled
from gcm_learn.errors import ClusterError, MissingExtraError
from gcm_learn.processes.crew import STRIKES, Crew, Result, Task

CONNECT = 30  # [s] until the scheduler must have answered
AHEAD = 2  # tasks that wait for each thread of the cluster
_TURN = threading.Lock()  # kernels keep scratch space, which a worker's threads would share


class ClusterCrew(Crew):
    """The workers of a Dask cluster.

    A worker that dies or leaves costs what it was at: the scheduler gives its tasks to others. One
    that has other sources than this process is refused, since other numbers might come of them.

    Parameters
    ----------
    address : str
        Of the scheduler: ``tcp://host:port``.

    Raises
    ------
    ClusterError
        In one line: no scheduler answers, it has gone away, or a worker has other sources.
    """

    def __init__(self, address: str) -> None:
        self.address = address

    def __enter__(self) -> Self:
        try:
            from distributed import Client, as_completed
        except ImportError:
            raise MissingExtraError("--cluster", "dask and distributed", "cluster") from None
        try:
            self._client = Client(self.address, set_as_default=False, timeout=CONNECT)
        except (OSError, ValueError) as error:
            raise ClusterError(f"{self.address}: no scheduler answers ({error})") from None
        self._as_completed = as_completed
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Leave the cluster, which drops what it was asked for."""
        self._client.close()

    def results(
        self,
        work: Callable[[Task], Result],
        tasks: Iterable[Task],
        alone: Callable[[Task], Result] | None = None,
    ) -> Iterator[tuple[int, Result]]:
        """Do tasks; results come as they are ready."""
        strikes: Counter[int] = Counter()
        coming, window = enumerate(tasks), self._as_completed(loop=self._client.loop)
        running: dict[Any, tuple[int, Task]] = {}

        def submit(task: tuple[int, Task] | None) -> None:
            if task is not None:
                future = self._client.submit(done, work, task[1], sources(), pure=False)
                running[future] = task
                window.add(future)

        for _ in range(AHEAD * max(sum(self._client.nthreads().values()), 1)):
            submit(next(coming, None))
        for future in window:
            number, task = running.pop(future)
            if future.status == "finished":
                yield number, future.result()
            elif future.status == "cancelled":
                raise ClusterError(f"{self.address}: the cluster has gone away")
            elif isinstance(error := future.exception(), ClusterError):
                raise ClusterError(f"{self.address}: {error}")
            else:
                strikes[number] += 1
                if strikes[number] < STRIKES:
                    submit((number, task))
                    continue
                yield number, (alone or work)(task)
            submit(next(coming, None))


def done(work: Callable[[Task], Result], task: Task, wanted: str) -> Result:
    """Do a task on a worker, one at a time."""
    if sources() != wanted:
        raise ClusterError("a worker has other sources of gcm_learn than this machine")
    with _TURN:
        return work(task)


@cache
def sources() -> str:
    """Hash of all sources of the package."""
    return compiled.sources_hash(["."])
