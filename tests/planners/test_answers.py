"""Answers whose truth is known: blocked, hopeless, waiting, free space, limits."""

from __future__ import annotations

import math
import re
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from gcm_learn import seeding, solve
from gcm_learn.arms import Arm
from gcm_learn.families.random_planar import random_planar
from gcm_learn.families.random_solid import random_solid
from gcm_learn.planners import plan_to_json
from gcm_learn.situation import (
    Body,
    Disc,
    PlanarQuadratic,
    Plane,
    Polygon,
    Situation,
    SolidQuadratic,
    Sphere,
)
from tests.judging import judge
from tests.transforms import mirrored, turned

PLANNERS = ["gcm", "layered", "marching", "straight"]
SOONEST = ["layered", "straight"]  # planners that may wait and start at full speed
REST = (0.0, 0.0)
ARM = Arm((1.3, 0.6), 3.0)
FLAT = Plane((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))


@pytest.fixture(params=PLANNERS)
def planner(request):
    return request.param


def goal(position, velocity=REST, acceleration=REST, radius=0.08):
    return Body("target", "goal", Disc(radius), PlanarQuadratic(position, velocity, acceleration))


def post(position, radius=0.1, velocity=REST):
    name = f"post at {position}"
    return Body("obstacle", name, Disc(radius), PlanarQuadratic(position, velocity, REST))


def scene(*bodies, arm=ARM, horizon=2.0):
    return Situation("scene", horizon, arm, bodies)


def checked(situation, planner):
    """Solve, and let the referee see every catch."""
    plan = solve(situation, planner)
    assert plan.planner == planner and plan.name == situation.name
    assert plan.message and "\n" not in plan.message
    assert plan.planning_ms > 0.0
    if plan.status == "caught":
        assert judge(situation, plan) == []
    else:
        nothing = (plan.catch_time, plan.catch_body, plan.clearance, plan.trajectory)
        assert nothing == (None, None, None, None)
    return plan


# --- blocked at the start --------------------------------------------------------------------

# Hand at (1, -1): the upper arm lies on -y, the forearm along +x at y = -1.
FOLDED = Arm((1.0, -1.0), 3.0)


@pytest.mark.parametrize("at", [(0.0, -0.5), (0.05, -0.95), (0.5, -1.05), (1.05, -1.0), (0.0, 0.0)])
def test_a_limb_that_touches_at_the_start_is_blocked(planner, at):
    plan = checked(scene(goal((1.4, -0.9)), post(at), arm=FOLDED), planner)
    assert plan.status == "start_blocked"
    assert re.fullmatch("(upper arm|forearm) and 'post at .*' overlap by .* at t = 0", plan.message)


@pytest.mark.parametrize("at", [(0.2, -0.5), (0.5, -0.8), (0.5, -1.2), (-0.2, -1.0)])
def test_a_limb_beside_an_obstacle_is_not(planner, at):
    """A disc of 0.1 at 0.2 from the limb leaves room for a thickness below 0.1."""
    away = goal((1.5, -1.2), radius=0.05)
    thin, thick = (replace(FOLDED, thickness=t) for t in (0.09, 0.11))
    assert checked(scene(away, post(at), arm=thin), planner).status != "start_blocked"
    assert checked(scene(away, post(at), arm=thick), planner).status == "start_blocked"


def test_the_other_elbow_is_somewhere_else(planner):
    left = replace(FOLDED, elbow="left")
    in_the_way = post((0.5, -1.05))
    assert checked(scene(goal((1.4, -0.9)), in_the_way, arm=left), planner).status == "caught"


def test_a_target_never_blocks(planner):
    lying_on_the_arm = goal((0.5, -1.0), radius=0.2)
    plan = checked(scene(lying_on_the_arm, arm=FOLDED), planner)
    assert plan.status == "caught"


def test_a_solid_that_only_passes_over_the_arm_does_not_block(planner):
    still = ((0.0,) * 3, (0.0,) * 3)
    for height, status in ((0.15, "caught"), (0.05, "start_blocked")):
        over = Body("obstacle", "over", Sphere(0.1), SolidQuadratic((0.5, -1.0, height), *still))
        ball = Body("target", "goal", Sphere(0.1), SolidQuadratic((1.4, -1.1, 0.02), *still))
        situation = Situation("scene", 2.0, FOLDED, (ball, over), FLAT)
        assert checked(situation, planner).status == status


# --- hopeless --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("target", "horizon"),
    [
        (goal((3.0, 0.0)), 2.0),
        (goal((3.0, 0.0), (1.0, 0.5)), 2.0),
        (goal((30.0, 0.0), (-10.0, 0.0)), 2.0),  # too late
        (goal((-1.2, -1.0)), 0.5),  # within reach, but too far for the time
        (goal((1.3, 2.5), (0.0, -1.0), (0.0, 2.0)), 2.0),  # turns back in time
    ],
)
def test_a_target_that_never_comes_within_reach_is_unreachable_at_once(planner, target, horizon):
    plan = checked(scene(target, horizon=horizon), planner)
    assert plan.status == "unreachable" and plan.map is None


def test_a_solid_beside_the_plane_is_unreachable(planner):
    beside = Body("target", "goal", Sphere(0.1), SolidQuadratic((1.4, 0.0, 0.2), REST3, REST3))
    assert checked(Situation("s", 1.0, ARM, (beside,), FLAT), planner).status == "unreachable"


REST3 = (0.0, 0.0, 0.0)


def test_a_target_in_the_hole_of_the_ring_is_unreachable(planner):
    arm = Arm((1.3, 0.6), 3.0, upper_arm=1.5, grasp=0.02)
    plan = checked(scene(goal((0.1, 0.0), radius=0.1), arm=arm), planner)
    assert plan.status == "unreachable"
    assert checked(scene(goal((0.45, 0.0), radius=0.1), arm=arm), planner).status == "caught"


def test_a_target_behind_a_closed_wall_is_unreachable(planner):
    """A bar through the arm's plane on either side: the arm cannot get round."""
    bars = [((0.1, 0.3), (2.5, 0.3)), ((-2.5, 0.3), (-0.1, 0.3))]
    walls = [
        Body(
            "obstacle",
            f"bar {k}",
            Polygon(((a, y), (b, y), (b, y + 0.1), (a, y + 0.1))),
            PlanarQuadratic(REST, REST, REST),
        )
        for k, ((a, y), (b, _)) in enumerate(bars)
    ]
    situation = scene(goal((1.0, 1.2)), *walls, arm=Arm((1.2, -0.8), 3.0))
    assert checked(situation, planner).status == "unreachable"


# --- at once, waiting, free space ------------------------------------------------------------


def test_a_target_in_the_hand_is_caught_at_once(planner):
    plan = checked(scene(goal((1.35, 0.65)), post((-1.0, 0.3))), planner)
    assert plan.status == "caught" and plan.catch_time == 0.0
    assert plan.trajectory.time[-1] == 0.0
    assert (plan.trajectory.hand == ARM.hand).all()


@pytest.mark.parametrize("speed", [0.001, 0.01, 0.1])
@pytest.mark.parametrize("planner", SOONEST)
def test_a_target_that_comes_to_the_hand_is_awaited(speed, planner):
    """The hand is too slow to go anywhere; the ball flies into it."""
    flying = goal((1.3 - 1.2, 0.6 + 0.9), (2.0, -1.5))
    slow = replace(ARM, max_hand_speed=speed)
    plan = checked(scene(flying, arm=slow, horizon=1.0), planner)
    assert plan.status == "caught"
    assert plan.catch_time == pytest.approx((1.5 - 0.08 - 0.05) / (2.5 + speed), abs=0.005)


@pytest.mark.parametrize("planner", SOONEST)
def test_a_target_that_grazes_the_grasp_is_awaited(planner):
    """It never comes to the hand, only by: a chord of 0.1 s, half a thickness of the ball deep."""
    passing = goal((1.3 - 1.0, 0.6 + 0.12), (2.0, 0.0))
    slow = replace(ARM, max_hand_speed=0.001)
    plan = checked(scene(passing, arm=slow, horizon=1.0), planner)
    assert plan.status == "caught"
    assert plan.catch_time == pytest.approx(0.475, abs=0.005)


def test_fronts_that_cannot_wait_say_nothing_wrong(planner):
    """Erratum 16: what comes in behind the front may be missed, but nothing is promised then."""
    for speed in (0.01, 0.1, 0.5):
        slow = replace(ARM, max_hand_speed=speed)
        flying = goal((1.3 - 1.2, 0.6 + 0.9), (2.0, -1.5))
        assert checked(scene(flying, arm=slow, horizon=1.0), planner).status != "start_blocked"


@pytest.mark.parametrize("position", [(1.0, -0.9), (1.7, 0.5), (0.9, 1.1)])
def test_in_free_space_catches_come_as_soon_as_can_be(planner, position):
    plan = checked(scene(goal(position)), planner)
    soonest = (math.dist(position, ARM.hand) - 0.08 - ARM.grasp) / ARM.max_hand_speed
    # The wave loses some 26 tau (0.07 s) at its start and 7 % along the axes (erratum 9).
    late = 0.09 + 0.08 * soonest if planner == "gcm" else 0.01
    assert soonest - 1e-6 <= plan.catch_time <= soonest + late


def test_a_ball_that_flies_towards_the_hand_is_met_on_the_way(planner):
    plan = checked(scene(goal((1.3, -1.4), (0.0, 2.0))), planner)
    soonest = (2.0 - 0.08 - ARM.grasp) / (3.0 + 2.0)
    assert soonest - 1e-6 <= plan.catch_time <= soonest + 0.12


def test_without_obstacles_there_is_no_clearance(planner):
    alone = scene(goal((1.0, -0.9)))
    plan = checked(alone, planner)
    assert plan.clearance == math.inf
    assert plan_to_json(plan, alone)["clearance"] is None


def test_a_hand_without_grasp_has_to_touch_the_target_itself(planner):
    bare = replace(ARM, grasp=0.0)
    plan = checked(scene(goal((1.0, -0.9)), post((1.9, 0.0)), arm=bare), planner)
    assert plan.status == "caught"
    assert math.dist(plan.trajectory.hand[-1], (1.0, -0.9)) <= 0.08


def test_of_two_targets_the_nearer_is_caught(planner):
    far = replace(goal((-1.0, 1.0)), name="far")
    plan = checked(scene(far, goal((1.5, 0.0))), planner)
    assert plan.catch_body == "goal"


def test_obstacles_are_gone_round():
    """Where the straight way touches, the fronts find one that does not."""
    situation = scene(goal((1.4, -1.0)), post((1.5, 0.0), 0.2), arm=Arm((1.5, 1.0), 3.0))
    assert checked(situation, "straight").status == "unreachable"
    for planner in ("gcm", "marching", "layered"):
        plan = checked(situation, planner)
        assert plan.status == "caught" and plan.clearance > 0.0
        if planner in ("gcm", "marching"):
            assert plan.map.interception.body == "goal"


def test_the_catch_must_come_before_the_horizon(planner):
    free = checked(scene(goal((1.0, -0.9))), planner)
    if planner != "gcm":  # a finer lattice may yet be in time
        short = scene(goal((1.0, -0.9)), horizon=0.98 * free.catch_time)
        assert checked(short, planner).status == "unreachable"
    long = scene(goal((1.0, -0.9)), horizon=1.1 * free.catch_time)
    assert checked(long, planner).status == "caught"


@pytest.mark.parametrize("target", [(-0.5, 0.0), (-1.3, 0.0), (-0.8, 1e-3)])
def test_no_way_runs_through_the_shoulder(planner, target):
    """With rho = 1 the arm folds there and would have to turn round within no time (erratum 5)."""
    plan = checked(scene(goal(target), arm=Arm((1.0, 0.0), 4.0)), planner)
    assert plan.status == "caught" or planner == "straight"
    if plan.status == "caught":
        assert np.abs(np.diff(plan.trajectory.joints, axis=0)).max() < 1.0


# --- joint limits ----------------------------------------------------------------------------


@pytest.mark.parametrize("joint", [0, 1])
def test_slow_joints_make_a_slow_catch(planner, joint):
    free = checked(scene(goal((1.0, -0.9))), "straight")
    rates = np.abs(np.diff(free.trajectory.joints, axis=0)).T / np.diff(free.trajectory.time)
    limits = [100.0, 100.0]
    limits[joint] = float(0.5 * rates[joint].max())
    arm = replace(ARM, max_joint_speed=tuple(limits))
    plan = checked(scene(goal((1.0, -0.9)), arm=arm, horizon=5.0), planner)
    assert plan.status == "caught" and plan.catch_time > 1.05 * free.catch_time


def test_generous_joints_change_nothing(planner):
    free = checked(scene(goal((1.0, -0.9)), post((1.9, 0.0))), planner)
    arm = replace(ARM, max_joint_speed=(1e3, 1e3))
    limited = checked(scene(goal((1.0, -0.9)), post((1.9, 0.0)), arm=arm), planner)
    assert limited.catch_time == pytest.approx(free.catch_time, abs=2e-3)


# --- the same again --------------------------------------------------------------------------


def answer(plan):
    """What must not depend on anything but the situation."""
    return {key: value for key, value in plan_to_json(plan).items() if key != "planning_ms"}


def test_plans_are_deterministic(planner):
    """Whatever was solved before, and in whatever thread."""
    situations = [random_planar(seeding.rng(71, k), (2, 5)) for k in range(12)]
    situations += [random_solid(seeding.rng(71, k)) for k in range(4)]
    first = [answer(solve(s, planner)) for s in situations]
    assert sum(a["status"] == "caught" for a in first) >= 4
    again = [answer(solve(s, planner)) for s in situations[::-1]][::-1]
    assert again == first
    with ThreadPoolExecutor(2) as pool:
        assert [answer(p) for p in pool.map(lambda s: solve(s, planner), situations)] == first


def compare(planner, change, seed, tolerance, exceptions=0.1):
    """Answers to changed situations: the same statuses and catch times, with few exceptions."""
    differences, caught = [], 0
    count = 50
    for k in range(count):
        situation = random_planar(seeding.rng(seed, k))
        here, there = (solve(s, planner) for s in (situation, change(situation)))
        caught += here.status == "caught"
        if (here.status == "start_blocked") != (there.status == "start_blocked"):
            differences.append((k, here.status, there.status))
        elif here.status != there.status:
            differences.append((k, here.message, there.message))
        elif here.caught and abs(here.catch_time - there.catch_time) > tolerance:
            differences.append((k, here.catch_time, there.catch_time))
    assert caught > count / 4
    # Ties are broken by the order of cells and rounding decides at obstacles' edges, so that now
    # and then another way is found.
    assert len(differences) <= exceptions * count, differences


def test_the_mirror_image_has_the_mirrored_answer(planner):
    compare(planner, mirrored, 72, 1e-6 if planner == "straight" else 0.02)


def test_a_quarter_turn_changes_nothing(planner):
    compare(
        planner, lambda s: turned(s, 0.5 * math.pi), 73, 1e-6 if planner == "straight" else 0.02
    )


def test_any_turn_changes_little():
    compare("straight", lambda s: turned(s, 0.7), 74, 1e-3)
    compare("marching", lambda s: turned(s, 0.7), 74, 0.05, exceptions=0.2)
