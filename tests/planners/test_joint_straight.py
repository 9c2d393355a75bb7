"""Straight lines in the joints: the earliest interception, waits, limits of speed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gcm_learn import seeding, situation as records
from gcm_learn.arms import SpatialArm, forward_in_space
from gcm_learn.motion import rules_of
from gcm_learn.planners import JointProblem
from gcm_learn.planners.baselines.straight import StraightPlanner, StraightWaitPlanner
from gcm_learn.planners.joints.moves import study_of, time_of
from gcm_learn.planners.joints.pull import box, met_from, slope_at
from gcm_learn.planners.joints.straight import attempt_along
from gcm_learn.scene import pack
from tests.judging import judge
from tests.spatial import EXAMPLES

ARM = SpatialArm(
    upper_arm=(1.0, 0.0, 0.0),
    forearm=(1.0, 0.0, 0.0),
    joints=(0.0, 0.0, 0.0, -0.8),
    joint_range=((-2.8, 2.0), (-0.6, 2.2), (-2.4, 2.4), (-2.6, 0.0)),
    max_joint_speed=(5.0, 5.0, 7.0, 7.0),
    grasp=0.1,
    thickness=0.05,
)
GOAL = (0.9, 1.1, -0.4, -1.2)
RADIUS = 0.05


def hand_of(joints):
    return forward_in_space(ARM, joints)[1]


def flying(role, shape, place, velocity=(0.0, 0.0, 0.0)):
    return records.Body(
        role, role, shape, records.SolidQuadratic(tuple(place), tuple(velocity), (0.0, 0.0, 0.0))
    )


def ball(place, velocity=(0.0, 0.0, 0.0)):
    return flying("target", records.Sphere(RADIUS), place, velocity)


def scene(*bodies, arm=ARM, horizon=1.0):
    return records.Situation("scene", horizon, arm, bodies)


def soonest(count=200_000):
    """Joints of random postures, and when a straight move gets there [s]."""
    low, high = np.array(ARM.joint_range).T
    joints = seeding.rng(3).uniform(low, high, (count, 4))
    return joints, (np.abs(joints - ARM.joints) / ARM.max_joint_speed).max(axis=1)


def studied(*bodies):
    packed = pack(scene(*bodies))
    return study_of(packed, rules_of(packed))


def test_what_joints_can_reach_in_a_time_is_reached_in_it():
    study, rng = studied(ball(hand_of(GOAL))), seeding.rng(9)
    for span in rng.uniform(0.01, 0.3, 200):
        q = rng.uniform(*np.array(ARM.joint_range).T)
        box(study, q, span)
        for corner in (study.low, study.high):
            assert time_of(study, q, corner)[0] <= span


def test_what_is_met_from_a_posture_is_met_in_time():
    study, start = studied(ball(hand_of(GOAL))), np.array(ARM.joints)
    took = (np.abs(np.subtract(GOAL, start)) / ARM.max_joint_speed).max()
    assert met_from(study, start, 0.1, 0, np.array(GOAL), 0.1 + 1.1 * took) > 0
    hand = hand_of(study.goal)
    assert np.linalg.norm(hand - hand_of(GOAL)) <= RADIUS + ARM.grasp
    assert time_of(study, start, study.goal)[0] <= 1.1 * took
    assert met_from(study, start, 0.1, 0, np.array(GOAL), 0.1 + 0.3 * took) == 0


def test_the_slope_of_a_target_leads_to_it():
    study = studied(flying("target", records.Cylinder(0.2, 0.3), (0.5, 0.4, 0.3)))
    place = np.array([1.0, 0.4, 0.3])
    assert np.allclose(slope_at(study, 0, *place, 0.0), (1.0, 0.0, 0.0), atol=1e-6)
    assert np.allclose(slope_at(study, 0, 0.5, 0.4, 0.9, 0.0), (0.0, 0.0, 1.0), atol=1e-6)


@pytest.mark.parametrize("velocity", [(0.0, 0.0, 0.0), (0.5, -1.0, 0.4)])
def test_no_posture_of_many_catches_earlier(velocity):
    place, velocity = hand_of(GOAL), np.array(velocity)
    plan = StraightPlanner().plan(scene(ball(place - 0.2 * velocity, velocity)))
    joints, times = soonest()
    hands = forward_in_space(ARM, joints)[1]
    found = np.inf
    for t in np.linspace(0.0, 1.0, 401):
        away = np.linalg.norm(hands - (place + (t - 0.2) * velocity), axis=1)
        if ((away <= RADIUS + ARM.grasp) & (times <= t)).any():
            found = t
            break
    assert plan.caught and plan.catch_time <= found
    assert plan.catch_time > 0.8 * found  # the samples are dense enough to say something


def test_the_way_is_straight_and_as_fast_as_the_slowest_joint_allows():
    plan = StraightPlanner().plan(scene(ball(hand_of(GOAL))))
    rates = np.diff(plan.trajectory.joints, axis=0) / np.diff(plan.trajectory.time)[:, None]
    assert np.abs(rates / ARM.max_joint_speed).max() == pytest.approx(1.0, abs=1e-3)
    along = plan.trajectory.joints - ARM.joints
    assert np.linalg.matrix_rank(along, tol=1e-9) == 1


def test_the_limit_of_the_hand_holds_all_the_way():
    slow = replace(ARM, max_hand_speed=2.0)
    free, kept = (StraightPlanner().plan(scene(ball(hand_of(GOAL)), arm=a)) for a in (ARM, slow))
    times = np.linspace(0.0, kept.catch_time, 2000)
    speeds = np.linalg.norm(np.diff(kept.trajectory.hand_at(times), axis=0), axis=1)
    assert kept.catch_time > 1.1 * free.catch_time
    assert 1.8 < speeds.max() / (times[1] - times[0]) <= 2.0 * (1.0 + 1e-6)


def test_long_solids_are_met_where_they_are_near():
    far = flying("target", records.Box((0.05, 5.0, 0.05)), hand_of(GOAL) + (0.0, 4.9, 0.0))
    plan = StraightPlanner().plan(scene(far))
    assert plan.caught and plan.catch_time < 0.5


def test_a_pendulum_is_met():
    pivot, axis, down = hand_of(GOAL) + (0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (0.0, 0.0, -1.0)
    swing = records.Pendulum(tuple(pivot), axis, down, 1.0, 9.81, 0.6, 0.0)
    plan = StraightPlanner().plan(
        scene(records.Body("target", "ball", records.Sphere(RADIUS), swing))
    )
    assert plan.caught


def test_who_is_near_waits_for_nothing():
    plan = StraightPlanner().plan(scene(ball(hand_of(ARM.joints))))
    assert plan.catch_time == 0.0 and plan.trajectory.time.size == 1


def test_out_of_time():
    plan = StraightPlanner().plan(scene(ball(hand_of(GOAL)), horizon=0.05))
    assert plan.status == "unreachable"


def test_straight_wait_waits_for_the_gate():
    still = ball(hand_of(GOAL))
    lid = flying("obstacle", records.Sphere(0.35), hand_of(GOAL), (0.0, 1.2, 0.0))
    assert not StraightPlanner().plan(scene(still, lid)).caught
    plan = StraightWaitPlanner().plan(scene(still, lid))
    opens = (0.35 - RADIUS - ARM.grasp + ARM.thickness) / 1.2
    assert plan.caught and plan.catch_time > opens


def test_most_of_the_examples():
    drawn = [s for s in records.read_situations(EXAMPLES) if s.arm.max_joint_acceleration is None]
    plans = [[p.plan(s) for p in (StraightPlanner(), StraightWaitPlanner())] for s in drawn]
    assert all(b.catch_time == a.catch_time for a, b in plans if a.caught)
    for situation, pair in zip(drawn, plans, strict=True):
        for plan in (p for p in pair if p.caught):
            assert judge(situation, plan) == []
    assert sum(a.caught for a, _ in plans) >= 22
    assert sum(b.caught for _, b in plans) >= 30


@pytest.mark.parametrize("span", [0.0, np.spacing(0.5), 1e-12, 1e-6])
def test_legs_that_take_hardly_any_time_are_still_in_order(span):
    """A leg is told in pieces where the hand's speed limits it; their times must not be equal."""
    problem = JointProblem(scene(ball((0.5, 0.5, 9.0)), arm=replace(ARM, max_hand_speed=2.0)), "x")
    study = study_of(problem.scene, problem.rules)
    joints = np.array([ARM.joints, GOAL, ARM.joints, GOAL])
    assert time_of(study, joints[0], joints[1])[1] > 1
    time = np.array([0.0, 0.5, 0.5 + span, 0.9])
    moves = attempt_along(problem, study, time, joints, 0).trajectory
    assert (np.diff(moves.time) > 0.0).all()
    assert moves.duration == 0.9
