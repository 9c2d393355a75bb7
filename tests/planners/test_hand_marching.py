"""Marching in space: what it catches, what it shows, what it refuses."""

from __future__ import annotations

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
import pytest

from gcm_learn import solve
from gcm_learn.families import paper_scene
from gcm_learn.planners.joints.marching import HandMarching
from gcm_learn.plots import plan_figure
from gcm_learn.situation import read_situations, situation_from_json
from tests.chains import COUNT, drawn
from tests.judging import judge
from tests.spatial import EXAMPLES

pytestmark = pytest.mark.slow  # compiles a march for chains


@pytest.fixture(scope="module")
def caught():
    """A situation and a plan of `marching`."""
    for k in range(COUNT):
        situation = situation_from_json(drawn("panda", k))
        plan = solve(situation, "marching")
        if plan.caught and plan.map is not None:
            return situation, plan
    raise AssertionError("no map of a Panda led to a catch")


def test_a_plan_shows_the_map_that_it_came_from(caught):
    _, plan = caught
    assert plan.map.engine == "marching" and plan.map.interception is not None
    assert plan.catch_body == plan.map.interception.body
    assert plan.map.effective_target[plan.map.interception.cell]


def test_the_map_is_drawn_beside_the_movement(caught):
    situation, plan = caught
    figure = plan_figure(situation, plan)
    figure.canvas.draw()
    map_panel = figure.axes[2]
    assert "cognitive map" in map_panel.get_title()
    image = np.asarray(map_panel.images[0].get_array())
    white = (image[..., :3] > 0.97).all(axis=-1)
    assert 0.02 < 1.0 - white.mean() < 0.98
    plt.close(figure)


def test_limits_of_acceleration_are_refused_in_one_line(caught):
    situation, _ = caught
    arm = replace(situation.arm, max_joint_acceleration=(10.0,) * situation.arm.dof)
    plan = solve(replace(situation, arm=arm), "marching")
    assert plan.status == "unreachable"
    assert plan.message == "accelerations are limited, which this planner cannot keep"


def test_more_lattices_catch_more():
    situations = [situation_from_json(drawn("panda", k)) for k in range(COUNT)]
    planner, one = HandMarching(), HandMarching((16,))
    first = {s.name for s in situations if one.plan(s).caught}
    assert first <= {s.name for s in situations if planner.plan(s).caught}
    assert len(first) >= 3


@pytest.mark.parametrize("name", ["fig5-space", "fig8-space"])
def test_the_papers_scenes_without_their_plane_are_solved(name):
    situation = paper_scene(name)
    plan = solve(situation, "marching")
    assert plan.caught and judge(situation, plan) == []
    # the obstacle has bent the front
    assert plan.map is not None and plan.map.effective_obstacles.sum() > 20


@pytest.mark.slow  # fifty situations
def test_catches_of_spatial_arms_hold_and_are_frequent():
    caught = 0
    for situation in read_situations(EXAMPLES):
        plan = solve(situation, "marching")
        if plan.caught:
            caught += 1
            assert judge(situation, plan) == []
    assert caught >= 20
