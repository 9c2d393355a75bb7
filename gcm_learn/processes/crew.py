"""Crews of workers that apply a function to tasks taken lazily, and a time limit for code."""

from __future__ import annotations

import contextlib
import signal
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator
from types import FrameType, TracebackType
from typing import Self, TypeVar

from gcm_learn.compiled import is_compiling

STRIKES = 3  # times that a task may be under way when its process dies, before it is done alone
Task = TypeVar("Task")
Result = TypeVar("Result")


class Crew(ABC):
    """Workers that live as long as their ``with`` block.

    Leaving the block by an error, e.g. by Ctrl-C, ends the tasks under way.
    """

    @abstractmethod
    def results(
        self,
        work: Callable[[Task], Result],
        tasks: Iterable[Task],
        alone: Callable[[Task], Result] | None = None,
    ) -> Iterator[tuple[int, Result]]:
        """Do `tasks`; yield (task number, result) pairs as results become ready.

        Parameters
        ----------
        work : callable
            ``work(task)``, a pure function at the top level of a module, so that others find it.
        tasks : iterable
            Taken lazily, as workers need them.
        alone : callable, optional
            ``alone(task)``, run in this process for tasks that `STRIKES` times could not be ended;
            by default `work`.
        """

    def map(
        self,
        work: Callable[[Task], Result],
        tasks: Iterable[Task],
        alone: Callable[[Task], Result] | None = None,
    ) -> Iterator[Result]:
        """Do `tasks` as `results` does; yield the results in the order of the tasks."""
        early: dict[int, Result] = {}
        wanted = 0
        for number, result in self.results(work, tasks, alone):
            early[number] = result
            while wanted in early:
                yield early.pop(wanted)
                wanted += 1

    def __enter__(self) -> Self:
        return self

    @abstractmethod
    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Release the workers."""


class Here(Crew):
    """Crew of the present process alone."""

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        pass

    def results(
        self,
        work: Callable[[Task], Result],
        tasks: Iterable[Task],
        alone: Callable[[Task], Result] | None = None,
    ) -> Iterator[tuple[int, Result]]:
        """Do tasks one after the other."""
        for number, task in enumerate(tasks):
            yield number, work(task)


TICK, SHORTEST = 0.1, 1e-3  # between readings of the clock [s]


class OutOfTime(BaseException):
    """Code has used up its time; a `BaseException`, which planners rarely catch by chance."""


@contextlib.contextmanager
def time_limit(seconds: float | None) -> Iterator[None]:
    """Interrupt the block by `OutOfTime` after some time on the wall.

    Time in which numba compiles is not counted. Signals of POSIX do this, in the main thread of a
    process only; elsewhere there is no limit. Python code, sleeps and waits are interrupted; a
    compiled loop is, as soon as it returns.

    Parameters
    ----------
    seconds : float, optional
        None for no limit.
    """
    able = hasattr(signal, "setitimer") and threading.current_thread() is threading.main_thread()
    if seconds is None or not able:
        yield
        return
    done, spent, seen, since = False, 0.0, time.monotonic(), time.monotonic()

    def look(number: int, frame: FrameType | None) -> None:
        nonlocal spent, seen
        last, seen = seen, time.monotonic()
        if is_compiling():
            return
        spent += seen - last
        if spent >= seconds and not done:
            raise OutOfTime

    tick = max(min(TICK, seconds), SHORTEST)
    before = signal.signal(signal.SIGALRM, look)
    left, every = signal.setitimer(signal.ITIMER_REAL, tick, tick)
    try:
        try:
            yield
        finally:
            done = True
    finally:
        done = True
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, signal.SIG_DFL if before is None else before)
        if left:  # somebody else's limit goes on
            remaining = max(left - (time.monotonic() - since), 1e-3)
            signal.setitimer(signal.ITIMER_REAL, remaining, every)
