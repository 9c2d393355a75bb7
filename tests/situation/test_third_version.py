"""Arms in space and situations of version 3: round trips, the contract's numbers, refusals."""

import copy
import json
import math

import numpy as np
import pytest
from hypothesis import given, strategies as st

from gcm_learn import situation, situation as records
from gcm_learn.arms import Base, Chain, ChainJoint, ChainModel, Hand, Link, SpatialArm, hands_along
from gcm_learn.errors import FileFormatError, SituationError
from gcm_learn.scene import pack
from tests import strategies
from tests.refusals import refusal
from tests.situation.scenes import (
    CHAIN,
    GONE,
    MODEL,
    MOVING,
    NAO,
    OLDER,
    PLANAR,
    REFUSED,
    SOLID,
    changed,
)

HALF = math.sqrt(0.5)
LINK = {"joint": 1, "from": [0, 0, 0], "to": [0.4, 0, 0], "radius": 0.04}


@pytest.mark.parametrize(
    ("path", "expected", "value"),
    [pytest.param(*case[1:3], case[3:]) for case in REFUSED if case[0] == "model"],
)
def test_models_are_refused_with_their_field(path, expected, value):
    assert refusal(SituationError, records.arm_from_json, changed(MODEL, path, *value)) == expected


def test_a_file_of_an_arm_is_refused_with_its_line(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = json.dumps(changed(MODEL, ("links", 1, "radius"), -1), indent=1)
    (tmp_path / "arm.json").write_text(text, encoding="utf-8")
    line = text[: text.index('"radius": -1')].count("\n") + 1
    reason = f"arm.json:{line}: links[1].radius: must be positive (got -1.0)"
    assert refusal(FileFormatError, records.read_arm, "arm.json") == reason
    scene = changed(CHAIN, ("arm", "model"), "arm.json")
    assert refusal(SituationError, records.situation_from_json, scene) == f"arm.model: {reason}"


def test_records_know_what_their_version_has():
    body = records.situation_from_json(CHAIN).bodies[0]
    still = records.Body(
        "target", "ball", records.Sphere(0.1), records.SolidQuadratic(*[(0.0,) * 3] * 3)
    )
    given = {
        "name": "s",
        "horizon": 1.0,
        "arm": records.situation_from_json(OLDER).arm,
        "bodies": (still,),
    }
    second, third, fourth = (f"gcm-learn/situation@{k}" for k in (2, 3, 4))
    assert records.Situation(**given).format == second
    assert records.Situation(**given | {"bodies": (body,)}, format=third).format == third
    for field, value, reason in (
        ("bodies", (body,), f'[0].motion.kind: "piecewise" is not known to {second}'),
        ("catch", "all", f': "all" is not known to {second}'),
        ("format", "@1", f': must be "{second}" or "{third}" or "{fourth}" (got "@1")'),
    ):
        assert (
            refusal(SituationError, records.Situation, **given | {field: value}) == field + reason
        )


def test_vectors_that_are_nearly_of_length_one_are_normalised():
    motion = OLDER["bodies"][0]["motion"] | {"orientation": [1.000005, 0, 0, 0]}
    scene = changed(CHAIN, ("bodies", 1, "motion"), motion)
    scene = changed(scene, ("arm", "base"), {"rotation": [0, 0.999994, 0, 0]})
    situation = records.situation_from_json(scene)
    assert situation.bodies[1].motion.orientation == (1.0, 0.0, 0.0, 0.0)
    assert situation.arm.base.rotation == (0.0, 1.0, 0.0, 0.0)


def test_limits_of_acceleration_come_from_the_model_or_the_situation():
    model = copy.deepcopy(MODEL)
    for joint in model["joints"]:
        joint["max_acceleration"] = 7.0
    scene = changed(CHAIN, ("arm", "model"), model)
    assert records.situation_from_json(scene).arm.max_joint_acceleration == (7.0, 7.0)
    own = records.situation_from_json(changed(scene, ("arm", "max_acceleration"), [1, 2]))
    assert own.arm.max_joint_acceleration == (1.0, 2.0)
    none = records.situation_from_json(changed(scene, ("arm", "max_acceleration"), None))
    assert none.arm.max_joint_acceleration is None
    assert records.situation_from_json(records.situation_to_json(none)) == none


def test_models_are_objects_paths_or_names(tmp_path):
    (tmp_path / "arms").mkdir()
    (tmp_path / "arms" / "mine.json").write_text(json.dumps(MODEL))
    lines = [
        json.dumps(changed(changed(CHAIN, ("arm", "model"), model), ("name",), str(k)))
        for k, model in enumerate(["planar-2", MODEL, "arms/mine.json"])
    ]
    (tmp_path / "scene.jsonl").write_text("\n".join(lines))
    first, *others = records.read_situations(tmp_path / "scene.jsonl")
    assert all(other.arm == first.arm for other in others)


@pytest.mark.parametrize("kind", ["chain", "spatial"])
def test_a_posture_nearly_in_its_range_is_the_bound(kind):
    scene, key = (CHAIN, "posture") if kind == "chain" else (OLDER, "joints")
    given = records.situation_from_json(scene)
    for k, ends in enumerate(given.arm.joint_range):
        for bound, away in zip(ends, (-1, 1), strict=True):
            off = away * max(1.0, abs(bound))
            for share in (1e-16, 1e-9, 0.999e-5):
                near = changed(scene, ("arm", key, k), bound + share * off)
                assert records.situation_from_json(near).arm.joints[k] == bound
            with pytest.raises(SituationError, match=rf"arm\.{key}\[{k}\]: .* outside its range"):
                records.situation_from_json(changed(scene, ("arm", key, k), bound + 1.001e-5 * off))


def test_a_name_in_ignore_stands_for_all_links_of_that_name():
    links = [LINK | {"name": name} for name in ("base", "fore", "fore")]
    model = MODEL | {"format": "gcm-learn/arm@2", "links": links}
    scene = changed(CHAIN, ("arm", "model"), model)
    by_name, by_number = (
        records.situation_from_json(changed(scene, ("arm", "ignore"), pairs))
        for pairs in ([["fore", "table"]], [[1, "table"], [2, "table"]])
    )
    assert by_name.arm.ignored == by_number.arm.ignored == ((1, "table"), (2, "table"))
    assert (pack(by_name).limb.ignored == pack(by_number).limb.ignored).all()
    assert records.situation_from_json(records.situation_to_json(by_name)) == by_name


@pytest.mark.parametrize("name", records.arm_names())
def test_shipped_arms_bear_their_names(name):
    model = records.shipped_arm(name)
    assert model.name == name and model.source


def assert_hand(arm, hand, axis, atol=1e-6):
    """The hand of an arm is at a point and reaches along an axis."""
    there, along = hands_along(arm, [arm.joints])
    np.testing.assert_allclose(there[0], hand, atol=1e-6)
    np.testing.assert_allclose(along[0], axis, atol=atol)


def test_hands_of_shipped_arms():
    planar, panda = (records.shipped_arm(name) for name in ("planar-2", "panda"))
    forth = (math.cos(0.2), -math.sin(0.2), 0)
    assert_hand(Chain(planar, (0.3, -0.5), 0.1), (0.889296, 0.064319, 0), forth)
    joints = (0, -0.785, 0, -2.356, 0, 1.571, 0.785)
    assert_hand(Chain(panda, joints, 0.1), (0.307020, 0, 0.486870), (0, 0, -1), atol=1e-3)
    assert panda.hand == Hand(7, (0.0, 0.0, 0.2104), (0.0, 0.0, 1.0))


def test_a_chain_with_a_prismatic_joint():
    joint = {"range": (-1.0, 1.0), "max_speed": 1.0, "axis": (0, 0, 1)}
    joints = (
        ChainJoint(origin=(0, 0, 0.3), **joint),
        ChainJoint(type="prismatic", origin=(0.1, 0, 0), rotation=(HALF, 0, HALF, 0), **joint),
        ChainJoint(origin=(0, 0, 0.2), rotation=(HALF, HALF, 0, 0), **joint),
    )
    link = Link(0, (0, 0, 0), (0, 0, 0), 0.1)
    model = ChainModel("three", joints, (link,), Hand(3, (0.3, 0, 0), (1, 0, 0)))
    turn = math.radians(22.5)
    base = Base((1, 2, 0), (math.cos(turn), 0, 0, math.sin(turn)))
    hand, axis = (1.134107, 2.330568, 0.070547), (-0.242180, -0.596964, -0.764842)
    assert_hand(Chain(model, (0.4, 0.25, -0.7), 0.1, base), hand, axis)


@given(strategies.chain_models() | strategies.chain_models(trees=True))
def test_models_are_read_back_equal_from_the_oldest_format_that_holds_them(model):
    written = records.arm_to_json(model)
    assert records.arm_from_json(json.loads(json.dumps(written))) == model
    newer = not model.serial or any(link.name is not None for link in model.links)
    assert written["format"] == f"gcm-learn/arm@{1 + newer}"
    if not model.serial:
        with pytest.raises(SituationError, match=r"is not a known field"):
            records.arm_from_json(written | {"format": "gcm-learn/arm@1"})


def test_the_example_of_the_contract_means_what_it_says():
    arm = situation.situation_from_json(NAO).arm
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
    assert arm.reach == pytest.approx(math.hypot(0.105, 0.015) + 0.114364, abs=1e-6)


def test_what_may_be_left_out():
    scene = NAO | {"arm": dict(NAO["arm"])}
    for name in ("base", "thickness", "max_hand_speed"):
        del scene["arm"][name]
    arm = situation.situation_from_json(scene).arm
    assert (arm.base, arm.thickness, arm.max_hand_speed) == (Base(), 0.0, None)
    assert arm.base == Base((0, 0, 0), (1, 0, 0, 0))
    assert situation.situation_from_json(changed(NAO, ("arm", "base"), {})).arm.base == Base()
    for part, other in (("origin", "rotation"), ("rotation", "origin")):
        base = situation.situation_from_json(changed(NAO, ("arm", "base", other), GONE)).arm.base
        assert getattr(base, other) == getattr(Base(), other)
        assert list(getattr(base, part)) == NAO["arm"]["base"][part]
    written = situation.situation_to_json(situation.situation_from_json(scene))["arm"]
    assert {"max_hand_speed", "max_joint_acceleration", "joint_rates"}.isdisjoint(written)
    assert written["kind"] == "spatial"


def test_an_arm_with_limits_of_acceleration_rests_unless_it_says_otherwise():
    resting = situation.situation_from_json(changed(MOVING, ("arm", "joint_rates"), GONE))
    assert resting.arm.joint_rates == (0.0, 0.0, 0.0, 0.0)
    zeros = situation.situation_from_json(changed(MOVING, ("arm", "joint_rates"), [0, 0, 0, 0]))
    assert resting == zeros
    assert situation.situation_from_json(MOVING).arm.joint_rates == (0.0, -1.0, 8.268, 0.0)


def test_ends_of_ranges_are_within_them():
    held = changed(NAO, ("arm", "joint_range"), [[a, a] for a in NAO["arm"]["joints"]])
    assert situation.situation_from_json(held).arm.joints == (1.4, 0.2, -1.2, -0.6)


@given(st.floats(-9e-7, 9e-7), strategies.unit_vectors(4))
def test_rotations_are_normalised_once_and_for_all(off, rotation):
    base = Base(rotation=tuple((1.0 + off) * part for part in rotation))
    assert math.hypot(*base.rotation) == pytest.approx(1.0, abs=1e-15)
    assert Base(rotation=base.rotation) == base
    np.testing.assert_allclose(base.rotation, rotation, atol=1e-15)


def test_one_file_may_hold_both(tmp_path):
    scenes = [
        situation.situation_from_json(obj) for obj in (PLANAR, NAO, SOLID, MOVING | {"name": "m"})
    ]
    situation.write_situations(tmp_path / "both.jsonl", scenes)
    assert situation.read_situations(tmp_path / "both.jsonl") == scenes
    lines = (tmp_path / "both.jsonl").read_text().splitlines()
    formats = [json.loads(line)["format"][-2:] for line in lines]
    assert formats == ["@1", "@2", "@1", "@2"]
    situation.write_situations(tmp_path / "one.json", scenes[1:2])
    assert situation.read_situations(tmp_path / "one.json") == scenes[1:2]
