"""The same world, looked at later."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

from gcm_learn import families
from gcm_learn.errors import ArmKindError, SituationError
from gcm_learn.scene.laws import later
from gcm_learn.scene.packing import pose
from gcm_learn.situation import situation_from_json
from tests import strategies
from tests.refusals import refusal
from tests.situation.scenes import MOVING, NAO, PLANAR


def assert_goes_on(now, t, then, shares, atol):
    """Bodies are where they would have been, at shares of the later horizon."""
    assert then.horizon == pytest.approx(now.horizon - t)
    for k, body in enumerate(now.bodies):
        for share in shares:
            there, turn = pose(then, k, share * then.horizon)
            wanted, wanted_turn = pose(now, k, min(t + share * then.horizon, now.horizon))
            np.testing.assert_allclose(there, wanted, atol=0.1 * atol)
            if body.shape.kind not in ("disc", "sphere"):
                np.testing.assert_allclose(turn, wanted_turn, atol=atol)


@pytest.mark.parametrize("name", ["random-planar", "spinning", "spinning-solid", "pendulum"])
def test_bodies_are_where_they_would_have_been(name):
    for index in range(4):
        now = families.draw(name, 8, index)
        then = later(now, 0.3 * now.horizon, (0.5, 1.0))
        assert then.arm.hand == (0.5, 1.0)
        assert_goes_on(now, 0.3 * now.horizon, then, (0.0, 0.3, 1.0), 1e-8)


@given(strategies.spatial_situations(), st.floats(0.0, 0.9))
def test_bodies_around_a_spatial_arm_go_on(now, share):
    low, high = np.array(now.arm.joint_range).T
    t, joints = share * now.horizon, tuple(np.clip(0.5 * (low + high), low, high))
    assert_goes_on(now, t, later(now, t, joints=joints), (0.0, 1.0), 1e-6)


def test_a_spatial_arm_stands_and_moves_as_it_is_told():
    resting, moving = situation_from_json(NAO), situation_from_json(MOVING)
    for now in (resting, moving, families.draw("gate", 8, 0)):
        assert later(now, 0.0) == now
    assert later(resting, 0.2).arm == resting.arm
    there = (1.0, 0.0, -1.0, -0.5)
    assert later(resting, 0.2, joints=there).arm.joints == there
    assert later(resting, 0.2, joints=there).arm.joint_rates is None
    assert later(moving, 0.2, joints=there).arm.joint_rates == (0.0, 0.0, 0.0, 0.0)
    rates = (1.0, 2.0, 3.0, 4.0)
    assert later(moving, 0.2, joints=np.array(there), rates=rates).arm.joint_rates == rates


def test_what_cannot_be_so_is_refused():
    resting, moving, planar = (situation_from_json(scene) for scene in (NAO, MOVING, PLANAR))
    joints, zeros = resting.arm.joints, (0, 0, 0, 0)
    for error, situation, change, words in (
        (SituationError, moving, {}, "joints: are needed of an arm that moves"),
        (SituationError, resting, {"joints": joints, "rates": zeros}, "are given without"),
        (SituationError, resting, {"joints": zeros}, "outside its range"),
        (ArmKindError, resting, {"hand": (0.1, 0.1)}, "hand: is of planar arms"),
        (ArmKindError, planar, {"joints": zeros}, "joints, rates: are of spatial arms"),
    ):
        assert words in refusal(error, later, situation, 0.2, **change)
