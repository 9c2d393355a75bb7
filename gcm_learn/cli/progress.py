"""Options of long commands, and what they say while they run."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from types import TracebackType
from typing import Annotated, Self, TextIO

from tyro.conf import arg

from gcm_learn.cli.failures import CommandFailure

QUIET_FOR = 2.0  # [s] a shorter job needs no progress line
BETWEEN_UPDATES = 0.2  # [s]


class Progress:
    """Counts finished items; shows count, rate and time left once the job proves long.

    Nothing is written unless `stream` is a terminal, and the line is wiped at the end.

    Parameters
    ----------
    total : int
        Number of items.
    label : str
        What they are.

    Other Parameters
    ----------------
    quiet : bool
        Write nothing, whatever the stream is.
    stream : text stream, optional
        Default: standard error.
    clock : callable
        Returns the time [s].
    """

    def __init__(
        self,
        total: int,
        label: str,
        *,
        quiet: bool = False,
        stream: TextIO | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.total, self.label, self.done = total, label, 0
        self._stream = sys.stderr if stream is None else stream
        self._clock = clock
        self._live = not quiet and self._stream is not None and self._stream.isatty()
        self._start = clock()
        self._next = self._start + QUIET_FOR
        self._shown = False

    def advance(self, count: int = 1) -> None:
        """Note that `count` more items are done, and renew the line when it is due."""
        self.done += count
        now = self._clock()
        if self._live and now >= self._next:
            self._next = now + BETWEEN_UPDATES
            self._shown = True
            self._stream.write(f"\r{self._line(now - self._start)}\x1b[K")
            self._stream.flush()

    def _line(self, elapsed: float) -> str:
        rate = self.done / elapsed if elapsed > 0 else 0.0
        left = _duration((self.total - self.done) / rate) if rate > 0 else "?"
        return f"{self.done}/{self.total} {self.label}, {rate:.3g}/s, {left} left"

    def close(self) -> None:
        """Wipe the line."""
        if self._shown:
            self._stream.write("\r\x1b[K")
            self._stream.flush()
            self._shown = False

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


def _duration(seconds: float) -> str:
    """Return a time span in the unit in which a person would say it."""
    if seconds < 100:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 6000 else f"{seconds / 3600:.1f} h"


AllCores = Annotated[int | None, arg(metavar="N", help_behavior_hint="(default: all cores)")]
Cluster = Annotated[
    str | None, arg(metavar="ADDRESS", help_behavior_hint="(default: this machine)")
]


def check_workers(workers: int | None) -> None:
    """Refuse what is no number of processes."""
    if workers is not None and workers < 1:
        raise CommandFailure(f"--workers {workers}: must be at least 1")
