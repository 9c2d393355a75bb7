"""Chains in the arena: observations and catches against the independent referee."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from gcm_learn.arms import rotation_of
from gcm_learn.collision.postures import desk_of, distance_at
from gcm_learn.errors import ArenaError
from gcm_learn.execution import (
    CAUGHT,
    ChainSettings,
    KinematicPlant,
    Pool,
    follower_of,
    pool_for,
    run_episode,
    way_of,
)
from gcm_learn.motion.rules import opening
from gcm_learn.planners import Attempt, SpatialProblem, checked, get_planner, plan_to_json
from gcm_learn.referee import judge
from gcm_learn.scene import pack
from gcm_learn.situation import arm_to_json, shipped_arm, situation_from_json, situation_to_json
from tests.chains import BLOCKED, COUNT, drawn
from tests.geometry import arm_of, hand_of, least_at, links_of, poses

OBSTACLE, UNTIL_AIM = 20, 26  # numbers of an obstacle, and of a target before the aim


@pytest.fixture(scope="module", params=["panda", "planar-2", "slide"])
def moved(request, tmp_path_factory):
    """Return a plant in the midst of its episodes."""
    made = [situation_from_json(drawn(request.param, k)) for k in range(COUNT) if k != BLOCKED]
    arm = tmp_path_factory.mktemp("arms") / "arm.json"
    arm.write_text(json.dumps(arm_to_json(made[0].arm.model)))
    settings = ChainSettings(slots=3, arm=str(arm))
    plant = KinematicPlant(pool_for(settings, made), len(made), settings)
    plant.put(np.arange(len(made)), np.arange(len(made)))
    rng = np.random.default_rng(4)
    for _ in range(5):
        plant.move(rng.uniform(-0.4, 0.4, (len(made), settings.commands)))
    return plant


def written(situation):
    """Return a situation as the referee reads it, the arm's model in it."""
    told = situation_to_json(situation)
    told["arm"]["model"] = arm_to_json(situation.arm.model)
    return told


def seen(plant):
    """Yield the row, situation, its arm for the referee, unit of lengths, joints and rates."""
    for e, situation in enumerate(plant.pool.situations):
        n = situation.arm.dof
        arm = arm_of(written(situation)["arm"])
        joints, rates = plant.posture[e, :n], plant.posture[e, n:]
        yield e, plant.observations[e], situation, arm, situation.arm.reach, joints, rates


def in_base(situation, points):
    """Return points of the world in the frame of the arm's base."""
    base = situation.arm.base
    return (np.asarray(points) - base.origin) @ rotation_of(base.rotation)


def test_the_arm_is_told(moved):
    for e, row, situation, arm, reach, q, v in seen(moved):
        n, m, rules = len(q), len(arm.geometry.radii), opening(pack(situation)).rules
        (hand,), (axis,) = hand_of(arm, q[None])
        ends, radii = links_of(arm, q[None])
        outer = in_base(situation, ends[:, 1, 0]) / reach
        low, high = np.array(situation.arm.joint_range).T
        top, unit = np.array(situation.arm.max_joint_speed), reach / moved.pool.speed[e]
        itself = min(least_at({"bodies": []}, arm, np.zeros(1), q[None])) - rules.touch
        axis = axis @ rotation_of(situation.arm.base.rotation)
        wanted = np.hstack([
            q, v / top, in_base(situation, hand) / reach, axis, outer.ravel(), q - low, high - q,
            top * unit, np.zeros(n), radii / reach, itself / reach, rules.catch / reach,
            (situation.horizon - moved.time[e]) / unit, 0.02 / unit,
        ])  # fmt: skip
        assert moved.settings.layout.arm == len(wanted) == 6 * n + 4 * m + 10
        np.testing.assert_allclose(
            row[: len(wanted)], np.clip(wanted, -10, 10), rtol=1e-5, atol=1e-5
        )


def test_the_approach_is_told(moved):
    told = 0
    for e, row, situation, arm, _, q, _ in seen(moved):
        n = len(q)
        at = moved.settings.layout.arm + UNTIL_AIM + n
        target = next(b for b in written(situation)["bodies"] if b["role"] == "target")
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
    assert min(straight) > -1e-6
    if n > 3:
        assert np.median(straight) > 0.95


def test_obstacles_are_told_nearest_first(moved):
    """Against the distances of the referee."""
    near = 0
    for e, row, situation, arm, reach, q, _ in seen(moved):
        rules, scene, t = opening(pack(situation)).rules, pack(situation), moved.time[e]
        obstacles = [b for b in written(situation)["bodies"] if b["role"] == "obstacle"]
        true = [least_at({"bodies": [b]}, arm, np.array([t]), q[None])[0] for b in obstacles]
        at = moved.settings.layout.arm + moved.settings.layout.target
        slots = row[at:].reshape(-1, OBSTACLE)
        count = int(slots[:, 0].sum())
        assert count == min(len(obstacles), 3)
        found = slots[:count, 7] * reach + rules.touch
        wanted = np.sort(true)[:count]
        close = wanted < 0.4 * reach
        near += close.sum()
        np.testing.assert_allclose(found[close], wanted[close], atol=2e-3 * reach)
        if close.any():
            least = distance_at(scene, q.copy(), t, desk_of(scene))
            assert found[0] == pytest.approx(least, abs=2e-4 * reach)
    assert near > 5


def test_velocities_of_points_are_differences(moved):
    """Points that are fixed in links, by differences."""
    from gcm_learn.arms.limbs import place
    from gcm_learn.execution.arena.kernels.joints.chains import point_velocity_on

    rng, h = np.random.default_rng(2), 1e-6
    for _, _, situation, arm, _, q, _ in seen(moved):
        limb, rates = pack(situation).limb, rng.normal(size=len(q))
        ends, _ = links_of(arm, np.stack([q - h * rates, q, q + h * rates]))
        for i in range(len(arm.geometry.radii)):
            share = rng.uniform()
            points = in_base(situation, ends[i, 0] + share * (ends[i, 1] - ends[i, 0]))
            where = place(limb, q)
            told = point_velocity_on(limb, where, i, q, rates, *points[1])
            np.testing.assert_allclose(told, (points[2] - points[0]) / (2 * h), atol=1e-5)


class Straight:
    """Agent that follows the aim."""

    def __init__(self, settings):
        self._part = slice(settings.straight, settings.straight + settings.commands)

    def act(self, moment):
        return moment.observations[:, self._part].astype(float)


def test_the_referee_accepts_every_catch(chains):
    """Catches of the arena as solutions, among them some with an approach."""
    settings, caught, aimed = ChainSettings(), 0, 0
    plant = KinematicPlant(Pool.of(chains), len(chains), settings)
    episodes = run_episode(Straight(settings), plant, np.arange(len(chains)))
    for e in np.flatnonzero(episodes.outcomes == CAUGHT):
        situation, way = chains[e], way_of(chains[e].arm, *episodes.path(e))
        target = next(k for k, b in enumerate(situation.bodies) if b.role == "target")
        plan, reason = checked(SpatialProblem(situation, "arena"), Attempt(way, target))
        assert plan is not None, reason
        assert judge(written(situation), plan_to_json(plan, situation)) == []
        caught += 1
        aimed += situation.bodies[target].approach is not None
    assert caught > 5 and aimed > 0


def test_plans_can_be_followed(chains):
    """What a planner catches is caught again, step by step."""
    settings = ChainSettings()
    plans = [get_planner("straight").plan(s) for s in chains]
    kept = [(s, p.trajectory) for s, p in zip(chains, plans, strict=True) if p.caught]
    pool = pool_for(settings, [s for s, _ in kept])
    plant = KinematicPlant(pool, len(pool), settings)
    agent = follower_of([way for _, way in kept], pool, settings.dt)
    episodes = run_episode(agent, plant, np.arange(len(pool)))
    assert len(kept) > 3 and (episodes.outcomes == CAUGHT).mean() > 0.8


def test_models_with_shorter_lists_stand_side_by_side(chains):
    """Pairs, bodies and ignored bodies may be fewer; every arm is observed as if alone."""
    model = chains[1].arm.model
    fewer = replace(model, self_collision=model.self_collision[:2])
    lone = replace(chains[2], bodies=chains[2].targets, arm=replace(chains[2].arm, ignore=()))
    some = [chains[0], replace(chains[1], arm=replace(chains[1].arm, model=fewer)), lone]
    told = []
    for situations in (some, *([one] for one in some)):
        plant = KinematicPlant(Pool.of(situations), len(situations), ChainSettings())
        plant.put(np.arange(plant.count), np.arange(plant.count))
        plant.move(np.full((plant.count, 7), 0.3))
        told.append(plant.observations.copy())
    np.testing.assert_array_equal(told[0], np.concatenate(told[1:]))


def test_arms_of_other_sizes_are_refused_in_one_line(chains):
    flat = situation_from_json(drawn("planar-2", 0))
    for refused, message in (
        (lambda: Pool.of([chains[0], flat]), "its arm has 2 joints and 2 links, that of 'panda-0'"),
        (lambda: KinematicPlant(Pool.of([flat]), 1, ChainSettings()),
         "arm: 'panda' has 7 joints and 9 links, that of situation 'planar-2-0' 2 joints"),
        (lambda: ChainSettings(arm="pandy"), 'arm: "pandy" is not the name of an arm'),
        (lambda: ChainSettings(arm="no.json"), "arm: no.json: cannot be read"),
        (lambda: ChainSettings(fan=True), "fan: chains have none"),
    ):  # fmt: skip
        with pytest.raises(ArenaError) as caught:
            refused()
        assert message in str(caught.value) and "\n" not in str(caught.value)


def test_a_model_decides_how_much_is_observed():
    for name in ("panda", "ur5", "iiwa14", "xarm6"):
        model, settings = shipped_arm(name), ChainSettings(arm=name)
        assert settings.commands == model.dof
        assert settings.width == 7 * model.dof + 4 * len(model.links) + 41 + 20 * settings.slots
