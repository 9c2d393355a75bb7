"""Work in a forked copy of the process, so that a crash or hang spares the original."""

from __future__ import annotations

import contextlib
import faulthandler
import os
import pickle
import signal
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NoReturn

Tell = Callable[[Any], None]
POSSIBLE = hasattr(os, "fork") and hasattr(signal, "setitimer")
"""On POSIX systems only."""


@dataclass(frozen=True)
class _Failed:
    """An exception in the copy."""

    trace: str


def told(work: Callable[[Tell], None], longest: float) -> tuple[list[Any], bool]:
    """Run `work` in a forked copy of this process and collect the things that it sends.

    Parameters
    ----------
    work : callable
        Gets a function that sends a picklable thing.  Each thing arrives whatever happens
        afterwards.
    longest : float
        Processor time after which the copy is ended [s].

    Returns
    -------
    things : list
    whole : bool
        Whether the work came to its end; False if the copy crashed or was ended.

    Raises
    ------
    RuntimeError
        If the work raised an exception; a crash is none.
    """
    read, write = os.pipe()
    copy = os.fork()
    if copy == 0:
        os.close(read)
        _work_and_leave(work, write, longest)
    os.close(write)
    things: list[Any] = []
    try:
        # A crash may cut off what is being told: then all before it counts.
        with os.fdopen(read, "rb") as stream, contextlib.suppress(EOFError, pickle.PickleError):
            while True:
                things.append(pickle.load(stream))
    except BaseException:  # an interrupt: nobody waits for the copy any more
        os.kill(copy, signal.SIGKILL)
        os.waitpid(copy, 0)
        raise
    _, status = os.waitpid(copy, 0)
    if things and isinstance(things[-1], _Failed):
        raise RuntimeError(f"in a copy of the process:\n{things[-1].trace}")
    return things, status == 0


def _work_and_leave(work: Callable[[Tell], None], write: int, longest: float) -> NoReturn:
    """Run `work` in the forked copy, then exit without the original's cleanup."""
    try:
        faulthandler.disable()  # crashes are expected and no news
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # the original hears it, and ends this
        signal.signal(signal.SIGPROF, signal.SIG_DFL)
        signal.setitimer(signal.ITIMER_PROF, longest)
        work(lambda thing: _put(write, thing))
    except BaseException:
        with contextlib.suppress(OSError):
            _put(write, _Failed(traceback.format_exc()))
    finally:
        os._exit(0)


def _put(write: int, thing: Any) -> None:
    data = memoryview(pickle.dumps(thing))
    while data:
        data = data[os.write(write, data) :]
