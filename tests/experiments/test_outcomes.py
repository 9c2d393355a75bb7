"""Outcomes of single situations, and what is computed from them."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import pytest

from experiments import recompute

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
