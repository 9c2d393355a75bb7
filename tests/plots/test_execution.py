"""Films and figures of executions show what was done, not what was planned."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image

from gcm_learn.arms import Base, forward_in_space
from gcm_learn.execution import body_for, execute, with_motor_limits
from gcm_learn.families import paper_scene
from gcm_learn.planners import get_planner
from gcm_learn.plots import animate_execution
from gcm_learn.plots.figures.execution import HIT, MET, Replay, told, touched_at
from gcm_learn.plots.figures.film import ROUND
from gcm_learn.scene import pose
from gcm_learn.situation import Body, Box, Capsule, Cylinder, SolidQuadratic, Sphere
from tests.worlds import pick


def caught():
    scene = paper_scene("fig8-space")
    situation = with_motor_limits(scene, body_for(scene.arm))
    return situation, execute(get_planner("search").plan(situation), situation)


@pytest.fixture(scope="module")
def case():
    return caught()


@pytest.fixture(scope="module")
def struck(case):
    """The same plan where a ball that it knows nothing of is on the way of the hand."""
    situation, done = case
    place = tuple(done.plan.hand_at(0.45) + (0.0, 0.0, 0.05))
    still = SolidQuadratic(place, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    barred = replace(
        situation, bodies=(*situation.bodies, Body("obstacle", "ball 2", Sphere(0.02), still))
    )
    plan = get_planner("search").plan(situation)
    return barred, execute(plan, barred)


def test_the_target_bounces_off_in_the_film(case):
    situation, done = case
    replay = Replay(situation, done)
    when = done.catch_time
    before, after = np.array([0.5 * when]), np.array([replay.end])
    law = [pose(situation, 0, t)[0] for t in (0.5 * when, replay.end)]
    assert replay.places(before)[0, 0] == pytest.approx(law[0], abs=2e-3)
    assert np.linalg.norm(replay.places(after)[0, 0] - law[1]) > 0.05
    assert replay.end > when + 0.1
    assert [(mark.time, mark.colour) for mark in replay.marks] == [(when, MET)]


def test_the_arm_in_the_film_is_where_physics_had_it(case):
    situation, done = case
    replay = Replay(situation, done)
    k = done.plant.steps // 3
    assert replay.moves.joints_at(k * replay.step) == pytest.approx(done.plant.joints_log[k])


def test_places_of_targets_are_those_of_the_world_with_a_base_that_is_turned():
    scene = paper_scene("fig8-space")
    half = np.sqrt(0.5)
    arm = replace(scene.arm, base=Base((0.3, -0.2, 0.1), (half, 0.0, 0.0, half)))
    drift = SolidQuadratic((0.3, -0.02, 0.1), (0.1, 0.0, 0.0), (0.0, 0.0, 0.0))
    ball = Body("target", "ball", Sphere(0.03), drift)
    situation = with_motor_limits(replace(scene, arm=arm, bodies=(ball,)), body_for(arm))
    done = execute(get_planner("search").plan(situation), situation)
    assert done.caught
    place = Replay(situation, done).places(np.array([0.05]))[0, 0]
    assert place == pytest.approx((0.305, -0.02, 0.1), abs=2e-4)


def test_a_contact_is_marked_where_it_is(struck):
    situation, done = struck
    assert done.status == "collided"
    replay = Replay(situation, done)
    assert replay.marks[-1].colour == HIT and replay.mark_at(0.0) is None
    bone = np.linalg.norm(replay.marks[-1].place - situation.bodies[-1].motion.position)
    assert bone == pytest.approx(situation.arm.thickness + 0.02, abs=5e-3)
    assert "touches 'ball 2'" in told(done)


def test_hold_carry_and_place_are_told_in_turn():
    """The ring goes with the ball, which ends at its place."""
    situation = pick()
    done = execute(get_planner("search").plan(situation), situation)
    replay = Replay(situation, done)
    times = [done.planned + 0.1, done.grip.closed + 0.1, done.grip.opened + 0.1]
    marks = [replay.mark_at(t) for t in times]
    for mark, word in zip(marks, ("moves with", "carries", "put down"), strict=True):
        assert mark.word.startswith(word) or word in mark.word
    assert replay.mark_at(done.planned - 0.01) is None
    ax = Figure().subplots()
    for t in times:
        replay.show(ax, t)
        ball = replay.view.see(replay.places(np.array([t]))[0, 0])[:2]
        cross, ring = ax.lines[-2:]
        assert np.ravel(ring.get_data()) == pytest.approx(ball)
    place = replay.view.see(np.array(situation.bodies[0].place.position))[:2]
    assert np.ravel(cross.get_data()) == pytest.approx(place)
    assert np.linalg.norm(ball - place) < 0.02
    assert "put down" in told(done)


@pytest.mark.parametrize(
    "shape", [Box((0.02, 0.02, 0.1)), Capsule(0.02, 0.08), Cylinder(0.02, 0.1), Sphere(0.02)]
)
def test_the_touched_point_is_the_nearest_of_the_bones(case, shape):
    """Something beside the elbow is touched by the elbow."""
    situation, _ = case
    arm = situation.arm
    elbow, _ = forward_in_space(arm, np.array(arm.joints))
    at = SolidQuadratic(tuple(elbow + (0.0, 0.15, 0.0)), (0.0,) * 3, (0.0,) * 3)
    beside = replace(situation, bodies=(*situation.bodies, Body("obstacle", "it", shape, at)))
    place = touched_at(beside, "it", 0.0, np.array(arm.joints))
    assert np.linalg.norm(place - elbow) < 0.03


def test_film_and_text(case, tmp_path):
    situation, done = case
    animate_execution(situation, done, tmp_path / "film.gif", frames=5)
    with Image.open(tmp_path / "film.gif") as film:
        assert 5 + ROUND <= film.n_frames <= 5 + ROUND + 8  # equal frames are one
    text = told(done)
    assert f"caught at {done.catch_time:.3f} s (planned {done.planned:.3f} s)" in text
    assert f"{100 * done.torque:.0f} %" in text
