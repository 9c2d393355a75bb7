"""Fixtures of the tests of sheets."""

from __future__ import annotations

import pytest

from gcm_learn import seeding
from gcm_learn.evaluation import asking
from tests.evaluation.worlds import three


@pytest.fixture
def rng():
    """Return a generator of its own for every test."""
    return seeding.rng(12)


@pytest.fixture(autouse=True)
def quick_calibration(monkeypatch):
    """Calibrate at once, as on the reference machine."""
    monkeypatch.setattr(asking, "passes", lambda: [60.0] * 5)


@pytest.fixture
def suite(tmp_path):
    """Return a file of a warm-up and three situations."""
    return three(tmp_path / "three.jsonl")
