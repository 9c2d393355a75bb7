"""Marching plans for spatial arms: what it claims holds, and its map tells the same."""

from __future__ import annotations

import pytest

from gcm_learn import solve
from gcm_learn.families import paper_scene
from gcm_learn.planners.joints.marching import FrontInSpace
from gcm_learn.situation import read_situations
from gcm_learn.wave import MarchingParams
from tests.judging import judge
from tests.spatial import EXAMPLES

SITUATIONS = read_situations(EXAMPLES)
pytestmark = pytest.mark.slow  # compiles a march for spatial arms


@pytest.mark.parametrize("first", range(0, 50, 10))
def test_catches_hold_and_are_frequent(first):
    caught = 0
    for situation in SITUATIONS[first : first + 10]:
        plan = solve(situation, "marching")
        assert plan.status != "start_blocked"
        if plan.caught:
            caught += 1
            assert judge(situation, plan) == []
    assert caught >= 5


def test_a_plan_shows_the_map_that_it_came_from():
    plan = solve(SITUATIONS[0], "marching")
    assert plan.caught and plan.map is not None and plan.map.interception is not None
    assert plan.map.arrival.shape == (40, 40, 40)
    assert plan.catch_body == plan.map.interception.body
    assert plan.catch_time < 2.0 * plan.map.interception.time


def test_more_postures_catch_more():
    levels = [(MarchingParams(n=24, margin=0.0), postures) for postures in (1, 4)]
    one, more = FrontInSpace("one", (levels[0],)), FrontInSpace("more", tuple(levels))
    caught = [[p.plan(s).caught for s in SITUATIONS[:16]] for p in (one, more)]
    assert sum(caught[1]) >= sum(caught[0]) >= 6


@pytest.mark.parametrize("name", ["fig5-space", "fig8-space"])
def test_the_papers_scenes_without_their_plane_are_solved(name):
    situation = paper_scene(name)
    plan = solve(situation, "marching")
    assert plan.caught
    assert judge(situation, plan) == []
    # the obstacle has bent the front
    assert plan.map is not None and plan.map.effective_obstacles.sum() > 100
