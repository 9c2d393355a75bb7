"""The second look at a catch sees every broken promise."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from gcm_learn.families import thrown_scene
from gcm_learn.families.paper import PAPER_SCENES
from gcm_learn.motion import Failure, Movement
from gcm_learn.planners import solve
from gcm_learn.planners.outside import broken_promise


@pytest.fixture(scope="module")
def planar_case():
    situation = PAPER_SCENES["fig4"]()
    return situation, solve(situation, "gcm")


@pytest.fixture(scope="module")
def solid_case():
    situation = PAPER_SCENES["fig6"]()
    return situation, solve(situation, "gcm")


@pytest.fixture(scope="module")
def spatial_case():
    situation = thrown_scene()
    return situation, solve(situation, "search")


def with_way(plan, time, hand, **changes):
    way = Movement.of_hand(plan.trajectory.arm, time, hand)
    return dataclasses.replace(plan, trajectory=way, **{"catch_time": way.duration, **changes})


def test_a_verified_plan_breaks_nothing(planar_case, solid_case, spatial_case):
    assert spatial_case[1].caught
    assert broken_promise(*spatial_case) is None
    assert broken_promise(*planar_case) is None
    assert broken_promise(*solid_case) is None


def test_what_was_not_promised_cannot_be_broken(planar_case):
    situation, plan = planar_case
    assert broken_promise(situation, dataclasses.replace(plan, status="unreachable")) is None


def test_a_catch_needs_a_trajectory(planar_case):
    situation, plan = planar_case
    assert "without" in broken_promise(situation, dataclasses.replace(plan, trajectory=None))


def break_start(plan):
    return with_way(plan, plan.trajectory.time, plan.trajectory.hand + 0.01)


def break_end(plan):
    return dataclasses.replace(plan, catch_time=plan.catch_time + 0.1)


def break_speed(plan):
    way = plan.trajectory
    return with_way(plan, 0.5 * way.time, way.hand)


def break_catch(plan):
    way = plan.trajectory
    half = len(way.time) // 2
    return with_way(plan, way.time[:half], way.hand[:half])


def break_clearance(plan):
    """Go straight to the target: through the obstacle, at no more than the hand's speed."""
    start, goal = plan.trajectory.hand[0], plan.trajectory.hand[-1]
    hand = start + np.linspace(0, 1, 60)[:, None] * (goal - start)
    return with_way(plan, np.linspace(0, plan.catch_time, 60), hand)


@pytest.mark.parametrize(
    ("damage", "said"),
    [
        (break_start, Failure.WRONG_START.value),
        (break_end, "end at the catch"),
        (break_speed, "max_hand_speed"),
        (break_catch, "misses the target"),
        (break_clearance, "touched"),
    ],
)
def test_every_promise_is_looked_at(planar_case, damage, said):
    situation, plan = planar_case
    assert said in broken_promise(situation, damage(plan))


def test_joint_speeds_are_looked_at(planar_case):
    situation, plan = planar_case
    slow = dataclasses.replace(situation.arm, max_joint_speed=(0.01, 0.01))
    assert "joint" in broken_promise(
        dataclasses.replace(situation, arm=slow), moved(plan, arm=slow)
    )


def moved(plan, **changes):
    return dataclasses.replace(plan, trajectory=dataclasses.replace(plan.trajectory, **changes))


def other_start(plan):
    return moved(plan, joints=plan.trajectory.joints + 0.001)


def too_fast(plan):
    time = plan.trajectory.time.copy()
    time[1:-1] *= 0.02
    return moved(plan, time=time)


def too_early(plan):
    time = np.array([0.0, 0.01])
    stays = moved(plan, time=time, joints=np.tile(plan.trajectory.joints[0], (2, 1)))
    return dataclasses.replace(stays, catch_time=0.01)


def other_arm(plan):
    longer = dataclasses.replace(plan.trajectory.arm, grasp=2.0 * plan.trajectory.arm.grasp)
    return moved(plan, arm=longer)


@pytest.mark.parametrize(
    ("damage", "said"),
    [
        (other_start, Failure.WRONG_START.value),
        (break_end, "end at the catch"),
        (lambda plan: dataclasses.replace(plan, catch_body="nobody"), "no target"),
        (too_fast, "max_joint_speed"),
        (too_early, "misses the target"),
        (other_arm, "another arm"),
    ],
)
def test_every_promise_in_space_is_looked_at(spatial_case, damage, said):
    situation, plan = spatial_case
    assert said in broken_promise(situation, damage(plan))


def test_a_touch_in_space_is_seen(spatial_case):
    situation, plan = spatial_case
    post = next(body for body in situation.bodies if body.role == "obstacle")
    way = plan.trajectory
    midst = tuple(way.hand_at(0.5 * way.duration))
    still = dataclasses.replace(post.motion, position=midst, velocity=(0.0, 0.0, 0.0))
    there = dataclasses.replace(post, motion=still)
    bodies = tuple(there if body is post else body for body in situation.bodies)
    assert "touched" in broken_promise(dataclasses.replace(situation, bodies=bodies), plan)


def test_a_plan_for_the_other_kind_of_arm_is_broken(planar_case, spatial_case):
    assert "other kind" in broken_promise(planar_case[0], spatial_case[1])
    assert "other kind" in broken_promise(spatial_case[0], planar_case[1])
