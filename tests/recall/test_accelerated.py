"""Recall under limits of acceleration: catches keep their timing, and are retimed where needed."""

from dataclasses import replace

import numpy as np
import pytest

from gcm_learn import get_planner, solve
from gcm_learn.recall import RecallPlanner, waypoints_of
from gcm_learn.recall.joint_moves import EARLIEST, TIME
from gcm_learn.situation import canonical
from tests.judging import judge
from tests.recall.conftest import memory_in_space
from tests.recall.worlds import LIMITED, catches_of, memory_of
from tests.worlds import solid_ball

pytestmark = pytest.mark.slow  # compiles recall for spatial arms under such limits


def test_a_catch_keeps_its_timing_where_it_was_made():
    """Where it was made it is mostly one of its own times, and its way."""
    memory, catches = memory_of(LIMITED), catches_of(LIMITED)
    planner, own, ways = RecallPlanner(memory, 1, novelty=0.0), 0, []
    for k, (situation, plan) in enumerate(catches):
        found = planner.recollect(situation)
        if found.memory == k and found.plan.catch_time == pytest.approx(plan.catch_time, rel=1e-6):
            own += 1
            at = np.linspace(0.0, plan.catch_time, 50)
            ways.append(found.plan.trajectory.joints_at(at) - plan.trajectory.joints_at(at))
    assert own > 0.7 * len(catches)
    assert np.median([np.abs(way).max() for way in ways]) < 0.2


def test_weaker_joints_keep_the_way_and_need_more_time():
    memory, catches = memory_of(LIMITED), catches_of(LIMITED)
    planner, retimed = RecallPlanner(memory, 1, novelty=0.0), 0
    for k, (situation, plan) in enumerate(catches):
        arm = situation.arm
        for share in (0.6, 0.4, 0.25):
            limits = tuple(share * limit for limit in arm.max_joint_acceleration)
            weak = replace(situation, arm=replace(arm, max_joint_acceleration=limits))
            found = planner.recollect(weak)
            if found.memory == k and found.plan.catch_time > 1.03 * plan.catch_time:
                retimed += 1
                assert judge(weak, found.plan) == []
                again = waypoints_of(weak, found.plan).knots
                assert np.abs(again[-1, :4] - memory.knots[k, -1, :4]).max() < 1.0
                break
    assert retimed >= 3


def test_knots_of_a_curve_tell_its_course_and_only_rests_are_waits():
    waiting = 0
    for situation, plan in catches_of(LIMITED):
        knots, path = waypoints_of(situation, plan).knots.astype(float), plan.trajectory
        turned = canonical(situation)[1]
        assert knots[-1, TIME] == pytest.approx(plan.catch_time, rel=1e-6)
        at = np.linspace(0.0, path.duration, 200)
        there = np.stack([np.interp(at, knots[:, TIME], knots[:, j]) for j in range(4)], axis=1)
        assert np.abs(there - turned.canonical_joints(path.joints_at(at))).max() < 0.15
        for k in np.flatnonzero(knots[:, EARLIEST]):
            waiting += 1
            speed = np.abs(knots[k, :4] - knots[k - 1, :4]) / (knots[k, TIME] - knots[k - 1, TIME])
            assert (speed < 0.11 * np.array(situation.arm.max_joint_speed)).any()
    assert waiting > 0


def test_memories_without_such_limits_serve_under_them_and_the_other_way_round():
    """What is kept is the same for both, so folders from before such limits were known load."""
    free = list(replace(LIMITED, accelerates=False).drawn(313, 24))
    plans = [solve(s, "search") for s in free]
    found = [(s, p) for s, p in zip(free, plans, strict=True) if p.caught]
    unlimited = memory_in_space(found)
    memory = memory_of(LIMITED)
    assert unlimited.knots.shape[1:] == memory.knots.shape[1:]
    served = [RecallPlanner(unlimited).plan(s).caught for s in LIMITED.drawn(314, 24)]
    assert sum(served) >= 8
    assert sum(RecallPlanner(memory).plan(s).caught for s in free) >= 8


def test_what_touches_at_all_times_is_pushed_aside():
    """A ball rests where the hand comes through halfway, so no other time helps."""
    pushed = 0
    for situation, plan in catches_of(LIMITED):
        if plan.catch_time < 0.2:
            continue
        place = plan.trajectory.hand_at(0.5 * plan.catch_time)
        ball = solid_ball("in the way", place, radius=0.06)
        blocked = replace(situation, bodies=(*situation.bodies, ball))
        planner = RecallPlanner(memory_in_space([(situation, plan)]), 1, novelty=0.0)
        found = planner.plan(blocked)
        if found.caught:
            pushed += 1
            assert judge(blocked, found) == []
    assert pushed >= 5


def test_hybrid_keeps_deadlines_and_bounds():
    planner, sooner, bounded = get_planner("hybrid"), 0, 0
    for situation in LIMITED.drawn(317, 12):
        first = planner.plan(situation)
        if not first.caught:
            continue
        patient = planner.plan(situation, deadline=0.25)
        assert patient.catch_time <= first.catch_time
        sooner += patient.catch_time < first.catch_time
        asked = planner.plan(situation, bound=0.7 * first.catch_time)
        assert not asked.caught or asked.catch_time <= 0.7 * first.catch_time
        bounded += asked.caught
        for plan in (patient, asked):
            if plan.caught:
                assert judge(situation, plan) == []
    assert sooner > 0 and bounded > 0
