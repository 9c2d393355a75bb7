"""Situations of version 3 and files of arms: round trips, the contract's numbers, refusals."""

from __future__ import annotations

import copy
import json
import math

import numpy as np
import pytest
from hypothesis import given

from gcm_learn.arms import Base, Chain, ChainJoint, ChainModel, Hand, Link, hands_along
from gcm_learn.errors import FileFormatError, SituationError
from gcm_learn.scene import pack
from gcm_learn.situation import (
    FORMATS,
    Body,
    Situation,
    SolidQuadratic,
    Sphere,
    arm_from_json,
    arm_names,
    arm_to_json,
    read_arm,
    read_situations,
    shipped_arm,
    situation_from_json,
    situation_to_json,
)
from tests import strategies
from tests.situation.scenes import CHAIN, MODEL, OLDER, REFUSED, changed

HALF = math.sqrt(0.5)
LINK = {"joint": 1, "from": [0, 0, 0], "to": [0.4, 0, 0], "radius": 0.04}


@pytest.mark.parametrize(
    ("path", "expected", "value"),
    [pytest.param(*case[1:3], case[3:]) for case in REFUSED if case[0] == "model"],
)
def test_models_are_refused_with_their_field(path, expected, value):
    with pytest.raises(SituationError) as caught:
        arm_from_json(changed(MODEL, path, *value))
    assert str(caught.value) == expected


def test_a_file_of_an_arm_is_refused_with_its_line(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = json.dumps(changed(MODEL, ("links", 1, "radius"), -1), indent=1)
    (tmp_path / "arm.json").write_text(text, encoding="utf-8")
    line = text[: text.index("-1,\n" if "-1,\n" in text else '"radius": -1')].count("\n") + 1
    with pytest.raises(FileFormatError) as caught:
        read_arm("arm.json")
    reason = f"arm.json:{line}: links[1].radius: must be positive (got -1.0)"
    assert str(caught.value) == reason
    with pytest.raises(SituationError) as refused:
        situation_from_json(changed(CHAIN, ("arm", "model"), "arm.json"))
    assert str(refused.value) == f"arm.model: {reason}"


def test_records_know_what_their_version_has():
    body = situation_from_json(CHAIN).bodies[0]
    arm = situation_from_json(OLDER).arm
    still = Body("target", "ball", Sphere(0.1), SolidQuadratic(*[(0.0,) * 3] * 3))
    assert Situation("s", 1.0, arm, (still,)).format == "gcm-learn/situation@2"
    newer = Situation("s", 1.0, arm, (body,), format="gcm-learn/situation@3")
    assert newer.format == "gcm-learn/situation@3"
    for expected, changes in {
        'bodies[0].motion.kind: "piecewise" is not known to gcm-learn/situation@2': {
            "bodies": (body,)
        },
        'catch: "all" is not known to gcm-learn/situation@2': {"catch": "all"},
        'format: must be "gcm-learn/situation@2" or "gcm-learn/situation@3" (got "@1")': {
            "format": "@1"
        },
    }.items():
        with pytest.raises(SituationError) as caught:
            Situation(**{"name": "s", "horizon": 1.0, "arm": arm, "bodies": (still,), **changes})
        assert str(caught.value) == expected


def test_vectors_that_are_nearly_of_length_one_are_normalised():
    motion = OLDER["bodies"][0]["motion"] | {"orientation": [1.000005, 0, 0, 0]}
    scene = changed(CHAIN, ("bodies", 1, "motion"), motion)
    scene = changed(scene, ("arm", "base"), {"rotation": [0, 0.999994, 0, 0]})
    situation = situation_from_json(scene)
    assert situation.bodies[1].motion.orientation == (1.0, 0.0, 0.0, 0.0)
    assert situation.arm.base.rotation == (0.0, 1.0, 0.0, 0.0)


def test_limits_of_acceleration_come_from_the_model_or_the_situation():
    model = copy.deepcopy(MODEL)
    for joint in model["joints"]:
        joint["max_acceleration"] = 7.0
    scene = changed(CHAIN, ("arm", "model"), model)
    assert situation_from_json(scene).arm.max_joint_acceleration == (7.0, 7.0)
    own = situation_from_json(changed(scene, ("arm", "max_acceleration"), [1, 2]))
    assert own.arm.max_joint_acceleration == (1.0, 2.0)
    none = situation_from_json(changed(scene, ("arm", "max_acceleration"), None))
    assert none.arm.max_joint_acceleration is None
    assert situation_from_json(situation_to_json(none)) == none


def test_models_are_objects_paths_or_names(tmp_path):
    (tmp_path / "arms").mkdir()
    (tmp_path / "arms" / "mine.json").write_text(json.dumps(MODEL))
    lines = [
        json.dumps(changed(changed(CHAIN, ("arm", "model"), model), ("name",), str(k)))
        for k, model in enumerate(["planar-2", MODEL, "arms/mine.json"])
    ]
    (tmp_path / "scene.jsonl").write_text("\n".join(lines))
    first, *others = read_situations(tmp_path / "scene.jsonl")
    assert all(other.arm == first.arm for other in others)


@given(strategies.chain_models())
def test_models_are_read_back_equal(model):
    assert arm_from_json(json.loads(json.dumps(arm_to_json(model)))) == model


@given(strategies.chain_models())
def test_models_are_written_in_the_oldest_format_that_holds_them(model):
    named = any(link.name is not None for link in model.links)
    assert arm_to_json(model)["format"] == f"gcm-learn/arm@{1 + named}"


@pytest.mark.parametrize("kind", ["chain", "spatial"])
def test_a_posture_nearly_in_its_range_is_the_bound(kind):
    scene, key = (CHAIN, "posture") if kind == "chain" else (OLDER, "joints")
    given = situation_from_json(scene)
    for k, ends in enumerate(given.arm.joint_range):
        for bound, away in zip(ends, (-1, 1), strict=True):
            off = away * max(1.0, abs(bound))
            for share in (1e-16, 1e-9, 0.999e-5):
                near = changed(scene, ("arm", key, k), bound + share * off)
                assert situation_from_json(near).arm.joints[k] == bound
            with pytest.raises(SituationError, match=rf"arm\.{key}\[{k}\]: .* outside its range"):
                situation_from_json(changed(scene, ("arm", key, k), bound + 1.001e-5 * off))


def test_a_name_in_ignore_stands_for_all_links_of_that_name():
    links = [LINK | {"name": name} for name in ("base", "fore", "fore")]
    model = MODEL | {"format": "gcm-learn/arm@2", "links": links}
    scene = changed(CHAIN, ("arm", "model"), model)
    by_name, by_number = (
        situation_from_json(changed(scene, ("arm", "ignore"), pairs))
        for pairs in ([["fore", "table"]], [[1, "table"], [2, "table"]])
    )
    assert by_name.arm.ignored == by_number.arm.ignored == ((1, "table"), (2, "table"))
    assert (pack(by_name).limb.ignored == pack(by_number).limb.ignored).all()
    assert situation_from_json(situation_to_json(by_name)) == by_name


@pytest.mark.parametrize("name", arm_names())
def test_shipped_arms_bear_their_names(name):
    model = shipped_arm(name)
    assert model.name == name and model.source


# --- the contract's numbers ------------------------------------------------------------------


def hand_at(arm, joints):
    """Hand (3,) and its axis (3,) at a posture."""
    hand, axis = hands_along(arm, [joints])
    return np.array([hand[0], axis[0]])


def test_planar_2():
    arm = Chain(shipped_arm("planar-2"), (0.3, -0.5), 0.1)
    np.testing.assert_allclose(hand_at(arm, arm.joints)[0], (0.889296, 0.064319, 0), atol=1e-6)


def test_panda():
    joints = (0, -0.785, 0, -2.356, 0, 1.571, 0.785)
    arm = Chain(shipped_arm("panda"), joints, 0.1)
    hand, axis = hand_at(arm, joints)
    np.testing.assert_allclose(axis, (0, 0, -1), atol=1e-3)
    model = arm.model
    lower = Hand(7, (0.0, 0.0, 0.2104), (0.0, 0.0, 1.0))
    assert model.hand == lower
    np.testing.assert_allclose(hand, (0.307020, 0, 0.486870), atol=1e-6)


def test_a_chain_with_a_prismatic_joint():
    joint = {"range": (-1.0, 1.0), "max_speed": 1.0, "axis": (0, 0, 1)}
    model = ChainModel(
        "three",
        (
            ChainJoint(origin=(0, 0, 0.3), **joint),
            ChainJoint(type="prismatic", origin=(0.1, 0, 0), rotation=(HALF, 0, HALF, 0), **joint),
            ChainJoint(origin=(0, 0, 0.2), rotation=(HALF, HALF, 0, 0), **joint),
        ),
        (Link(0, (0, 0, 0), (0, 0, 0), 0.1),),
        Hand(3, (0.3, 0, 0), (1, 0, 0)),
    )
    turn = math.radians(22.5)
    base = Base((1, 2, 0), (math.cos(turn), 0, 0, math.sin(turn)))
    hand, axis = hand_at(Chain(model, (0.4, 0.25, -0.7), 0.1, base), (0.4, 0.25, -0.7))
    np.testing.assert_allclose(hand, (1.134107, 2.330568, 0.070547), atol=1e-6)
    np.testing.assert_allclose(axis, (-0.242180, -0.596964, -0.764842), atol=1e-6)


def test_versions_know_their_arms():
    kinds = {name: [kind.name for kind in version.kinds] for name, version in FORMATS.items()}
    assert list(kinds.values()) == [["planar"], ["spatial"], ["spatial", "chain"]]


@given(strategies.chain_models(trees=True))
def test_trees_and_followers_round_trip(model):
    written = arm_to_json(model)
    assert arm_from_json(json.loads(json.dumps(written))) == model
    newer = not model.serial or any(link.name is not None for link in model.links)
    assert written["format"] == f"gcm-learn/arm@{1 + newer}"
    if not model.serial:
        with pytest.raises(SituationError, match=r"is not a known field"):
            arm_from_json(written | {"format": "gcm-learn/arm@1"})
