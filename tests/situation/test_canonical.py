"""The canonical form: what differs only by how it lies becomes the same."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, strategies as st

from gcm_learn import rng as generator, solve
from gcm_learn.arms import quaternion_of, rotation_of
from gcm_learn.families import random_planar
from gcm_learn.families.random_solid import random_rotation, random_solid
from gcm_learn.motion.movement import Movement
from gcm_learn.motion.rules import rules_of
from gcm_learn.motion.verification import verify
from gcm_learn.scene.packing import pack, pose
from gcm_learn.situation import situation_to_json
from gcm_learn.situation.canonical import Frame, canonical
from tests.strategies import unit_vectors
from tests.transforms import carried, mirrored, turned


def numbers(value):
    """Return the numbers of a JSON value in order, and everything else as text."""
    if isinstance(value, dict):
        return [x for member in value.values() for x in numbers(member)]
    if isinstance(value, list):
        return [x for member in value for x in numbers(member)]
    return [float(value)] if isinstance(value, int | float) else []


def assert_same(a, b):
    np.testing.assert_allclose(
        numbers(situation_to_json(a)), numbers(situation_to_json(b)), atol=1e-9
    )


@pytest.mark.parametrize("k", range(12))
def test_turned_and_mirrored_situations_have_one_form(k):
    situation = random_planar(generator(5, k))
    form, frame = canonical(situation)
    assert form.arm.elbow == "right" and form.arm.hand[1] == 0.0 < form.arm.hand[0]
    for angle in (0.4, -2.9):
        there, other = canonical(turned(situation, angle))
        assert_same(there, form)
        assert math.cos(other.angle - frame.angle - angle) == pytest.approx(1.0)
        assert_same(canonical(mirrored(turned(situation, angle)))[0], form)
    assert canonical(mirrored(situation))[1].mirrored is not frame.mirrored


@pytest.mark.parametrize("k", range(6))
def test_carried_situations_have_one_form(k):
    source = generator(6, k)
    situation = random_solid(source)
    there = carried(situation, random_rotation(source), source.uniform(-1, 1, 3))
    a, b = canonical(situation)[0], canonical(there)[0]
    for body in range(len(a.bodies)):
        for t in (0.0, 0.5):
            for one, other in zip(pose(a, body, t), pose(b, body, t), strict=True):
                np.testing.assert_allclose(one, other, atol=1e-6)


@pytest.mark.parametrize("make", [random_planar, random_solid])
@pytest.mark.parametrize("k", range(4))
def test_bodies_move_as_before_seen_in_the_frame(make, k):
    situation = make(generator(7, k))
    form, frame = canonical(situation)
    np.testing.assert_allclose(frame.canonical(situation.arm.hand), form.arm.hand, atol=1e-12)
    for body in range(len(situation.bodies)):
        for t in (0.0, 0.3, 0.9):
            before, after = pose(situation, body, t)[0], pose(form, body, t)[0]
            np.testing.assert_allclose(frame.canonical(before[:2]), after[:2], atol=1e-9)
            height = before[2] if not frame.mirrored else -before[2]
            assert after[2] == pytest.approx(height, abs=1e-9)


@pytest.mark.parametrize("make", [random_planar, random_solid])
def test_a_catch_in_the_canonical_form_is_one_where_it_came_from(make):
    caught = 0
    for k in range(12):
        situation = make(generator(8, k))
        form, frame = canonical(situation)
        plan = solve(form, "straight")
        if not plan.caught or plan.clearance < 1e-3:
            continue
        caught += 1
        hand = frame.original(plan.trajectory.hand)
        hand[0] = situation.arm.hand
        arm = situation.arm
        slower = plan.trajectory.time  # the same times: turning keeps speeds
        way = Movement.of_hand(arm, slower, hand)
        body = [b.name for b in situation.bodies].index(plan.catch_body)
        scene = pack(situation)
        verdict = verify(scene, rules_of(scene), way, body)
        assert verdict.good, verdict.reason
        assert verdict.clearance == pytest.approx(plan.clearance, abs=5e-4)
    assert caught >= 3


@given(st.floats(-3.0, 3.0), st.booleans(), st.tuples(*[st.floats(-3, 3)] * 2))
def test_the_frame_goes_there_and_back(angle, mirrored_, point):
    frame = Frame(angle, mirrored_)
    there = frame.canonical(point)
    np.testing.assert_allclose(frame.original(there), point, atol=1e-12)
    assert np.hypot(*there) == pytest.approx(math.hypot(*point))


@given(unit_vectors(4))
def test_quaternions_come_back(quaternion):
    there = quaternion_of(rotation_of(quaternion))
    assert abs(np.dot(there, quaternion)) == pytest.approx(1.0)
    assert max(there) == pytest.approx(max(map(abs, there)))


def test_a_canonical_situation_is_its_own_form():
    form, _ = canonical(random_planar(generator(9)))
    again, frame = canonical(form)
    assert frame == Frame(0.0, False)
    assert_same(again, form)
    assert replace(again, name="x").name == "x"
