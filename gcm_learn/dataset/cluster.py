"""Tasks done by the workers of a Dask cluster."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from typing import Any, Generic, TypeVar

from gcm_learn.errors import DatasetError

STRIKES = 3  # times that a task may fail on the cluster before it is done here, alone
CONNECT = 30  # [s] until the scheduler must have answered
AHEAD = 2  # tasks that wait for each thread of the cluster
Result = TypeVar("Result")


class ClusterPool(Generic[Result]):
    """Does tasks on a Dask cluster, in any order.

    A worker that dies or leaves costs what it was at: the scheduler gives its tasks to others.

    Parameters
    ----------
    work : callable
        ``work(task)``, at the top level of a module, so that a worker finds it.
    address : str
        Of the scheduler: ``tcp://host:port``.
    alone : callable
        ``alone(task)``, run here for tasks that have failed there `STRIKES` times.
    """

    def __init__(
        self, work: Callable[[int], Result], address: str, alone: Callable[[int], Result]
    ) -> None:
        self.work, self.address, self.alone = work, address, alone

    def results(self, tasks: Iterable[int]) -> Iterator[Result]:
        """Do the tasks; results come as they are ready."""
        client, as_completed = self._connected()
        strikes: Counter[int] = Counter()
        with client:
            coming, window = iter(tasks), as_completed(loop=client.loop)
            running: dict[Any, int] = {}

            def submit(task: int | None) -> None:
                if task is not None:
                    future = client.submit(self.work, task, pure=False)
                    running[future] = task
                    window.add(future)

            for _ in range(AHEAD * max(sum(client.nthreads().values()), 1)):
                submit(next(coming, None))
            for future in window:
                task = running.pop(future)
                if future.status == "finished":
                    yield future.result()
                elif future.status == "cancelled":
                    raise DatasetError(f"{self.address}: the cluster has gone away")
                else:
                    strikes[task] += 1
                    if strikes[task] < STRIKES:
                        submit(task)
                        continue
                    yield self.alone(task)
                submit(next(coming, None))

    def _connected(self) -> tuple[Any, Any]:
        """A client of the scheduler, and what gives its results as they come."""
        try:
            from distributed import Client, as_completed
        except ImportError:
            raise DatasetError(
                "--cluster needs dask and distributed: pip install 'gcm_learn[cluster]'"
            ) from None
        try:
            client = Client(self.address, set_as_default=False, timeout=CONNECT)
        except (OSError, ValueError) as error:
            raise DatasetError(f"{self.address}: no scheduler answers ({error})") from None
        return client, as_completed
