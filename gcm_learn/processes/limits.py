"""Limits of time for code from outside of the package."""

from __future__ import annotations

import contextlib
import signal
import threading
import time
from collections.abc import Iterator
from types import FrameType

AGAIN = 0.2  # between interruptions of code that goes on after the first one [s]


class OutOfTime(BaseException):
    """Code has used up its time; no `Exception`, so that planners do not catch it by chance."""


@contextlib.contextmanager
def time_limit(seconds: float | None) -> Iterator[None]:
    """Interrupt the block by `OutOfTime` after some time on the wall.

    Signals of POSIX do this, in the main thread of a process only. Elsewhere there is no limit.
    Python code, sleeps and waits are interrupted; a compiled loop is, as soon as it returns.

    Parameters
    ----------
    seconds : float, optional
        None for no limit.
    """
    able = hasattr(signal, "setitimer") and threading.current_thread() is threading.main_thread()
    if seconds is None or not able:
        yield
        return
    done, since = False, time.monotonic()

    def stop(number: int, frame: FrameType | None) -> None:
        if not done:
            raise OutOfTime

    before = signal.signal(signal.SIGALRM, stop)
    left, every = signal.setitimer(signal.ITIMER_REAL, seconds, AGAIN)
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
