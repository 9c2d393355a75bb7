"""The comparison of planners under inexact perception."""

from __future__ import annotations

import pytest

from gcm_learn import families
from gcm_learn.cli import main
from gcm_learn.errors import SuiteError
from gcm_learn.evaluation.suites import Entry
from gcm_learn.evaluation.under_noise import compare_under_noise, noise_episodes, under_noise
from gcm_learn.execution import HABITS


@pytest.fixture(scope="module")
def entries():
    """Return planar and spatial situations."""
    names = ("random-planar", "crossing-swarm", "falling-space")
    drawn = [(name, k, families.draw(name, 31, k)) for name in names for k in range(5)]
    return [Entry("made", n, s, name, "Q", 0.5) for n, (name, _, s) in enumerate(drawn)]


def test_rows_are_outcomes_of_the_closed_loop(entries):
    """Catches are lost under noise, and planning anew does not lose more of them."""
    results = compare_under_noise(["layered"], entries, [0.04], workers=1)
    assert len(results) == noise_episodes(["layered"], entries, [0.04]) == 4 * len(entries)
    assert set(results["outcome"].tolist()) <= {"caught", "touched", "late"}
    rows = under_noise(results)
    assert [(row.noise, row.way) for row in rows] == [(0.0, "once"), *((0.04, h) for h in HABITS)]
    assert rows[0].lost == 0.0 < rows[0].caught.value
    for row in rows:
        assert row.lost == pytest.approx(rows[0].caught.value - row.caught.value)
    lost = {row.way: row.lost for row in rows[1:]}
    assert lost["once"] > 0.0 and lost["broken"] <= lost["once"]


def test_refusals(tmp_path, capsys):
    with pytest.raises(SuiteError, match="from 0 to 1 forearms"):
        compare_under_noise(["straight"], [], [2.0])
    pytest.importorskip("gymnasium")
    with pytest.raises(SuiteError, match="'clone' is no planner"):
        compare_under_noise(["clone"], [], [0.1])
    for text, message in (("a", "numbers with commas"), ("-1", "above 0")):
        argv = ["evaluate", "--policies", "straight", "--noise", text, "--out", str(tmp_path)]
        assert main(argv) == 2
        assert message in capsys.readouterr().err
