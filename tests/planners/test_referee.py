"""The referee itself: it must find fault with plans that have been tampered with."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gcm_learn import solve
from gcm_learn.arms import Arm
from gcm_learn.motion import Movement
from gcm_learn.motion.rules import rules_of
from gcm_learn.motion.verification import verify
from gcm_learn.scene.packing import pack
from gcm_learn.situation import (
    Body,
    Box,
    Disc,
    PlanarQuadratic,
    Plane,
    Polygon,
    Situation,
    SolidQuadratic,
    Sphere,
)
from tests.referee import judge, windings, within_grasp

REST = (0.0, 0.0)
ARM = Arm((1.5, 0.8), 3.0, max_joint_speed=(9.0, 9.0))
GOAL = Body("target", "goal", Disc(0.1), PlanarQuadratic((1.4, -0.9), REST, REST))
POST = Body("obstacle", "post", Disc(0.1), PlanarQuadratic((1.9, 0.0), REST, REST))
SCENE = Situation("scene", 2.0, ARM, (GOAL, POST))


@pytest.fixture(scope="module")
def plan():
    plan = solve(SCENE, "straight")
    assert judge(SCENE, plan).complaints == []
    return plan


def tampered(plan, **changes):
    """Return the plan with another trajectory: arrays are replaced, joints made anew."""
    path = plan.trajectory
    time, hand = changes.get("time", path.time), changes.get("hand", path.hand)
    joints = changes.get("joints")
    fresh = Movement.of_hand(ARM, time, hand)
    path = fresh if joints is None else Movement(ARM, time, joints, path=hand)
    return replace(plan, trajectory=path, catch_time=float(time[-1]))


def faults(plan, situation=SCENE):
    """Complaints of the referee; the package's own verification must not be content either."""
    body = [b.name for b in situation.bodies].index(plan.catch_body)
    scene = pack(situation)
    verdict = verify(scene, rules_of(scene), plan.trajectory, body)
    complaints = judge(situation, plan).complaints
    assert not verdict.good or not complaints, complaints
    return " | ".join(complaints)


def test_haste_is_noticed(plan):
    assert "too fast" in faults(tampered(plan, time=0.98 * plan.trajectory.time))
    joints = replace(SCENE, arm=replace(ARM, max_joint_speed=(9.0, 0.5)))
    assert "a joint is too fast" in faults(plan, joints)


def test_a_jump_is_noticed(plan):
    time = plan.trajectory.time.copy()
    time[5] = time[4]
    assert "too fast" in faults(tampered(plan, time=time))


def test_another_start_is_noticed(plan):
    hand = plan.trajectory.hand.copy()
    hand[0] += 1e-3
    assert "starts on the hand" in faults(tampered(plan, hand=hand))
    late = plan.trajectory.time + 0.1
    assert "starts at t = 0" in faults(tampered(plan, time=late))


def test_a_miss_is_noticed(plan):
    short = slice(0, len(plan.trajectory.time) - 3)
    path = {"time": plan.trajectory.time[short], "hand": plan.trajectory.hand[short]}
    assert "misses" in faults(tampered(plan, **path))


def test_a_late_catch_is_noticed(plan):
    assert "horizon" in faults(tampered(plan, time=5.0 * plan.trajectory.time))


@pytest.mark.parametrize("at", [(1.45, 0.0), (0.5, -0.5), (0.95, -0.25)])
def test_a_touch_is_noticed(plan, at):
    """A needle in the way of the hand, of the upper arm, of the elbow."""
    needle = Body("obstacle", "needle", Disc(1e-3), PlanarQuadratic(at, REST, REST))
    assert "touches" in faults(plan, replace(SCENE, bodies=(GOAL, needle)))


def test_a_touch_between_samples_is_noticed(plan):
    """A bullet that crosses the forearm half way between two samples."""
    path = plan.trajectory
    moment = 0.5 * (path.time[7] + path.time[8])
    hand = path.hand_at(moment)
    motion = PlanarQuadratic(
        tuple(0.97 * hand - moment * np.array([0.0, 300.0])), (0.0, 300.0), REST
    )
    bullet = Body("obstacle", "bullet", Disc(1e-3), motion)
    assert "touches" in faults(plan, replace(SCENE, bodies=(GOAL, bullet)))


def test_thickness_counts(plan):
    clear = judge(SCENE, plan).clearance
    for thickness, noticed in ((0.9 * clear, False), (1.1 * clear, True)):
        thick = replace(SCENE, arm=replace(ARM, thickness=thickness))
        found = judge(thick, replace(plan, clearance=clear - thickness)).complaints
        assert any("touches" in complaint for complaint in found) == noticed


def test_leaving_the_ring_is_noticed(plan):
    hand = plan.trajectory.hand.copy()
    hand[3:] *= 2.01 / np.linalg.norm(hand[3:], axis=1, keepdims=True)
    assert "ring" in faults(tampered(plan, hand=hand))


def test_wrong_joints_are_noticed(plan):
    joints = plan.trajectory.joints
    assert "joints" in " ".join(judge(SCENE, tampered(plan, joints=joints + 1e-3)).complaints)
    wrapped = joints.copy()
    wrapped[5:, 0] += 2.0 * np.pi
    assert "continuous" in " ".join(judge(SCENE, tampered(plan, joints=wrapped)).complaints)
    left = replace(ARM, elbow="left")
    other = Movement.of_hand(left, plan.trajectory.time, plan.trajectory.hand).joints
    assert "elbow" in " ".join(judge(SCENE, tampered(plan, joints=other)).complaints)


def test_a_wrong_clearance_or_body_is_noticed(plan):
    assert "clearance" in " ".join(judge(SCENE, replace(plan, clearance=0.5)).complaints)
    assert "is a target" in " ".join(judge(SCENE, replace(plan, catch_body="post")).complaints)


def test_windings_tell_inside_from_outside():
    bay = np.array([(0, 0), (3, 0), (3, 3), (2, 3), (2, 1), (1, 1), (1, 3), (0, 3)], dtype=float)
    points = np.array([(0.5, 2.0), (1.5, 2.0), (2.5, 2.0), (1.5, 0.5), (4.0, 1.0)])
    assert windings(bay, points).tolist() == [1, 0, 1, 1, 0]


@pytest.mark.parametrize(("gap", "caught"), [(0.049, True), (0.051, False)])
def test_the_grasp_of_planar_targets(plan, gap, caught):
    square = Polygon(((-0.1, -0.1), (0.1, -0.1), (0.1, 0.1), (-0.1, 0.1)))
    end = plan.trajectory.hand[-1]
    for shape in (Disc(0.1), square):
        motion = PlanarQuadratic((end[0] + 0.1 + gap, end[1]), REST, REST)
        situation = replace(SCENE, bodies=(replace(GOAL, shape=shape, motion=motion),))
        assert within_grasp(situation, plan) == caught


@pytest.mark.parametrize(("gap", "caught"), [(0.0499, True), (0.0501, False)])
def test_the_grasp_of_solids_is_measured_in_the_plane_to_their_cut(plan, gap, caught):
    """A ball whose centre is 0.06 above the plane is cut in a disc of radius 0.08."""
    end = plan.trajectory.hand[-1]
    plane = Plane((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    for shape, half in ((Sphere(0.1), 0.08), (Box((0.08, 0.2, 0.1)), 0.08)):
        motion = SolidQuadratic((end[0] + half + gap, end[1], 0.06), (0.0,) * 3, (0.0,) * 3)
        target = Body("target", "goal", shape, motion)
        situation = replace(SCENE, bodies=(target,), plane=plane)
        assert within_grasp(situation, plan) == caught
    over = SolidQuadratic((*end, 0.11), (0.0,) * 3, (0.0,) * 3)
    situation = replace(SCENE, bodies=(Body("target", "goal", Sphere(0.1), over),), plane=plane)
    assert not within_grasp(situation, plan)  # right over the hand, but it does not meet the plane
