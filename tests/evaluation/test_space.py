"""Comparisons in space: planners on suites of spatial arms."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from gcm_learn.cli import main
from gcm_learn.errors import ArmKindError
from gcm_learn.evaluation import compare, draw_suite, measured
from gcm_learn.evaluation.kinds import charged, resting
from gcm_learn.evaluation.methods import get_method
from gcm_learn.evaluation.suites import Entry
from gcm_learn.families import draw
from gcm_learn.situation import situation_to_json
from tests.motion.test_joint_verification import ARM, ball, situation

COUNT = 6


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("suites")


@pytest.fixture(scope="module")
def entries(folder):
    return draw_suite("late-target-space", COUNT, folder, 1)


def test_rows_say_what_planners_do(entries):
    results = compare(["straight", "search"], entries, charge=2, workers=1)
    mine = measured(results, "search")
    assert mine.count == COUNT and mine.caught.value > 0.0
    for row in range(len(results)):
        if results["outcome"][row] == "caught":
            assert results["end"][row] > 0.0 and results["length"][row] > 0.0
            assert results["peak_hand"][row] > 0.0 and results["peak_shoulder"][row] > 0.0


def test_what_takes_planar_arms_only_is_refused_before_anything_runs(entries):
    with pytest.raises(ArmKindError, match="policy 'gcm' does not take spatial arms"):
        compare(["straight", "gcm"], entries, workers=1)


def test_a_resting_arm_may_be_touched_or_come_upon():
    still = situation()
    assert resting(still, 0.3) == ""
    bullet = ball("bullet", "obstacle", (1.0, 0.0, -5.0), (0.0, 0.0, 20.0), 0.1)
    assert resting(situation(obstacles=(bullet,)), 0.2) == ""
    assert resting(situation(obstacles=(bullet,)), 0.3) == "touched"
    place = (1.9, 0.4, -5.0)
    coming = replace(still, bodies=(ball("t", "target", place, (0.0, 0.0, 10.0), 0.3),))
    assert resting(coming, 0.6) == "caught"


def test_who_moves_at_the_start_cannot_rest_and_think():
    limited = replace(ARM, max_joint_acceleration=(99.0,) * 4, joint_rates=(0.1, 0.0, 0.0, 0.0))
    assert charged(get_method("search"), situation(limited), 0.02) is None
    rests = replace(ARM, max_joint_acceleration=(99.0,) * 4)
    assert charged(get_method("search"), situation(rests), 0.02) == "caught"


def test_one_command_compares_in_space(folder, entries, tmp_path, capsys):
    out = tmp_path / "page"
    command = ["evaluate", "--policies", "straight,layered", "--suite", "late-target-space"]
    command += ["--count", str(COUNT), "--charge", "1", "--workers", "1"]
    assert main([*command, "--suites", str(folder), "--out", str(out)]) == 0
    assert (out / "report.html").stat().st_size > 10_000
    assert "search" in capsys.readouterr().out


def test_an_entry_of_a_draw_is_compared_like_any_other():
    drawn = draw("window-space", 1, 0)
    entry = Entry("mine", 0, drawn, "window-space", "W", 1.0)
    assert json.dumps(situation_to_json(drawn))
    assert len(compare(["straight"], [entry], charge=0, workers=1)) == 1
