"""Situations of version 4: formats of records in code, limits of jerk, ends, canonical form."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, strategies as st

from gcm_learn import situation as records
from gcm_learn.arms import Base, ChainModel, hands_along
from gcm_learn.errors import SituationError
from gcm_learn.scene import pose
from tests import strategies
from tests.refusals import refusal
from tests.situation.scenes import CHAIN, OLDER, PLANAR, SCENES, changed

FOURTH = "gcm-learn/situation@4"
PICK = records.situation_from_json(SCENES["fourth"])
PART, TABLE = PICK.bodies
BARE = records.Body("target", "part", PART.shape, PART.motion)
JERKS = (70.0, 80.0)


def jerking(limits=JERKS):
    """The arm of two joints, whose model has limits of acceleration and of jerk."""
    model = PICK.arm.model
    joints = tuple(
        replace(joint, max_acceleration=9.0, max_jerk=jerk)
        for joint, jerk in zip(model.joints, limits, strict=True)
    )
    return ChainModel(model.name, joints, model.links, model.hand)


def test_an_example_means_what_it_says():
    assert (PICK.end, PICK.end_by, PICK.format) == ("rest", 4.0, FOURTH)
    assert PART.approach == (
        records.Approach((0, 1, 0), 0.2, (0, 0, 1)), records.Approach((1, 0, 0), 0.3),
    )  # fmt: skip
    assert (PART.hold, PART.place) == (records.Hold(0.2, 0.1), records.Place((0.5, -0.4, 0), 0.02))
    assert (PART.ignore, PART.ignore_for) == (("table",), 0.3)
    assert TABLE.margin == records.Margin(0.01, 0.02)
    assert PICK.arm.max_joint_jerk == (300.0, 300.0)
    assert PICK.arm.joint_accelerations == (1.0, -2.0)
    plain = records.situation_from_json(CHAIN | {"format": FOURTH})
    assert (plain.end, plain.end_by, plain.arm.max_joint_jerk) == ("free", None, None)


def test_one_approach_is_written_as_an_object():
    approach = SCENES["fourth"]["bodies"][0]["approach"]
    path = ("bodies", 0, "approach")
    one, alone, two = (
        records.situation_from_json(changed(SCENES["fourth"], path, given))
        for given in (approach[:1], approach[0], approach)
    )
    assert one == alone
    given = [records.situation_to_json(s)["bodies"][0]["approach"] for s in (one, two)]
    assert isinstance(given[0], dict) and len(given[1]) == 2
    first = records.Approach((0, 0, 1), 0.5)
    made = [records.Body("target", "a", PART.shape, PART.motion, a) for a in (first, [first])]
    assert made[0] == made[1] == replace(made[0], approach=(first,))
    assert replace(made[0], approach=None).approach == ()


NEWER = [
    ("end", {"end": "rest"}),
    ("end_by", {"end_by": 3.0}),
    ("arm.max_jerk", {"arm": replace(PICK.arm, joint_accelerations=None)}),
    ("bodies[0].hold", {"bodies": [replace(BARE, hold=PART.hold)]}),
    ("bodies[0].approach", {"bodies": [replace(BARE, approach=PART.approach)]}),
    ("bodies[1].margin", {"bodies": [BARE, TABLE]}),
]  # fmt: skip


@pytest.mark.parametrize(("field", "given"), NEWER, ids=[field for field, _ in NEWER])
def test_a_record_with_new_fields_is_of_version_4(field, given):
    arm = replace(PICK.arm, max_joint_jerk=None, joint_accelerations=None)
    plain = {
        "name": "s",
        "horizon": 1.0,
        "arm": arm,
        "bodies": records.situation_from_json(OLDER).bodies,
    }
    third = records.Situation(**plain)
    assert third.format == "gcm-learn/situation@3"
    assert records.Situation(**plain | given).format == FOURTH
    said = refusal(SituationError, replace, third, **given)
    assert said == f"{field}: is not known to gcm-learn/situation@3"


def test_limits_of_jerk_come_from_the_model_in_version_4_only():
    model = records.arm_to_json(jerking())
    scene = changed(CHAIN, ("arm", "model"), model)
    third = records.situation_from_json(scene)
    assert third.arm.max_joint_jerk is None and third.arm.joint_accelerations is None
    assert "max_jerk" not in records.situation_to_json(third)["arm"]
    scene = scene | {"format": FOURTH}
    fourth = records.situation_from_json(scene)
    assert (fourth.arm.max_joint_jerk, fourth.arm.joint_accelerations) == (JERKS, (0.0, 0.0))
    for path, value, jerks in (
        ("max_jerk", None, None),
        ("max_jerk", [5, 6], (5.0, 6.0)),
        ("max_acceleration", None, None),
        ("max_acceleration", [1, 2], JERKS),
    ):
        other = records.situation_from_json(changed(scene, ("arm", path), value))
        assert other.arm.max_joint_jerk == jerks
        assert records.situation_from_json(records.situation_to_json(other)) == other
    bare = records.Situation("s", 1.0, replace(fourth.arm), fourth.bodies)
    assert bare == replace(third, name="s", horizon=1.0)  # a model's limits ask for nothing newer


def test_a_stop_can_be_asked_of_older_situations():
    scene = changed(CHAIN, ("arm", "model"), records.arm_to_json(jerking()))
    third = records.situation_from_json(scene)
    ended = records.with_end(third, "rest")
    assert ended == replace(
        records.situation_from_json(scene | {"format": FOURTH}), end="rest", name=third.name
    )
    assert records.with_end(records.with_end(ended, "free"), "rest") == ended
    kept = replace(ended, arm=replace(ended.arm, max_joint_jerk=None, joint_accelerations=None))
    assert records.with_end(kept, "rest").arm.max_joint_jerk is None
    needs = 'end: "rest" needs limits of acceleration, which the arm does not have'
    for scene, said in (
        (CHAIN, f'{needs} (situation "bounce")'),
        (OLDER, f'{needs} (situation "old")'),
        (PLANAR, 'end: is not known to gcm-learn/situation@1 (situation "ball-and-post")'),
    ):
        given = records.situation_from_json(scene)
        assert refusal(SituationError, records.with_end, given, "rest") == said


@given(strategies.fourth_situations(), st.integers(0, 2**32 - 1))
def test_the_canonical_form_keeps_places_and_directions(situation, seed):
    form, frame = records.canonical(situation)
    rng = np.random.default_rng(seed)
    joints = rng.uniform(-3.0, 3.0, len(situation.arm.joints))
    there = frame.canonical_joints(joints)
    for k, (body, other) in enumerate(zip(situation.bodies, form.bodies, strict=True)):
        if body.place is not None:
            np.testing.assert_allclose(
                frame.canonical(body.place.position), other.place.position, atol=1e-9
            )
        for one, its in zip(body.approach, other.approach, strict=True):
            before, after = (
                angle(s, k, q, a) for s, q, a in ((situation, joints, one), (form, there, its))
            )
            assert after == pytest.approx(before, abs=1e-6)


def angle(situation, k, joints, approach):
    """Angle of a hand in a posture to the approach of a body at t = 0 [rad]."""
    arm, axis = situation.arm, approach.hand or situation.arm.hand_axis
    seen = [replace(body, shape=records.Box((1, 1, 1))) for body in situation.bodies]
    world = replace(situation, arm=replace(arm, base=Base()), bodies=seen)
    _, turn = pose(world, k, 0.0)  # that of balls is not known
    if arm.kind == "chain":
        arm = replace(arm, model=replace(arm.model, hand=replace(arm.model.hand, axis=axis)))
    else:
        arm = replace(arm, forearm=axis)
    (along,), wanted = hands_along(arm, [joints])[1], turn @ np.array(approach.axis)
    return math.atan2(np.linalg.norm(np.cross(along, wanted)), along @ wanted)
