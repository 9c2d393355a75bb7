"""Outcomes of single situations, and what is computed from them."""

from __future__ import annotations

import gzip
import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from experiments import recompute
from experiments.common import outcomes

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
