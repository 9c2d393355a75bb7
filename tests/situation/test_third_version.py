"""Situations of version 3 and files of arms: round trips, the contract's numbers, refusals."""

from __future__ import annotations

import copy
import json
import math

import numpy as np
import pytest
from hypothesis import given

from gcm_learn.arms import (
    Base,
    Chain,
    ChainJoint,
    ChainModel,
    Hand,
    Link,
    SpatialArm,
    hands_along,
)
from gcm_learn.errors import FileFormatError, SituationError
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

HALF = math.sqrt(0.5)
STILL = {"kind": "quadratic", "position": [1, 0, 0], "velocity": [0] * 3, "acceleration": [0] * 3}
BALL = {"kind": "sphere", "radius": 0.1}
PIECES = [
    {"start": 0, "position": [1, 0, 1], "velocity": [0, 0, -2], "acceleration": [0, 0, 0]},
    {"start": 0.5, "position": [1, 0, 0], "velocity": [0, 0, 1], "acceleration": [0, 0, -9]},
]
CHAIN = {
    "format": "gcm-learn/situation@3",
    "name": "bounce",
    "horizon": 1.5,
    "arm": {"kind": "chain", "model": "planar-2", "posture": [0.3, -0.5], "grasp": 0.05},
    "catch": "any",
    "bodies": [
        {
            "role": "target",
            "name": "ball",
            "shape": BALL,
            "motion": {"kind": "piecewise", "pieces": PIECES},
            "approach": {"axis": [0, 0, 1], "within": 0.5},
        },
        {
            "role": "obstacle",
            "name": "table",
            "shape": BALL,
            "motion": {"kind": "sampled", "times": [0, 1], "positions": [[0, 1, 0], [0, 2, 0]]},
        },
    ],
}
MODEL = arm_to_json(shipped_arm("planar-2"))
SPATIAL = {
    "kind": "spatial",
    "upper_arm": [1, 0, 0],
    "forearm": [1, 0, 0],
    "joints": [0, 0, 0, 0],
    "joint_range": [[-1, 1]] * 4,
    "max_joint_speed": [9] * 4,
    "grasp": 0.1,
}
GONE = object()


def changed(scene, path, value):
    """Return a copy of `scene` with one field replaced, added or (GONE) taken away."""
    result = copy.deepcopy(scene)
    parent = result
    for step in path[:-1]:
        parent = parent[step]
    if value is GONE:
        del parent[path[-1]]
    else:
        parent[path[-1]] = value
    return result


def turned(orientations):
    return {"kind": "sampled", "times": [0, 1], "positions": [[0] * 3] * 2} | orientations


ARM, B0, B1 = ("arm",), ("bodies", 0), ("bodies", 1)
AXES = (*ARM, "model")
REFUSED = [
    (
        ARM,
        {**CHAIN["arm"], "kind": "planar"},
        'arm.kind: must be one of spatial, chain (got "planar")',
    ),
    ((*ARM, "kind"), GONE, "arm.kind: is missing (known: spatial, chain)"),
    ((*ARM, "model"), GONE, "arm.model: is missing"),
    ((*ARM, "model"), None, "arm.model: must not be null (leave the field out)"),
    (
        (*ARM, "model"),
        "puma",
        'arm.model: "puma" is not the name of an arm (known: panda, planar-2)',
    ),
    (
        (*ARM, "model"),
        "no.json",
        "arm.model: no.json:1: cannot be read (No such file or directory)",
    ),
    ((*ARM, "model"), 3, "arm.model: must be an object (got 3)"),
    (
        (*ARM, "model"),
        changed(MODEL, ("joints", 1, "axis"), [0, 0, 2]),
        "arm.model.joints[1].axis: must have length 1 (got 2)",
    ),
    ((*ARM, "posture"), [0.3], "arm.posture: must be a list of 2 numbers (got 1)"),
    ((*ARM, "posture"), [0.3, 3], "arm.posture[1]: 3.0 is outside its range [-2.2, 2.2]"),
    ((*ARM, "joints"), [0, 0], None),
    ((*ARM, "rates"), [0, 0], "arm.rates: are given without max_acceleration"),
    ((*ARM, "max_acceleration"), [1], "arm.max_acceleration: must be a list of 2 numbers (got 1)"),
    ((*ARM, "ignore"), [[2, "table"]], "arm.ignore[0]: 2 is no link (there are 2, from 0)"),
    ((*ARM, "ignore"), [[0, "ball"]], 'arm.ignore[0]: "ball" is not the name of an obstacle'),
    ((*ARM, "base"), {"origin": [0, 0]}, "arm.base.origin: must be a list of 3 numbers (got 2)"),
    (
        (*ARM, "base"),
        {"rotation": [1, 0, 0, 0.01]},
        "arm.base.rotation: must have length 1 (got 1.00005)",
    ),
    (("catch",), "some", 'catch: must be "any" or "all" or "most" (got "some")'),
    ((*B1, "role"), "target", 'catch: "any" is for one target (there are 2)'),
    (("plane",), {}, 'plane: is for planar arms ("gcm-learn/situation@3" has none)'),
    (
        (*B1, "shape"),
        {"kind": "disc", "radius": 1},
        'bodies[1].motion.kind: "sampled" needs a 3D shape',
    ),
    (
        (*B1, "approach"),
        CHAIN["bodies"][0]["approach"],
        "bodies[1].approach: is for targets (this is an obstacle)",
    ),
    ((*B0, "approach", "within"), 3.2, "bodies[0].approach.within: must be from 0 to pi (got 3.2)"),
    (
        (*B0, "approach", "axis"),
        [0, 0, 1.1],
        "bodies[0].approach.axis: must have length 1 (got 1.1)",
    ),
    ((*B0, "approach", "within"), GONE, "bodies[0].approach.within: is missing"),
    ((*B0, "motion", "pieces"), [], "bodies[0].motion.pieces: must not be empty"),
    (
        (*B0, "motion", "pieces"),
        {},
        "bodies[0].motion.pieces: must be a list of objects (got an object)",
    ),
    (
        (*B0, "motion", "pieces", 0, "start"),
        0.1,
        "bodies[0].motion.pieces[0].start: must be 0 (got 0.1)",
    ),
    (
        (*B0, "motion", "pieces", 1, "start"),
        0,
        "bodies[0].motion.pieces[1].start: 0.0 does not come after 0.0",
    ),
    ((*B0, "motion", "pieces", 1, "start"), GONE, "bodies[0].motion.pieces[1].start: is missing"),
    (
        (*B0, "motion", "pieces", 1, "start"),
        None,
        "bodies[0].motion.pieces[1].start: must not be null (leave the field out)",
    ),
    (
        (*B0, "motion", "pieces", 1, "velocity"),
        GONE,
        "bodies[0].motion.pieces[1].velocity: is missing",
    ),
    (
        (*B0, "motion", "pieces", 1, "position"),
        [1, 0, 3e-6],
        "bodies[0].motion.pieces[1].position: is 3e-06 away from the end of pieces[0]"
        " (at most 1e-06)",
    ),
    (
        (*B0, "motion", "pieces", 1, "orientation"),
        [0, 1, 0, 0],
        "bodies[0].motion.pieces[1].orientation: is 1 away from the end of pieces[0]"
        " (at most 1e-06)",
    ),
    ((*B1, "motion", "times"), [0, 0], "bodies[1].motion.times[1]: 0.0 does not come after 0.0"),
    ((*B1, "motion", "times"), [1, 2], "bodies[1].motion.times[0]: must be 0 (got 1.0)"),
    ((*B1, "motion", "times"), [], "bodies[1].motion.times: must not be empty"),
    (
        (*B1, "motion", "times"),
        [0, 1e-60],
        "bodies[1].motion.times[1]: 1e-60 is too soon after 0.0",
    ),
    (
        (*B1, "motion", "times"),
        [0, 1, 2],
        "bodies[1].motion.positions: must have one entry for each of 3 times (got 2)",
    ),
    (
        (*B1, "motion"),
        turned({"orientations": [[1, 0, 0, 0], [0, 0, 1, 0]]}),
        "bodies[1].motion.orientations[1]: is half a turn away from orientations[0]",
    ),
    (
        (*B1, "motion", "kind"),
        "spline",
        "bodies[1].motion.kind: must be one of quadratic, pendulum, piecewise, sampled"
        ' (got "spline")',
    ),
    (
        ARM,
        SPATIAL
        | {"max_joint_acceleration": [9] * 4, "joint_rates": [0, 1, 0, 0], "max_hand_speed": 1},
        "arm.joint_rates: move the hand at 2 (max 1)",
    ),
    (
        ARM,
        {**CHAIN["arm"], "max_acceleration": [9, 9], "rates": [1, 0], "max_hand_speed": 0.5},
        "arm.rates: move the hand at 0.891619 (max 0.5)",
    ),
]


@pytest.mark.parametrize(
    ("path", "value", "expected"),
    [pytest.param(*case, id=str(k)) for k, case in enumerate(REFUSED)],
)
def test_refused_with_file_line_and_field(tmp_path, monkeypatch, path, value, expected):
    monkeypatch.chdir(tmp_path)
    lines = [
        json.dumps(changed(CHAIN, ("name",), "first")),
        json.dumps(changed(CHAIN, path, value)),
    ]
    (tmp_path / "scene.jsonl").write_text("\n".join(lines), encoding="utf-8")
    with pytest.raises(FileFormatError) as caught:
        read_situations("scene.jsonl")
    message = str(caught.value)
    assert "\n" not in message
    if expected is None:
        assert message.startswith("scene.jsonl:2: arm.joints: is not a known field (known: base,")
    else:
        assert message == f"scene.jsonl:2: {expected}"


MODEL_REFUSED = [
    (("format",), "gcm-learn/arm@2", 'format: must be "gcm-learn/arm@1" (got "gcm-learn/arm@2")'),
    (("joints",), [], "joints: must not be empty"),
    (
        ("joints", 0, "type"),
        "continuous",
        'joints[0].type: must be "revolute" or "prismatic" (got "continuous")',
    ),
    (("joints", 0, "range"), [1, 0], "joints[0].range: low 1.0 is above high 0.0"),
    (("joints", 0, "max_speed"), 0, "joints[0].max_speed: must be positive (got 0.0)"),
    (
        ("joints", 0, "max_acceleration"),
        1,
        "joints[1].max_acceleration: is missing, but joints[0] has one: all have it or none",
    ),
    (("joints", 0, "axis"), [0, 0, 1.0001], "joints[0].axis: must have length 1 (got 1.0001)"),
    (("links",), [], "links: must not be empty"),
    (("links", 0, "radius"), 0, "links[0].radius: must be positive (got 0.0)"),
    (("links", 0, "to"), GONE, "links[0].to: is missing"),
    (("links", 0, "from"), [0], "links[0].from: must be a list of 3 numbers (got 1)"),
    (
        ("links", 0, "start"),
        [0] * 3,
        "links[0].start: is not a known field (known: from, joint, radius, to)",
    ),
    (("links", 1, "joint"), 3, "links[1].joint: must be from 0 to 2 (got 3)"),
    (("hand", "joint"), 0, "hand.joint: must be from 1 to 2 (got 0)"),
    (("hand",), GONE, "hand: is missing"),
    (("self_collision",), [[0, 0]], "self_collision[0]: is a pair of link 0 with itself"),
    (("self_collision",), [[0, 2]], "self_collision[0]: 2 is no link (there are 2, from 0)"),
]


@pytest.mark.parametrize(
    ("path", "value", "expected"),
    [pytest.param(*case, id=str(k)) for k, case in enumerate(MODEL_REFUSED)],
)
def test_models_are_refused_with_their_field(path, value, expected):
    with pytest.raises(SituationError) as caught:
        arm_from_json(changed(MODEL, path, value))
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
        situation_from_json(changed(CHAIN, AXES, "arm.json"))
    assert str(refused.value) == f"arm.model: {reason}"


OLDER = [
    (
        ("catch",),
        "all",
        "catch: is not a known field (known: arm, bodies, format, horizon, name, plane)",
    ),
    (
        ("bodies", 0, "approach"),
        {"axis": [0, 0, 1], "within": 1},
        "bodies[0].approach: is not a known field (known: motion, name, role, shape)",
    ),
    (
        ("bodies", 0, "motion"),
        {"kind": "piecewise", "pieces": PIECES},
        'bodies[0].motion.kind: must be one of quadratic, pendulum (got "piecewise")',
    ),
    (("arm",), CHAIN["arm"], 'arm.kind: must be one of spatial (got "chain")'),
    (
        ("bodies", 0, "motion"),
        STILL | {"orientation": [1.000005, 0, 0, 0]},
        "bodies[0].motion.orientation: must have length 1 (got 1.000005)",
    ),
]


@pytest.mark.parametrize(("path", "value", "expected"), OLDER)
def test_older_versions_stay_as_they_were(path, value, expected):
    body = {"role": "target", "name": "ball", "shape": BALL, "motion": STILL}
    older = {
        "format": "gcm-learn/situation@2",
        "name": "old",
        "horizon": 1,
        "arm": SPATIAL,
        "bodies": [body],
    }
    situation_from_json(older)
    with pytest.raises(SituationError) as caught:
        situation_from_json(changed(older, path, value))
    assert str(caught.value) == expected


def test_records_know_what_their_version_has():
    body = situation_from_json(CHAIN).bodies[0]
    arm = SpatialArm(**{k: v for k, v in SPATIAL.items() if k != "kind"})
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
    motion = STILL | {"orientation": [1.000005, 0, 0, 0]}
    scene = changed(CHAIN, (*B1, "motion"), motion)
    scene = changed(scene, (*ARM, "base"), {"rotation": [0, 0.999994, 0, 0]})
    situation = situation_from_json(scene)
    assert situation.bodies[1].motion.orientation == (1.0, 0.0, 0.0, 0.0)
    assert situation.arm.base.rotation == (0.0, 1.0, 0.0, 0.0)


def test_limits_of_acceleration_come_from_the_model_or_the_situation():
    model = copy.deepcopy(MODEL)
    for joint in model["joints"]:
        joint["max_acceleration"] = 7.0
    scene = changed(CHAIN, AXES, model)
    assert situation_from_json(scene).arm.max_joint_acceleration == (7.0, 7.0)
    own = situation_from_json(changed(scene, (*ARM, "max_acceleration"), [1, 2]))
    assert own.arm.max_joint_acceleration == (1.0, 2.0)
    none = situation_from_json(changed(scene, (*ARM, "max_acceleration"), None))
    assert none.arm.max_joint_acceleration is None
    assert situation_from_json(situation_to_json(none)) == none


def test_models_are_objects_paths_or_names(tmp_path):
    (tmp_path / "arms").mkdir()
    (tmp_path / "arms" / "mine.json").write_text(json.dumps(MODEL))
    lines = [
        json.dumps(changed(changed(CHAIN, AXES, model), ("name",), str(k)))
        for k, model in enumerate(["planar-2", MODEL, "arms/mine.json"])
    ]
    (tmp_path / "scene.jsonl").write_text("\n".join(lines))
    first, *others = read_situations(tmp_path / "scene.jsonl")
    assert all(other.arm == first.arm for other in others)


@given(strategies.chain_models())
def test_models_are_read_back_equal(model):
    assert arm_from_json(json.loads(json.dumps(arm_to_json(model)))) == model


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
