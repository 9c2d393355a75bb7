"""Arms in space: what they check of themselves, and their exchange format."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gcm_learn.arms import Base, SpatialArm
from gcm_learn.errors import ArmKindError, FileFormatError, SituationError
from gcm_learn.situation import (
    Body,
    Plane,
    Situation,
    SolidQuadratic,
    Sphere,
    planar,
    read_situations,
    situation_from_json,
    situation_to_json,
    write_situations,
)
from tests import strategies
from tests.situation.scenes import GONE, MOVING, NAO, PLANAR, changed, refusal
from tests.situation.scenes import SOLID as IN_PLANE


@pytest.fixture
def in_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_example_of_the_contract_means_what_it_says():
    arm = situation_from_json(NAO).arm
    assert arm == SpatialArm(
        upper_arm=(0.105, 0.015, 0),
        forearm=(0.1137, 0, -0.01231),
        joints=(1.4, 0.2, -1.2, -0.6),
        joint_range=NAO["arm"]["joint_range"],
        max_joint_speed=(8.268, 7.194, 8.268, 7.194),
        grasp=0.015,
        base=Base((0, 0.098, 0.43)),
        max_hand_speed=2.0,
        thickness=0.025,
    )
    assert arm.kind == "spatial" and arm.joint_rates is None
    assert (
        arm.inner_reach < arm.reach == pytest.approx(math.hypot(0.105, 0.015) + 0.114364, abs=1e-6)
    )


def test_what_may_be_left_out():
    scene = changed(NAO, ("arm", "base"), GONE)
    scene = changed(changed(scene, ("arm", "thickness"), GONE), ("arm", "max_hand_speed"), GONE)
    arm = situation_from_json(scene).arm
    assert (arm.base, arm.thickness, arm.max_hand_speed) == (Base(), 0.0, None)
    assert arm.base == Base((0, 0, 0), (1, 0, 0, 0))
    assert situation_from_json(changed(NAO, ("arm", "base"), {})).arm.base == Base()
    for part, other in (("origin", "rotation"), ("rotation", "origin")):
        base = situation_from_json(changed(NAO, ("arm", "base", other), GONE)).arm.base
        assert getattr(base, other) == getattr(Base(), other)
        assert list(getattr(base, part)) == NAO["arm"]["base"][part]
    written = situation_to_json(situation_from_json(scene))["arm"]
    assert {"max_hand_speed", "max_joint_acceleration", "joint_rates"}.isdisjoint(written)
    assert written["kind"] == "spatial"


def test_an_arm_with_limits_of_acceleration_rests_unless_it_says_otherwise():
    resting = situation_from_json(changed(MOVING, ("arm", "joint_rates"), GONE))
    assert resting.arm.joint_rates == (0.0, 0.0, 0.0, 0.0)
    zeros = situation_from_json(changed(MOVING, ("arm", "joint_rates"), [0, 0, 0, 0]))
    assert resting == zeros
    assert situation_from_json(MOVING).arm.joint_rates == (0.0, -1.0, 8.268, 0.0)


def test_ends_of_ranges_are_within_them():
    held = changed(NAO, ("arm", "joint_range"), [[a, a] for a in NAO["arm"]["joints"]])
    assert situation_from_json(held).arm.joints == (1.4, 0.2, -1.2, -0.6)


@given(st.floats(-9e-7, 9e-7), strategies.unit_vectors(4))
def test_rotations_are_normalised_once_and_for_all(off, rotation):
    base = Base(rotation=tuple((1.0 + off) * part for part in rotation))
    assert math.hypot(*base.rotation) == pytest.approx(1.0, abs=1e-15)
    assert Base(rotation=base.rotation) == base
    np.testing.assert_allclose(base.rotation, rotation, atol=1e-15)


def test_one_file_may_hold_both(in_folder):
    scenes = [situation_from_json(obj) for obj in (PLANAR, NAO, IN_PLANE, MOVING | {"name": "m"})]
    write_situations("both.jsonl", scenes)
    assert read_situations("both.jsonl") == scenes
    lines = (in_folder / "both.jsonl").read_text().splitlines()
    formats = [json.loads(line)["format"][-2:] for line in lines]
    assert formats == ["@1", "@2", "@1", "@2"]
    write_situations("one.json", scenes[1:2])
    assert read_situations("one.json") == scenes[1:2]


def test_pretty_printed_file_gives_the_line_of_the_field(in_folder):
    text = json.dumps(changed(NAO, ("arm", "joints", 2), 3), indent=1)
    (in_folder / "scene.json").write_text(text)
    line = text[: text.index('"joints"')].count("\n") + 1 + 3
    assert refusal("scene.json").startswith(f"scene.json:{line}: arm.joints[2]: 3.0 is outside")


def test_a_field_that_is_given_twice(in_folder):
    text = json.dumps(NAO).replace('"origin":', '"origin": [0, 0, 0], "origin":')
    (in_folder / "scene.jsonl").write_text(text)
    with pytest.raises(FileFormatError) as caught:
        read_situations("scene.jsonl")
    assert str(caught.value) == "scene.jsonl:1: arm.base.origin: is given twice"


def test_records_refuse_what_files_cannot_say():
    arm = situation_from_json(NAO).arm
    ball = Body("target", "b", Sphere(0.1), SolidQuadratic((1, 0, 0), (0, 0, 0), (0, 0, 0)))
    with pytest.raises(SituationError) as caught:
        Situation("s", 1.0, arm, (ball,), Plane((0, 0, 0), (1, 0, 0), (0, 1, 0)))
    assert str(caught.value) == "plane: is for planar arms (the arm is spatial)"
    with pytest.raises(SituationError, match="base: must be a base"):
        SpatialArm((1, 0, 0), (1, 0, 0), (0,) * 4, ((-1, 1),) * 4, (1,) * 4, 0.1, base=(0, 0, 0))
    there = Situation("s", 1.0, arm, (ball,))
    assert there.is_spatial and not there.is_solid


def test_who_takes_planar_arms_only_says_so():
    with pytest.raises(ArmKindError) as caught:
        planar(situation_from_json(NAO), "planner 'gcm'")
    assert str(caught.value) == "planner 'gcm' does not take spatial arms (situation \"nao\")"
    situation = situation_from_json(PLANAR)
    assert planar(situation, "anybody") is situation
