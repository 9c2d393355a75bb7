"""Compiled code made ready before many processes ask for it at once."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from dataclasses import replace
from typing import TypeVar

from filelock import FileLock
from llvmlite import binding

from gcm_learn import compiled
from gcm_learn.arms import Arm
from gcm_learn.dataset.item import Case, make_item
from gcm_learn.dataset.spec import DatasetSpec
from gcm_learn.situation import Body, Disc, PlanarQuadratic, Situation

DRAWS = 2  # items of each family
_WARM: set[str] = set()  # specifications that this process is ready for
Task = TypeVar("Task")
Result = TypeVar("Result")


def warm_up(spec: DatasetSpec) -> None:
    """Load, and compile where need be, all code that the items of a specification run.

    Where none of this machine's kind has compiled before, one process after another does so:
    numba's cache on disk is not made for many that compile at once.
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
    for k in range(small.count):
        family = spec.families[k // DRAWS]
        one = replace(
            small, families=(family,), audit=float(spec.spatial and spec.audit > 0.0 and k == 0)
        )
        make_item(one, k)
    for situation in () if spec.spatial else _scenes():
        case = Case(situation, small)
        for name in ("straight", "marching", "layered", *spec.planners):
            case.plan(name)
        case.map()
        if spec.audit > 0.0 or spec.label == "oracle":
            case.oracle()


def _scenes() -> tuple[Situation, Situation]:
    """A target that is free and one that is covered."""
    still = PlanarQuadratic((0.4, 1.4), (0.0, 0.0), (0.0, 0.0))
    ball = Body("target", "ball", Disc(0.08), still)
    lid = Body("obstacle", "lid", Disc(0.4), still)
    arm = Arm((1.3, 0.0), 3.0)
    return Situation("free", 1.0, arm, (ball,)), Situation("covered", 1.0, arm, (ball, lid))
