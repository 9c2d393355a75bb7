"""Checks, looks and bends of a recollection, counted without a change to the kernels.

The loops over memories run once more in Python, from the sources of the compiled ones. Functions in
them that look at a memory or bend a path are counted.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from types import FunctionType
from typing import Any

from gcm_learn.recall import RecallPlanner, freeing, trials
from gcm_learn.recall.timed_moves import TimedQuery


def counted(planner: RecallPlanner, situation: Any) -> dict[str, int]:
    """Return how many memories a planner checks and compares, and how often it changes a path.

    Parameters
    ----------
    planner : RecallPlanner
    situation : Situation

    Returns
    -------
    dict of str to int
        `checks` are verified paths, `looks` quick comparisons with other memories, and `bends`
        changes of a path, one upon the other.
    """
    with _counting() as seen:
        found = planner.recollect(situation)
    return {"checks": found.checked, "looks": seen["looks"], "bends": seen["bends"]}


@contextmanager
def _counting() -> Iterator[Counter[str]]:
    """Count within the block."""
    seen: Counter[str] = Counter()
    known = trials.first_valid
    trials.first_valid = _first_valid(seen)
    try:
        yield seen
    finally:
        trials.first_valid = known


def _first_valid(seen: Counter[str]) -> Callable[..., Any]:
    """Return the loop over memories, which counts."""

    def noted(name: str, function: Callable[..., Any]) -> Callable[..., Any]:
        def called(*given: Any) -> Any:
            seen[name] += 1
            return function(*given)

        return called

    free = _in_python(freeing.free, _touch_of=noted("bends", freeing._touch_of))
    freed = {
        is_timed: _in_python(kernel, free=free)
        for is_timed, kernel in ((False, trials._freed_path), (True, trials._freed_in_its_time))
    }
    return _in_python(
        trials.first_valid,
        _compare=_in_python(trials._compare, quick_check=noted("looks", trials.quick_check)),
        freed=partial(_by_query, freed),
    )


def _by_query(freed: dict[bool, Callable[..., Any]], query: Any, *more: Any) -> Any:
    return freed[isinstance(query, TimedQuery)](query, *more)


def _in_python(kernel: Any, **names: Any) -> Callable[..., Any]:
    """Return a kernel's own source as a Python function in which names mean something else."""
    source = kernel.py_func
    return FunctionType(source.__code__, source.__globals__ | names, source.__name__)
