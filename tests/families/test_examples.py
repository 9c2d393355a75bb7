"""The examples show what they are made to show."""

from __future__ import annotations

import dataclasses

import pytest

from gcm_learn.families.examples import gate_scene
from gcm_learn.planners import solve
from gcm_learn.situation import situation_from_json, situation_to_json


def test_the_gate_is_a_situation_of_the_exchange_format():
    assert situation_from_json(situation_to_json(gate_scene())) == gate_scene()


@pytest.mark.parametrize("planner", ["gcm", "marching", "straight", "straight-wait"])
def test_who_cannot_wait_on_the_way_misses_the_ball(planner):
    assert not solve(gate_scene(), planner).caught


def test_the_hand_waits_for_the_gate_and_for_nothing_else():
    scene = gate_scene()
    plan = solve(scene, "layered")
    assert plan.caught and plan.trajectory is not None
    resting = sum(wait.duration for wait in plan.trajectory.waits())
    assert resting > 0.2
    open_ = solve(dataclasses.replace(scene, bodies=scene.targets), "layered")
    assert open_.trajectory is not None and open_.trajectory.waits() == []
    assert open_.catch_time < plan.catch_time - 0.2
