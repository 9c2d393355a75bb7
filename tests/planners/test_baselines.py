"""The simple planners to compare with: a straight line and patience, a potential field."""

from __future__ import annotations

import numpy as np
import pytest

from gcm_learn import seeding
from gcm_learn.arms import Arm
from gcm_learn.families.random_planar import random_planar
from gcm_learn.planners.baselines.potential import PotentialPlanner
from gcm_learn.planners.baselines.straight import StraightPlanner, StraightWaitPlanner
from gcm_learn.situation import Body, Disc, PlanarQuadratic, Polygon, Situation
from tests.judging import judge

SPEED = 3.3
GRASP, RADIUS = 0.05, 0.05


def scene(*bodies, hand=(0.9, 0.0), horizon=1.2):
    return Situation("scene", horizon, Arm(hand, SPEED, grasp=GRASP), bodies)


def body(role, shape, position, velocity=(0.0, 0.0)):
    return Body(role, role, shape, PlanarQuadratic(position, velocity, (0.0, 0.0)))


def goal(x, y):
    return body("target", Disc(RADIUS), (x, y))


# The target is free once the disc has moved off so far that a hand fits beside it.
OPENS = (0.4 - RADIUS - GRASP) / 0.5
GATE = scene(goal(1.5, 0.0), body("obstacle", Disc(0.4), (1.5, 0.0), (0.5, 0.0)))
# Across the straight way, near enough to its end that the field leads past it.
POST = scene(goal(1.3, 0.5), body("obstacle", Disc(0.1), (1.35, 0.0)), hand=(1.3, -0.5))
FREE = scene(goal(1.3, 0.6), hand=(0.9, -0.4))
# A bar from near the shoulder to the rim: round it goes the long way, which no field shows.
BAR = Polygon(((0.3, -0.02), (2.6, -0.02), (2.6, 0.02), (0.3, 0.02)))
TRAP = scene(goal(0.7, 1.2), body("obstacle", BAR, (0.0, 0.0)), hand=(0.7, -1.2))


def rests(trajectory):
    """Total time that the hand rests [s]."""
    steps = np.linalg.norm(np.diff(trajectory.hand, axis=0), axis=1)
    return np.diff(trajectory.time)[steps < 1e-9].sum()


def test_straight_wait_waits_for_the_gate():
    assert not StraightPlanner().plan(GATE).caught
    plan = StraightWaitPlanner().plan(GATE)
    assert plan.caught and judge(GATE, plan) == []
    assert OPENS <= plan.catch_time <= OPENS + 1.2 / 20
    assert rests(plan.trajectory) > 0.3
    way = plan.trajectory.hand - plan.trajectory.hand[0]
    across = way @ [-way[-1, 1], way[-1, 0]] / np.hypot(*way[-1])
    assert np.abs(across).max() < 1e-9


def test_more_instants_wait_less():
    few, many = (StraightWaitPlanner(instants=n).plan(GATE).catch_time for n in (6, 96))
    assert OPENS <= many < few


@pytest.mark.parametrize("shares", [(1.0,), (0.5,)])
def test_the_wait_may_be_before_leaving(shares):
    plan = StraightWaitPlanner(shares=shares).plan(GATE)
    assert plan.caught
    resting = np.hypot(*(plan.trajectory.hand - plan.trajectory.hand[0]).T) < 1e-12
    assert plan.trajectory.time[resting].max() > 0.4 * shares[0]


def test_straight_wait_catches_whatever_a_straight_line_does():
    patient, straight = StraightWaitPlanner(), StraightPlanner()
    more = 0
    for k in range(400):
        situation = random_planar(seeding.rng(91, k))
        plan, other = patient.plan(situation), straight.plan(situation)
        if other.caught:
            assert plan.catch_time == other.catch_time
        more += plan.caught and not other.caught
    assert more >= 5


def test_straight_wait_does_not_go_round_anything():
    assert StraightWaitPlanner().plan(TRAP).status == "unreachable"


def test_the_field_leads_straight_where_nothing_is():
    plan = PotentialPlanner().plan(FREE)
    exact = (np.hypot(0.4, 1.0) - RADIUS - GRASP) / SPEED
    assert exact <= plan.catch_time <= exact * 1.001


def test_the_field_pushes_past_a_post():
    assert not StraightPlanner().plan(POST).caught
    plan = PotentialPlanner().plan(POST)
    assert plan.caught and judge(POST, plan) == []
    assert plan.clearance > 0.01


def test_the_field_gets_stuck_behind_a_bar():
    assert PotentialPlanner().plan(TRAP).status == "unreachable"


def test_the_field_follows_a_moving_target():
    moving = scene(body("target", Disc(RADIUS), (1.5, -0.9), (0.0, 1.5)), hand=(0.9, 0.3))
    plan, straight = PotentialPlanner().plan(moving), StraightPlanner().plan(moving)
    assert plan.caught and plan.catch_time == pytest.approx(straight.catch_time, rel=0.01)
