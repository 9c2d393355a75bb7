"""Item k: a pure function of the specification and k, whatever happens on the way."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from gcm_learn import dataset
from gcm_learn.dataset import item as items
from gcm_learn.dataset.folder import Folder
from gcm_learn.dataset.item import case_of, make_item, parameters_of, structure_of, twin_key
from gcm_learn.dataset.shards import make_shard, shard_name
from gcm_learn.dataset.splits import Split
from gcm_learn.errors import SituationError
from gcm_learn.families import random_planar
from gcm_learn.families.random_solid import random_solid
from gcm_learn.planners import get_planner
from gcm_learn.seeding import rng
from gcm_learn.situation.canonical import canonical
from tests.dataset.conftest import make_here
from tests.transforms import mirrored, turned


def content(folder: str, shard: int = 0) -> bytes:
    return Folder(folder).read(shard_name(shard))


def test_a_shard_has_the_same_bytes_whatever_was_made_before(small, tmp_path):
    for name in "ab":
        Folder(tmp_path / name).make()
    make_shard(small, 2, str(tmp_path / "a"))
    make_item(small, 3)
    make_shard(small, 1, str(tmp_path / "b"))
    make_shard(small, 2, str(tmp_path / "b"))
    assert content(tmp_path / "a", 2) == content(tmp_path / "b", 2)
    larger = replace(small, count=1000)
    make_shard(larger, 1, str(tmp_path / "a"))
    assert content(tmp_path / "a", 1) == content(tmp_path / "b", 1)
    make_shard(replace(small, seed=4), 1, str(tmp_path / "a"))
    assert content(tmp_path / "a", 1) != content(tmp_path / "b", 1)


def test_plans_and_labels_are_those_of_the_planners(small):
    spec = replace(small, n=80, rungs=4)
    for k in range(25):
        found = make_item(spec, k)
        assert found.error is None
        answers = {
            name: get_planner(name).plan(found.situation)
            for name in ("straight", "marching", "layered")
        }
        for name, plan in found.plans.items():
            assert (plan.status, plan.catch_time) == (
                answers[name].status,
                answers[name].catch_time,
            )
        caught = [name for name, plan in answers.items() if plan.caught]
        first = {"straight": "L", "marching": "W", "layered": "Q"}
        assert found.stratum == (first[caught[0]] if caught else "U")
        assert not case_of(found.situation, spec).blocked


@pytest.mark.parametrize("wanted", ["L", "W", "U"])
def test_rejection_fills_a_stratum_and_counts_what_it_threw_away(wanted, small):
    spec = replace(small, strata={wanted: 1.0})
    made = [make_item(spec, k) for k in range(6)]
    assert {item.stratum for item in made} == {wanted}
    for item in made:
        assert item.attempts == 1 + item.rejected.total()
        assert wanted not in item.rejected
    assert sum(item.attempts for item in made) > len(made)
    alone = case_of(made[0].situation, small)
    assert alone.verdict() == wanted


def test_a_stratum_that_is_not_found_is_a_failure_not_a_loop(small):
    never = replace(small, strata={"Q": 1.0}, attempts=2)
    item = make_item(never, 1)
    assert item.situation is None and item.attempts == 2
    assert item.error == "no situation of stratum Q in 2 draws"


def test_a_poisoned_item_is_recorded_and_the_others_are_made(small, tmp_path, monkeypatch):
    whole = str(tmp_path / "whole")
    make_here(small, whole)

    def poisoned(situation):
        if situation.name == "small-7":
            raise SituationError("bodies[0]", "is a ghost")
        return canonical(situation)

    monkeypatch.setattr(items, "canonical", poisoned)
    folder = str(tmp_path / "poisoned")
    make_here(small, folder)
    there, here = dataset.open(whole), dataset.open(folder)
    assert len(here) == len(there) - 1 == small.count - 1
    assert 7 not in here.column("index")
    manifest = here.manifest
    assert manifest["failed"] == 1
    assert manifest["errors"] == {"7": "SituationError: bodies[0]: is a ghost"}
    assert content(folder, 1) == content(whole, 1)


@pytest.mark.parametrize("make", [random_planar, random_solid])
def test_twins_have_one_key_and_others_do_not(make):
    keys = set()
    for k in range(10):
        situation = make(rng(11, k))
        form = canonical(situation)[0]
        structure, numbers = structure_of(form), parameters_of(form)
        assert np.isfinite(numbers).all()
        keys.add(twin_key(structure, numbers))
        swapped = replace(form, bodies=form.bodies[::-1])
        assert twin_key(structure_of(swapped), parameters_of(swapped)) in keys
        if make is random_planar:
            twin = canonical(turned(mirrored(situation), 1.3))[0]
            assert twin_key(structure_of(twin), parameters_of(twin)) in keys
    assert len(keys) == 10


def test_the_oracle_labels_what_it_is_asked_to(small):
    audited = replace(small, audit=1.0)
    found = [make_item(audited, k) for k in range(4)]
    for one in found:
        assert one.oracle.lower <= one.oracle.upper
        assert one.oracle.decided
    assert make_item(small, 0).oracle is None
    labelled = make_item(replace(small, label="oracle"), 0)
    assert labelled.stratum == labelled.oracle.stratum == found[0].oracle.stratum


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
