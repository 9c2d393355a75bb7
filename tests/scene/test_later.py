"""The same world, looked at later."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gcm_learn import families
from gcm_learn.errors import ArmKindError, SituationError
from gcm_learn.scene.later import later
from gcm_learn.scene.packing import pose
from gcm_learn.situation import situation_from_json
from tests import strategies
from tests.situation.scenes import MOVING, NAO, PLANAR


@pytest.mark.parametrize("name", ["random-planar", "spinning", "spinning-solid", "pendulum"])
def test_bodies_are_where_they_would_have_been(name):
    for index in range(4):
        now = families.draw(name, 8, index)
        t = 0.3 * now.horizon
        then = later(now, t, (0.5, 1.0))
        assert then.arm.hand == (0.5, 1.0)
        assert then.horizon == pytest.approx(0.7 * now.horizon)
        for k, body in enumerate(now.bodies):
            for s in (0.0, 0.2, then.horizon):
                there, turn = pose(then, k, s)
                wanted, wanted_turn = pose(now, k, min(t + s, now.horizon))
                np.testing.assert_allclose(there, wanted, atol=1e-9)
                if body.shape.kind not in ("disc", "sphere"):
                    np.testing.assert_allclose(turn, wanted_turn, atol=1e-8)


def test_nothing_changes_in_no_time():
    now = families.draw("gate", 8, 0)
    assert later(now, 0.0) == now


@given(strategies.spatial_situations(), st.floats(0.0, 0.9))
def test_bodies_around_a_spatial_arm_go_on(now, share):
    t = share * now.horizon
    low, high = np.array(now.arm.joint_range).T
    then = later(now, t, joints=tuple(np.clip(0.5 * (low + high), low, high)))
    assert then.horizon == pytest.approx(now.horizon - t)
    for k, body in enumerate(now.bodies):
        for s in (0.0, then.horizon):
            there, turn = pose(then, k, s)
            wanted, wanted_turn = pose(now, k, min(t + s, now.horizon))
            np.testing.assert_allclose(there, wanted, atol=1e-7)
            if body.shape.kind != "sphere":
                np.testing.assert_allclose(turn, wanted_turn, atol=1e-6)


def test_a_spatial_arm_stands_and_moves_as_it_is_told():
    resting, moving = situation_from_json(NAO), situation_from_json(MOVING)
    assert later(resting, 0.0) == resting and later(moving, 0.0) == moving
    assert later(resting, 0.2).arm == resting.arm
    there = (1.0, 0.0, -1.0, -0.5)
    assert later(resting, 0.2, joints=there).arm.joints == there
    assert later(resting, 0.2, joints=there).arm.joint_rates is None
    assert later(moving, 0.2, joints=there).arm.joint_rates == (0.0, 0.0, 0.0, 0.0)
    rates = (1.0, 2.0, 3.0, 4.0)
    assert later(moving, 0.2, joints=np.array(there), rates=rates).arm.joint_rates == rates


def test_what_cannot_be_so_is_refused():
    resting, moving = situation_from_json(NAO), situation_from_json(MOVING)
    with pytest.raises(SituationError, match="joints: are needed of an arm that moves"):
        later(moving, 0.2)
    with pytest.raises(SituationError, match="joint_rates: are given without"):
        later(resting, 0.2, joints=resting.arm.joints, rates=(0, 0, 0, 0))
    with pytest.raises(SituationError, match="outside its range"):
        later(resting, 0.2, joints=(0, 0, 0, 0))
    with pytest.raises(ArmKindError, match="hand: is of planar arms"):
        later(resting, 0.2, (0.1, 0.1))
    with pytest.raises(ArmKindError, match="joints, rates: are of spatial arms"):
        later(situation_from_json(PLANAR), 0.2, joints=(0, 0, 0, 0))
