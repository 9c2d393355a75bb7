"""Compiled code made ready before many processes ask for it at once."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from dataclasses import replace
from typing import TypeVar

from filelock import FileLock
from llvmlite import binding

from gcm_learn import compiled
from gcm_learn.dataset.item import case_of, make_item
from gcm_learn.dataset.kinds import RECORDS
from gcm_learn.dataset.spec import DatasetSpec

DRAWS = 2  # items of each family
_WARM: set[str] = set()  # specifications that this process is ready for
Task = TypeVar("Task")
Result = TypeVar("Result")


def warm_up(spec: DatasetSpec) -> None:
    """Load, and compile where need be, all code that the items of a specification run.

    The first processes of a kind of machine compile one after another: numba's cache on disk is not
    made for many that compile at once.
    """
    folder = compiled.folder()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        turn = FileLock(folder / "warming.lock")
        with turn:
            pass
    except OSError:  # nothing can be kept there, so nobody has to wait
        _run(spec)
        return
    done = folder / f"warm-{compiled.source_hash(__name__)}-{binding.get_host_cpu_name()}"
    if done.exists():
        _run(spec)
        return
    with turn:
        _run(spec)
        with contextlib.suppress(OSError):
            done.touch()


def warmed(spec: DatasetSpec, work: Callable[[Task], Result], task: Task) -> Result:
    """Do a task about a specification in a process that may be new."""
    if spec.digest not in _WARM:
        warm_up(spec)
        _WARM.add(spec.digest)
    return work(task)


def _run(spec: DatasetSpec) -> None:
    """Make a few items, and try all levels of all planners in a situation without a path."""
    small = replace(spec, strata=None, count=DRAWS * len(spec.families))
    examples = RECORDS.of(spec.kind).case.examples()
    for k in range(small.count):
        family = spec.families[k // DRAWS]
        alone = not examples and spec.audit > 0.0 and k == 0
        make_item(replace(small, families=(family,), audit=float(alone)), k)
    for situation in examples:
        case = case_of(situation, small)
        for name in ("straight", "marching", "layered", *spec.planners):
            case.plan(name)
        case.map()
        if spec.audit > 0.0 or spec.label == "oracle":
            case.oracle()
