"""Any valid situation gets one of three answers: no crash, no hang, no NaN."""

from __future__ import annotations

import json
import math
import time
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, example, given, settings, strategies as st

from gcm_learn import solve
from gcm_learn.arms import Arm
from gcm_learn.planners import plan_to_json
from gcm_learn.situation import (
    Body,
    Box,
    Capsule,
    Cylinder,
    Disc,
    Pendulum,
    PlanarQuadratic,
    Polygon,
    Situation,
    SolidQuadratic,
    Sphere,
)
from gcm_learn.situation.motion import MOST_PERIODS
from tests import strategies
from tests.extras import INSTALLED
from tests.judging import judge

LONGEST = {False: 60.0, True: 20.0}
"""Processor time for one plan, in the plane and in space [s]; usual ones take milliseconds."""
SLOW = {"layered", "oracle", "st-rrt-star"}
planners = [name for name in INSTALLED if name not in ("oracle", "st-rrt-star")]
every = st.sampled_from([name for name in INSTALLED if name != "oracle"])
quick = st.sampled_from([name for name in INSTALLED if name not in SLOW])


def answered(situation, planner):
    """Solve in time and check the form of the answer."""
    started = time.thread_time()
    plan = solve(situation, planner)
    assert time.thread_time() - started < LONGEST[situation.is_spatial]
    record = plan_to_json(plan, situation)
    assert record == json.loads(json.dumps(record, allow_nan=False))
    assert record["status"] in ("caught", "unreachable", "start_blocked")
    assert (record["status"] == "caught") == ("trajectory" in record)
    return plan


def complaints(situation, plan):
    """Complaints, but for ways through the shoulder, which have their own test."""
    found = judge(situation, plan)
    if np.linalg.norm(plan.trajectory.hand, axis=1).min() < 0.02:
        found = [complaint for complaint in found if "joints" not in complaint]
    return found


@pytest.fixture(scope="module", autouse=True)
def _compiled():
    """Compile everything before the clock runs."""
    rest = ((0.0, 0.0), (0.0, 0.0))
    goal = Body("target", "goal", Disc(0.1), PlanarQuadratic((-1.0, 0.5), *rest))
    post = Body("obstacle", "post", Disc(0.3), PlanarQuadratic((0.3, 1.2), *rest))
    for planner in planners:
        solve(Situation("warm", 2.0, Arm((1.2, 0.5), 3.0), (goal, post)), planner)


@settings(max_examples=25)
@given(strategies.situations(), st.sampled_from(planners))
def test_valid_situations_get_an_answer_that_holds(situation, planner):
    plan = answered(situation, planner)
    if plan.caught:
        assert complaints(situation, plan) == []


# Sizes, places and speeds from far too small to far too large, and plain ones among them.
wild = st.sampled_from([1e-9, 1e-6, 1e-3, 0.03, 0.3, 1.0, 3.0, 30.0, 1e3, 1e6, 1e9])
signed = st.tuples(wild, st.sampled_from([-1.0, 0.0, 1.0])).map(math.prod)
plain = st.floats(-2.0, 2.0)
numbers = plain | signed
sizes = st.floats(0.02, 0.4) | wild


@st.composite
def wild_arms(draw):
    """Arms of any proportion, their hand anywhere in the ring, the rims included."""
    rho = draw(st.just(1.0) | wild)
    share = draw(st.sampled_from([0.0, 1e-9, 1.0, 1.0 - 1e-9]) | st.floats(0.0, 1.0))
    radius = abs(rho - 1.0) + share * (rho + 1.0 - abs(rho - 1.0))
    angle = draw(st.sampled_from([0.0, 0.5 * math.pi]) | strategies.angles)
    limits = st.tuples(wild, wild)
    return Arm(
        hand=(radius * math.cos(angle), radius * math.sin(angle)),
        max_hand_speed=draw(st.just(3.0) | wild),
        upper_arm=rho,
        elbow=draw(st.sampled_from(["left", "right"])),
        max_joint_speed=draw(st.none() | limits),
        thickness=draw(st.just(0.0) | wild),
        grasp=draw(st.sampled_from([0.0, 0.05]) | wild),
    )


def rectangles(a, b):
    return Polygon(((-a, -b), (a, -b), (a, b), (-a, b)))


def wild_motions(size, kind):
    vectors = strategies.vectors(size, numbers)
    if kind is PlanarQuadratic:
        return st.builds(kind, vectors, vectors, vectors, numbers, numbers)
    turns = strategies.unit_vectors(4)
    quadratic = st.builds(SolidQuadratic, vectors, vectors, vectors, turns, vectors)
    swings = st.builds(
        lambda frame, pivot, length, gravity, angle, rate: Pendulum(
            pivot, *frame, length, abs(gravity), angle, rate
        ),
        strategies.frames(),
        vectors,
        sizes,
        numbers,
        plain,
        numbers,
    )
    return quadratic | swings


planar = st.tuples(
    st.builds(Disc, sizes) | st.builds(rectangles, sizes, sizes), wild_motions(2, PlanarQuadratic)
)
solid = st.tuples(
    st.builds(Sphere, sizes)
    | st.builds(Box, st.tuples(sizes, sizes, sizes))
    | st.builds(Capsule, sizes, sizes)
    | st.builds(Cylinder, sizes, sizes),
    wild_motions(3, SolidQuadratic),
)


def wild_horizons(draw, bodies):
    """Draw a horizon in which no pendulum swings so often that it is refused."""
    horizon = draw(st.floats(0.05, 1.0) | wild)
    swings = [body.motion.fastest for body in bodies if isinstance(body.motion, Pendulum)]
    assume(max(swings, default=0.0) * horizon < 2.0 * math.pi * MOST_PERIODS)
    return horizon


@st.composite
def wild_situations(draw):
    """Situations whose numbers may have any magnitude."""
    space, plane = draw(st.sampled_from([(planar, st.none()), (solid, strategies.planes())]))
    parts = draw(st.lists(space, min_size=1, max_size=3))
    bodies = tuple(
        Body("obstacle" if k else "target", str(k), shape, motion)
        for k, (shape, motion) in enumerate(parts)
    )
    return Situation("wild", wild_horizons(draw, bodies), draw(wild_arms()), bodies, draw(plane))


REST = ((0.0, 0.0), (0.0, 0.0))
STATIC = (Body("target", "0", Disc(0.1), PlanarQuadratic((1.6, -0.9), *REST)),)
MOVING = (Body("target", "0", Disc(0.1), PlanarQuadratic((1.6, -0.9), (0.1, 0.1), (0.0, 0.0))),)
FAST = Body("obstacle", "1", rectangles(1e6, 1e-6), PlanarQuadratic((5.0, 5.0), *REST, 0.0, 1e6))


@settings(max_examples=25)
@given(wild_situations(), quick)
@example(
    Situation("slow joints", 1.0, Arm((1.0, 0.5), 3.0, 1.0, "right", (5.0, 1e-9)), MOVING), "gcm"
)
@example(
    Situation("slow joints", 1.0, Arm((1.0, 0.5), 3.0, 1.0, "right", (5.0, 1e-9)), MOVING),
    "marching",
)
@example(Situation("for ever", 1e9, Arm((1.0, 0.5), 3.0), MOVING), "marching")
@example(Situation("for ever", 1e9, Arm((1.0, 0.5), 1e-9), STATIC), "straight")
@example(Situation("spinning", 1.0, Arm((1.0, 0.5), 3.0), (*STATIC, FAST)), "marching")
@example(Situation("no upper arm", 1.0, Arm((1.0, 0.0), 3.0, 1e-9), STATIC), "gcm")
@example(Situation("no forearm", 1.0, Arm((1e9, 0.0), 3.0, 1e9), STATIC), "gcm")
@example(Situation("all grasp", 1.0, Arm((1.0, 0.5), 3.0, grasp=1e9), STATIC), "straight")
@example(Situation("all arm", 1.0, Arm((1.0, 0.5), 3.0, thickness=1e9), STATIC), "gcm")
def test_wild_situations_get_an_answer(situation, planner):
    answered(situation, planner)


@pytest.mark.slow
@settings(max_examples=500)
@given(wild_situations(), every)
def test_many_wild_situations_get_an_answer(situation, planner):
    answered(situation, planner)


@pytest.mark.slow
@settings(max_examples=500)
@given(strategies.situations(), every)
def test_many_valid_situations_get_an_answer_that_holds(situation, planner):
    plan = answered(situation, planner)
    if plan.caught:
        assert complaints(situation, plan) == []


@pytest.mark.parametrize("planner", ["gcm", "layered", "marching", "straight"])
@pytest.mark.parametrize("speed", [1e-6, 1e-3, 1e3, 1e6])
def test_speed_does_not_matter_for_a_world_at_rest(planner, speed):
    """A static scene, slowed down or sped up with its horizon, has the same catch."""
    usual = Situation("usual", 2.0, Arm((1.0, 0.5), 3.0), STATIC)
    plan = answered(usual, planner)
    other = replace(usual, horizon=2.0 * 3.0 / speed, arm=replace(usual.arm, max_hand_speed=speed))
    again = answered(other, planner)
    assert again.status == plan.status == "caught"
    assert again.catch_time * speed == pytest.approx(plan.catch_time * 3.0, rel=0.02)
