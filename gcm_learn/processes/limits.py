"""Limits of time for code from outside of the package."""

from __future__ import annotations

import contextlib
import signal
import threading
import time
from collections.abc import Iterator
from types import FrameType

from numba.core.compiler_lock import global_compiler_lock

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
        if global_compiler_lock.is_locked():
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
