"""How records of spatial arms are made: budgets, strata, limits of acceleration, splits, twins."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gcm_learn import seeding
from gcm_learn.dataset import (
    FamilyShare,
    Holdout,
    generate,
    make_item,
    spec_to_json,
    verify_dataset,
)
from gcm_learn.dataset import open as open_data
from gcm_learn.dataset.item import case_of
from gcm_learn.dataset.parameters import parameters_of, structure_of, twin_key
from gcm_learn.errors import SpecError
from gcm_learn.families import draw, family_names
from gcm_learn.planners import get_planner, yardstick
from gcm_learn.situation import Sphere, canonical
from tests.dataset.conftest import SMALL
from tests.dataset.test_space import SPEC
from tests.planners.test_joint_straight import GOAL, ball, flying, hand_of, scene
from tests.planners.test_joint_trees import POST
from tests.situation.test_spatial_frame import MIRROR, moved

LIMITS = {"arm": {"ramp": [0.04, 0.1], "moving": 0.5}}
HURRIED = replace(
    SPEC,
    name="hurried",
    count=8,
    families=(FamilyShare("tray-space", config=LIMITS), FamilyShare("door-space", config=LIMITS)),
    planners=("layered",),
    effort=0.25,
    shard_size=8,
)


def case(situation, **changes):
    return case_of(situation, replace(SPEC, **changes))


# --- how hard planners try --------------------------------------------------------------------


def test_effort_is_for_space_and_old_specifications_keep_their_digest():
    assert "effort" not in spec_to_json(SPEC)
    assert replace(SPEC, effort=0.5).digest != SPEC.digest
    with pytest.raises(SpecError, match="effort: is for spatial arms"):
        replace(SMALL, effort=0.5)
    with pytest.raises(SpecError, match=r"effort: must be a share, 0 to 1 \(got 2.0\)"):
        replace(SPEC, effort=2.0)


def test_who_may_not_search_goes_straight_or_gives_up():
    caught = {0.0: 0, 1.0: 0}
    for k in range(12):
        situation, _ = canonical(draw("window-space", 3, k))
        for effort in caught:
            caught[effort] += case(situation, effort=effort).plan("layered").caught
        whole = get_planner("layered").plan(situation)
        assert case(situation, effort=1.0).plan("layered").catch_time == whole.catch_time
    assert 0 < caught[0.0] < caught[1.0]


# --- strata -----------------------------------------------------------------------------------


LID = flying("obstacle", Sphere(0.35), hand_of(GOAL), (0.0, 1.2, 0.0))


@pytest.mark.parametrize(
    "bodies", [(), (POST,), (LID,), (flying("obstacle", Sphere(0.7), hand_of(GOAL)),)]
)
def test_strata_are_those_of_the_yardstick(bodies):
    situation = scene(ball(hand_of(GOAL)), *bodies)
    assert case(situation).verdict() == yardstick(situation, 200.0, earliest=False).stratum


def test_what_the_yardstick_says_is_the_same_twice():
    first, second = (make_item(replace(SPEC, audit=1.0), 1).oracle for _ in range(2))
    assert first == second and first.stratum in "LWQU" and first.lower <= first.upper
    situation = make_item(SPEC, 1).situation
    assert "st-rrt-star" not in yardstick(situation, 0.0).plans
    labelled = make_item(replace(SPEC, label="oracle"), 1)
    assert labelled.error is None and labelled.oracle == first


# --- limits of acceleration -------------------------------------------------------------------


@pytest.fixture(scope="module")
def hurried(tmp_path_factory):
    folder = tmp_path_factory.mktemp("hurried")
    generate(HURRIED, folder, workers=1)
    return open_data(folder)


def test_catches_under_limits_of_acceleration_are_kept_whole(hurried):
    caught = [record for record in hurried if record.stratum != "U"]
    assert len(hurried) == 8 and len(caught) >= 3
    for record in caught:
        arm, plan = record.situation.arm, record.plans["layered"]
        assert record.structure.startswith("space+hand+acceleration")
        assert any(arm.joint_rates) and np.allclose(plan.trajectory.rates[0], arm.joint_rates)
        assert (record.stratum == "Q") == plan.trajectory.rests and record.stratum != "L"
    assert verify_dataset(hurried.folder.url, 1).faults == 0


def test_who_keeps_no_such_limits_says_so():
    record = make_item(replace(HURRIED, planners=("straight", "layered")), 0)
    assert record.error is None and "acceleration" in record.plans["straight"].message


# --- splits and twins -------------------------------------------------------------------------


def test_arms_are_many_and_some_are_held_out():
    config = {"arm": {"human": 0.2, "nao": 0.2}}
    spec = replace(
        SPEC,
        families=tuple(FamilyShare(name, config=config) for name in family_names("spatial")),
        planners=("straight",),
        holdouts=(Holdout("test-arms", quantity="upper_arm", above=1.1),),
    )
    arms = {}
    for k in range(60):
        record = make_item(spec, k)
        ratio = record.quantities["upper_arm"]
        assert (record.split == "test-arms") == (ratio > 1.1)
        arms.setdefault(record.split, set()).add(ratio)
    assert len(arms["train"]) > 20 and max(arms["train"]) <= 1.1 < min(arms["test-arms"])


@pytest.mark.parametrize("name", family_names("spatial"))
def test_what_lies_otherwise_is_a_twin(name):
    situation, rng = draw(name, 8, 0), seeding.rng(8)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    keys = set()
    for matrix in (np.eye(3), turn, MIRROR, turn @ MIRROR):
        there, _ = canonical(moved(situation, matrix, rng.normal(size=3)))
        there = replace(there, bodies=there.bodies[::-1])
        keys.add(twin_key(structure_of(there), parameters_of(there)))
    assert len(keys) == 1
    other, _ = canonical(draw(name, 8, 1))
    assert twin_key(structure_of(other), parameters_of(other)) not in keys
