"""Synthetic movements: they meet targets, are as long as catches, and know no obstacle."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("pyarrow")

from gcm_learn import dataset, families
from gcm_learn.arms import kind_of
from gcm_learn.cli import main
from gcm_learn.errors import RecallError
from gcm_learn.recall import Memory, RandomIndex, RecallPlanner, remember, waypoints_of
from gcm_learn.recall.growth import Habit, Synthetic, habits_of

SPATIAL = pytest.param("crossing-swarm-space", marks=pytest.mark.slow)
FAMILIES = ("crossing-swarm", SPATIAL, "swarm-chain")
HABIT = Habit(length=1.5, end=0.8, wait=0.25)


def records(family, count=12):
    return [SimpleNamespace(situation=families.draw(family, 5, k), index=k) for k in range(count)]


@pytest.mark.parametrize("family", FAMILIES)
def test_movements_last_and_wait_as_wanted(family):
    made = [Synthetic((HABIT,))(record) for record in records(family)]
    some = [(m, r.situation) for m, r in zip(made, records(family), strict=True) if m is not None]
    assert len(some) > 4
    for movement, situation in some:
        end = HABIT.end * situation.horizon
        assert movement.catch_time == pytest.approx(end)
        begins = movement.knots[movement.knots[:, -1] > 0.0, -1]
        assert begins[0] == pytest.approx(HABIT.wait * end)


@pytest.mark.parametrize("family", FAMILIES)
def test_movements_catch_where_nothing_is_in_the_way(family):
    caught = []
    for record in records(family):
        free = replace(record.situation, bodies=record.situation.targets)
        made = Synthetic((HABIT._replace(end=0.9),))(SimpleNamespace(situation=free, index=0))
        if made is not None:
            memory = Memory(RandomIndex.fit([free], 0), kind=kind_of(free))
            memory.add([free], [made])
            caught.append(RecallPlanner(memory).plan(free).caught)
    assert len(caught) > 4
    assert np.mean(caught) > 0.7


@pytest.mark.parametrize("family", FAMILIES)
def test_obstacles_change_nothing(family):
    source = Synthetic((HABIT,), seed=3)
    for record in records(family, 4):
        targets = replace(record.situation, bodies=record.situation.targets)
        whole, bare = source(record), source(SimpleNamespace(situation=targets, index=record.index))
        assert (whole is None) == (bare is None)
        if whole is not None:
            np.testing.assert_array_equal(whole.knots, bare.knots)


def test_seeds_differ_and_repeat():
    some = records("swarm-chain", 3)
    first, again, other = ([Synthetic((HABIT,), seed)(r) for r in some] for seed in (1, 1, 2))
    same = [np.array_equal(a.knots, b.knots) for a, b in zip(first, again, strict=True) if a]
    assert same and all(same)
    assert not all(np.array_equal(a.knots, b.knots) for a, b in zip(first, other, strict=True) if a)


def test_habits_are_those_of_catches():
    sample = dataset.open("data/sample")
    some = [sample[k] for k in range(40)]
    habits = habits_of(some)
    caught = [r for r in some if any(plan.caught for plan in r.plans.values())]
    assert len(habits) == len(caught)
    ends = [
        min(p.catch_time for p in r.plans.values() if p.caught) / r.situation.horizon
        for r in caught
    ]
    assert [habit.end for habit in habits] == pytest.approx(ends)
    with pytest.raises(RecallError, match="no catches"):
        habits_of([])


def test_a_memory_of_them_is_made_and_indexed(tmp_path, capsys):
    sample = dataset.open("data/sample")
    memory = remember(sample, "random", synthetic=True, most=30, seed=4)
    stored = [waypoints_of(r.situation, p) for r in sample for p in r.plans.values() if p.caught]
    assert 15 < len(memory) <= 30
    assert not any(np.array_equal(memory.knots[0], waypoints.knots) for waypoints in stored)
    out = str(tmp_path / "memory")
    assert main(["memory", "make", "data/sample", "--synthetic", "--most", "5", "--out", out]) == 0
    assert len(Memory.load(tmp_path / "memory")) <= 5
    command = ["memory", "make", "data/sample", "--synthetic", "--planner", "layered", "--out", out]
    assert main(command) == 2
    assert "--planner: has no part in --synthetic" in capsys.readouterr().err
