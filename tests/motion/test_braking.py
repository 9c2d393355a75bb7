"""Braking after a movement, as soon as limits of acceleration allow."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gcm_learn.motion import Movement, braked
from tests.motion.test_joint_verification import ARM

FORCES = (30.0, 20.0, 40.0, 25.0)
LIMITED = replace(ARM, max_joint_acceleration=FORCES)


@pytest.mark.parametrize("seed", range(20))
def test_a_movement_ends_at_rest_as_soon_as_it_can(seed):
    """Each joint with its limit, all the way; the others go on meanwhile."""
    rng = np.random.default_rng(seed)
    rates = rng.uniform(-3.0, 3.0, 4) * (rng.random(4) < 0.8)
    plan = Movement(LIMITED, np.array([0.7]), np.zeros((1, 4)), rates[None])
    whole = braked(plan, np.array(FORCES))
    assert whole.duration == pytest.approx(0.7 + np.max(np.abs(rates) / FORCES))
    assert np.allclose(whole.rates[-1], 0.0, atol=1e-12)
    fine = np.linspace(0.7, whole.duration, 500, endpoint=False)[1:]
    _, moving, forces = whole.states_at(fine)
    on = np.abs(rates) / FORCES > (fine - 0.7)[:, None] + 1e-9
    assert np.allclose(forces[on], np.broadcast_to(-np.sign(rates) * FORCES, on.shape)[on])
    assert np.allclose(moving[~on], 0.0, atol=1e-9)
    assert np.allclose(whole.joints[-1], 0.5 * rates * np.abs(rates) / FORCES)


def test_a_joint_that_brakes_stays_in_its_range():
    """Its end takes what speed is left, at once where there is no room at all."""
    high = np.array([pair[1] for pair in ARM.joint_range])
    near = high - [0.3, 0.01, 0.0, 0.0]
    plan = Movement(LIMITED, np.zeros(1), near[None], np.full((1, 4), 3.0))
    whole = braked(plan, np.array(FORCES))
    fine = whole.states_at(np.linspace(0.0, whole.duration, 4001))[0]
    assert (fine <= high + 1e-6).all()
    assert np.allclose(whole.joints[-1], [near[0] + 0.15, *high[1:]], atol=1e-6)


def test_joints_that_stop_together_are_one_sample():
    """However rounding has it."""
    rates = np.array([0.3, 0.2 * (1.0 + 1e-15), 0.4, 0.25])
    plan = Movement(LIMITED, np.array([1.1]), np.zeros((1, 4)), rates[None])
    assert braked(plan, np.array(FORCES)).time.size == 2
