"""The paper's scenes and the examples: valid, and what they are made to show."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from gcm_learn.families import paper
from gcm_learn.families.paper import gate_scene
from gcm_learn.planners import solve
from gcm_learn.scene.outlines import cut_outline
from gcm_learn.scene.packing import pose
from gcm_learn.situation import Box, Disc, Situation, Sphere, situation_from_json, situation_to_json


def body_index(situation: Situation, name: str) -> int:
    return [body.name for body in situation.bodies].index(name)


def cut_at(situation: Situation, name: str, tau: float) -> np.ndarray:
    """Outline of a solid's cut with the arm plane; (0, 2) when there is none."""
    index = body_index(situation, name)
    return cut_outline(situation.bodies[index].shape, *pose(situation, index, tau * paper.KAPPA))


@pytest.mark.parametrize("name", paper.PAPER_SCENES)
def test_a_scene_has_the_papers_arm_and_time_after_the_captions_contact(name):
    situation = paper.PAPER_SCENES[name]()
    assert situation.name == name
    assert situation_from_json(situation_to_json(situation)) == situation
    instants = paper.CAPTION_INSTANTS.get(name, (0.0,))
    assert situation.horizon > 1.5 * instants[-1] * paper.KAPPA
    arm = situation.arm
    assert (arm.upper_arm, arm.elbow, arm.thickness) == (1.0, "right", 0.0)
    assert arm.max_hand_speed == paper.HAND_SPEED


def test_hand_speed_gives_the_papers_time_scale():
    from gcm_learn.wave.params import WaveParams
    from gcm_learn.wave.solver import front_speed

    kappa = front_speed(WaveParams()).fastest * paper.LATTICE_SPACING / paper.HAND_SPEED
    assert kappa == pytest.approx(paper.KAPPA, rel=0.01)


def test_fig1_direct_way_is_barred():
    """The forearm crosses the point somewhere on the straight way of the hand."""
    from gcm_learn.arms.planar_limb import elbow_position

    situation = paper.fig1()
    start = np.array(situation.arm.hand)
    goal = np.array(situation.targets[0].motion.position)
    point = np.array(situation.obstacles[0].motion.position)
    side = []
    for share in np.linspace(0.0, 1.0, 200):
        hand = start + share * (goal - start)
        elbow = elbow_position(hand)
        along = np.clip((point - elbow) @ (hand - elbow), 0.0, 1.0)
        side.append(np.linalg.norm(elbow + along * (hand - elbow) - point))
    assert min(side) < situation.obstacles[0].shape.radius < side[0]


def test_fig2_images_overlap_and_obstacles_do_not():
    from gcm_learn.charts.extended import occupied_cells
    from gcm_learn.charts.lattice import Lattice

    situation = paper.fig2()
    target = situation.targets
    images = [
        occupied_cells(Situation("one", 1.0, situation.arm, (*target, obstacle)), Lattice(160), 0.0)
        for obstacle in situation.obstacles
    ]
    assert (images[0] & images[1]).sum() > 50
    (disc, square) = (np.array(body.motion.position) for body in situation.obstacles)
    corner = max(np.hypot(*v) for v in situation.obstacles[1].shape.vertices)
    assert np.linalg.norm(disc - square) > situation.obstacles[0].shape.radius + corner


def test_fig3_has_two_movers_and_fig4_one_moving_point():
    movers, (point,) = paper.fig3().obstacles, paper.fig4().obstacles
    assert len(movers) == 2
    assert all(np.hypot(*body.motion.velocity) > 1.0 for body in movers)
    assert isinstance(point.shape, Disc) and point.shape.radius < paper.LATTICE_SPACING
    assert np.hypot(*point.motion.velocity) > 0.5
    assert paper.fig4().targets[0].motion.velocity == (0.0, 0.0)


def test_fig5_ball_falls_and_the_bar_cuts_the_plane_in_a_fixed_disc():
    situation = paper.fig5()
    assert situation.targets[0].motion.velocity == (0.0, 0.0, 0.0)
    assert situation.targets[0].motion.acceleration == (0.0, 0.0, -paper.FIG5_GRAVITY)
    first, later = cut_at(situation, "bar", 0.0), cut_at(situation, "bar", 220.0)
    np.testing.assert_allclose(first, later)
    centre = first.mean(axis=0)
    radii = np.linalg.norm(first - centre, axis=1)
    np.testing.assert_allclose(radii, situation.obstacles[0].shape.radius, rtol=1e-6)


def test_fig5_scale_is_a_parameter():
    """At the robot's scale a ball at rest falls far out of reach before 220 tau."""
    situation = paper.fig5(gravity=paper.EARTH_GRAVITY)
    centre, _ = pose(situation, body_index(situation, "ball"), 220 * paper.KAPPA)
    assert np.hypot(*centre[:2]) > 4 * situation.arm.reach


def test_fig6_both_come_through_the_plane_from_opposite_sides_and_spin():
    """Nothing is in the plane at 20, both are at 60 and 100; cross-sections vary."""
    situation = paper.fig6()
    for name in ("bar", "disk"):
        assert len(cut_at(situation, name, 20.0)) == 0
        assert len(cut_at(situation, name, 60.0)) > 2
        assert len(cut_at(situation, name, 100.0)) > 2
    assert len(cut_at(situation, "bar", 160.0)) > 2
    sizes = [np.ptp(cut_at(situation, "disk", tau), axis=0) for tau in (60.0, 100.0)]
    assert np.abs(sizes[0] - sizes[1]).max() > 0.05
    bar, disk = situation.targets[0].motion, situation.obstacles[0].motion
    normal = np.array(situation.plane.normal)
    for motion in (bar, disk):
        assert np.linalg.norm(np.cross(motion.velocity, normal)) < 1e-12
        assert np.linalg.norm(motion.spin) > 1.0
    assert np.dot(bar.velocity, normal) * np.dot(disk.velocity, normal) < 0.0


def test_fig8_box_and_cord_have_the_papers_size():
    situation = paper.fig8()
    box = situation.bodies[body_index(situation, "box")]
    assert isinstance(box.shape, Box)
    metres = sorted(2 * half * paper.FOREARM for half in box.shape.half_extents)
    np.testing.assert_allclose(metres, [0.26, 0.38, 0.60])
    floor = (box.motion.position[2] - box.shape.half_extents[2]) * paper.FOREARM
    cord = situation.bodies[body_index(situation, "cord")].motion
    assert cord.pivot[2] * paper.FOREARM - floor == pytest.approx(1.50)
    assert situation.arm.reach * paper.FOREARM == pytest.approx(0.27)


def test_fig8_ball_hangs_at_the_end_of_the_cord():
    situation = paper.fig8()
    cord, ball = body_index(situation, "cord"), body_index(situation, "ball")
    assert isinstance(situation.bodies[ball].shape, Sphere)
    for t in (0.0, 0.3, 0.7):
        middle, turn = pose(situation, cord, t)
        end = middle + situation.bodies[cord].shape.half_length * turn[:, 2]
        np.testing.assert_allclose(end, pose(situation, ball, t)[0], atol=1e-9)


def test_fig8_only_the_box_is_in_the_plane_until_the_ball_swings_through():
    situation = paper.fig8()
    for tau in (0.0, 120.0, 240.0):
        assert len(cut_at(situation, "box", tau)) > 2
        assert len(cut_at(situation, "ball", tau)) == 0
        assert len(cut_at(situation, "cord", tau)) == 0
    in_plane = [tau for tau in np.arange(200.0, 330.0, 0.5) if len(cut_at(situation, "ball", tau))]
    assert 0.85 * 280 < in_plane[0] < 280 < 1.15 * 280
    assert len(cut_at(situation, "cord", 280.0)) > 2


def test_fig8_released_at_rest_and_going_down():
    situation = paper.fig8()
    ball = body_index(situation, "ball")
    motion = situation.bodies[ball].motion
    assert motion.rate == 0.0
    assert motion.gravity == pytest.approx(9.81 / 0.135)
    heights = [pose(situation, ball, t)[0][1] for t in (0.0, 0.1, 0.2)]
    assert heights[0] > heights[1] > heights[2]
    assert math.isclose(motion.length * paper.FOREARM, paper.CORD_LENGTH)


@pytest.mark.parametrize("name", paper.CAPTION_INSTANTS)
def test_contact_comes_near_the_captions_instant(name):
    """On the paper's own lattice, within 15 %, and the catch is verified."""
    situation = paper.PAPER_SCENES[name]()
    plan = solve(situation, "gcm")
    assert plan.status == "caught"
    assert plan.map.lattice.n == 80
    assert plan.map.interception_tau == pytest.approx(paper.CAPTION_INSTANTS[name][-1], rel=0.15)
    if name == "fig8":
        assert len(cut_at(situation, "cord", plan.map.interception_tau)) > 2


@pytest.mark.parametrize("name", paper.PAPER_SCENES)
def test_both_engines_catch_where_a_straight_line_fails(name):
    situation = paper.PAPER_SCENES[name]()
    statuses = [solve(situation, planner).status for planner in ("gcm", "marching", "straight")]
    assert statuses == ["caught", "caught", "unreachable"]


def test_the_gate_is_a_situation_of_the_exchange_format():
    assert situation_from_json(situation_to_json(gate_scene())) == gate_scene()


@pytest.mark.parametrize("planner", ["gcm", "marching", "straight", "straight-wait"])
def test_who_cannot_wait_on_the_way_misses_the_ball(planner):
    assert not solve(gate_scene(), planner).caught


def test_the_hand_waits_for_the_gate_and_for_nothing_else():
    scene = gate_scene()
    plan = solve(scene, "layered")
    assert plan.caught and plan.trajectory is not None
    resting = sum(wait.duration for wait in plan.trajectory.waits())
    assert resting > 0.2
    open_ = solve(dataclasses.replace(scene, bodies=scene.targets), "layered")
    assert open_.trajectory is not None and open_.trajectory.waits() == []
    assert open_.catch_time < plan.catch_time - 0.2
