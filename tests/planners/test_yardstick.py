"""The yardstick in space: what all methods catch, and what is ruled out for certain."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from gcm_learn.motion import Failure
from gcm_learn.planners import stratum, yardstick
from gcm_learn.planners.baselines.potential import PotentialPlanner
from gcm_learn.planners.baselines.straight import StraightPlanner, StraightWaitPlanner
from gcm_learn.planners.completion import JointProblem
from gcm_learn.planners.joints.moves import study_of
from gcm_learn.planners.oracle.bounds import OraclePlanner
from gcm_learn.planners.oracle.posture_boxes import earliest_possible
from gcm_learn.situation import Box, Sphere, read_situations
from tests.judging import judge
from tests.planners.test_joint_straight import ARM, GOAL, ball, flying, hand_of, scene
from tests.planners.test_joint_trees import POST
from tests.spatial import EXAMPLES

pytestmark = pytest.mark.slow  # compiles the oracle and the field for spatial arms

LID = flying("obstacle", Sphere(0.35), hand_of(GOAL), (0.0, 1.2, 0.0))


def lower(situation):
    problem = JointProblem(situation, "test")
    return earliest_possible(study_of(problem.scene, problem.rules))


# --- what is ruled out ------------------------------------------------------------------------


def test_the_joints_need_their_time():
    free = scene(ball(hand_of(GOAL)))
    plan = StraightPlanner().plan(free)
    assert 0.6 * plan.catch_time < lower(free) <= plan.catch_time
    assert math.isinf(lower(replace(free, horizon=0.5 * plan.catch_time)))


def test_the_hand_needs_its_time():
    slow = scene(ball(hand_of(GOAL)), arm=replace(ARM, max_hand_speed=1.0), horizon=3.0)
    way = np.linalg.norm(hand_of(GOAL) - hand_of(ARM.joints)) - 0.15
    assert lower(slow) == pytest.approx(way, abs=2 * 3.0 / 32)
    assert lower(slow) <= way


def test_a_target_in_an_obstacle_is_ruled_out_until_it_is_bare():
    inside = Sphere(0.7)  # so large that no hand within grasp of the target is outside
    buried = scene(ball(hand_of(GOAL)), flying("obstacle", inside, hand_of(GOAL)))
    assert math.isinf(lower(buried))
    leaves = flying("obstacle", inside, hand_of(GOAL), (0.0, 4.0, 0.0))
    found = lower(scene(ball(hand_of(GOAL)), leaves))
    assert 0.05 < found <= (0.7 + 0.05 + 0.15) / 4.0


def test_a_thin_board_rules_nothing_out():
    board = flying("obstacle", Box((0.01, 0.5, 0.5)), hand_of(GOAL) - (0.3, 0.0, 0.0))
    assert math.isfinite(lower(scene(ball(hand_of(GOAL)), board)))


def test_nothing_is_caught_before():
    for situation in read_situations(EXAMPLES):
        plan = StraightWaitPlanner().plan(situation)
        if plan.caught:
            assert lower(situation) <= plan.catch_time, situation.name


# --- strata -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("bodies", "expected"),
    [
        ((), "L"),
        ((POST,), "LW"),
        ((LID,), "LWQ"),
        ((flying("obstacle", Sphere(0.7), hand_of(GOAL)),), "U"),
    ],
)
def test_strata(bodies, expected):
    situation = scene(ball(hand_of(GOAL)), *bodies)
    known = yardstick(situation, 200.0, earliest=False)
    assert known.stratum in expected and stratum(situation, known) == known.stratum
    assert known.decided and (known.lower <= known.upper)
    if known.plan.caught:
        assert judge(situation, known.plan) == []


def test_the_oracle_answers_with_its_best():
    situation = scene(ball(hand_of(GOAL)), POST)
    plan = OraclePlanner(trees_ms=200.0).plan(situation)
    assert plan.planner == "oracle" and plan.caught and judge(situation, plan) == []
    buried = scene(ball(hand_of(GOAL)), flying("obstacle", Sphere(0.7), hand_of(GOAL)))
    assert OraclePlanner().plan(buried).failure is Failure.IMPOSSIBLE


# --- the potential field ----------------------------------------------------------------------


def test_the_field_leads_straight_where_nothing_is():
    free = scene(ball(hand_of(GOAL)))
    plan = PotentialPlanner().plan(free)
    assert plan.caught and judge(free, plan) == []
    assert plan.catch_time <= 1.2 * StraightPlanner().plan(free).catch_time


def test_the_field_follows_a_moving_target():
    moving = scene(ball(hand_of(GOAL) - (0.2, 0.0, 0.0), (0.8, -0.5, 0.3)))
    plan = PotentialPlanner().plan(moving)
    assert plan.caught and judge(moving, plan) == []


def test_the_field_gives_up_where_a_target_is_buried():
    buried = scene(ball(hand_of(GOAL)), flying("obstacle", Sphere(0.3), hand_of(GOAL)))
    assert not PotentialPlanner().plan(buried).caught
