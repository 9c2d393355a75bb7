"""Work done by the workers of a Dask cluster."""

from __future__ import annotations

import logging
import threading
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from itertools import islice
from types import TracebackType
from typing import Any, Self

from gcm_learn import compiled
from gcm_learn.errors import ClusterError, MissingExtraError
from gcm_learn.processes.crew import STRIKES, Crew, Result, Task

CONNECT = 30  # [s] until the scheduler must have answered
AHEAD = 2  # tasks that wait for each thread of the cluster
_LOGGERS = logging.getLogger("distributed"), logging.getLogger("distributed.client")
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
            from distributed.client import ClosedClientError, FutureCancelledError
        except ImportError:
            raise MissingExtraError("--cluster", "dask and distributed", "cluster") from None
        self._losses = (OSError, ClosedClientError, FutureCancelledError)
        self._levels = [logger.level for logger in _LOGGERS]
        self._hear(logging.CRITICAL, logging.CRITICAL)  # an error reports who dies
        try:
            self._client = Client(self.address, set_as_default=False, timeout=CONNECT)
        except (OSError, ValueError) as error:
            self._hear(*self._levels)
            raise ClusterError(f"{self.address}: no scheduler answers ({error})") from None
        self._as_completed = as_completed
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Leave the cluster, which drops unfinished tasks."""
        self._client.close()
        self._hear(*self._levels)

    def _hear(self, *levels: int) -> None:
        """Set the lowest levels that Dask's two loggers report."""
        for logger, level in zip(_LOGGERS, levels, strict=True):
            logger.setLevel(level)

    def results(
        self,
        work: Callable[[Task], Result],
        tasks: Iterable[Task],
        alone: Callable[[Task], Result] | None = None,
    ) -> Iterator[tuple[int, Result]]:
        """Do `tasks`; yield (task number, result) pairs as results become ready."""
        strikes: Counter[int] = Counter()
        coming, window = enumerate(tasks), self._as_completed(loop=self._client.loop)
        running: dict[Any, tuple[int, Task]] = {}

        def submit(number: int, task: Task) -> None:
            future = self._client.submit(done, work, task, sources(), pure=False)
            running[future] = number, task
            window.add(future)

        ahead = AHEAD * max(sum(self._asked(self._client.nthreads).values()), 1)
        for number, task in islice(coming, ahead):
            self._asked(submit, number, task)
        while running:
            future = self._asked(next, window)
            number, task = running.pop(future)
            if future.status == "finished":
                yield number, self._asked(future.result)
            elif future.status == "cancelled":
                raise self._gone()
            elif isinstance(error := self._asked(future.exception), ClusterError):
                raise ClusterError(f"{self.address}: {error}")
            else:
                strikes[number] += 1
                if strikes[number] < STRIKES:
                    self._asked(submit, number, task)
                    continue
                yield number, (alone or work)(task)
            for number, task in islice(coming, 1):
                self._asked(submit, number, task)

    def _asked(self, question: Callable[..., Any], *given: Any) -> Any:
        """Call `question`; raise ClusterError if the cluster has gone away."""
        try:
            return question(*given)
        except self._losses:
            raise self._gone() from None

    def _gone(self) -> ClusterError:
        return ClusterError(f"{self.address}: the cluster has gone away")


def done(work: Callable[[Task], Result], task: Task, wanted: str) -> Result:
    """Do `task` on a worker, one at a time, if the worker has the `wanted` sources."""
    if sources() != wanted:
        raise ClusterError("a worker has other sources of gcm_learn than this machine")
    with _TURN:
        return work(task)


@cache
def sources() -> str:
    """Hash of all sources of the package."""
    return compiled.sources_hash(["."])
