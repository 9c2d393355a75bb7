"""Catches under limits of acceleration: what is claimed holds, and how many are left."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gcm_learn import get_planner, solve
from gcm_learn.motion import Failure
from gcm_learn.situation import read_situations
from tests.judging import judge
from tests.spatial import EXAMPLES

SITUATIONS = read_situations(EXAMPLES)
LIMITED = [s for s in SITUATIONS if s.arm.max_joint_acceleration is not None]


def limited(situation, factor, rates=None):
    """The situation with accelerations that take a joint to its full speed in horizon / factor."""
    arm = situation.arm
    limits = tuple(factor * speed / situation.horizon for speed in arm.max_joint_speed)
    return replace(situation, arm=replace(arm, max_joint_acceleration=limits, joint_rates=rates))


def promised(situation):
    """The plan; what it claims is judged."""
    plan = solve(situation, "search")
    if plan.caught:
        assert judge(situation, plan) == [], situation.name
        assert plan.trajectory.rates is not None
    return plan


@pytest.mark.parametrize("situation", LIMITED, ids=lambda s: s.name)
def test_the_examples_catches_hold(situation):
    promised(situation)


def test_few_catches_are_lost_to_wide_limits_and_many_to_narrow_ones():
    kept, free = dict.fromkeys((0.5, 12.0), 0), 0
    for situation in SITUATIONS[:16]:
        if situation.arm.max_joint_acceleration is None and solve(situation, "search").caught:
            free += 1
            for factor in kept:
                kept[factor] += promised(limited(situation, factor)).caught
    assert free >= 8
    assert kept[12.0] >= 0.7 * free
    assert kept[0.5] < kept[12.0]


@pytest.mark.parametrize("k", range(0, 16, 3))
def test_an_arm_that_moves_at_the_start_goes_on_from_there(k):
    arm, rng = SITUATIONS[k].arm, np.random.default_rng(k)
    rates = tuple(0.3 * rng.uniform(-1.0, 1.0, 4) * arm.max_joint_speed)
    plan = promised(limited(SITUATIONS[k], 12.0, rates))
    if plan.caught:
        assert tuple(plan.trajectory.rates[0]) == rates


@pytest.mark.parametrize("name", ["straight", "straight-wait"])
def test_who_cannot_keep_accelerations_says_so(name):
    plan = get_planner(name).plan(LIMITED[0])
    assert not plan.caught and plan.failure is Failure.ACCELERATION_UNTAKEN
