"""Parts of experiments that decide their results."""

from __future__ import annotations

import pytest

from experiments.common import judging
from experiments.common.masses import OFF, followed, heavier
from gcm_learn import solve
from gcm_learn.execution import body_for, execute, with_motor_limits
from gcm_learn.families import paper_scene
from gcm_learn.referee import Complaint


@pytest.mark.parametrize("words", [[], ["clearance: is off"]])
def test_a_catch_is_broken_if_the_referee_complains_and_is_judged_once(monkeypatch, words):
    asked = []

    def judge(situation, solution):
        asked.append(solution["name"])
        return [Complaint(*word.split(": ")) for word in words]

    monkeypatch.setattr(judging, "judge", judge)
    situation = paper_scene("fig6")
    found, plan = judging.Referee(), solve(situation, "layered")
    assert plan.caught
    for _ in range(2):
        assert found.broken(situation, plan) is bool(words)
    assert judging.complaints(situation, plan) == words and len(asked) == 2


def test_the_controller_of_a_heavy_arm_does_not_know_how_heavy_it_is():
    """It ends farther from its plan than one that does; an arm of known masses ends near it."""
    scene = paper_scene("fig8-space")
    body = body_for(scene.arm)
    situation = with_motor_limits(scene, body)
    plan = solve(situation, "layered")
    heavy, known = followed(plan, situation, "heavy"), followed(plan, situation, "known")
    told = execute(plan, situation, heavier(body, OFF))
    at_the_end = 2
    assert heavy.error[at_the_end] > 5.0 * told.error[at_the_end]
    assert known.error == execute(plan, situation).error
