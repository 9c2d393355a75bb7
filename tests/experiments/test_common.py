"""Parts of experiments that decide their results."""

from __future__ import annotations

from experiments.common.masses import OFF, followed, heavier
from gcm_learn import solve
from gcm_learn.execution import body_for, execute, with_motor_limits
from gcm_learn.families import paper_scene


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
