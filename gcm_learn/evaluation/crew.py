"""Calls of a comparison, shared among processes that take one thread each."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import as_completed
from typing import Any

from gcm_learn.processes import cores, pool

Rows = list[dict[str, Any]]


def rows_of(
    calls: Sequence[Callable[[], Rows]],
    workers: int | None,
    progress: Callable[[int], object],
) -> Rows:
    """Rows of all calls, in their order.

    Parameters
    ----------
    calls : sequence of callable
        Each makes a row for each of some situations; processes get them pickled.
    workers : int, optional
        Processes; by default one for each core.
    progress : callable
        Told how many rows are new.
    """
    rows: Rows = []
    workers = min(workers or cores(), len(calls))
    if workers <= 1:
        for call in calls:
            rows += (new := call())
            progress(len(new))
        return rows
    with pool(workers) as executor:
        running = [executor.submit(call) for call in calls]
        for future in as_completed(running):
            progress(len(future.result()))
    return [row for future in running for row in future.result()]
