"""Jobs of a comparison, shared among processes that take one thread each."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import as_completed
from typing import Any, Protocol, TypeVar

from gcm_learn.evaluation.suites import Entry
from gcm_learn.processes import cores, pool


class Piece(Protocol):
    """Some situations to be answered at once."""

    @property
    def entries(self) -> tuple[Entry, ...]:
        """The situations."""


AnyPiece = TypeVar("AnyPiece", bound=Piece)
Rows = list[dict[str, Any]]


def rows_of(
    jobs: Sequence[AnyPiece],
    do: Callable[[AnyPiece], Rows],
    workers: int | None,
    progress: Callable[[int], object],
) -> Rows:
    """Rows of all jobs, in any order.

    Parameters
    ----------
    jobs : sequence
    do : callable
        A function of a module: makes the rows of a job.
    workers : int, optional
        Processes; by default one for each core.
    progress : callable
        Told how many situations of a job are done.
    """
    rows: Rows = []
    workers = min(workers or cores(), len(jobs))
    if workers <= 1:
        for job in jobs:
            rows += do(job)
            progress(len(job.entries))
        return rows
    with pool(workers) as executor:
        running = {executor.submit(do, job): job for job in jobs}
        for future in as_completed(running):
            rows += future.result()
            progress(len(running[future].entries))
    return rows
