"""Datasets of chains: record@3."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gcm_learn.cli.inspect import report
from gcm_learn.dataset import (
    DatasetSpec,
    FamilyShare,
    Holdout,
    generate,
    make_item,
    read_spec,
    survey,
    verify_dataset,
)
from gcm_learn.dataset import open as open_data
from gcm_learn.dataset.parameters import parameters_of, structure_of, twin_key
from gcm_learn.dataset.record import Record
from gcm_learn.dataset.verifying import _broken_plans
from gcm_learn.errors import SpecError
from gcm_learn.families import draw, family_names
from gcm_learn.situation import canonical

DATA = Path(__file__).parents[2] / "data"
SLOW_BELTS = {"parts": [2, 3], "posts": [0, 1], "directed": 0.0, "pace": [0.05, 0.2]}
SPEC = DatasetSpec(
    "chains",
    7,
    8,
    (
        FamilyShare("conveyor-chain", 2.0, SLOW_BELTS),
        FamilyShare("falling-chain"),
        FamilyShare("other-arm-chain"),
    ),
    ("straight", "search"),
    map="none",
    shard_size=4,
    holdouts=(Holdout("test-others", family="other-arm-chain"),),
)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("chains")
    generate(SPEC, folder, workers=1)
    return folder


def test_records_come_back_as_they_were_made(made):
    records = open_data(made)
    assert len(records) == 8 and records.manifest["schema"] == "gcm-learn/record@3"
    for record in list(records)[::3]:
        fresh = make_item(SPEC, record.index)
        assert record.situation == fresh.situation and record.frame == fresh.frame
        assert record.stratum == fresh.stratum in ("L", "W", "Q", "U")
        assert np.array_equal(record.parameters, fresh.parameters)
        assert record.quantities == fresh.quantities and record.map is None
        assert (record.split == "test-others") == (record.family == "other-arm-chain")
        for name, plan in fresh.plans.items():
            read = record.plans[name]
            assert (read.status, read.catches) == (plan.status, plan.catches)
            if plan.caught:
                assert read.trajectory.joints.shape[1] == 7
                assert np.array_equal(read.trajectory.joints, plan.trajectory.joints)


def test_catches_hold_and_all_of_several_are_checked(made):
    assert verify_dataset(made, 1).faults == 0
    record = next(r for r in open_data(made) if r.plans["search"].on_the_way)
    plan = record.plans["search"]
    (body, time), *others = plan.on_the_way
    for wrong in ((body, 0.5 * time), (record.plans["search"].catch_body, time)):
        worse = replace(plan, on_the_way=(wrong, *others))
        spoiled = Record(SPEC, {"situation": record.situation, "plans": {"search": worse}})
        assert record.stratum != "U" and any(_faults(spoiled))


def _faults(record):
    record.values["stratum"] = "W"
    return list(_broken_plans(record))


def test_the_report_says_which_arms(made):
    lines = list(report(survey(made)))
    assert "  seed 7, chains, no maps" in lines


@pytest.mark.parametrize("name", family_names("chain"))
def test_the_order_of_bodies_does_not_make_another_situation(name):
    situation, _ = canonical(draw(name, 8, 0))
    turned = replace(situation, bodies=situation.bodies[::-1])
    if len(situation.targets) == 1:
        keys = {twin_key(structure_of(s), parameters_of(s)) for s in (situation, turned)}
        assert len(keys) == 1
    other, _ = canonical(draw(name, 8, 1))
    key = twin_key(structure_of(situation), parameters_of(situation))
    assert key != twin_key(structure_of(other), parameters_of(other))


def test_another_arm_is_another_structure():
    words = set()
    for model in ("panda", "ur5", "iiwa14"):
        share = FamilyShare("swarm-chain", config={"arm": {"model": model}})
        words.add(structure_of(share.draw(np.random.default_rng(0), "x")).split("|")[0])
    assert len(words) == 3 and all(word.startswith("chain-") for word in words)


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"map": "wave"}, "map: must be 'none' for chains"),
        ({"planners": ("layered",)}, r"planners\[0\]: 'layered' does not take chains"),
        ({"effort": 0.5}, "effort: is for spatial arms"),
        ({"audit": 0.1}, "audit: the oracle does not take chains"),
        ({"label": "oracle"}, "label: the oracle does not take chains"),
    ],
)
def test_what_is_not_for_chains_is_refused(changes, reason):
    with pytest.raises(SpecError, match=reason):
        replace(SPEC, **changes)


def test_the_specification_that_ships_has_all_families():
    spec = read_spec(DATA / "specs" / "panda.toml")
    assert {share.family for share in spec.families} == set(family_names("chain"))
    assert spec.kind.name == "chain" and spec.planners == ("straight", "search")
