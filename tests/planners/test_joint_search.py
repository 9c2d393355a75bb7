"""The planner of first choice for spatial arms: what it claims holds, and what it must find."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from gcm_learn import families, get_planner, seeding, solve
from gcm_learn.arms import forward_in_space
from gcm_learn.charts import joint_lattice
from gcm_learn.charts.joint_lattice import nearest, neighbour, posture_of
from gcm_learn.planners.joints.backward import reversed_scene
from gcm_learn.planners.joints.layered import LayeredInSpace
from gcm_learn.scene import pack, poses_at
from gcm_learn.situation import (
    Body,
    Box,
    Capsule,
    Cylinder,
    Pendulum,
    Situation,
    SolidQuadratic,
    Sphere,
    read_situations,
    situation_from_json,
)
from tests.referee import judge
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


def test_the_referee_has_no_complaints():
    caught = 0
    for k in range(40):
        situation = scene_of(seeding.rng(7, k), walls=k % 4)
        plan = solve(situation, "layered")
        caught += plan.caught
        assert not plan.caught or judge(situation, plan).complaints == []
    assert caught >= 20


def test_examples_are_caught():
    situations = [s for s in read_situations(EXAMPLES) if s.arm.max_joint_acceleration is None]
    plans = [solve(situation, "layered") for situation in situations]
    assert sum(plan.caught for plan in plans) >= 0.9 * len(plans)
    for situation, plan in zip(situations, plans, strict=True):
        assert not plan.caught or judge(situation, plan).complaints == []


def behind(cover):
    """A ball that rests within reach, and a box that covers it."""
    arm = SPATIAL.arm
    place = forward_in_space(arm, (0.3, 0.3, 0.2, -0.6))[1]
    ball = Body("target", "ball", Sphere(0.02), still(place))
    box = Body("obstacle", "cover", Box((0.06, 0.06, 0.06)), replace(cover, position=tuple(place)))
    return Situation("covered", 1.0, arm, (ball, box))


def test_it_waits_until_a_cover_has_gone():
    situation = behind(SolidQuadratic(NOTHING, NOTHING, (0.0, 0.0, 2.0)))
    plan = solve(situation, "layered")
    assert plan.caught and judge(situation, plan).complaints == []
    assert plan.catch_time > math.sqrt(2.0 * 0.05 / 2.0)


@pytest.mark.parametrize(("family", "index"), [("bench-space", 10), ("crate-space", 6)])
def test_a_target_that_can_only_be_grazed_is_caught(family, index):
    """No posture with the hand at its centre, or where it is nearest, is free at any time."""
    situation = families.draw(family, 1300, index)
    arm = replace(situation.arm, max_joint_acceleration=None, joint_rates=None)
    situation = replace(situation, arm=arm)
    plan = LayeredInSpace().plan(situation)
    assert plan.caught
    assert judge(situation, plan).complaints == []


def test_what_is_shut_in_is_given_up_soon():
    plan = solve(behind(still(NOTHING)), "layered")
    assert not plan.caught
    assert plan.failure is not None


def test_the_earliest_catch_is_no_later_and_a_bound_is_kept():
    for k in range(6):
        situation = scene_of(seeding.rng(8, k))
        first = LayeredInSpace().plan(situation)
        earliest = LayeredInSpace(earliest=True).plan(situation)
        assert first.caught == earliest.caught
        if not first.caught or first.catch_time == 0.0:
            continue
        assert earliest.catch_time <= first.catch_time
        bounded = get_planner("layered").plan(situation, bound=first.catch_time)
        assert not bounded.caught or bounded.catch_time <= first.catch_time


def test_a_bound_is_a_time():
    with pytest.raises(ValueError, match="bound: must be positive"):
        LayeredInSpace().plan(SPATIAL, bound=0.0)


def test_time_runs_backwards():
    down = (0.0, 0.0, -1.0)
    cord = Pendulum((0.1, 0.0, 0.5), (0.0, 1.0, 0.0), down, 0.3, 9.81, 0.8, -1.0)
    thrown = SolidQuadratic(
        (0.1, 0.2, 0.3), (0.3, -0.1, 1.0), (0.0, 0.0, -9.81), spin=(1.0, -2.0, 3.0)
    )
    bodies = [
        Body("target", "ball", Sphere(0.02), thrown),
        Body("obstacle", "box", Box((0.1, 0.2, 0.3)), thrown),
        Body("obstacle", "cord", Capsule(0.01, 0.2), cord),
    ]
    scene = pack(Situation("all", 0.9, SPATIAL.arm, tuple(bodies)))
    back = reversed_scene(scene)
    ahead, there = np.zeros((2, 3, 12))
    for t in (0.0, 0.05, 0.31, 0.899, 0.9):
        poses_at(scene.bodies, t, ahead)
        poses_at(back.bodies, 0.9 - t, there)
        np.testing.assert_allclose(there, ahead, atol=1e-9)


@pytest.mark.parametrize("nodes", [16**4, 500, 1])
def test_a_lattice_holds_the_start_and_the_ends(nodes):
    scene = pack(SPATIAL)
    lattice = joint_lattice(scene, nodes)
    q = np.zeros(4)
    posture_of(lattice, lattice.start, q)
    np.testing.assert_array_equal(q, scene.limb.start)
    for j in range(4):
        values = lattice.values[j, : lattice.counts[j]]
        assert (np.diff(values) > 0.0).all()
        assert scene.limb.low[j] <= values[0] and values[-1] <= scene.limb.high[j]
        node = lattice.start
        while neighbour(lattice, node, j, 1) >= 0:
            node = neighbour(lattice, node, j, 1)
        posture_of(lattice, node, q)
        assert q[j] == values[-1]


def test_nodes_about_a_posture_are_the_corners_of_its_cell(rng):
    scene = pack(SPATIAL)
    lattice, q = joint_lattice(scene, 2000), np.zeros(4)
    ends = lattice.values[:, 0], lattice.values[range(4), lattice.counts - 1]
    for _ in range(20):
        posture = rng.uniform(*ends)
        corners = [nearest(lattice, posture, corner) for corner in range(16)]
        assert len(set(corners)) == 16 and min(corners) >= 0
        for corner, node in enumerate(corners):
            posture_of(lattice, node, q)
            above = np.array([corner >> j & 1 for j in range(4)], dtype=bool)
            assert ((q >= posture) == above).all()
