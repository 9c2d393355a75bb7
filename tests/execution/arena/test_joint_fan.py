"""What arms in space are told of commands, against slow and independent ways to work it out."""

from itertools import pairwise

import numpy as np
import pytest

from gcm_learn.arms import forward_in_space, rotation_of
from gcm_learn.collision.distance import bone_distance
from gcm_learn.execution import AIM, COMMANDS, Pool, SpatialSettings, commands_of
from gcm_learn.execution.arena.kernels.joints import fan
from gcm_learn.motion.joint_interception import fastest_hand
from gcm_learn.motion.rules import opening
from gcm_learn.scene import pack, poses_at
from gcm_learn.scene.bodies import LIMB, PART, REACH
from tests.execution.conftest import begun

pytestmark = pytest.mark.slow
SETTINGS = SpatialSettings(fan=True, slots=2)


@pytest.fixture(scope="module")
def moved(arms):
    """Return a plant in the midst of its episodes, and the situations."""
    plant, rng = begun(Pool.of(arms), SETTINGS), np.random.default_rng(4)
    for _ in range(6):
        plant.move(rng.uniform(-0.5, 0.5, (len(arms), 4)))
    return plant, arms


def frames(plant):
    """Return the frames of the fans (n, 4, 4), vectors as rows."""
    at = SETTINGS.fan_at
    return plant.observations[:, at : at + fan.FRAME].astype(float).reshape(-1, 4, 4)


def commands(plant, ray):
    """Return the commands (n, 4) of a ray."""
    out = np.empty((plant.count, 4))
    commands_of(plant.observations, AIM, SETTINGS.fan_at, np.full(plant.count, ray), out)
    return out


def test_the_fan_changes_nothing_else(moved):
    pool, rng = moved[0].pool, np.random.default_rng(0)
    plain, other = begun(pool, SpatialSettings(slots=2)), begun(pool, SETTINGS)
    for _ in range(3):
        actions = rng.uniform(-0.5, 0.5, (len(pool), 4))
        plain.move(actions)
        other.move(actions)
        told = other.observations[:, : plain.settings.width]
        np.testing.assert_array_equal(told, plain.observations)
    assert other.settings.width == plain.settings.width + fan.FRAME + fan.RAY * COMMANDS


def test_frames_are_orthonormal_and_begin_with_the_aim(moved):
    """The second vector moves the elbow and not the hand."""
    plant, arms = moved
    aims = plant.observations[:, AIM : AIM + 4].astype(float)
    still = []
    for e, frame in enumerate(frames(plant)):
        np.testing.assert_allclose(frame @ frame.T, np.eye(4), atol=1e-5)
        np.testing.assert_allclose(frame[0], aims[e] / np.linalg.norm(aims[e]), atol=1e-5)
        arm, q = arms[e].arm, plant.posture[e, :4]
        steps = 1e-4 * frame * arm.max_joint_speed
        hands = forward_in_space(arm, np.vstack([q, q + steps]))[1]
        way = np.linalg.norm(hands[1:] - hands[0], axis=1)
        still.append(way[1] / way.max())
    assert np.median(still) < 1e-3


def test_commands_are_the_aim_turned(moved):
    """By their angles from the frame's first vector; no joint is asked for more than it can."""
    plant, _ = moved
    aims = plant.observations[:, AIM : AIM + 4].astype(float)
    np.testing.assert_array_equal(commands(plant, 0), aims)
    np.testing.assert_allclose(commands(plant, fan.HALF), 0.5 * aims)
    np.testing.assert_array_equal(commands(plant, fan.REST), 0.0)
    for ray in range(1, fan.HALF):
        made = commands(plant, ray)
        np.testing.assert_allclose(np.abs(made).max(axis=1), 1.0)
        unit = made / np.linalg.norm(made, axis=1)[:, None]
        inside = np.einsum("nij,nj->ni", frames(plant), unit)
        np.testing.assert_allclose(inside, np.tile(fan.DIRECTIONS[ray], (len(made), 1)), atol=1e-5)
    apart = fan.DIRECTIONS[: fan.HALF] @ fan.DIRECTIONS[: fan.HALF].T
    np.fill_diagonal(apart, -1.0)
    assert apart.max() < 0.99


def led(situation, posture, command, times):
    """Return the joints at `times` [s] of an arm that turns to a command and then with it."""
    arm, top = situation.arm, np.array(situation.arm.max_joint_speed)
    q, v, rates = posture[:4].copy(), posture[4:].copy(), command * top
    h = 1e-6
    hands = forward_in_space(arm, np.stack([q, q + h * rates]))[1]
    speed = np.linalg.norm(hands[1] - hands[0]) / h
    rates = rates * min(1.0, (arm.max_hand_speed or np.inf) / max(speed, 1e-12))
    most = np.full(4, np.inf)
    if arm.max_joint_acceleration is not None:
        most = np.array(arm.max_joint_acceleration)
    low, high = np.array(arm.joint_range).T
    out, fine = [], 400
    for before, after in pairwise((0.0, *times)):
        step = (after - before) / fine
        for _ in range(fine):
            new = v + np.clip(rates - v, -most * step, most * step)
            q, v = q + 0.5 * step * (v + new if np.isfinite(most[0]) else 2.0 * rates), new
        out.append(np.clip(q, low, high))
    return out


def room_of(situation, q, t):
    """Return the distance of a limb to the obstacles at t [s], and of the hand to the target."""
    scene, base = pack(situation), situation.arm.base
    turn = rotation_of(base.rotation)
    elbow, hand = ((p - base.origin) @ turn for p in forward_in_space(situation.arm, q))
    bodies, least, gap = scene.bodies, np.inf, np.inf
    poses = np.zeros((len(bodies.rows), 12))
    poses_at(bodies, t, poses)
    for b in range(len(bodies.rows)):
        if bodies.rows[b, PART] != LIMB:
            gap = np.linalg.norm(poses[b, :3] - hand) - bodies.rows[b, REACH]
        else:
            for p, r in ((np.zeros(3), elbow), (elbow, hand)):
                least = min(
                    least, bone_distance(bodies, poses, b, tuple(p), tuple(r), 1e300, 1e300)
                )
    return least, gap


def test_what_becomes_of_commands_is_told(moved):
    """How long the limb is free, the room it has till then, and how near the hand passes."""
    plant, arms = moved
    touched = checked = 0
    for e, situation in enumerate(arms):
        if len(situation.targets) > 1:
            continue
        scene, rules = pack(situation), opening(pack(situation)).rules
        reach = scene.limb.reach
        times = fan.TIMES * reach / fastest_hand(scene)
        for ray in (0, 3, 11, 22, fan.HALF, fan.REST):
            free, room, gap = 0.0, fan.ROOM * reach, reach
            close = False
            way = led(situation, plant.posture[e], commands(plant, ray)[e], times)
            for k, q in enumerate(way):
                now = min(plant.time[e] + times[k], situation.horizon)
                least, away = room_of(situation, q, now)
                close |= abs(least - rules.touch) < 1e-3 * reach
                if least <= rules.touch:
                    room, touched = 0.0, touched + 1
                    break
                room, free = min(room, least - rules.touch), fan.TIMES[k]
                gap = min(gap, away - rules.catch)
            if close:  # by a hair
                continue
            checked += 1
            at = SETTINGS.fan_at + fan.FRAME + fan.RAY * ray
            wanted = [free, room / reach, gap / reach]
            np.testing.assert_allclose(plant.observations[e, at : at + fan.RAY], wanted, atol=2e-3)
    assert checked > 100 and touched > 20
