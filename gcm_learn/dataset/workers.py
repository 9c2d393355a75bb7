"""Processes that make shards on this machine, and what is done when they die."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from typing import Generic, TypeVar

from gcm_learn.processes import pool

STRIKES = 3  # times that a task may be under way when a process dies, before it is done alone
Result = TypeVar("Result")


class LocalPool(Generic[Result]):
    """Does tasks in processes of their own, in a short queue, in any order.

    A process that dies (killed, out of memory, a fault in compiled code) takes the whole pool with
    it: a new one is started and what was under way is done again.  A task that was under way
    `STRIKES` times is done by `alone`, which has to get by without the pool.

    Parameters
    ----------
    work : callable
        ``work(task)``, at the top level of a module, so that another process finds it.
    workers : int
    alone : callable
        ``alone(task)``, run in this process for tasks that kill theirs.
    prepare : callable, optional
        Run first in each process.
    ahead : int
        Tasks that wait for each worker or are with it: more than one, so that none is idle, and
        one where a process that dies must tell which task was to blame.
    """

    def __init__(
        self,
        work: Callable[[int], Result],
        workers: int,
        alone: Callable[[int], Result],
        prepare: Callable[[], None] | None = None,
        ahead: int = 2,
    ) -> None:
        self.work, self.workers, self.alone, self.prepare = work, workers, alone, prepare
        self.ahead = ahead
        self.rebuilt = 0
        """How often processes had to be replaced."""

    def results(self, tasks: Iterable[int]) -> Iterator[Result]:
        """Do the tasks; results come as they are ready.

        Leaving the iteration early, e.g. by Ctrl-C, ends the processes at once.
        """
        coming, again = iter(tasks), deque[int]()
        strikes: Counter[int] = Counter()
        while True:
            first = again.popleft() if again else next(coming, None)
            if first is None:
                return
            if strikes[first] >= STRIKES:
                yield self.alone(first)
                continue
            again.appendleft(first)
            with pool(self.workers, self.prepare) as executor:
                running: dict[Future[Result], int] = {}
                broken = False
                while not broken:
                    broken = self._fill(executor, running, coming, again, strikes)
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
                            strikes[task] += 1
                        else:
                            yield result
            if not broken:
                continue
            self.rebuilt += 1
            # Which of the tasks was to blame is not known.
            again.extend(running.values())
            strikes.update(running.values())

    def _fill(
        self,
        executor: ProcessPoolExecutor,
        running: dict[Future[Result], int],
        coming: Iterator[int],
        again: deque[int],
        strikes: Counter[int],
    ) -> bool:
        """Keep the queue filled; tells whether the pool is broken."""
        while len(running) < self.ahead * self.workers:
            if again and strikes[again[0]] >= STRIKES:
                return False  # to be done alone, once the queue is empty
            task = again.popleft() if again else next(coming, None)
            if task is None:
                return False
            try:
                running[executor.submit(self.work, task)] = task
            except BrokenProcessPool:
                again.appendleft(task)
                return True
        return False
