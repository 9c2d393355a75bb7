"""The same world, looked at later."""

from __future__ import annotations

import numpy as np
import pytest

from gcm_learn import families
from gcm_learn.scene.later import later
from gcm_learn.scene.packing import pose


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
