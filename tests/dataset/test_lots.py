"""Lots of a dataset: what is decided by one says nothing of what is decided by another."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import pytest

from gcm_learn.dataset import item as items
from gcm_learn.dataset.item import make_item
from gcm_learn.dataset.splits import Split


class Quick:
    """A case that answers at once; only what a lot decides is of interest."""

    def __init__(self, case):
        self.situation, self.problem = case.situation, case.problem

    def verdict(self, wanted):
        return "L"

    def plan(self, name):
        raise AssertionError("no planner was asked for")

    def map(self):
        return None

    def oracle(self):
        return "labelled"


@pytest.fixture
def made(small, monkeypatch):
    """Return items of which a half is audited, and a half is for tests, all by lot."""
    case_of = items.case_of
    monkeypatch.setattr(items, "case_of", lambda situation, spec: Quick(case_of(situation, spec)))
    spec = replace(small, planners=(), map="none", audit=0.5, split=Split(0.2, 0.5), count=400)
    return [make_item(spec, k) for k in range(120)]


def test_audited_items_are_of_all_splits(made):
    assert not any(item.error for item in made)
    counts = Counter((item.split, item.oracle is not None) for item in made)
    assert set(counts) == {(s, a) for s in ("train", "validation", "test") for a in (True, False)}
    for audited in (True, False):
        assert 18 < counts["test", audited] < 42, "a quarter of 120, within three deviations"


def test_as_many_are_audited_as_asked_for(made):
    assert 44 <= sum(item.oracle is not None for item in made) <= 76
    assert 44 <= sum(item.split == "test" for item in made) <= 76
