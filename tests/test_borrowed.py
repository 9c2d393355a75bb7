"""Compiled code gives back the memory that it takes, and counts arrays where it must."""

from __future__ import annotations

import gc
import importlib
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest
from numba.core.registry import CPUDispatcher
from numba.core.runtime import _nrt_python, rtsys

import gcm_learn
from gcm_learn import families, get_planner
from gcm_learn.situation import Situation

MAKERS = {"array", "copy", "empty", "full", "ones", "zeros", "append"}
MAKERS |= {"Bodies", "World", "State", "Agenda", "MarchingState", "Spans"}
MAKERS |= {"Batch", "CheckedCells", "ReachedCells"}
PLANNERS = ("gcm", "marching", "layered", "straight", "recall")


@pytest.fixture(scope="module")
def drawn() -> list[Situation]:
    """Bodies of every kind: polygons, solids, pendulums."""
    names = ("crossing-swarm", "gate", "gate-solid", "falling-solid", "pendulum", "random-solid")
    return [families.draw(name, 5, k) for name in names for k in range(2)]


def functions() -> Iterator[CPUDispatcher]:
    """Yield all compiled functions of the package."""
    root = Path(gcm_learn.__file__).parent
    for path in sorted(root.rglob("*.py")):
        if "@njit" in path.read_text() and path.name != "compiled.py":
            module = importlib.import_module(
                ".".join(("gcm_learn", *path.relative_to(root).with_suffix("").parts))
            )
            yield from (f for f in vars(module).values() if isinstance(f, CPUDispatcher))


def makes_arrays(function: CPUDispatcher) -> bool:
    """Return whether a function, or one that it names, makes arrays or puts some together.

    Names of attributes count as well, so functions may seem to name each other in a circle.
    """
    waiting, seen = [function], {function}
    while waiting:
        asked = waiting.pop().py_func
        if not MAKERS.isdisjoint(asked.__code__.co_names):
            return True
        names, spaces = asked.__code__.co_names, [asked.__globals__]
        spaces += [vars(m) for m in map(spaces[0].get, names) if isinstance(m, ModuleType)]
        for named in (space[name] for space in spaces for name in names if name in space):
            if isinstance(named, CPUDispatcher) and named not in seen:
                seen.add(named)
                waiting.append(named)
    return False


def test_only_what_makes_no_arrays_goes_uncounted():
    """What an uncounted function were given by another would never be given back."""
    pytest.importorskip("gymnasium")
    uncounted = {f for f in functions() if f.targetoptions.get("_nrt") is False}
    assert len(uncounted) > 50
    assert [f.py_func.__name__ for f in uncounted if makes_arrays(f)] == []


def held() -> int:
    """Arrays of compiled code that are still alive."""
    gc.collect()
    stats = rtsys.get_allocation_stats()
    return int(stats.mi_alloc - stats.mi_free)


@pytest.fixture(scope="module", autouse=True)
def counting():
    """Let numba count arrays; they are not counted by default."""
    _nrt_python.memsys_enable_stats()
    yield
    _nrt_python.memsys_disable_stats()


@pytest.mark.parametrize("name", PLANNERS)
def test_plans_leave_nothing_behind(name, drawn):
    planner = get_planner(name)
    for _ in range(2):  # the first time compiles, and fills what is kept on purpose
        before = held()
        caught = sum(planner.plan(situation).caught for situation in drawn)
    assert held() == before
    assert caught > 0


def test_steps_leave_nothing_behind(drawn):
    pytest.importorskip("gymnasium")
    from gcm_learn.envs import CatchArm

    for control in ("hand", "joint"):
        env = CatchArm(drawn, control=control, fan=True)
        env.action_space.seed(1)
        for _ in range(2):
            before = held()
            for index in range(len(drawn)):
                over = False
                env.reset(options={"index": index})
                while not over:
                    _, _, ended, late, _ = env.step(env.action_space.sample())
                    over = ended or late
        assert held() == before
