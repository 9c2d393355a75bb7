"""Moves under limits of acceleration, and the search for chains that is made of them."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from gcm_learn import families, get_planner
from gcm_learn.planners import plan_to_json
from gcm_learn.planners.joints import ramps
from gcm_learn.referee import judge
from gcm_learn.scene import JointLimits
from gcm_learn.situation import situation_to_json

DOF = 3
FREE = [ramps.GIVEN, ramps.START_FREE, ramps.END_FREE, ramps.START_FREE + ramps.END_FREE]


def limits(rng):
    return JointLimits(rng.uniform(1.0, 3.0, DOF), rng.uniform(4.0, 20.0, DOF), np.inf, 0.1, 5.0)


@pytest.mark.parametrize("free", FREE)
def test_a_ramp_leads_from_end_to_end_within_its_limits(free, rng):
    found = 0
    for _ in range(400):
        kept, made, span = limits(rng), ramps.new_ramp(DOF), rng.uniform(0.2, 2.0)
        q, way = rng.uniform(-1, 1, DOF), rng.uniform(-1, 1, DOF) * rng.uniform(0, 2)
        r, v = rng.uniform(-0.9, 0.9, (2, DOF)) * kept.joint_speed * rng.uniform(0, 1)
        pieces = ramps.ramp(kept, q, r, q + way, v, span, free, made)
        if pieces == 0:
            continue
        found += 1
        time, joints, rates = (part[: pieces + 1] for part in (made.time, made.joints, made.rates))
        steps = np.diff(time)[:, None]
        assert time[0] == 0.0 and time[-1] == span and (steps > 0.0).all()
        np.testing.assert_allclose(joints[[0, -1]], [q, q + way], atol=1e-12)
        if not free & ramps.START_FREE:
            np.testing.assert_array_equal(rates[0], r)
        if not free & ramps.END_FREE:
            np.testing.assert_array_equal(rates[-1], v)
        assert (abs(rates) <= kept.joint_speed).all()
        assert (abs(np.diff(rates, axis=0)) <= kept.joint_acceleration * steps).all()
        # quadratic in time: as far as the mean of the rates leads
        np.testing.assert_allclose(
            np.diff(joints, axis=0), steps * 0.5 * (rates[1:] + rates[:-1]), atol=1e-9
        )
    assert found > 40


@pytest.mark.parametrize("free", [ramps.GIVEN, ramps.END_FREE])
def test_no_move_from_rest_takes_less_than_the_least_time(free, rng):
    for _ in range(200):
        kept, made, rest = limits(rng), ramps.new_ramp(DOF), np.zeros(DOF)
        q, p = rng.uniform(-2, 2, (2, DOF))
        least = ramps.least_ramp(kept, q, p, free)
        assert ramps.ramp(kept, q, rest, p, rest, least, free, made) > 0
        assert ramps.ramp(kept, q, rest, p, rest, 0.999 * least, free, made) == 0


@pytest.mark.parametrize("moving", [False, True])
def test_the_referee_accepts_catches_under_limits_of_acceleration(moving):
    caught = 0
    for k in range(5):
        situation = families.draw("panda-crowded-accelerated", 5, k)
        if moving:
            rates = tuple(0.2 * np.cos(np.arange(7.0)))
            situation = replace(situation, arm=replace(situation.arm, joint_rates=rates))
        plan = get_planner("search").plan(situation)
        caught += plan.caught
        written = json.loads(
            json.dumps([situation_to_json(situation), plan_to_json(plan, situation)])
        )
        assert judge(*written) == [], situation.name
    assert caught >= 2


def test_with_a_deadline_catches_come_earlier():
    situation = families.draw("panda-crowded-accelerated", 5, 4)
    first = get_planner("search").plan(situation)
    best = get_planner("search").plan(situation, deadline=1.5)
    assert first.caught and best.catch_time <= first.catch_time
    with pytest.raises(ValueError, match="bound"):
        get_planner("search").plan(situation, bound=0.0)
