"""Crew of processes on this machine, which are replaced when they die."""

from __future__ import annotations

import contextlib
import os
import signal
import threading
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack
from functools import partial
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnContext, SpawnProcess
from multiprocessing.synchronize import Semaphore
from types import TracebackType
from typing import Any

from gcm_learn import compiled
from gcm_learn.processes.cluster import ClusterCrew
from gcm_learn.processes.crew import STRIKES, Crew, Here, Result, Task

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


def cores() -> int:
    """Return the number of cores that this process may use; all cores where that is unknown."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextlib.contextmanager
def interrupts_held() -> Iterator[None]:
    """Delay Ctrl-C until the block ends; keep it from processes that start in the block.

    A terminal sends it to all processes. A process that is just starting would answer with a
    traceback, and half of its input would make the next one fail.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    came: list[int] = []
    before = signal.getsignal(signal.SIGINT)
    heard = before not in (signal.SIG_IGN, None)
    if heard:
        signal.signal(signal.SIGINT, lambda number, frame: came.append(number))
    masks = hasattr(signal, "pthread_sigmask")  # not on Windows
    if masks:
        resource_tracker.ensure_running()  # which lifts the mask when it is first started
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT}) if masks else set()
    try:
        yield
    finally:
        if masks:
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        if heard:
            signal.signal(signal.SIGINT, before)
        if came:
            signal.raise_signal(signal.SIGINT)


class _Process(SpawnProcess):
    """Process that Ctrl-C does not interrupt at its start; the parent decides when to end it."""

    def start(self) -> None:
        """Start the process, with Ctrl-C held back."""
        with interrupts_held():
            super().start()


class Context(SpawnContext):
    """Context that starts new interpreters, as multiprocessing's ``spawn`` does, without Ctrl-C."""

    def __init__(self) -> None:
        super().__init__()
        self._started: list[SpawnProcess] = []

    def Process(self, *given: Any, **named: Any) -> SpawnProcess:  # type: ignore[override]
        """A process that is not started yet."""
        process = _Process(*given, **named)
        self._started.append(process)
        return process

    def kill(self) -> None:
        """Kill all processes at once, also processes that have not begun their work."""
        for process in self._started:
            if process.is_alive():
                process.kill()


@contextlib.contextmanager
def pool(workers: int) -> Iterator[ProcessPoolExecutor]:
    """Yield a pool of up to `workers` one-thread processes; they end with the block or parent."""
    context = Context()
    listening, speaking = context.Pipe(duplex=False)
    untold = context.Semaphore(1)
    begin = partial(_begin, listening, tuple(compiled.on_compile), untold)
    executor = ProcessPoolExecutor(workers, context, initializer=begin)
    try:
        with _one_thread():
            yield executor
            executor.shutdown()
    finally:
        executor.shutdown(wait=False, cancel_futures=True)
        context.kill()  # what still runs
        speaking.close()
        listening.close()
        if not untold.acquire(block=False):  # one of them has called the listeners
            compiled.on_compile.clear()


@contextlib.contextmanager
def _one_thread() -> Iterator[None]:
    """Set the environment so that processes started in the block use one thread each."""
    kept = {name: os.environ.get(name) for name in THREADS}
    os.environ.update(dict.fromkeys(THREADS, "1"))
    try:
        yield
    finally:
        for name, value in kept.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def _begin(line: Connection, listeners: Sequence[Callable[[], object]], untold: Semaphore) -> None:
    """Prepare a worker: ignore Ctrl-C, exit if the parent closes `line` or dies, set listeners."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_leave_with_parent, args=(line,), daemon=True).start()
    compiled.on_compile[:] = [partial(_tell_first, listeners, untold)] if listeners else []


def _leave_with_parent(line: Connection) -> None:
    """Wait until the parent closes the other end of `line`, or dies; then exit."""
    with contextlib.suppress(EOFError, OSError):
        line.recv_bytes()
    os._exit(1)


def _tell_first(listeners: Sequence[Callable[[], object]], untold: Semaphore) -> None:
    """Call the listeners in the first of all processes that compiles."""
    if untold.acquire(block=False):
        for listener in listeners:
            listener()


class LocalCrew(Crew):
    """Crew of processes that take tasks from a short queue.

    A process that dies (killed, out of memory, a fault in compiled code) takes the whole pool with
    it.  A new pool is started, and tasks under way are done again.  A task that was under way at
    `STRIKES` such deaths is done in this process, without the pool.

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
        """End the processes; at once if an error leaves the block."""
        self._executor = None
        self._block.__exit__(kind, error, trace)

    def results(
        self,
        work: Callable[[Task], Result],
        tasks: Iterable[Task],
        alone: Callable[[Task], Result] | None = None,
    ) -> Iterator[tuple[int, Result]]:
        """Do `tasks`; yield (task number, result) pairs as results become ready.

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
                if self._executor is None:
                    self._executor = self._block.enter_context(pool(self.workers))
                running[self._executor.submit(work, task[1])] = task
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
