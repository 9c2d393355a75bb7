"""Tables of plans in physics, computed from outcomes that are known by hand."""

from __future__ import annotations

import importlib

import pytest

from experiments.common import outcomes

report = importlib.import_module("experiments.14_body.report")


def row(number, way, status, **values):
    """Return the outcome of a situation in a way."""
    known = {"situation": f"gate-{number}", "family": "gate", "body": "nao", "method": way}
    return known | {"status": status, "caught": status == "caught"} | values


def test_plans_are_counted_by_condition(tmp_path):
    rows = [row(k, "kinematic", "", caught=k < 3) for k in range(4)]
    first, *others = report.WAYS
    moved = {"torque": 0.5, "stays": 1, "braked_into": 0}
    rows += [row(0, first, "caught", error_mm=1.0, **moved)]
    rows += [row(1, first, "caught", error_mm=3.0, **(moved | {"stays": 0, "torque": 1.0}))]
    rows += [row(2, first, report.NO_PLAN)]
    rows += [row(3, first, "collided", error_mm=5.0, **(moved | {"braked_into": 1}))]
    rows += [row(k, way, "caught", error_mm=1.0, **moved) for way in others for k in range(4)]
    outcomes.write(tmp_path / "outcomes.csv.gz", rows)
    made = report.table(outcomes.read(tmp_path / "outcomes.csv.gz"))
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
