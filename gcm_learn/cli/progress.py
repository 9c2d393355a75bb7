"""Bars that show how far long commands are."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from datetime import timedelta
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self, TextIO

if TYPE_CHECKING:
    from rich.progress import Progress as Bar

QUIET_FOR = 2.0  # [s] a shorter job needs no bar
BETWEEN_UPDATES = 0.2  # [s]


class Progress:
    """Bar that shows how far a job is, once the job proves long.

    Only a terminal shows the bar, which is wiped at the end.

    Parameters
    ----------
    total : int
        Number of items.
    label : str
        Plural of an item, e.g. ``"situations"``.

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
        self._bar: Bar | None = None

    def advance(self, count: int = 1) -> None:
        """Count `count` more finished items, and redraw the bar when an update is due."""
        self.done += count
        now = self._clock()
        if self._live and now >= self._next:
            self._next = now + BETWEEN_UPDATES
            self._show(self.done / (now - self._start))

    def _show(self, rate: float) -> None:
        """Draw the bar with a rate [1/s]."""
        left = timedelta(seconds=round((self.total - self.done) / rate)) if rate > 0.0 else "?"
        told: dict[str, Any] = {"rate": f"{rate:.3g}/s", "left": f"{left} left"}
        if self._bar is None:
            self._bar = _bar(self._stream, self._clock)
            self._bar.add_task(self.label, total=self.total, completed=self.done, **told)
            self._bar.start()
        else:
            (task,) = self._bar.task_ids
            self._bar.update(task, completed=self.done, refresh=True, **told)

    def close(self) -> None:
        """Wipe the bar."""
        if self._bar is not None:
            self._bar.stop()
            self._bar = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


def _bar(stream: TextIO, clock: Callable[[], float]) -> Bar:
    """Return a bar on a terminal; rich is imported here: that takes as long as a short job."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress as Bar, TextColumn

    columns = (
        MofNCompleteColumn(), TextColumn("{task.description}"), BarColumn(),
        TextColumn("{task.fields[rate]}"), TextColumn("{task.fields[left]}"),
    )  # fmt: skip
    # Without a thread of its own and without other streams in its hands it disturbs no worker.
    return Bar(
        *columns, console=Console(file=stream, force_terminal=True), auto_refresh=False,
        transient=True, redirect_stdout=False, redirect_stderr=False, get_time=clock,
    )  # fmt: skip
