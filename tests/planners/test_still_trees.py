"""Trees that grow in steps: in joints alone for worlds at rest, and in time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gcm_learn import families
from gcm_learn.motion import Failure
from gcm_learn.planners import TreeSearch
from gcm_learn.planners.completion import JointProblem
from gcm_learn.planners.joints import tree_search
from gcm_learn.planners.joints.moves import time_of
from gcm_learn.planners.joints.still_trees import search_still, straighten, timed
from gcm_learn.planners.joints.timely_trees import search_timely
from gcm_learn.planners.joints.trees import new_trees
from gcm_learn.planners.joints.ways import new_way
from gcm_learn.scene import pose
from gcm_learn.situation import SolidQuadratic
from tests.judging import judge

REST = (0.0, 0.0, 0.0)
REACHED, SHUT_IN = (5, 7), 8  # of the draws at rest


def drawn(index):
    """Return a Panda among many obstacles, without limits of acceleration."""
    situation = families.draw("panda-crowded", 7, index)
    arm = replace(situation.arm, max_joint_acceleration=None, joint_rates=None)
    return replace(situation, arm=arm)


def at_rest(index):
    """Return a drawn situation in which bodies stay where they are in the middle of it."""
    situation = drawn(index)
    bodies = []
    for k, body in enumerate(situation.bodies):
        place, _ = pose(situation, k, 0.5 * situation.horizon)
        bodies.append(replace(body, motion=SolidQuadratic(tuple(place.tolist()), REST, REST)))
    return replace(situation, bodies=tuple(bodies))


def met(situation, seed, search):
    """Return the problem, its trees, and the first way that they find."""
    problem = JointProblem(situation, "search")
    study, way = problem.study, new_way(problem.study.goal.size)
    trees = new_trees(study, 4000, seed, False)
    assert search(study, trees, 4000, situation.horizon, way)
    return problem, trees, way


def test_no_tree_in_time_is_grown_in_a_world_at_rest(monkeypatch):
    monkeypatch.setattr(tree_search, "search_trees", None)
    for index in REACHED:
        situation = at_rest(index)
        plan = TreeSearch().plan(situation)
        assert plan.caught and judge(situation, plan) == []
        sooner = TreeSearch().plan(situation, bound=0.98 * plan.catch_time)
        assert not sooner.caught or sooner.catch_time <= 0.98 * plan.catch_time


@pytest.mark.parametrize("index", REACHED)
def test_a_way_is_straightened_without_becoming_longer(index):
    problem, _, way = met(at_rest(index), 1, search_still)
    still = problem.study
    before, ends = timed(still, way), way.joints[[0, way.size[0] - 1]].copy()
    straighten(still, way)
    assert timed(still, way) <= before + 0.1 * before
    assert np.array_equal(way.joints[[0, way.size[0] - 1]], ends)


def test_steps_in_time_make_a_way_that_keeps_its_promise():
    situation = drawn(3)
    for seed in range(1, 5):
        problem, trees, way = met(situation, seed, search_timely)
        n = way.size[0]
        assert way.reached[0] == 0.0 and way.left[n - 1] <= situation.horizon
        for k in range(n - 1):
            least = time_of(problem.study, way.joints[k], way.joints[k + 1])[0]
            assert way.left[k] >= way.reached[k]
            assert way.reached[k + 1] - way.left[k] >= least * (1.0 - 1e-9)
        plan = tree_search._finished(problem, trees.moves, way, situation.horizon)
        assert plan is not None and judge(situation, plan) == []


def test_the_limit_of_work_ends_a_search_that_has_no_goal():
    plan = TreeSearch().plan(at_rest(SHUT_IN))
    assert plan.failure is Failure.OUT_OF_WORK and plan.nodes == 0
