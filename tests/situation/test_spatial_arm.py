"""Arms in space: what they check of themselves, and their exchange format."""

from __future__ import annotations

import copy
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
from tests.situation.test_json_format import GONE, PLANAR, changed, refusal
from tests.situation.test_json_format import SOLID as IN_PLANE

BALL = {
    "role": "target",
    "name": "ball",
    "shape": {"kind": "sphere", "radius": 0.03},
    "motion": {
        "kind": "quadratic",
        "position": [0.2, 0.1, 0.4],
        "velocity": [0, 0, 0],
        "acceleration": [0, 0, -9.81],
    },
}
CORD = {
    "role": "obstacle",
    "name": "cord",
    "shape": {"kind": "capsule", "radius": 0.01, "half_length": 0.2},
    "motion": {
        "kind": "pendulum",
        "pivot": [0.3, 0, 1.5],
        "axis": [0, 1, 0],
        "down": [0, 0, -1],
        "length": 1.1,
        "gravity": 9.81,
        "angle": 0.5,
        "rate": 0,
    },
}
NAO = {
    "format": "gcm-learn/situation@2",
    "name": "nao",
    "horizon": 0.9,
    "arm": {
        "kind": "spatial",
        "base": {"origin": [0, 0.098, 0.43], "rotation": [1, 0, 0, 0]},
        "upper_arm": [0.105, 0.015, 0],
        "forearm": [0.1137, 0, -0.01231],
        "joints": [1.4, 0.2, -1.2, -0.6],
        "joint_range": [
            [-2.0857, 2.0857],
            [-0.3142, 1.3265],
            [-2.0857, 2.0857],
            [-1.5446, -0.0349],
        ],
        "max_joint_speed": [8.268, 7.194, 8.268, 7.194],
        "max_hand_speed": 2.0,
        "thickness": 0.025,
        "grasp": 0.015,
    },
    "bodies": [BALL, CORD],
}
MOVING = copy.deepcopy(NAO)
MOVING["arm"] |= {"max_joint_acceleration": [50, 50, 60, 70], "joint_rates": [0, -1, 8.268, 0]}

KNOWN = (
    "known: base, forearm, grasp, joint_range, joint_rates, joints, kind, max_hand_speed,"
    " max_joint_acceleration, max_joint_speed, thickness, upper_arm"
)
NAN, INF = float("nan"), float("inf")
B0, B1 = ("bodies", 0), ("bodies", 1)
REFUSED = [
    # the kind of arm, and what belongs to the other one
    (("arm", "kind"), GONE, "arm.kind: is missing (known: spatial)"),
    (("arm", "kind"), "planar", 'arm.kind: must be one of spatial (got "planar")'),
    (("arm", "kind"), 2, "arm.kind: must be one of spatial (got 2)"),
    (("arm", "kind"), None, "arm.kind: must be one of spatial (got null)"),
    (("arm",), PLANAR["arm"], "arm.kind: is missing (known: spatial)"),
    (("arm",), [1], "arm: must be an object (got a list of 1)"),
    (("arm",), GONE, "arm: is missing"),
    (("arm", "elbow"), "right", f"arm.elbow: is not a known field ({KNOWN})"),
    (("arm", "hand"), [0, 0, 0], f"arm.hand: is not a known field ({KNOWN})"),
    (
        ("plane",),
        IN_PLANE["plane"],
        'plane: is for planar arms ("gcm-learn/situation@2" has none)',
    ),
    (("plane",), None, "plane: must not be null (leave the field out)"),
    (
        ("bodies", 0),
        PLANAR["bodies"][0],
        'bodies[0].shape.kind: "disc" is planar, but the arm is spatial',
    ),
    (
        ("bodies", 1),
        PLANAR["bodies"][1],
        'bodies[1].shape.kind: "polygon" is planar, but the arm is spatial',
    ),
    # what is missing or has the wrong type
    *(
        (("arm", name), GONE, f"arm.{name}: is missing")
        for name in ("upper_arm", "forearm", "joints", "joint_range", "max_joint_speed", "grasp")
    ),
    (("arm", "base"), [0, 0, 0], "arm.base: must be an object (got a list of 3)"),
    (("arm", "base"), None, "arm.base: must not be null (leave the field out)"),
    (("arm", "base", "x"), 1, "arm.base.x: is not a known field (known: origin, rotation)"),
    (("arm", "base", "origin"), [0, 0], "arm.base.origin: must be a list of 3 numbers (got 2)"),
    (("arm", "base", "origin"), "0", 'arm.base.origin: must be a list of 3 numbers (got "0")'),
    (
        ("arm", "base", "rotation"),
        [1, 0, 0],
        "arm.base.rotation: must be a list of 4 numbers (got 3)",
    ),
    (
        ("arm", "base", "rotation"),
        [1.00001, 0, 0, 0],
        "arm.base.rotation: must have length 1 (got 1.00001)",
    ),
    (("arm", "upper_arm"), 1.0, "arm.upper_arm: must be a list of 3 numbers (got 1.0)"),
    (("arm", "joints"), [1.4, 0.2], "arm.joints: must be a list of 4 numbers (got 2)"),
    (("arm", "joints", 1), "0", 'arm.joints[1]: must be a number (got "0")'),
    (("arm", "joints", 1), True, "arm.joints[1]: must be a number (got true)"),
    (("arm", "joint_range"), [[-3, 3]] * 3, "arm.joint_range: must be a list of 4 pairs (got 3)"),
    (("arm", "joint_range"), 3, "arm.joint_range: must be a list of 4 pairs (got 3)"),
    (
        ("arm", "joint_range", 2),
        [-3, 0, 3],
        "arm.joint_range[2]: must be a list of 2 numbers (got 3)",
    ),
    (("arm", "joint_range", 2, 1), None, "arm.joint_range[2][1]: must be a number (got null)"),
    (
        ("arm", "max_joint_speed"),
        [1, 1],
        "arm.max_joint_speed: must be a list of 4 numbers (got 2)",
    ),
    (("arm", "max_hand_speed"), None, "arm.max_hand_speed: must not be null (leave the field out)"),
    # NaN, infinity, sizes
    (("arm", "joints", 0), NAN, "arm.joints[0]: must be finite (got nan)"),
    (("arm", "joint_range", 0, 1), INF, "arm.joint_range[0][1]: must be finite (got inf)"),
    (("arm", "base", "rotation", 0), NAN, "arm.base.rotation[0]: must be finite (got nan)"),
    (("arm", "forearm", 2), -INF, "arm.forearm[2]: must be finite (got -inf)"),
    (("arm", "upper_arm"), [0, 0, 0], "arm.upper_arm: must not have length 0"),
    (("arm", "forearm"), [0.0, -0.0, 0], "arm.forearm: must not have length 0"),
    (("arm", "max_joint_speed", 3), 0, "arm.max_joint_speed[3]: must be positive (got 0.0)"),
    (("arm", "max_hand_speed"), -1, "arm.max_hand_speed: must be positive (got -1.0)"),
    (("arm", "thickness"), -0.1, "arm.thickness: must not be negative (got -0.1)"),
    (("arm", "grasp"), -0.1, "arm.grasp: must not be negative (got -0.1)"),
    (("horizon",), 0, "horizon: must be positive (got 0.0)"),
    # ranges and limits
    (("arm", "joint_range", 1), [0.5, 0.4], "arm.joint_range[1]: low 0.5 is above high 0.4"),
    (("arm", "joints", 3), 0, "arm.joints[3]: 0.0 is outside its range [-1.5446, -0.0349]"),
    (
        ("arm", "joints", 0),
        1.4 + 2 * math.pi,
        f"arm.joints[0]: {1.4 + 2 * math.pi} is outside its range [-2.0857, 2.0857]",
    ),
    (
        ("arm", "joint_rates"),
        [0, 0, 0, 0],
        "arm.joint_rates: are given without max_joint_acceleration",
    ),
    (
        ("arm", "max_joint_acceleration"),
        [1, 1, 0, 1],
        "arm.max_joint_acceleration[2]: must be positive (got 0.0)",
    ),
    # bodies, as in a 3D scene of @1
    (
        (*B1, "motion", "down"),
        [0, 1, 0],
        "bodies[1].motion.down: must be orthogonal to axis (dot product 1)",
    ),
    (
        (*B1, "motion", "down"),
        [0, 0.00001, -1],
        "bodies[1].motion.down: must be orthogonal to axis (dot product 1e-05)",
    ),
    ((*B0, "role"), "obstacle", "bodies: no target among 2 bodies"),
    ((*B1, "name"), "ball", 'bodies[1].name: "ball" is already the name of bodies[0]'),
]
REFUSED_MOVING = [
    (
        ("arm", "joint_rates", 1),
        -7.2,
        "arm.joint_rates[1]: -7.2 is too fast (max 7.194)",
    ),
    (("arm", "joint_rates"), [0], "arm.joint_rates: must be a list of 4 numbers (got 1)"),
    (("arm", "joint_rates", 0), NAN, "arm.joint_rates[0]: must be finite (got nan)"),
    (
        ("arm", "max_joint_acceleration"),
        GONE,
        "arm.joint_rates: are given without max_joint_acceleration",
    ),
    (
        ("arm", "max_joint_acceleration"),
        5,
        "arm.max_joint_acceleration: must be a list of 4 numbers (got 5)",
    ),
]
CASES = [(NAO, *case) for case in REFUSED] + [(MOVING, *case) for case in REFUSED_MOVING]


@pytest.fixture
def in_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    ("scene", "path", "value", "expected"),
    [pytest.param(*case, id=f"{k}-{'.'.join(map(str, case[1]))}") for k, case in enumerate(CASES)],
)
def test_refused_with_line_and_field(in_folder, scene, path, value, expected):
    good = json.dumps(changed(NAO, ("name",), "first"))
    (in_folder / "scene.jsonl").write_text(f"{good}\n{json.dumps(changed(scene, path, value))}\n")
    assert refusal("scene.jsonl") == f"scene.jsonl:2: {expected}"


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
