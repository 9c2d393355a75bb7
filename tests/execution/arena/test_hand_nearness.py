"""Quick answers about what is near: never wrong, and mostly enough."""

import numpy as np
import pytest

from gcm_learn.arms.planar_limb import elbow_of
from gcm_learn.collision.distance import arm_distance
from gcm_learn.collision.sweep import least_distance
from gcm_learn.execution.arena.kernels.hands import nearness as near
from gcm_learn.motion.interception import first_catch
from gcm_learn.scene.bodies import BALL, HAND, KIND, PART, pose_at
from gcm_learn.scene.packing import pack
from gcm_learn.situation.canonical import canonical


@pytest.fixture(scope="module")
def turned(scenes):
    """Return canonical situations, and their bodies as the kernels want them."""
    found = [canonical(s)[0] for s in scenes]
    return [(s, pack(s)) for s in found]


def pieces(situation, rng, count=60):
    """Yield short straight pieces of ways anywhere in the ring, with their times."""
    arm = situation.arm
    for _ in range(count):
        radius, angle = rng.uniform(arm.inner_reach + 0.05, arm.reach - 0.1), rng.uniform(-3, 3)
        start = radius * np.array([np.cos(angle), np.sin(angle)])
        step = 0.02 * arm.max_hand_speed * rng.uniform(-0.7, 0.7, 2)
        t = rng.uniform(0.0, situation.horizon - 0.02)
        yield np.array([t, t + 0.02]), np.array([start, start + step])


def test_what_is_said_to_be_free_is_free(turned, rng):
    said, free = 0, 0
    for situation, scene in turned:
        poses = np.zeros((len(scene.bodies.rows), 12))
        moments = np.empty((6, near.MOMENT_COLUMNS))
        for time, way in pieces(situation, rng):
            floor = rng.uniform(0.0, 0.1)
            distance, _ = least_distance(scene, time, way, floor, 1e9)
            answer = near.stays_free(scene, time, way, floor, moments, poses)
            assert distance > floor or not answer
            said, free = said + answer, free + (distance > floor)
    assert said > 0.9 * free > 0


def test_what_is_said_to_be_away_is_not_caught(turned, rng):
    said, caught = 0, 0
    for situation, (bodies, *_) in turned:
        for time, way in pieces(situation, rng):
            reach = rng.uniform(0.0, 0.5)
            met, _ = first_catch(bodies, time, way, reach, 1e-4)
            answer = near.stays_away(bodies, time, way, reach)
            assert met < 0.0 or not answer
            said, caught = said + answer, caught + (met >= 0.0)
    assert said > 0 and caught > 0


def test_rooms_are_distances_where_bodies_are_near(turned, rng):
    """Exact to bodies near the limb and to discs, to the ball that holds a body else."""
    kinds = set()
    for situation, (bodies, *_) in turned:
        rho, n = situation.arm.upper_arm, len(bodies.rows)
        poses, moments = np.zeros((n, 12)), np.empty((6, near.MOMENT_COLUMNS))
        for time, way in pieces(situation, rng, 20):
            for k in range(2):
                near.place_limb(moments, k, time[k], way[k, 0], way[k, 1], rho)
            for b in range(n):
                if bodies.rows[b, PART] == HAND:
                    continue
                if not near.follow(bodies, b, 2, moments):
                    near.exactly(bodies, b, 2, moments, poses, False)
                for k in range(2):
                    pose_at(bodies, b, time[k], poses)
                    x, y = way[k]
                    true = arm_distance(bodies, poses, b, x, y, *elbow_of(x, y, rho, 1.0))
                    room = max(moments[k, near.ROOM], 0.0)
                    assert room <= true + 1e-12
                    if room <= 0.15 or bodies.rows[b, BALL] > 0.0:
                        assert room == pytest.approx(true, abs=1e-12)
                        kinds.add(bodies.rows[b, KIND])
    assert len(kinds) > 2
