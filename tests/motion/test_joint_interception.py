"""Hands in space and the targets they meet."""

from __future__ import annotations

import numpy as np
import pytest

from gcm_learn.arms import forward_in_space, rotation_of
from gcm_learn.arms.curves import line
from gcm_learn.motion.joint_interception import (
    fastest_hand,
    first_meeting,
    may_be_met,
    met_at,
    target_room,
)
from gcm_learn.scene import pack
from gcm_learn.situation import (
    Body,
    Box,
    Capsule,
    Cylinder,
    Situation,
    SolidQuadratic,
    Sphere,
    read_situations,
)
from tests.motion.test_joint_verification import ARM
from tests.spatial import EXAMPLES

SITUATIONS = read_situations(EXAMPLES)
SHAPES = [Sphere(0.3), Box((0.3, 0.2, 0.5)), Capsule(0.2, 0.4), Cylinder(0.3, 0.4)]
TURN = (0.5, -0.5, 0.5, 0.5)


def surface_of(shape, rng, count=20_000):
    """Points on a solid's surface, in its own frame."""
    way = rng.normal(size=(count, 3))
    way /= np.linalg.norm(way, axis=1)[:, None]
    if isinstance(shape, Sphere):
        return way * shape.radius
    if isinstance(shape, Capsule):
        caps = way * shape.radius + np.sign(way[:, 2:]) * (0.0, 0.0, shape.half_length)
        side = way * (1.0, 1.0, 0.0)
        side *= shape.radius / np.linalg.norm(side, axis=1)[:, None]
        side[:, 2] = rng.uniform(-shape.half_length, shape.half_length, count)
        return np.concatenate([caps, side])
    if isinstance(shape, Box):
        half = np.array(shape.half_extents)
        points = rng.uniform(-1.0, 1.0, (count, 3)) * half
        side = rng.integers(0, 3, count)
        points[np.arange(count), side] = half[side] * rng.choice([-1.0, 1.0], count)
        return points
    angle, height = rng.uniform(0, 2 * np.pi, count), rng.uniform(-1, 1, count)
    radius = np.where(np.abs(height) < 0.5, 1.0, np.sqrt(rng.random(count))) * shape.radius
    height = np.where(np.abs(height) < 0.5, 2.0 * height, np.sign(height)) * shape.half_length
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), height], axis=1)


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: shape.kind)
def test_the_room_of_a_target_is_the_signed_distance_to_its_surface(shape):
    rng, place = np.random.default_rng(0), np.array([0.2, -0.1, 0.4])
    law = SolidQuadratic(tuple(place), (0, 0, 0), (0, 0, 0), orientation=TURN)
    scene = pack(Situation("one", 1.0, ARM, (Body("target", "ball", shape, law),)))
    surface = surface_of(shape, rng) @ rotation_of(TURN).T + place
    poses = np.zeros((1, 12))
    for _ in range(60):
        point = place + rng.uniform(-0.9, 0.9, 3)
        room = target_room(scene, 0, *point, 0.5, poses)
        nearest = np.linalg.norm(surface - point, axis=1).min()
        assert abs(room) == pytest.approx(nearest, abs=0.03)
        inward = target_room(scene, 0, *(point + 1e-3 * (place - point)), 0.5, poses)
        assert inward < room  # these solids are star-shaped about their centres


@pytest.mark.parametrize("k", range(0, len(SITUATIONS), 5))
def test_a_meeting_is_the_first_of_all_instants(k):
    situation = SITUATIONS[k]
    scene, rng = pack(situation), np.random.default_rng(k)
    curve, poses = np.empty((4, 4)), np.zeros((len(situation.bodies), 12))
    catch = 5.0 * situation.arm.grasp
    for _ in range(5):
        ends = scene.limb.low + rng.random((2, 4)) * (scene.limb.high - scene.limb.low)
        line(*ends, curve)
        t, body = first_meeting(scene, curve, 0.0, situation.horizon, catch, 1e-5, poses)
        seen = -1.0
        for s in np.linspace(0.0, 1.0, 1000):
            q = ends[0] + s * (ends[1] - ends[0])
            if met_at(scene, q, s * situation.horizon, catch, poses) >= 0:
                seen = s * situation.horizon
                break
        if seen >= 0.0:
            assert 0.0 <= t <= seen + 1e-4 and body >= 0
        if t >= 0.0:
            share = t / situation.horizon
            q = ends[0] + share * (ends[1] - ends[0])
            assert met_at(scene, q, t, catch * (1 + 1e-9), poses) >= 0


@pytest.mark.parametrize("k", range(0, len(SITUATIONS), 5))
def test_no_hand_is_faster_than_its_bound(k):
    scene, arm = pack(SITUATIONS[k]), SITUATIONS[k].arm
    rng, most = np.random.default_rng(k), fastest_hand(pack(SITUATIONS[k]))
    for _ in range(50):
        q = scene.limb.low + rng.random(4) * (scene.limb.high - scene.limb.low)
        rate = scene.limits.joint_speed * rng.choice([-1.0, 1.0], 4)
        way = np.subtract(*(forward_in_space(arm, q + h * rate)[1] for h in (1e-6, -1e-6)))
        assert np.linalg.norm(way) / 2e-6 <= most * 1.0001 or most == scene.limits.speed


def far_away(x):
    law = SolidQuadratic((x, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    body = Body("target", "ball", Sphere(0.1), law)
    return pack(Situation("far", 1.0, ARM, (body,)))


@pytest.mark.parametrize(("x", "hopeful"), [(1.9, True), (2.19, True), (2.21, False), (9, False)])
def test_what_is_out_of_reach_is_known_to_be(x, hopeful):
    assert may_be_met(far_away(x), np.zeros((1, 12))) == hopeful
