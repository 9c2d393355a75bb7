"""A later horizon loses no catch."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from gcm_learn import Arm, Body, Disc, PlanarQuadratic, Situation, get_planner, solve
from gcm_learn.arms import kind_of
from gcm_learn.families import draw, family_names
from gcm_learn.planners.plan import Deadline, Plan, takes
from gcm_learn.planners.stages import Staged, _spans, quiet_from, spans_within_reach, stages
from gcm_learn.scene import later, pose
from gcm_learn.situation import Pendulum
from tests.judging import judge

PLANNERS = (
    "gcm", "hybrid", "layered", "marching", "potential", "recall", "search",
    "straight", "straight-wait",
)  # fmt: skip
QUICK = ("recall", "search", "straight", "straight-wait")
TIMES = (10.0, 50.0, 1000.0)


def with_horizon(situation, horizon):
    """The situation with another horizon, as long as its pendulums have."""
    swings = [body.motion for body in situation.bodies if isinstance(body.motion, Pendulum)]
    longest = [1999.0 * math.pi / swing.fastest for swing in swings]
    return replace(situation, horizon=min([horizon, *longest]))


def held(planner, situation, times):
    """Return whether a situation is caught, and check that it is at later horizons."""
    if not solve(situation, planner).caught:
        return False
    for share in times:
        longer = with_horizon(situation, share * situation.horizon)
        plan = solve(longer, planner)
        assert plan.caught, (situation.name, planner, share, plan.message)
        assert judge(longer, plan) == []
    return True


@pytest.mark.parametrize(
    ("family", "planner"),
    [
        *product(("late-target", "throw-chain"), QUICK), ("falling-space", "search"),
        *(
            pytest.param(*pair, marks=pytest.mark.slow)
            for pair in product(("falling-space", "pendulum", "over-shelf-space"), QUICK)
        ),
    ],
)  # fmt: skip
def test_a_catch_is_a_catch_at_later_horizons(family, planner):
    held(planner, draw(family, 5, 0), (10.0, 1000.0))


@pytest.mark.slow
@pytest.mark.parametrize("planner", PLANNERS)
@pytest.mark.parametrize("family", family_names())
def test_a_catch_of_any_family_and_planner_is_one_at_later_horizons(family, planner):
    for index in range(6):
        situation = draw(family, 31, index)
        if takes(get_planner(planner), kind_of(situation)):
            held(planner, situation, TIMES)


def delayed(family, wait):
    """A situation whose only body, a target, comes straight from afar and is met after a wait."""
    drawn = draw(family, 1, 0)
    target, goal = drawn.targets[0], np.array(drawn.targets[0].motion.position)
    velocity = np.eye(len(goal))[0] * 0.5
    zero = (0.0,) * len(goal)
    moves = replace(
        target.motion, position=tuple(goal - wait * velocity), velocity=tuple(velocity),
        acceleration=zero,
    )  # fmt: skip
    return replace(drawn, bodies=(replace(target, motion=moves),), horizon=wait + 10.0)


JOINTS = ("static-clutter-space", "conveyor-chain")
LATE = [(family, planner) for family in JOINTS for planner in ("search", "straight")]
LATE += [("moving-point", planner) for planner in (*QUICK, "gcm")]
SLOW = [*product(JOINTS, ("hybrid", "marching", "recall", "straight-wait"))]
SLOW += [*product(["moving-point"], sorted({*PLANNERS} - {*QUICK, "gcm"}))]


@pytest.mark.parametrize(
    ("family", "planner"), [*LATE, *(pytest.param(*pair, marks=pytest.mark.slow) for pair in SLOW)]
)
def test_a_target_that_comes_late_is_caught(family, planner):
    situation = delayed(family, 90.0)
    plan = solve(situation, planner)
    assert plan.caught and judge(situation, plan) == []
    assert 80.0 < plan.catch_time < 100.0


def test_stages_share_a_deadline():
    """The planner takes all the time that it gets."""
    now, asked = [0.0], []

    class Wasteful:
        def plan(self, situation, deadline):
            while not deadline.over:
                now[0] += 0.001
            asked.append(now[0])
            return Plan(situation.name, "wasteful", "unreachable", "", 0.0)

    situation = delayed("static-clutter-space", 90.0)
    Staged(Wasteful()).plan(situation, deadline=Deadline(2.0, lambda: now[0]))
    parts = np.diff([0.0, *asked])
    assert len(asked) == len(stages(situation, situation.horizon)) > 3
    assert np.allclose(parts, 2.0 / len(parts), atol=0.01)


def test_a_wait_that_is_not_free_is_no_part_of_a_plan():
    """A post sweeps over the resting hand long before the target comes."""
    at = (1.2, 0.5)
    target = PlanarQuadratic((1.2 - 0.5 * 60.0, -0.4), (0.5, 0.0), (0.0, 0.0))
    sweep = PlanarQuadratic((at[0] + 0.3 * 20.0, at[1]), (-0.3, 0.0), (0.0, 0.0))
    bodies = Body("target", "ball", Disc(0.1), target), Body("obstacle", "post", Disc(0.1), sweep)
    situation = Situation("swept", 70.0, Arm(at, 3.0), bodies)
    for planner in ("search", "straight", "gcm", "recall"):
        plan = solve(situation, planner)
        assert judge(situation, plan) == []
    assert solve(situation, "search").caught


@pytest.mark.parametrize("family", family_names())
def test_spans_hold_all_times_at_which_a_target_is_within_reach(family):
    situation = with_horizon(draw(family, 7, 0), 6.0)
    spans, reach = spans_within_reach(situation, 0.0), situation.arm.reach
    for k, body in enumerate(situation.bodies):
        near = _spans(situation, body, reach) if body.role == "target" else ()
        for t in np.linspace(0.0, situation.horizon, 61) if near else ():
            centre, _ = pose(situation, k, t)
            room = np.linalg.norm(centre[: 2 if kind_of(situation).name == "planar" else 3])
            if room <= reach and any(since <= t <= until for since, until, _ in near):
                assert any(since <= t <= until for since, until in spans)
            elif room <= reach:
                assert abs(centre[2]) > body.shape.bounding_radius  # beside the arm's plane


def test_worlds_are_quiet_once_all_has_passed():
    """A body that leaves the arm's neighbourhood is quiet then, one that swings never."""
    moving = delayed("moving-point", 5.0)
    since = quiet_from(moving)
    assert 5.0 < since < 30.0 and quiet_from(later(moving, since + 0.1)) == 0.0
    assert math.isinf(quiet_from(draw("pendulum", 5, 0)))
    thrown = replace(moving.targets[0].motion, acceleration=(0.0, -1.0), velocity=(0.0, 0.0))
    falls = replace(moving, bodies=(replace(moving.targets[0], motion=thrown),))
    assert quiet_from(falls) < 20.0


@pytest.mark.parametrize("speed", [1e-232, 1e-160, 1e-9])
def test_targets_that_hardly_move_stay_within_reach(speed):
    law = PlanarQuadratic(position=(0.0, 0.0), velocity=(0.0, speed), acceleration=(0.0, 0.0))
    arm = Arm(hand=(1.0, 0.0), max_hand_speed=4.0, elbow="left", grasp=0.0)
    situation = Situation("slow", 1000.0, arm, (Body("target", "ball", Disc(0.5), law),))
    ((since, until),) = spans_within_reach(situation, 1.0)
    assert since == 0.0 and until * speed >= arm.reach
    assert all(start < end for start, end in stages(situation, 1000.0))


def test_an_arm_that_cannot_move_has_few_stages():
    drawn = draw("throw-chain", 1, 0)
    held = replace(drawn.arm.model.joints[0], range=(0.1, 0.1))
    model = replace(drawn.arm.model, joints=(held,) * drawn.arm.dof)
    arm = replace(drawn.arm, model=model, joints=(0.1,) * drawn.arm.dof, max_hand_speed=None)
    assert len(stages(replace(drawn, arm=arm, horizon=10.0), 10.0)) < 200
