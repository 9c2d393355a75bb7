"""Families in space: arms as they say, and what only they promise."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from gcm_learn import families, seeding
from gcm_learn.arms import forward_in_space, rotation_of
from gcm_learn.families.paper import FOREARM
from gcm_learn.families.solids import axes_along, gap, placed, solid, unit_vector
from gcm_learn.families.space.arms import HUMAN, NAO
from gcm_learn.motion import opening
from gcm_learn.planners import solve
from gcm_learn.scene import pack, pose
from gcm_learn.situation import (
    Box,
    Capsule,
    Cylinder,
    Pendulum,
    Sphere,
    situation_from_json,
    situation_to_json,
)
from tests.families.test_families import SPACE as NAMES


def of_arm(name, **shares):
    """Return a family whose arms are of one kind."""
    family = families.get_family(name)
    return replace(family, arm=replace(family.arm, **{"human": 0.0, "nao": 0.0, **shares}))


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_situations_of_all_seeds_start_free_and_may_be_caught(name):
    known = [opening(pack(families.draw(name, seed, 0))) for seed in range(200)]
    assert all(one.clearance > 0.0 for one in known)
    assert sum(one.hopeful for one in known) >= 0.97 * 200


@pytest.mark.parametrize("name", NAMES)
def test_arms_are_the_two_or_between_them(name):
    for build, share in ((HUMAN, "human"), (NAO, "nao")):
        for k in range(3):
            arm = families.draw(of_arm(name, **{share: 1.0}), 5, k).arm
            assert arm.upper_arm == build.upper_arm and arm.forearm == build.forearm
            assert arm.joint_range == build.joint_range and arm.grasp == build.grasp
            assert arm.base.origin[2] == build.height
    for k in range(5):
        arm = families.draw(of_arm(name), 5, k).arm
        assert 0.7 < math.hypot(*arm.forearm) < 1.3 and 0.08 < arm.thickness < 0.3


@pytest.mark.parametrize("name", NAMES)
def test_what_falls_and_swings_does_so_at_the_scale_of_the_arm(name):
    for build, share, metre in ((HUMAN, "human", 1 / 0.3), (NAO, "nao", 1.0)):
        for k in range(5):
            for body in families.draw(of_arm(name, **{share: 1.0}), 6, k).targets:
                motion = body.motion
                if isinstance(motion, Pendulum):
                    assert motion.gravity == pytest.approx(9.81 * metre)
                elif any(motion.acceleration):
                    assert motion.acceleration == pytest.approx((0, 0, -9.81 * metre))
                assert build.unit > 0.0


@pytest.mark.parametrize("name", NAMES)
def test_limits_of_acceleration_are_one_replace(name):
    family = families.get_family(name)
    arm = replace(family.arm, ramp=(0.1, 0.1), moving=0.5)
    drawn = families.draw(replace(family, arm=arm), 2, 0).arm
    top = np.array(drawn.max_joint_speed)
    np.testing.assert_allclose(drawn.max_joint_acceleration, 10.0 * top)
    assert 0.0 < np.max(np.abs(drawn.joint_rates) / top) <= 0.5
    assert families.draw(name, 2, 0).arm.max_joint_acceleration is None


def test_a_torso_leaves_the_shoulder_room():
    for k in range(40):
        situation = families.draw("static-clutter-space", 7, k)
        for body in situation.bodies:
            if body.name != "torso":
                continue
            away = np.array(body.motion.position) - situation.arm.base.origin
            beside = math.hypot(away[0], away[1]) - body.shape.radius
            assert beside > situation.arm.thickness


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize(
    "shape", [Sphere(0.4), Box((0.5, 0.2, 0.3)), Capsule(0.2, 0.5), Cylinder(0.4, 0.2)]
)
def test_gaps_are_distances_to_the_nearest_point(shape, seed):
    """Points on a ray from the centre are off it by at most their way, and inside below zero."""
    rng = seeding.rng(61, seed)
    axes = axes_along(rng.normal(size=3), rng.normal(size=3))
    body = solid("a", shape, rng.normal(size=3), axes, velocity=rng.normal(size=3))
    place = np.array(body.motion.position) + 0.3 * np.array(body.motion.velocity)
    along = unit_vector(rng.normal(size=3))
    points = place + np.linspace(0.0, 1.5, 400)[:, None] * along
    gaps = gap(points, body, 0.3)
    step = 1.5 / 399
    assert gaps[0] < 0.0 < gaps[-1] and np.all(np.abs(np.diff(gaps)) <= step + 1e-12)
    assert gaps[-1] >= 1.5 - shape.bounding_radius - 1e-12


def test_bodies_are_put_into_the_world_whole():
    rng = seeding.rng(62)
    body = solid("a", Box((1.0, 2.0, 3.0)), (0.1, 0.2, 0.3), axes_along((1, 1, 0)), pull=(0, 0, -2))
    turn, origin = rotation_of(unit_vector(rng.normal(size=4))), rng.normal(size=3)
    there = placed(body, 0.5, turn, origin)
    assert there.shape.half_extents == (0.5, 1.0, 1.5)
    np.testing.assert_allclose(there.motion.position, origin + turn @ (0.05, 0.1, 0.15))
    np.testing.assert_allclose(there.motion.acceleration, turn @ (0.0, 0.0, -1.0))
    np.testing.assert_allclose(
        rotation_of(there.motion.orientation), turn @ rotation_of(body.motion.orientation)
    )


def parts(situation, start):
    """Return indices of the bodies whose names begin so."""
    return [k for k, body in enumerate(situation.bodies) if body.name.startswith(start)]


def test_a_door_is_shut_first_and_opens_away_from_the_arm():
    for k in range(20):
        situation = families.draw("door-space", 8, k)
        (door,), (wall,) = parts(situation, "door"), parts(situation, "wall below")
        (first, turn), (later, _) = (pose(situation, door, t) for t in (0.0, 0.3))
        _, axes = pose(situation, wall, 0.0)
        assert abs(turn[:, 0] @ axes[:, 2]) > 0.999 and later @ axes[:, 2] > first @ axes[:, 2]


def test_the_shutter_of_a_window_opens_or_closes():
    seen = set()
    for k in range(40):
        situation = families.draw("window-space", 8, k)
        for shutter in parts(situation, "shutter"):
            target, _ = pose(situation, 0, 0.0)
            motion = situation.bodies[shutter].motion
            seen.add("opens" if any(motion.acceleration) else "closes")
            assert np.linalg.norm(pose(situation, shutter, 0.0)[0] - target) < 6.0
    assert seen == {"opens", "closes"}


@pytest.mark.parametrize("name", ["over-shelf-space", "late-target-space"])
def test_thrown_balls_come_from_afar_and_are_not_within_reach_at_first(name):
    for k in range(20):
        situation = families.draw(name, 9, k)
        place, _ = pose(situation, 0, 0.0)
        assert np.linalg.norm(place) > situation.arm.reach + situation.arm.grasp


def test_a_ball_thrown_over_a_shelf_is_gone_when_it_lands():
    for k in range(20):
        situation = families.draw("over-shelf-space", 9, k)
        (shelf,) = parts(situation, "shelf")
        height = pose(situation, shelf, 0.0)[0][2]
        ball = pose(situation, 0, situation.horizon)[0][2]
        assert ball >= height - 1e-9


@pytest.mark.parametrize("name", families.SPATIAL_SCENES)
def test_the_papers_scenes_are_caught_in_space_where_no_straight_line_is_free(name):
    situation = families.paper_scene(name)
    values = json.loads(json.dumps(situation_to_json(situation)))
    assert situation_from_json(values) == situation and situation.name == name
    statuses = [solve(situation, planner).status for planner in ("straight", "straight-wait")]
    assert statuses == ["unreachable", "unreachable"]
    plan = solve(situation)
    assert plan.caught
    contact = families.CAPTION_INSTANTS[name.removesuffix("-space")][-1] * families.KAPPA
    assert 0.2 < plan.catch_time < 1.2 * contact  # the wave's contact is not the earliest catch


def test_the_pendulum_in_space_has_the_papers_size():
    situation, planar = families.paper_scene("fig8-space"), families.paper_scene("fig8")
    ball, cord, box = situation.bodies
    assert sorted(2 * half for half in box.shape.half_extents) == pytest.approx([0.26, 0.38, 0.6])
    assert 2 * ball.shape.radius == pytest.approx(0.067) and situation.arm.reach < 0.23
    floor = box.motion.position[2] - box.shape.half_extents[2]
    assert floor == pytest.approx(-0.43) and cord.motion.pivot[2] - floor == pytest.approx(1.5)
    swing = planar.bodies[0].motion
    assert ball.motion.length == pytest.approx(swing.length * FOREARM)
    assert ball.motion.gravity == pytest.approx(9.81) and ball.motion.angle == swing.angle
    elbow, hand = forward_in_space(situation.arm, situation.arm.joints)
    assert max(elbow[0], hand[0]) < box.motion.position[0] - box.shape.half_extents[0]
    assert hand[2] < floor + 0.26  # the hand is lower than the box


def test_the_falling_ball_in_space_is_that_of_the_plane():
    situation, planar = families.paper_scene("fig5-space"), families.paper_scene("fig5")
    assert situation.bodies == planar.bodies
    _, hand = forward_in_space(situation.arm, situation.arm.joints)
    np.testing.assert_allclose(hand[[0, 2]], planar.arm.hand, atol=0.02)
    assert abs(hand[1]) < 0.02


def test_the_ball_of_a_pendulum_hangs_at_the_end_of_its_cord():
    for k in range(20):
        situation = families.draw("pendulum-space", 9, k)
        ball, cord = situation.bodies[:2]
        end = cord.motion.hang + cord.shape.half_length
        assert end + ball.shape.radius == pytest.approx(ball.motion.hang_distance)
        assert replace(cord.motion, hang=None) == ball.motion
