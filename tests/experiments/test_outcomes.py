"""Outcomes of single situations, and what is computed from them."""

from __future__ import annotations

import gzip
import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from experiments import recompute
from experiments.common import comparing, outcomes
from experiments.common.counting import counted
from gcm_learn import families
from gcm_learn.planners import get_planner
from gcm_learn.recall import trials

ROOT = Path(__file__).parents[2]
ROW = {"stratum": "W", "family": "gate", "method": "one", "caught": True}


@pytest.mark.parametrize("name", recompute.with_outcomes())
def test_tables_are_those_that_the_outcomes_give(name):
    assert recompute.differing(recompute.HERE / name) == []


def test_a_table_that_is_changed_by_hand_is_found(tmp_path, monkeypatch):
    report = SimpleNamespace(results=lambda folder: {"a.md": "1\n", "b.md": "2\n"})
    monkeypatch.setattr(recompute.importlib, "import_module", lambda name: report)
    (tmp_path / "report.py").write_text("def results(folder): ...")
    recompute.update(tmp_path)
    assert recompute.differing(tmp_path) == []
    (tmp_path / "b.md").write_text("3\n")
    assert recompute.differing(tmp_path) == [tmp_path / "b.md"]
    (tmp_path / "a.md").unlink()
    assert recompute.differing(tmp_path) == [tmp_path / "a.md", tmp_path / "b.md"]


def rows_of(count: int) -> list[dict]:
    return [ROW | {"situation": f"s{k}", "ms": 1.23456, "checks": k} for k in range(count)]


def test_the_same_answers_give_the_same_bytes(tmp_path):
    rows, files = rows_of(5), [tmp_path / "a.csv.gz", tmp_path / "b.csv.gz"]
    outcomes.write(files[0], rows)
    outcomes.write(files[1], reversed(rows))
    assert files[0].read_bytes() == files[1].read_bytes()
    assert gzip.decompress(files[0].read_bytes()).decode().splitlines()[1] == (
        "s0,W,gate,one,,1,,1.235,0,,,"
    )


def test_outcomes_are_read_as_they_were_written(tmp_path):
    file = tmp_path / "a.csv.gz"
    lost = {"situation": 7, "caught": False, "catch_time": math.inf, "split": "test-arms"}
    outcomes.write(file, [ROW | lost, ROW | {"situation": 8, "catch_time": 0.5, "split": "train"}])
    found = outcomes.read(file)
    assert found["situation"].tolist() == ["7", "8"] and found["caught"].tolist() == [False, True]
    assert np.isnan(found["catch_time"][0]) and found["catch_time"][1] == 0.5
    assert found["split"].tolist() == ["test-arms", "train"]
    assert len(found.where(split=("train", "test"))) == 1
    assert len(found.where(found["caught"], split="test-arms")) == 0


def test_rows_are_made_once(tmp_path):
    file = tmp_path / "out" / "one.jsonl"
    assert outcomes.kept(file, lambda: iter(rows_of(2))) == rows_of(2)
    assert outcomes.kept(file, lambda: pytest.fail("made again")) == rows_of(2)


def answers(name: str, caught: str, first: int = 0) -> list[dict]:
    """Return rows of a method: 1 is a catch, 0 is none."""
    return [
        ROW | {"situation": first + k, "method": name, "caught": one == "1", "ms": float(k)}
        for k, one in enumerate(caught)
    ]


def table_of(tmp_path, *rows: list[dict]) -> outcomes.Outcomes:
    outcomes.write(tmp_path / "t.csv.gz", (one for some in rows for one in some))
    return outcomes.read(tmp_path / "t.csv.gz")


def test_pairs_are_tested_exactly_and_corrected_by_hand(tmp_path):
    """Of 20 pairs with 8 to 0 the chance is 2 / 2^8, with 5 to 1 it is 14 / 2^6."""
    found = table_of(
        tmp_path,
        answers("a", "1" * 16 + "0000"),
        answers("b", "0" * 8 + "1" * 8 + "0000"),
        answers("c", "0" * 5 + "1" * 12 + "000"),
    )
    lines = comparing.pairs(found, [("a", "c"), ("a", "b")]).splitlines()[2:]
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    assert cells[0][0] == "a less c" and cells[0][1] == "20"
    assert cells[0][3:] == ["5", "1", f"{14 / 64:.3f}", f"{14 / 64:.3f}"]
    assert cells[1][3:] == ["8", "0", f"{2 / 256:.3f}", f"{4 / 256:.3f}"]
    assert cells[0][2].startswith("+20.0 (") and cells[1][2].startswith("+40.0 (")


def test_pairs_are_of_situations_that_both_answered(tmp_path):
    found = table_of(tmp_path, answers("a", "1111"), answers("b", "0000", first=2))
    one, other = found.by_situation(("a", "b"))
    assert one["situation"].tolist() == other["situation"].tolist() == ["2", "3"]


def test_shares_counts_and_quantiles_by_hand(tmp_path):
    """The score interval of 9 of 10 is 59.6 to 98.2 %, of 200 of 200 it is 98.1 to 100."""
    rows = answers("a", "1111111110")
    rows[0] |= {"complaints": 2, "checks": 3, "looks": 5, "bends": 0}
    rows[1] |= {"complaints": 0, "checks": 1, "looks": 0, "bends": 1}
    found = table_of(tmp_path, rows)
    assert comparing.share(found, 1) == "90.0 (59.6–98.2)"
    assert comparing.share(found.where(method="b")) == ""
    whole = table_of(tmp_path, answers("a", "1" * 200))
    assert comparing.share(whole, 1) == "100.0 (98.1–100.0)"
    assert comparing.complaints(found) == "1 of 9"
    assert comparing.counts(found) == ["2.0", "2.5", "0.5"]
    assert comparing.times(found, (0.5, 1.0)) == ["4.5", "9.0"]


@pytest.mark.slow
@pytest.mark.parametrize("family", ["crossing-swarm", "door-space"])
def test_counting_changes_no_answer(family):
    planner, known = get_planner("recall-random"), trials.first_valid
    for k in range(3):
        situation = families.draw(family, 21, k)
        before = planner.recollect(situation)
        numbers = counted(planner, situation)
        after = planner.recollect(situation)
        assert numbers["checks"] == before.checked == after.checked
        assert before.memory == after.memory
        assert (before.plan.trajectory is None) == (after.plan.trajectory is None)
    assert trials.first_valid is known


def test_looks_and_bends_stay_within_what_is_allowed():
    """The first check has no look, each further one at most five, and each at most five bends."""
    planner, many = get_planner("recall-random"), []
    for k in range(8):
        many.append(counted(planner, families.draw("crossing-swarm", 21, k)))
        checks, looks, bends = (many[-1][name] for name in comparing.COUNTS)
        assert looks <= 5 * (checks - 1) and bends <= 5 * checks
    assert max(one["looks"] for one in many) >= 5 and max(one["bends"] for one in many) >= 2
