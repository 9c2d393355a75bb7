"""The comparison of planners that see inexactly."""

from __future__ import annotations

import pytest

from gcm_learn.cli import main
from gcm_learn.errors import SuiteError
from gcm_learn.evaluation.blurred import HABITS, blurred, compare_blurred, episodes
from gcm_learn.evaluation.noise import Noise, under_noise
from tests.evaluation.test_contest import made_entries


def test_rows_say_what_becomes_of_the_planner():
    entries = [entry for entry in made_entries(8) if entry.stratum != "U"]
    results = compare_blurred(["straight"], entries, [0.05], workers=1)
    assert len(results) == episodes(["straight"], entries, [0.05]) == 5 * len(entries)
    from gcm_learn.planners import get_planner

    for way, (habit, caution) in HABITS.items():
        mine = results.where((results["noise"] == 0.05) & (results["way"] == way))
        outcomes = under_noise(get_planner("straight"), entries, Noise(0.05, caution), habit)
        assert mine["outcome"].tolist() == outcomes
    rows = blurred(results)
    assert [row.noise for row in rows] == [0.0] + 4 * [0.05] and rows[0].lost == 0.0
    for row in rows:
        assert row.lost == pytest.approx(rows[0].caught.value - row.caught.value)


def test_what_cannot_be_asked(tmp_path, capsys):
    with pytest.raises(SuiteError, match="from 0 to 1 forearms"):
        compare_blurred(["straight"], [], [2.0])
    pytest.importorskip("gymnasium")
    with pytest.raises(SuiteError, match="'clone' is no planner"):
        compare_blurred(["clone"], [], [0.1])
    for text, message in (("a", "numbers with commas"), ("-1", "above 0")):
        argv = ["evaluate", "--policies", "straight", "--noise", text, "--out", str(tmp_path)]
        assert main(argv) == 2
        assert message in capsys.readouterr().err
