"""Compiled code gives back the memory that it takes."""

from __future__ import annotations

import gc

import pytest
from numba.core.runtime import _nrt_python, rtsys

from gcm_learn import families, get_planner
from gcm_learn.situation import Situation

PLANNERS = ("gcm", "marching", "layered", "straight", "recall")


@pytest.fixture(scope="module")
def drawn() -> list[Situation]:
    """Bodies of every kind: polygons, solids, pendulums."""
    names = ("crossing-swarm", "gate", "gate-solid", "falling-solid", "pendulum", "random-solid")
    return [families.draw(name, 5, k) for name in names for k in range(2)]


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
