"""Work done by other processes of this machine, and what is done when they die."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack
from types import TracebackType
from typing import Any

from gcm_learn.processes.cluster import ClusterCrew
from gcm_learn.processes.crew import STRIKES, Crew, Here, Result, Task
from gcm_learn.processes.spawning import cores, pool


class LocalCrew(Crew):
    """Processes, which get their tasks from a short queue.

    A process that dies (killed, out of memory, a fault in compiled code) takes the whole pool with
    it.  A new one is started, and what was under way is done again.  A task that was under way
    `STRIKES` times is done alone, which has to get by without the pool.

    Parameters
    ----------
    workers : int
    ahead : int
        Tasks that wait for each worker or are with it: more than one, so that none is idle, and
        one where a process that dies must show which task was to blame.
    """

    def __init__(self, workers: int, ahead: int = 2) -> None:
        self.workers, self.ahead = workers, ahead
        self.rebuilt = 0
        """Number of times that processes had to be replaced."""
        self._block = ExitStack()
        self._executor: ProcessPoolExecutor | None = None

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """End the processes; at once if it is an error that leaves the block."""
        self._executor = None
        self._block.__exit__(kind, error, trace)

    def results(
        self,
        work: Callable[[Task], Result],
        tasks: Iterable[Task],
        alone: Callable[[Task], Result] | None = None,
    ) -> Iterator[tuple[int, Result]]:
        """Do tasks; results come as they are ready.

        Leaving the iteration early ends the processes at once.
        """
        coming, again = enumerate(tasks), deque[tuple[int, Task]]()
        strikes: Counter[int] = Counter()
        running: dict[Future[Result], tuple[int, Task]] = {}
        try:
            while (first := again.popleft() if again else next(coming, None)) is not None:
                if strikes[first[0]] >= STRIKES:
                    yield first[0], (alone or work)(first[1])
                    continue
                again.appendleft(first)
                broken = False
                while not broken:
                    broken = self._fill(work, running, coming, again, strikes)
                    if not running:
                        break
                    done, _ = wait(running, return_when=FIRST_COMPLETED)
                    for future in done:
                        task = running.pop(future)
                        try:
                            result = future.result()
                        except BrokenProcessPool:
                            broken = True
                            again.append(task)
                            strikes[task[0]] += 1
                        else:
                            yield task[0], result
                if broken:
                    self._let_go()
                    self.rebuilt += 1
                    # Which of the tasks was to blame is not known.
                    again.extend(running.values())
                    strikes.update(number for number, _ in running.values())
                    running.clear()
        finally:
            if running:
                self._let_go()

    def _pool(self) -> ProcessPoolExecutor:
        """The processes, which are started at the first use."""
        if self._executor is None:
            self._executor = self._block.enter_context(pool(self.workers))
        return self._executor

    def _let_go(self) -> None:
        """End the processes at once."""
        self.__exit__(GeneratorExit, GeneratorExit(), None)

    def _fill(
        self,
        work: Callable[[Task], Result],
        running: dict[Future[Result], tuple[int, Task]],
        coming: Iterator[tuple[int, Task]],
        again: deque[tuple[int, Any]],
        strikes: Counter[int],
    ) -> bool:
        """Keep the queue filled; return whether the pool is broken."""
        while len(running) < self.ahead * self.workers:
            if again and strikes[again[0][0]] >= STRIKES:
                return False  # to be done alone, once the queue is empty
            task = again.popleft() if again else next(coming, None)
            if task is None:
                return False
            try:
                running[self._pool().submit(work, task[1])] = task
            except BrokenProcessPool:
                again.appendleft(task)
                return True
        return False


def crew_of(workers: int | None = None, cluster: str | None = None) -> Crew:
    """Return the crew that does the work.

    Parameters
    ----------
    workers : int, optional
        Processes on this machine: one for each core by default, for one this process itself.
    cluster : str, optional
        Address of a Dask scheduler, ``tcp://host:port``, whose workers are used instead.
    """
    if cluster is not None:
        return ClusterCrew(cluster)
    workers = workers or cores()
    return Here() if workers == 1 else LocalCrew(workers)
