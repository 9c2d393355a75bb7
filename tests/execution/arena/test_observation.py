"""What arms in joints are told: against the independent referee, and by differences."""

import json
from dataclasses import replace

import numpy as np
import pytest

from gcm_learn.arms import Base, SpatialArm, forward_in_space, rotation_of
from gcm_learn.arms.swivels import RHO
from gcm_learn.collision.distance import bone_distance
from gcm_learn.collision.postures import desk_of, distance_at
from gcm_learn.execution import ChainSettings, Pool, SpatialSettings, pool_for
from gcm_learn.execution.arena.kernels.joints import nearness
from gcm_learn.execution.arena.kernels.joints.observation import OBSTACLE, UNTIL_AIM
from gcm_learn.motion.joint_interception import target_room
from gcm_learn.motion.rules import opening
from gcm_learn.scene import pack, pack_bodies, poses_at
from gcm_learn.scene.bodies import BOX, KIND, piece_at, velocity_by
from gcm_learn.situation import arm_to_json, carried, situation_from_json, situation_to_json
from tests.chains import BLOCKED, COUNT, drawn
from tests.execution.conftest import begun
from tests.geometry import arm_of, hand_of, least_at, links_of, poses


@pytest.fixture(scope="module", params=["spatial", "panda", "planar-2", "slide"])
def moved(request, arms, tmp_path_factory):
    """Return a plant in the midst of its episodes."""
    made, settings = arms, SpatialSettings(slots=3)
    if request.param != "spatial":
        made = [situation_from_json(drawn(request.param, k)) for k in range(COUNT) if k != BLOCKED]
        arm = tmp_path_factory.mktemp("arms") / "arm.json"
        arm.write_text(json.dumps(arm_to_json(made[0].arm.model)))
        settings = ChainSettings(slots=3, arm=str(arm))
    plant = begun(pool_for(settings, made), settings)
    rng = np.random.default_rng(4)
    for _ in range(6):
        plant.move(rng.uniform(-0.5, 0.5, (len(made), settings.commands)))
    return plant


CHAINS = pytest.mark.parametrize("moved", ["panda", "planar-2", "slide"], indirect=True)


def written(situation):
    """Return a situation as the referee reads it, a chain's model in it."""
    told = situation_to_json(situation)
    if not is_spatial(situation):
        told["arm"]["model"] = arm_to_json(situation.arm.model)
    return told


def is_spatial(situation):
    return isinstance(situation.arm, SpatialArm)


def seen(plant):
    """Yield the row, situation, its arm for the referee, unit of lengths, joints and rates."""
    for e, situation in enumerate(plant.pool.situations):
        n = plant.settings.commands
        arm = arm_of(written(situation)["arm"])
        joints, rates = plant.posture[e, :n], plant.posture[e, n:]
        yield e, plant.observations[e], situation, arm, situation.arm.reach, joints, rates


def in_base(situation, points):
    """Return points of the world in the frame of the arm's base."""
    base = situation.arm.base
    return (np.asarray(points) - base.origin) @ rotation_of(base.rotation)


def test_the_arm_is_told(moved):
    for e, row, situation, arm, reach, q, v in seen(moved):
        scene, limits = pack(situation), situation.arm
        rules, unit = opening(scene).rules, reach / moved.pool.speed[e]
        (hand,), (axis,) = hand_of(arm, q[None])
        ends, radii = links_of(arm, q[None])
        joints = in_base(situation, ends[:, 1, 0]) / reach
        itself = min(least_at({"bodies": []}, arm, np.zeros(1), q[None])) - rules.touch
        shape = np.hstack([axis @ rotation_of(limits.base.rotation), joints.ravel()])
        sizes = np.hstack([radii, itself])
        if is_spatial(situation):
            shape, sizes = joints[0], np.array([scene.limb.solved[RHO], limits.thickness])
        low, high = np.array(limits.joint_range).T
        top, ramp = np.array(limits.max_joint_speed), np.zeros(len(q))
        if limits.max_joint_acceleration is not None:
            ramp = top / limits.max_joint_acceleration / unit
        wanted = np.hstack([
            q, v / top, in_base(situation, hand) / reach, shape, q - low, high - q, top * unit,
            ramp, sizes / reach, rules.catch / reach, (situation.horizon - moved.time[e]) / unit,
            0.02 / unit,
        ])  # fmt: skip
        assert moved.settings.layout.arm == len(wanted)
        told = row[: len(wanted)]
        np.testing.assert_allclose(told, np.clip(wanted, -10, 10), rtol=1e-5, atol=1e-5)


def test_the_target_is_told(moved):
    """Velocities and accelerations by differences of poses."""
    for e, row, situation, _, reach, _, _ in seen(moved):
        if len(situation.targets) > 1:
            continue
        row, t = row[moved.settings.layout.arm :], moved.time[e]
        scene, unit = pack(situation), reach / moved.pool.speed[e]
        b = next(k for k, body in enumerate(situation.bodies) if body.role == "target")
        hand, bodies = moved.hand[e], scene.bodies

        def centre(when, bodies=bodies, b=b):
            return posed(bodies, when)[b, :3]

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
        room = target_room(scene, b, *hand, t, posed(bodies, t)) - opening(scene).rules.catch
        assert row[19] == pytest.approx(min(room / reach, 10), abs=1e-5)


@CHAINS
def test_the_approach_is_told(moved):
    told = 0
    for e, row, situation, arm, _, q, _ in seen(moved):
        target = next(b for b in written(situation)["bodies"] if b["role"] == "target")
        at = moved.settings.layout.arm + UNTIL_AIM + len(q)
        assert row[at] == ("approach" in target)
        if "approach" not in target:
            assert not row[at : at + 5].any()
            continue
        told += 1
        _, turn = poses(target, np.array([moved.time[e]]))
        wanted = turn[0] @ np.array(target["approach"]["axis"])
        _, (axis,) = hand_of(arm, q[None])
        angle = np.arccos(np.clip(axis @ wanted / np.linalg.norm(wanted), -1.0, 1.0))
        back = rotation_of(situation.arm.base.rotation)
        np.testing.assert_allclose(row[at + 1 : at + 4], wanted @ back, atol=1e-5)
        assert row[at + 4] == pytest.approx(angle - target["approach"]["within"], abs=1e-5)
    assert told > 0


def test_the_aim_leads_straight_to_the_meeting(moved):
    """Where no joint is at an end, a small step of the aim takes the hand there."""
    straight = []
    for _, row, situation, arm, _, q, _ in seen(moved):
        n, at = len(q), moved.settings.layout.arm
        aim = row[moved.settings.straight : moved.settings.straight + n].astype(float)
        assert np.abs(aim).max() <= 1.0 + 1e-6
        way = row[at + 21 : at + 24].astype(float)
        turned = q + 1e-5 * aim * situation.arm.max_joint_speed
        hands = in_base(situation, hand_of(arm, np.stack([q, turned]))[0])
        step = hands[1] - hands[0]
        straight.append(step @ way / max(np.linalg.norm(step) * np.linalg.norm(way), 1e-15))
    assert min(straight) > (0.0 if n == 4 else -1e-6)
    if n > 3:
        assert np.median(straight) > (0.98 if n == 4 else 0.95)


def test_obstacles_are_told_nearest_first(moved):
    """Against the distances of the referee; points that are told lie on limb and obstacle."""
    near = 0
    for e, row, situation, arm, reach, q, _ in seen(moved):
        scene, t = pack(situation), moved.time[e]
        touch = opening(scene).rules.touch
        obstacles = [b for b in written(situation)["bodies"] if b["role"] == "obstacle"]
        true = [least_at({"bodies": [b]}, arm, np.array([t]), q[None])[0] for b in obstacles]
        at = moved.settings.layout.arm + moved.settings.layout.target
        slots = row[at:].reshape(-1, OBSTACLE)
        count = int(slots[:, 0].sum())
        assert count == min(len(obstacles), 3)
        found = slots[:count, 7] * reach + touch
        wanted = np.sort(true)[:count]
        if is_spatial(situation):  # bones are told bare, and never inside
            wanted = np.maximum(wanted + situation.arm.thickness, 0.0)
        close = wanted < 0.4 * reach
        near += close.sum()
        np.testing.assert_allclose(found[close], wanted[close], atol=2e-3 * reach)
        if close.any():
            least = distance_at(scene, q.copy(), t, desk_of(scene))
            assert found[0] == pytest.approx(least, abs=2e-4 * reach)
        if is_spatial(situation):
            elbow, hand = in_base(situation, forward_in_space(situation.arm, q))
            for slot, distance in zip(slots, found, strict=False):
                gap = np.linalg.norm(slot[4:7]) * reach
                assert gap == pytest.approx(distance, abs=1e-5 * reach)
                point = slot[1:4] * reach
                assert on_bone(point, np.zeros(3), elbow) or on_bone(point, elbow, hand)
    assert near > 5


def on_bone(point, p, q):
    """Return whether a point is on a bone."""
    length = np.linalg.norm(q - p)
    around = np.linalg.norm(point - p) + np.linalg.norm(q - point)
    return length + 1e-5 >= around - 1e-5 * length


def posed(bodies, time):
    """Return poses (n, 12) of all bodies at a time."""
    made = np.zeros((len(bodies.rows), 12))
    made[:, 3:] = np.eye(3).ravel()
    poses_at(bodies, time, made)
    return made


def test_nearest_points_are_the_nearest(arms, rng):
    """Against the distances of the verification, and points of the body by sampling."""
    kinds = set()
    for situation in arms:
        bodies = pack_bodies(situation)
        at = posed(bodies, 0.3)
        for b in range(len(bodies.rows)):
            kinds.add(bodies.rows[b, KIND])
            size = bodies.rows[b, 5]
            p, q = (at[b, :3] + rng.normal(size=3) * size * 1.5 for _ in range(2))
            s, x, y, z = nearness.nearest_on_bone(bodies, b, at, tuple(p), tuple(q))
            true = bone_distance(bodies, at, b, tuple(p), tuple(q), 1e300, 1e300)
            assert np.sqrt(x * x + y * y + z * z) == pytest.approx(true, abs=1e-4 * size)
            assert 0.0 <= s <= 1.0
    assert len(kinds) > 2 and BOX in kinds


@CHAINS
def test_velocities_of_points_of_links_are_differences(moved):
    from gcm_learn.arms.limbs import place
    from gcm_learn.execution.arena.kernels.joints.chains import point_velocity_on

    rng, h = np.random.default_rng(2), 1e-6
    for _, _, situation, arm, _, q, _ in seen(moved):
        limb, rates = pack(situation).limb, rng.normal(size=len(q))
        ends, _ = links_of(arm, np.stack([q - h * rates, q, q + h * rates]))
        for i in range(len(arm.geometry.radii)):
            share = rng.uniform()
            points = in_base(situation, ends[i, 0] + share * (ends[i, 1] - ends[i, 0]))
            told = point_velocity_on(limb, place(limb, q), i, q, rates, *points[1])
            np.testing.assert_allclose(told, (points[2] - points[0]) / (2 * h), atol=1e-5)


def test_velocities_of_points_of_bodies_are_differences(arms, rng):
    """Of points fixed in bodies that spin or swing."""
    for situation in arms:
        bodies = pack_bodies(situation)
        t, h, inside = 0.4, 1e-5, rng.normal(size=3) * 0.1
        for b in range(len(bodies.rows)):
            at = [posed(bodies, when)[b] for when in (t - h, t, t + h)]
            spots = [row[:3] + row[3:].reshape(3, 3) @ inside for row in at]
            told = velocity_by(bodies, b, piece_at(bodies, b, t), t, tuple(spots[1]))
            np.testing.assert_allclose(told, (spots[2] - spots[0]) / (2 * h), atol=2e-2)


def test_a_turned_world_looks_the_same(arms, rng):
    """Observations are in the frame of the base."""
    turned = rng.normal(size=4)
    quarter = Base((0.3, -0.2, 0.1), tuple((turned / np.linalg.norm(turned)).tolist()))
    turn = rotation_of(quarter.rotation)
    for situation in arms[:12]:
        if situation.arm.base != Base():
            continue
        back = -turn.T @ np.array(quarter.origin)
        bodies = [replace(b, motion=carried(b.motion, turn, back)) for b in situation.bodies]
        arm = replace(situation.arm, base=quarter)
        told = []
        for one in (situation, replace(situation, arm=arm, bodies=tuple(bodies))):
            plant = begun(Pool.of([one]), SpatialSettings())
            plant.move(np.full((1, 4), 0.2))
            told.append(plant.observations[0].copy())
        np.testing.assert_allclose(told[0], told[1], atol=2e-4)
