"""Deadlines: what is searched by then is counted, not timed; more time is never worse."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from gcm_learn import families, get_planner
from gcm_learn.motion import Failure
from gcm_learn.planners import Deadline, TreeSearch, layered, search_in_space
from gcm_learn.planners.goal_directed import SLICE as LABELS
from gcm_learn.planners.joints import tree_search
from gcm_learn.planners.joints.tree_search import SLICE as POSTURES
from gcm_learn.planners.plan import GAIN, deadline_of


class Ticks:
    """A clock that goes on by one when it is read."""

    def __init__(self):
        self.reads = 0

    def __call__(self):
        self.reads += 1
        return float(self.reads)


def drawn(name, index):
    """Return a situation; in space without limits of acceleration."""
    situation = families.draw(name, 81, index)
    if not situation.is_spatial:
        return situation
    arm = replace(situation.arm, max_joint_acceleration=None, joint_rates=None)
    return replace(situation, arm=arm)


NODES = 3 * POSTURES
"""Nodes that a slice may add to both trees: for each posture itself and one of each tree."""
PLANE = [drawn(name, k) for name in ("gate", "crossing-swarm", "behind-mover") for k in range(6)]
SPACE = [drawn(name, k) for name in ("window-space", "crossing-swarm-space") for k in range(6)]
ARMS = [
    pytest.param(layered(), PLANE, LABELS, id="plane"),
    pytest.param(search_in_space(), SPACE, NODES, id="space"),
]


def after(planner, situation, reads):
    """Plan until the clock has been read so often; also how often it was read in all."""
    clock = Ticks()
    plan = planner.plan(situation, deadline=Deadline(reads, clock))
    return plan, clock.reads


@pytest.mark.parametrize(("planner", "situations", "size"), ARMS)
def test_nothing_is_searched_after_the_deadline(planner, situations, size):
    stopped = 0
    for situation in situations:
        for reads in (0, 1, 3, 10):
            plan, read = after(planner, situation, reads)
            assert plan.nodes <= reads * size
            assert read <= reads + 8  # who finds that it is over stops, and so do its callers
            stopped += plan.failure is Failure.OUT_OF_TIME
    assert stopped > 10


@pytest.mark.parametrize(("planner", "situations", "size"), ARMS)
def test_more_time_is_never_worse(planner, situations, size):
    sooner = 0
    for situation in situations:
        plans = [after(planner, situation, reads)[0] for reads in (1, 4, 10, 30, 100)]
        times = [math.inf if plan.catch_time is None else plan.catch_time for plan in plans]
        assert times == sorted(times, reverse=True)
        assert [p.nodes for p in plans] == sorted(p.nodes for p in plans)
        sooner += math.isfinite(times[0]) and times[-1] < times[0]
        sooner += math.isinf(times[0]) and math.isfinite(times[-1])
    assert sooner >= 3


def test_with_all_the_time_there_is_the_answer_is_the_earliest():
    for situation in PLANE:  # there the search looks for the earliest anyhow
        whole = layered().plan(situation)
        assert layered().plan(situation, deadline=1e9).catch_time == whole.catch_time
        if not whole.caught or whole.nodes == 0:
            continue
        bound, off = 1.05 * whole.catch_time, 2.0 * GAIN * situation.horizon
        again = layered().plan(situation, bound=bound, deadline=1e9)
        assert again.caught and again.catch_time <= whole.catch_time + off


def test_trees_end_when_they_find_nothing_earlier():
    planner = replace(search_in_space(), rounds=200)
    caught = 0
    for situation in SPACE:
        clock, first = Ticks(), planner.plan(situation)
        if first.caught:
            plan = planner.plan(situation, deadline=Deadline(1e9, clock))
            assert clock.reads < 1000
            assert plan.catch_time <= first.catch_time
            caught += 1
    assert caught >= 8


def test_limits_of_acceleration_are_kept_by_the_deadline_too():
    stopped = 0
    for k in range(4):
        situation = families.draw("window-space", 81, k)
        arm = replace(situation.arm, max_joint_acceleration=(60.0,) * 4, joint_rates=None)
        situation = replace(situation, arm=arm)
        plans = [after(search_in_space(), situation, reads)[0] for reads in (2, 20, 200)]
        assert all(p.nodes <= reads * NODES for p, reads in zip(plans, (2, 20, 200), strict=True))
        times = [math.inf if plan.catch_time is None else plan.catch_time for plan in plans]
        assert times == sorted(times, reverse=True)
        stopped += plans[0].failure is Failure.OUT_OF_TIME
    assert stopped > 0


def test_a_deadline_takes_the_place_of_the_limits_of_work(monkeypatch):
    situation = families.draw("panda-crowded", 3, 0)
    short = TreeSearch(rounds=1)
    assert short.plan(situation).failure is Failure.NO_TREE
    assert after(short, situation, 300)[0].caught
    monkeypatch.setattr(tree_search, "WORK", 0)
    assert TreeSearch().plan(situation).failure is Failure.OUT_OF_WORK
    assert after(TreeSearch(), situation, 300)[0].caught


def test_names_take_deadlines():
    planner = get_planner("search")
    assert planner.anytime and not getattr(get_planner("straight"), "anytime", False)
    for situation in (PLANE[0], SPACE[0]):
        assert planner.plan(situation, deadline=0.0).status in ("caught", "unreachable")


def test_a_deadline_is_a_time():
    assert deadline_of(None) is None
    running = Deadline(1.0)
    assert deadline_of(running) is running and not running.over
    assert deadline_of(0).over
    for wrong in (-1.0, math.nan):
        with pytest.raises(ValueError, match="deadline: must be from 0 on"):
            Deadline(wrong)
