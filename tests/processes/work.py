"""Work for other processes; what they import for it is little."""

from __future__ import annotations

import os
import signal
import sys
import time


def late(task):
    """The square; the first take longest."""
    time.sleep(0.1 if task < 2 else 0.0)
    return task * task


def wrong(task):
    """Fail at one task."""
    if task == 3:
        raise ZeroDivisionError("three")
    return task


def deadly(home, task):
    """Kill any process but the one at home."""
    if task == 1 and os.getpid() != home:
        os.kill(os.getpid(), signal.SIGKILL)
    return task


def say() -> None:
    """Tell that something is compiled."""
    print("compiling", file=sys.stderr, flush=True)


def compile_something(seconds) -> None:
    """Do as compiled functions do that have to be compiled."""
    from gcm_learn import compiled

    while compiled.on_compile:
        compiled.on_compile.pop()()
    time.sleep(seconds)
