"""What arms in space are told, against slow and independent ways to work it out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gcm_learn.arms import Base, forward_in_space, rotation_of
from gcm_learn.collision.solids import bone_distance
from gcm_learn.execution import AIM, KinematicPlant, Pool, SpatialSettings
from gcm_learn.execution.arena.kernels.joints import nearness
from gcm_learn.execution.arena.kernels.joints.observation import ARM, OBSTACLE, TARGET
from gcm_learn.motion.joint_interception import fastest_hand, target_room
from gcm_learn.motion.rules import opening
from gcm_learn.scene import pack, pack_bodies, poses_at
from gcm_learn.scene.bodies import BOX, KIND
from gcm_learn.situation import carried


@pytest.fixture(scope="module")
def moved(arms):
    """Return a plant in the midst of its episodes, and the situations."""
    import gcm_learn

    plant = KinematicPlant(Pool.of(arms), len(arms), SpatialSettings(slots=3))
    plant.put(np.arange(len(arms)), np.arange(len(arms)))
    rng = gcm_learn.rng(4)
    for _ in range(8):
        plant.move(rng.uniform(-0.6, 0.6, (len(arms), 4)))
    return plant, arms


def units(situation):
    """Return the scene, its rules, the reach and the unit of time."""
    scene = pack(situation)
    reach = scene.limb.rho + scene.limb.length
    return scene, opening(scene).rules, reach, reach / fastest_hand(scene)


def base_frame(situation, points):
    """Return points of the world in the frame of the arm's base."""
    base = situation.arm.base
    return (np.asarray(points) - base.origin) @ rotation_of(base.rotation)


def test_the_arm_is_told(moved):
    plant, arms = moved
    for e, situation in enumerate(arms):
        row, arm = plant.observations[e], situation.arm
        scene, rules, reach, unit = units(situation)
        q, v = plant.posture[e, :4], plant.posture[e, 4:]
        elbow, hand = base_frame(situation, forward_in_space(arm, q))
        low, high = np.array(arm.joint_range).T
        top = np.array(arm.max_joint_speed)
        ramp = np.zeros(4)
        if arm.max_joint_acceleration is not None:
            ramp = top / arm.max_joint_acceleration / unit
        wanted = np.hstack([
            q, v / top, hand / reach, elbow / reach, q - low, high - q, top * unit, ramp,
            scene.limb.rho / reach, arm.thickness / reach, rules.catch / reach,
            (situation.horizon - plant.time[e]) / unit, 0.02 / unit,
        ])  # fmt: skip
        np.testing.assert_allclose(row[:ARM], np.clip(wanted, -10, 10), rtol=1e-5, atol=1e-6)


def test_the_target_is_told(moved):
    """Velocities and accelerations by differences of poses."""
    plant, arms = moved
    for e, situation in enumerate(arms):
        if len(situation.targets) > 1:
            continue
        row, t = plant.observations[e, ARM:], plant.time[e]
        scene, rules, reach, unit = units(situation)
        b = next(k for k, body in enumerate(situation.bodies) if body.role == "target")
        bodies = pack_bodies(situation)
        hand = plant.hand[e]

        def centre(when, bodies=bodies, b=b):
            poses = np.zeros((len(bodies.rows), 12))
            poses_at(bodies, when, poses)
            return poses[b, :3].copy()

        h = 2e-4
        now = max(min(t, situation.horizon - h), h)
        speed = (centre(now + h) - centre(now - h)) / (2 * h)
        bend = (centre(now + h) - 2 * centre(now) + centre(now - h)) / h**2
        place = np.clip((centre(t) - hand) / reach, -10, 10)
        np.testing.assert_allclose(row[:3], place, atol=1e-5)
        np.testing.assert_allclose(row[3:6], np.clip(speed * unit / reach, -10, 10), atol=0.02)
        told = np.clip(bend * unit**2 / reach, -10, 10)
        np.testing.assert_allclose(row[6:9], told, atol=0.05, rtol=0.05)
        for k, moment in enumerate((0.5, 1.0, 2.0)):
            later = centre(min(t + moment * unit, situation.horizon))
            there = np.clip((later - hand) / reach, -10, 10)
            np.testing.assert_allclose(row[9 + 3 * k : 12 + 3 * k], there, atol=1e-5)
        poses = np.zeros((len(bodies.rows), 12))
        away = target_room(scene, b, *hand, t, poses) - rules.catch
        assert row[19] == pytest.approx(min(away / reach, 10), abs=1e-5)


def test_the_aim_leads_straight_to_the_meeting(moved):
    """Where no joint is in the way, a small step of the aim takes the hand in its direction."""
    plant, arms = moved
    straight = []
    for e, situation in enumerate(arms):
        row, q = plant.observations[e], plant.posture[e, :4]
        aim = row[AIM : AIM + 4].astype(float)
        assert np.abs(aim).max() <= 1.0 + 1e-6
        way = row[ARM + 21 : ARM + 24].astype(float)
        turned = q + 1e-4 * aim * situation.arm.max_joint_speed
        hands = base_frame(situation, forward_in_space(situation.arm, np.stack([q, turned]))[1])
        step = hands[1] - hands[0]
        straight.append(step @ way / max(np.linalg.norm(step) * np.linalg.norm(way), 1e-12))
    assert np.median(straight) > 0.98 and min(straight) > 0.0


def test_obstacles_are_told_nearest_first(moved):
    """Distances by samples along the limb; points that are told lie on limb and obstacle."""
    plant, arms = moved
    several = 0
    for e, situation in enumerate(arms):
        scene, rules, reach, _ = units(situation)
        bodies, t = scene.bodies, plant.time[e]
        poses = np.zeros((len(bodies.rows), 12))
        poses_at(bodies, t, poses)
        q = plant.posture[e, :4]
        elbow, hand = base_frame(situation, forward_in_space(situation.arm, q))
        obstacles = [k for k, b in enumerate(situation.bodies) if b.role != "target"]
        slots = plant.observations[e, ARM + TARGET :].reshape(-1, OBSTACLE)
        assert slots[:, 0].sum() == min(len(obstacles), 3)
        true = sorted(sampled(bodies, poses, b, elbow, hand) for b in obstacles)
        told = slots[slots[:, 0] > 0.0, 7] * reach + rules.touch
        near = np.array(true[: len(told)]) < 0.4 * reach
        several += near.sum() > 1
        np.testing.assert_allclose(told[near], np.array(true)[: len(told)][near], atol=4e-3 * reach)
        for slot, distance in zip(slots, told, strict=False):
            gap = np.linalg.norm(slot[4:7]) * reach
            assert gap == pytest.approx(distance, abs=1e-5 * reach)
            point = slot[1:4] * reach
            assert on_bone(point, np.zeros(3), elbow) or on_bone(point, elbow, hand)
    assert several > 5


def on_bone(point, p, q):
    """Return whether a point is on a bone."""
    return np.linalg.norm(q - p) + 1e-5 >= np.linalg.norm(point - p) + np.linalg.norm(q - point) - (
        1e-5 * np.linalg.norm(q - p)
    )


def sampled(bodies, poses, b, elbow, hand):
    """Return the distance of a limb to a body: the least of many short pieces of it."""
    zero = (0.0, 0.0, 0.0)
    upper = bone_distance(bodies, poses, b, zero, tuple(elbow))
    return min(upper, bone_distance(bodies, poses, b, tuple(elbow), tuple(hand)))


def test_nearest_points_are_the_nearest(arms, rng):
    """Against the distances of the verification, and points of the body by sampling."""
    kinds = set()
    for situation in arms:
        bodies = pack_bodies(situation)
        poses = np.zeros((len(bodies.rows), 12))
        poses_at(bodies, 0.3, poses)
        for b in range(len(bodies.rows)):
            kinds.add(bodies.rows[b, KIND])
            size = bodies.rows[b, 5]
            p, q = (poses[b, :3] + rng.normal(size=3) * size * 1.5 for _ in range(2))
            s, x, y, z = nearness.nearest_on_bone(bodies, b, poses, tuple(p), tuple(q))
            true = bone_distance(bodies, poses, b, tuple(p), tuple(q))
            assert np.sqrt(x * x + y * y + z * z) == pytest.approx(true, abs=1e-4 * size)
            assert 0.0 <= s <= 1.0
    assert len(kinds) > 2 and BOX in kinds


def test_velocities_of_points_are_differences(arms, rng):
    """Of the limb, and of points fixed in bodies that spin or swing."""
    for situation in arms:
        limb, bodies = pack(situation).limb, pack_bodies(situation)
        q, v, h = rng.uniform(limb.low, limb.high), rng.normal(size=4), 1e-6
        for forearm in (False, True):
            places = [limb_points(situation, q + k * h * v, 0.6, forearm) for k in (-1, 1)]
            elbow, point = (
                limb_points(situation, q, s, f) for s, f in ((1.0, False), (0.6, forearm))
            )
            told = nearness.limb_velocity(q, v, tuple(elbow), *point, forearm)
            np.testing.assert_allclose(told, (places[1] - places[0]) / (2 * h), atol=1e-4)
        t, h = 0.4, 1e-5
        inside = rng.normal(size=3) * 0.1
        for b in range(len(bodies.rows)):
            spots = []
            for when in (t - h, t, t + h):
                poses = np.zeros((len(bodies.rows), 12))
                poses[:, 3:] = np.eye(3).ravel()
                poses_at(bodies, when, poses)
                spots.append(poses[b, :3] + poses[b, 3:].reshape(3, 3) @ inside)
            poses_at(bodies, t, poses)
            told = nearness.point_velocity(bodies, b, t, poses, *spots[1])
            np.testing.assert_allclose(told, (spots[2] - spots[0]) / (2 * h), atol=2e-2)


def limb_points(situation, q, share, forearm):
    """Return a point of the limb at a share of a bone, in the frame of the base."""
    elbow, hand = base_frame(situation, forward_in_space(situation.arm, q))
    return elbow + share * (hand - elbow) if forearm else share * elbow


def test_a_turned_world_looks_the_same(arms, rng):
    """Observations are in the frame of the base."""
    turned = rng.normal(size=4)
    quarter = Base((0.3, -0.2, 0.1), tuple((turned / np.linalg.norm(turned)).tolist()))
    turn = rotation_of(quarter.rotation)
    for situation in arms[:12]:
        if situation.arm.base != Base():
            continue
        back = -turn.T @ np.array(quarter.origin)
        moves = [carried(b.motion, turn, back) for b in situation.bodies]
        bodies = tuple(replace(b, motion=m) for b, m in zip(situation.bodies, moves, strict=True))
        other = replace(situation, arm=replace(situation.arm, base=quarter), bodies=bodies)
        told = []
        for one in (situation, other):
            plant = KinematicPlant(Pool.of([one]), 1, SpatialSettings())
            plant.put(np.zeros(1, np.int64), np.zeros(1, np.int64))
            plant.move(np.full((1, 4), 0.2))
            told.append(plant.observations[0].copy())
        np.testing.assert_allclose(told[0], told[1], atol=2e-4)
