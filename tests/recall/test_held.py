"""Memories of held catches: kept as one movement, caught again, and placed."""

from functools import cache

import numpy as np
import pytest

from gcm_learn import recall, solve
from gcm_learn.arms import CHAIN, kind_of
from gcm_learn.families import draw
from gcm_learn.planners import JointProblem
from gcm_learn.recall.adaptation import Adaptation, HeldTries
from gcm_learn.recall.growth import habits_of
from gcm_learn.recall.waypoints import EARLIEST, TIME
from gcm_learn.situation import canonical
from tests.judging import judge

PRESETS = {"held": ("panda-turntable", 20), "placed": ("panda-belt", 14)}
SLOW = pytest.mark.slow  # compiles recall of held catches
KINDS = pytest.mark.parametrize("name", PRESETS)


@cache
def catches(name):
    """Catches of the default planner among the first situations of a preset."""
    preset, count = PRESETS[name]
    drawn = [draw(preset, 46, k) for k in range(count)]
    return [(s, plan) for s in drawn if (plan := solve(s)).caught]


@cache
def memory(name):
    """A memory of the first half of the catches."""
    some = catches(name)[: len(catches(name)) // 2]
    situations = [situation for situation, _ in some]
    made = recall.Memory(recall.RawIndex.fit(situations), kind=kind_of(situations[0]))
    made.add(situations, [recall.waypoints_of(*one) for one in some])
    return made


@KINDS
def test_a_memory_is_approach_hold_and_end(name):
    for situation, plan in catches(name):
        kept, end = recall.waypoints_of(situation, plan), plan.trajectory.duration
        assert kept.catch_time == pytest.approx(plan.catch_time, abs=1e-6)
        after = kept.knots[kept.knots[:, EARLIEST] < 0.0]
        assert after[:, TIME] == pytest.approx([plan.held_until, end], abs=1e-6)
        frame = canonical(situation)[1]
        rest = frame.canonical_joints(plan.trajectory.joints[-1])
        assert after[-1, 1:TIME] == pytest.approx(rest[1:], abs=1e-5)  # joint 1 has the heading


def test_synthetic_movements_end_as_early_as_catches():
    class Kept:
        def __init__(self, situation, plan):
            self.situation, self.earliest = situation, lambda: plan

    found = habits_of(Kept(*one) for one in catches("placed"))
    wanted = [plan.catch_time / situation.horizon for situation, plan in catches("placed")]
    assert [habit.end for habit in found] == pytest.approx(wanted)


@SLOW
@KINDS
def test_most_are_caught_again_from_themselves_and_some_from_others(name):
    planner, own = recall.RecallPlanner(memory(name)), 0
    for k, (situation, plan) in enumerate(catches(name)):
        found = planner.recollect(situation)
        assert judge(situation, found.plan) == []
        if found.plan.caught:
            assert (found.plan.placed is None) == (plan.placed is None)
            assert not found.plan.trajectory.rates[-1].any()
        own += found.memory == k
    assert own >= 0.7 * len(memory(name))


def test_what_memory_does_not_know_is_searched():
    empty = recall.Memory(recall.RandomIndex(), kind=CHAIN)
    situation, plan = catches("held")[0]
    hybrid = recall.HybridPlanner(recall.RecallPlanner(empty))
    assert hybrid.plan(situation).catch_time == plan.catch_time
    assert recall.RecallPlanner(empty).plan(situation).message == "nothing is known"


@SLOW
def test_the_search_goes_on_in_the_trees_that_memories_grew():
    made = memory("held")
    planner, went_on = recall.RecallPlanner(made, candidates=3), 0
    for situation, _ in catches("held")[len(made) :]:
        recalled = planner.recollect(situation)
        assert (recalled.begun is None) == recalled.plan.caught
        if recalled.begun is not None:
            ends = int(recalled.begun.ends.made[0])
            plan = recall.HybridPlanner(planner).plan(situation)
            assert judge(situation, plan) == []
            went_on += plan.caught and ends > 0
    assert went_on > 0


@SLOW
def test_memories_are_tried_each_alone_for_labels():
    made, own = memory("held"), 0
    for k, (situation, _) in enumerate(catches("held")[: len(made)]):
        tries = HeldTries(JointProblem(situation, "labels"), Adaptation())
        times = tries.catch_times(made.knots, made.goals, np.array([k, k]))
        assert (times[0] < 0.0) == (times[1] < 0.0)  # a first try leaves nothing behind
        assert (times < situation.horizon).all()
        own += times[0] > 0.0
    assert own >= 0.7 * len(made)


@SLOW
def test_a_memory_of_touches_proposes_postures_for_holds():
    planner = recall.RecallPlanner(recall.shipped_memory("recall", CHAIN), candidates=100)
    plans = [(situation, planner.plan(situation)) for situation, _ in catches("held")]
    assert any(plan.caught for _, plan in plans)
    assert all(judge(*one) == [] for one in plans)
