"""Tables of plans in physics, computed from outcomes that are known by hand."""

from __future__ import annotations

import importlib

import pandas as pd
import pytest

from gcm_learn import solve
from gcm_learn.execution import body_for, execute, with_motor_limits
from gcm_learn.families import paper_scene

report = importlib.import_module("experiments.14_body.report")
masses = importlib.import_module("experiments.14_body.masses")


def row(number, way, status, **values):
    """Return the outcome of a situation in a way."""
    known = {"situation": f"gate-{number}", "family": "gate", "body": "nao", "method": way}
    return known | {"status": status, "caught": status == "caught"} | values


def test_plans_are_counted_by_condition():
    rows = [row(k, "kinematic", "", caught=k < 3) for k in range(4)]
    first, *others = report.WAYS
    moved = {"torque": 0.5, "stays": 1, "braked_into": 0}
    rows += [row(0, first, "caught", error_mm=1.0, **moved)]
    rows += [row(1, first, "caught", error_mm=3.0, **(moved | {"stays": 0, "torque": 1.0}))]
    rows += [row(2, first, report.NO_PLAN)]
    rows += [row(3, first, "collided", error_mm=5.0, **(moved | {"braked_into": 1}))]
    rows += [row(k, way, "caught", error_mm=1.0, **moved) for way in others for k in range(4)]
    made = report.table(pd.DataFrame(rows))
    assert (made["situations"], made["kinematic"]) == (4, 3)
    found = made["conditions"][first]
    assert (found["plans"], found["caught"], found["collided"]) == (3, 2, 1)
    assert (found["stays"], found["brakes_into"], found["saturated"]) == (1, 1, 1)
    assert found["keeps_of_kinematic"] == pytest.approx(2 / 3)
    assert found["error_at_the_end_mm"]["nao"] == pytest.approx(
        {"median": 3.0, "95 %": 4.8, "most": 5.0}
    )
    assert found["caught_interval"][0] < 2 / 3 < found["caught_interval"][1]
    for way in others:
        assert made["conditions"][way]["caught_interval"][1] == 1.0


def test_the_controller_of_a_heavy_arm_does_not_know_how_heavy_it_is():
    """It ends farther from its plan than one that does; an arm of known masses ends near it."""
    scene = paper_scene("fig8-space")
    body = body_for(scene.arm)
    situation = with_motor_limits(scene, body)
    plan = solve(situation, "search")
    heavy, known = (
        masses.followed(plan, situation, "heavy"),
        masses.followed(plan, situation, "known"),
    )
    told = execute(plan, situation, masses.heavier(body, masses.OFF))
    at_the_end = 2
    assert heavy.error[at_the_end] > 5.0 * told.error[at_the_end]
    assert known.error == execute(plan, situation).error
