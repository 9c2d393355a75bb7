"""How records of spatial arms are made: budgets, strata, limits of acceleration, splits, twins."""

from dataclasses import replace

import numpy as np
import pytest

from gcm_learn import dataset
from gcm_learn.dataset import open as open_data
from gcm_learn.dataset.item import case_of
from gcm_learn.families import draw, family_names
from gcm_learn.planners import get_planner, yardstick
from gcm_learn.situation import Sphere, canonical
from tests.dataset.conftest import SPACE
from tests.planners.test_joint_straight import GOAL, ball, flying, hand_of, scene
from tests.planners.test_joint_trees import POST

LIMITS = {"arm": {"ramp": [0.04, 0.1], "moving": 0.5}}
HURRIED = replace(
    SPACE, name="hurried", count=8, planners=("search",), effort=0.25, shard_size=8,
    families=tuple(dataset.FamilyShare(n, config=LIMITS) for n in ("tray-space", "door-space")),
)  # fmt: skip


def case(situation, **changes):
    return case_of(situation, replace(SPACE, **changes))


def test_old_specifications_keep_their_digest():
    assert "effort" not in dataset.spec_to_json(SPACE)
    assert replace(SPACE, effort=0.5).digest != SPACE.digest


def test_who_may_not_search_goes_straight_or_gives_up():
    caught = {0.0: 0, 1.0: 0}
    for k in range(12):
        situation, _ = canonical(draw("window-space", 3, k))
        for effort in caught:
            caught[effort] += case(situation, effort=effort).plan("search").caught
        whole = get_planner("search").plan(situation)
        assert case(situation, effort=1.0).plan("search").catch_time == whole.catch_time
    assert 0 < caught[0.0] < caught[1.0]


LID = flying("obstacle", Sphere(0.35), hand_of(GOAL), (0.0, 1.2, 0.0))


@pytest.mark.slow  # compiles the oracle for spatial arms
@pytest.mark.parametrize(
    "bodies", [(), (POST,), (LID,), (flying("obstacle", Sphere(0.7), hand_of(GOAL)),)]
)
def test_strata_are_those_of_the_yardstick(bodies):
    situation = scene(ball(hand_of(GOAL)), *bodies)
    assert case(situation).verdict() == yardstick(situation, 200.0, earliest=False).stratum


@pytest.mark.slow
def test_what_the_yardstick_says_is_the_same_twice():
    first, second = (dataset.make_item(replace(SPACE, audit=1.0), 1).oracle for _ in range(2))
    assert first == second and first.stratum in "LWQU" and first.lower <= first.upper
    situation = dataset.make_item(SPACE, 1).situation
    assert "st-rrt-star" not in yardstick(situation, 0.0).plans
    labelled = dataset.make_item(replace(SPACE, label="oracle"), 1)
    assert labelled.error is None and labelled.oracle == first


@pytest.fixture(scope="module")
def hurried(tmp_path_factory):
    folder = tmp_path_factory.mktemp("hurried")
    dataset.generate(HURRIED, folder, workers=1)
    return open_data(folder)


def test_catches_under_limits_of_acceleration_are_kept_whole(hurried):
    caught = [record for record in hurried if record.stratum != "U"]
    assert len(hurried) == 8 and len(caught) >= 3
    for record in caught:
        arm, plan = record.situation.arm, record.plans["search"]
        assert record.structure.startswith("space+hand+acceleration")
        assert any(arm.joint_rates) and np.allclose(plan.trajectory.rates[0], arm.joint_rates)
        assert (record.stratum == "Q") == plan.trajectory.rests and record.stratum != "L"
    assert dataset.verify_dataset(hurried.folder.url, 1).faults == 0


def test_who_keeps_no_such_limits_says_so():
    record = dataset.make_item(replace(HURRIED, planners=("straight", "search")), 0)
    assert record.error is None and "acceleration" in record.plans["straight"].message


def test_arms_are_many_and_some_are_held_out():
    config = {"arm": {"human": 0.2, "nao": 0.2}}
    families = tuple(dataset.FamilyShare(name, config=config) for name in family_names("spatial"))
    long = dataset.Holdout("test-arms", quantity="upper_arm", above=1.1)
    spec, arms = replace(SPACE, families=families, planners=("straight",), holdouts=(long,)), {}
    for k in range(60):
        record = dataset.make_item(spec, k)
        ratio = record.quantities["upper_arm"]
        assert (record.split == "test-arms") == (ratio > 1.1)
        arms.setdefault(record.split, set()).add(ratio)
    assert len(arms["train"]) > 20 and max(arms["train"]) <= 1.1 < min(arms["test-arms"])
