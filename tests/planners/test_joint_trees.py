"""ST-RRT* over joints and time: what it is asked, what it answers."""

from __future__ import annotations

import numpy as np
import pytest

from gcm_learn import seeding
from gcm_learn.arms import forward_in_space
from gcm_learn.planners.baselines.st_rrt_star import STRRTStarPlanner
from gcm_learn.planners.baselines.st_rrt_star_joints import draw_posture, task_in_space
from gcm_learn.planners.completion import JointProblem
from gcm_learn.situation import Sphere, read_situations
from tests.judging import judge
from tests.planners.test_joint_straight import ARM, GOAL, RADIUS, ball, flying, hand_of, scene
from tests.planners.test_st_rrt_star import needs_ompl
from tests.spatial import EXAMPLES

pytestmark = pytest.mark.slow
POST = flying("obstacle", Sphere(0.2), hand_of((np.array(ARM.joints) + GOAL) / 2.0))


def task_of(situation):
    return task_in_space(JointProblem(situation, "test"), 0, 0.0, 0)


def test_a_leg_keeps_the_limits_and_goes_forward_in_time():
    task = task_of(scene(ball(hand_of(GOAL))))
    start, goal = np.array(task.start), np.array(GOAL) / ARM.max_joint_speed
    least = np.abs(goal - start).max()
    assert task.holds(start, 0.1, goal, 0.1 + least * 1.001)
    assert not task.holds(start, 0.1, goal, 0.1 + least * 0.999)
    assert not task.holds(goal, 0.3, goal, 0.3) and not task.holds(goal, 0.3, start, 0.2)


def test_a_leg_through_a_post_does_not_hold():
    task = task_of(scene(ball(hand_of(GOAL)), POST))
    goal = np.array(GOAL) / ARM.max_joint_speed
    assert not task.holds(task.start, 0.0, goal, 0.5)
    assert task.holds(task.start, 0.0, task.start, 0.5)


def test_goals_are_interceptions_in_time():
    place, velocity = hand_of(GOAL), np.array([0.5, -1.0, 0.4])
    task, rng = task_of(scene(ball(place, velocity))), seeding.rng(7)
    q, drawn = np.zeros(4), []
    for _ in range(200):
        t = draw_posture(task.study, 0.1, 0.9, rng.random((16, 7)), q)
        drawn.append((t, *q))
    drawn = np.array([d for d in drawn if d[0] >= 0.0])
    time, joints = drawn[:, 0], drawn[:, 1:]
    assert len(time) > 100 and 0.1 <= time.min() and time.max() <= 0.9
    hands = forward_in_space(ARM, joints)[1]
    off = np.linalg.norm(hands - (place + time[:, None] * velocity), axis=1)
    assert off.max() <= RADIUS + ARM.grasp and off.max() > 0.9 * (RADIUS + ARM.grasp)
    needed = (np.abs(joints - ARM.joints) / ARM.max_joint_speed).max(axis=1)
    assert (needed <= time).all()


@needs_ompl
def test_it_goes_round_a_post():
    situation = scene(ball(hand_of(GOAL)), POST)
    plan = STRRTStarPlanner().plan(situation)
    assert plan.caught
    assert judge(situation, plan) == []


@needs_ompl
def test_budgets_of_the_examples():
    kept = [s for s in read_situations(EXAMPLES) if s.arm.max_joint_acceleration is None][:12]
    caught = 0
    for situation in kept:
        plans = STRRTStarPlanner().plan_anytime(situation, (30.0, 300.0))
        times = [np.inf if plan.catch_time is None else plan.catch_time for plan in plans]
        assert times[1] <= times[0]
        for plan in (p for p in plans if p.caught):
            assert judge(situation, plan) == []
        caught += plans[1].caught
    assert caught >= 5
