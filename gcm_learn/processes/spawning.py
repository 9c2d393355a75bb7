"""Processes beside this one: how many there may be, and how they begin and end."""

from __future__ import annotations

import contextlib
import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnContext, SpawnProcess
from multiprocessing.synchronize import Semaphore
from typing import Any

from gcm_learn import compiled

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


def cores() -> int:
    """Processor cores that this process may use; all there are where nobody can tell."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextlib.contextmanager
def interrupts_held() -> Iterator[None]:
    """Ctrl-C waits until the block ends, and never comes to processes that start in it.

    A terminal sends it to all of them. A process that is just starting would answer with a
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
    """A process that does not know of Ctrl-C: its parent decides."""

    def start(self) -> None:
        """Start it."""
        with interrupts_held():
            super().start()


class Context(SpawnContext):
    """Starts new interpreters, as multiprocessing's ``spawn`` does, without Ctrl-C."""

    def __init__(self) -> None:
        super().__init__()
        self._started: list[SpawnProcess] = []

    def Process(self, *given: Any, **named: Any) -> SpawnProcess:  # type: ignore[override]
        """A process that is not started yet."""
        process = _Process(*given, **named)
        self._started.append(process)
        return process

    def kill(self) -> None:
        """End all processes at once, also those that have not come to their work yet."""
        for process in self._started:
            if process.is_alive():
                process.kill()


@contextlib.contextmanager
def pool(workers: int) -> Iterator[ProcessPoolExecutor]:
    """At most so many processes of one thread each; they end with the block or with this one."""
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
    """Set the number of threads that a process reads when it imports numpy."""
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
    """Start a process: Ctrl-C is for the parent, whose end is noticed on the line."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_leave_with_parent, args=(line,), daemon=True).start()
    compiled.on_compile[:] = [partial(_tell_first, listeners, untold)] if listeners else []


def _leave_with_parent(line: Connection) -> None:
    """Wait until the other end of the line is closed, by will or by death, and go."""
    with contextlib.suppress(EOFError, OSError):
        line.recv_bytes()
    os._exit(1)


def _tell_first(listeners: Sequence[Callable[[], object]], untold: Semaphore) -> None:
    """Call the listeners in the first of all processes that compiles."""
    if untold.acquire(block=False):
        for listener in listeners:
            listener()
