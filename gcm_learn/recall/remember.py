"""Memories made of datasets."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

from gcm_learn import seeding
from gcm_learn.dataset import Dataset, Record
from gcm_learn.errors import RecallError
from gcm_learn.recall.index import Index, index_class
from gcm_learn.recall.store import Memory
from gcm_learn.recall.waypoints import Trace, trace_of

CHUNK = 500  # records that are filed at once
FITTED = 5000  # situations at most that an index is fitted to


def remember(
    records: Dataset,
    index: str | Index = "raw",
    planner: str = "",
    *,
    seed: int = 0,
    most: int | None = None,
    progress: Callable[[int], None] = lambda done: None,
) -> Memory:
    """Make a memory of the catches of a dataset.

    Parameters
    ----------
    records : Dataset
        Those without a catch are left out; choose a split with `where` before.
    index : str or Index
        A registered name, which is fitted to a sample of the situations, or an index of your own.
    planner : str
        Whose catches; by default of all planners the earliest.
    seed : int
        Decides the sample, and which records are taken if there are more than `most`.
    most : int, optional
        Records that are read at most.
    progress : callable
        Called with the number of records read since the last call.
    """
    if planner and planner not in records.spec.planners:
        known = ", ".join(records.spec.planners)
        raise RecallError(f"planner: {planner!r} has no plans in the dataset (it has {known})")
    order = np.arange(len(records))
    if most is not None and most < len(order):
        order = np.sort(seeding.rng(seed, 0).permutation(len(order))[:most])
    if isinstance(index, str):
        index = _fitted(records, index, order, seed)
    memory = Memory(index)
    for start in range(0, len(order), CHUNK):
        part = order[start : start + CHUNK]
        _file(memory, (records[int(k)] for k in part), planner)
        progress(len(part))
    return memory


def _fitted(records: Dataset, name: str, order: np.ndarray, seed: int) -> Index:
    """A registered index, fitted to situations of the records."""
    if len(order) == 0:
        raise RecallError("the dataset has no records to remember")
    kind = index_class(name)
    sample = np.sort(seeding.rng(seed, 1).permutation(order)[:FITTED])
    return kind.fit([records[int(k)].situation for k in sample], seed)


def _file(memory: Memory, records: Iterable[Record], planner: str) -> None:
    found = [(record, trace) for record in records if (trace := _catch(record, planner))]
    memory.add(
        [record.situation for record, _ in found],
        [trace for _, trace in found],
        [record.family for record, _ in found],
        [record.stratum for record, _ in found],
    )


def _catch(record: Record, planner: str) -> Trace | None:
    """Trace of a record's catch, of the earliest if no planner is named."""
    names = (planner,) if planner else record.planners
    plans = [record.plans[name] for name in names if record.plans[name].caught]
    if not plans:
        return None
    return trace_of(record.situation, min(plans, key=lambda plan: plan.catch_time or 0.0))
