"""Datasets of spatial arms: record@2."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gcm_learn.dataset import DatasetSpec, FamilyShare, generate, make_item, verify_dataset
from gcm_learn.dataset import open as open_data
from gcm_learn.errors import DatasetError, SpecError
from gcm_learn.families import family_names
from gcm_learn.motion import opening, verify
from gcm_learn.planners import SpatialProblem, any_straight, without_waits
from gcm_learn.scene import pack
from gcm_learn.situation import SpatialFrame, canonical

NAMES = ("window-space", "late-target-space", "pendulum-space")
SPEC = DatasetSpec(
    "space",
    7,
    12,
    tuple(FamilyShare(name) for name in NAMES),
    ("straight", "layered"),
    map="none",
    shard_size=4,
)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("space")
    generate(SPEC, folder, workers=1)
    return folder


def test_records_come_back_as_they_were_made(made):
    records = open_data(made)
    assert len(records) == 12 and records.manifest["schema"] == "gcm-learn/record@2"
    for record in list(records)[1::3]:
        fresh = make_item(SPEC, record.index)
        assert record.situation == fresh.situation and record.frame == fresh.frame
        assert record.stratum == fresh.stratum in ("L", "W", "Q", "U")
        assert np.array_equal(record.parameters, fresh.parameters)
        assert record.quantities == fresh.quantities and record.map is None
        for name, plan in fresh.plans.items():
            read = record.plans[name]
            assert (read.status, read.catch_time) == (plan.status, plan.catch_time)
            if plan.caught:
                assert np.array_equal(read.trajectory.joints, plan.trajectory.joints)
                assert np.allclose(read.trajectory.hand, plan.trajectory.hand)


def test_strata_say_what_the_plans_show(made):
    for record in open_data(made):
        straight, layered = record.plans["straight"], record.plans["layered"]
        problem = SpatialProblem(record.situation, "test")
        line = any_straight(problem, 32).caught
        assert (record.stratum == "L") == (straight.caught or line)
        if record.stratum == "U":
            assert not layered.caught
        elif record.stratum != "L":
            hurried = without_waits(problem, layered)
            assert layered.caught and (record.stratum == "W") == (hurried is not None)
            assert hurried is not None or layered.trajectory.rests


def test_catches_hold_and_a_changed_one_does_not(made):
    caught = 0
    for record in open_data(made):
        scene = pack(record.situation)
        names = [body.name for body in record.situation.bodies]
        for plan in record.plans.values():
            if plan.caught:
                caught += 1
                rules, body = opening(scene).rules, names.index(plan.catch_body)
                assert verify(scene, rules, plan.trajectory, body).good
    assert caught > 8
    report = verify_dataset(made, 1)
    assert (report.records, report.plans, report.faults) == (12, caught, 0) and report.remade == 3


def test_the_situation_is_canonical_and_its_frame_leads_back(made):
    for record in open_data(made):
        assert canonical(record.situation)[1] == SpatialFrame()
        assert record.situation.arm.base.origin == (0.0, 0.0, 0.0)
        back = record.frame.original(np.zeros(3))
        assert np.allclose(back, record.base.origin)


def test_parameters_of_one_structure_have_one_length(made):
    lengths = {}
    for record in open_data(made):
        lengths.setdefault(record.structure, set()).add(len(record.parameters))
    assert all(len(found) == 1 for found in lengths.values())
    assert all(structure.startswith("space") for structure in lengths)


def test_the_same_bytes_on_any_number_of_workers(made, tmp_path):
    generate(replace(SPEC, count=8), tmp_path, workers=2)
    shards = sorted((tmp_path / "shards").iterdir())
    assert len(shards) == 2
    for path in shards:
        assert path.read_bytes() == (made / "shards" / path.name).read_bytes()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"map": "wave"}, "map: must be 'none' for spatial arms"),
        ({"planners": ("layered-wave",)}, r"planners\[0\]: 'layered-wave' does not take spatial"),
        (
            {"families": (FamilyShare("gate"), FamilyShare(NAMES[0]))},
            r"families\[1\]: is for spatial arms, and the first one for planar ones",
        ),
    ],
)
def test_what_does_not_go_together_is_refused(changes, message):
    with pytest.raises(SpecError, match=message):
        replace(SPEC, **changes)


def test_there_are_no_maps_to_feed(made):
    records = open_data(made)
    for feed in (records.cache, records.stream):
        with pytest.raises(DatasetError, match="its records hold no maps"):
            feed()


@pytest.mark.parametrize("name", family_names("spatial"))
def test_every_family_has_quantities_in_forearms(name):
    record = make_item(replace(SPEC, families=(FamilyShare(name),)), 0)
    assert record.error is None
    assert 0.3 < record.quantities["upper_arm"] < 3.0
    assert record.quantities["max_hand_speed"] > 0.0 and np.isfinite(record.parameters).all()
