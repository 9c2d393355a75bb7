"""The search for spatial arms: what it claims holds, and what it must find."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from gcm_learn import families, get_planner, seeding, solve
from gcm_learn.arms import forward_in_space
from gcm_learn.planners import GAIN, TreeSearch, search_in_space
from gcm_learn.situation import (
    Body,
    Box,
    Capsule,
    Cylinder,
    Situation,
    SolidQuadratic,
    Sphere,
    read_situations,
    situation_from_json,
)
from tests.judging import judge
from tests.situation.scenes import NAO
from tests.spatial import EXAMPLES

SPATIAL = situation_from_json(NAO)
NOTHING = (0.0, 0.0, 0.0)
SHAPES = (Sphere(0.03), Box((0.02, 0.03, 0.04)), Capsule(0.02, 0.05), Cylinder(0.03, 0.03))


def still(place):
    """A motion that is none."""
    return SolidQuadratic(tuple(map(float, place)), NOTHING, NOTHING)


def scene_of(rng, walls=2):
    """A target that flies to where a random posture has the hand, among boxes that stand still."""
    arm, horizon = SPATIAL.arm, 0.8
    low, high = np.array(arm.joint_range).T
    start, goal = rng.uniform(low, high, (2, 4))
    hand = forward_in_space(arm, goal)[1]
    velocity = rng.uniform(-0.3, 0.3, 3)
    flight = SolidQuadratic(tuple(hand - 0.5 * horizon * velocity), tuple(velocity), NOTHING)
    bodies = [Body("target", "ball", SHAPES[rng.integers(4)], flight)]
    for k in range(walls):
        place = forward_in_space(arm, rng.uniform(low, high))[1] + rng.uniform(-0.05, 0.05, 3)
        size = tuple(rng.uniform(0.01, 0.05, 3))
        bodies.append(Body("obstacle", f"o{k}", Box(size), still(place)))
    return Situation("drawn", horizon, replace(arm, joints=tuple(start)), tuple(bodies))


def test_examples_are_caught():
    situations = [s for s in read_situations(EXAMPLES) if s.arm.max_joint_acceleration is None]
    plans = [solve(situation) for situation in situations]
    assert sum(plan.caught for plan in plans) >= 0.9 * len(plans)
    for situation, plan in zip(situations, plans, strict=True):
        assert not plan.caught or judge(situation, plan) == []


def behind(cover):
    """A ball that rests within reach, and a box that covers it."""
    arm = SPATIAL.arm
    place = forward_in_space(arm, (0.3, 0.3, 0.2, -0.6))[1]
    ball = Body("target", "ball", Sphere(0.02), still(place))
    box = Body("obstacle", "cover", Box((0.06, 0.06, 0.06)), replace(cover, position=tuple(place)))
    return Situation("covered", 1.0, arm, (ball, box))


def test_it_waits_until_a_cover_has_gone():
    situation = behind(SolidQuadratic(NOTHING, NOTHING, (0.0, 0.0, 2.0)))
    plan = solve(situation)
    assert plan.caught and judge(situation, plan) == []
    assert plan.catch_time > math.sqrt(2.0 * 0.05 / 2.0)


@pytest.mark.parametrize(("family", "index"), [("bench-space", 10), ("crate-space", 6)])
def test_a_target_that_can_only_be_grazed_is_caught(family, index):
    """No posture with the hand at its centre, or where it is nearest, is free at any time."""
    situation = families.draw(family, 1300, index)
    arm = replace(situation.arm, max_joint_acceleration=None, joint_rates=None)
    situation = replace(situation, arm=arm)
    plan = search_in_space().plan(situation)
    assert plan.caught
    assert judge(situation, plan) == []


def test_what_is_shut_in_is_given_up_soon():
    plan = solve(behind(still(NOTHING)))
    assert not plan.caught
    assert plan.failure is not None


def test_patience_is_rarely_later_and_a_bound_is_kept():
    earlier = later = 0
    for k in range(12):
        situation = scene_of(seeding.rng(8, k))
        first, patient = TreeSearch().plan(situation), search_in_space().plan(situation)
        assert first.caught <= patient.caught
        if not first.caught or first.catch_time == 0.0:
            continue
        later += patient.catch_time > first.catch_time + GAIN * situation.horizon
        earlier += patient.catch_time < first.catch_time
        bounded = get_planner("search").plan(situation, bound=first.catch_time)
        assert not bounded.caught or bounded.catch_time <= first.catch_time
    assert earlier >= 3 and later <= 2


def test_nothing_is_looked_for_behind_a_free_straight_line():
    situation = Situation("alone", 0.8, SPATIAL.arm, scene_of(seeding.rng(7, 0), walls=0).bodies)
    plan = solve(situation)
    assert plan.caught and plan.nodes == 0
    assert plan.catch_time == solve(situation, "straight").catch_time


def test_a_bound_is_a_time():
    with pytest.raises(ValueError, match="bound: must be positive"):
        TreeSearch().plan(SPATIAL, bound=0.0)
