"""Calls of a comparison, shared out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from gcm_learn.processes import cores, crew_of

Rows = list[dict[str, Any]]


def is_alone(calls: int, workers: int | None, cluster: str | None) -> bool:
    """Return whether this process does all calls itself."""
    return cluster is None and min(workers or cores(), calls) <= 1


def rows_of(
    calls: Sequence[Callable[[], Rows]],
    workers: int | None,
    cluster: str | None,
    progress: Callable[[int], object],
) -> Rows:
    """Rows of all calls, in their order.

    Parameters
    ----------
    calls : sequence of callable
        Each makes a row for each of some situations; whoever does it gets it pickled.
    workers, cluster
        See `processes.crew_of`.
    progress : callable
        Told how many rows are new.
    """
    rows: Rows = []
    with crew_of(min(workers or cores(), len(calls)) or 1, cluster) as crew:
        for new in crew.map(_called, calls):
            rows += new
            progress(len(new))
    return rows


def _called(call: Callable[[], Rows]) -> Rows:
    return call()
