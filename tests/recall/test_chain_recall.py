"""Recall of chains: movements of any number of joints, turned to the target, verified."""

import json
import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from gcm_learn import families, get_planner, recall, referee, seeding
from gcm_learn.arms import CHAIN
from gcm_learn.cli import main
from gcm_learn.errors import ArmKindError, RecallError
from gcm_learn.families import family_from_dict
from gcm_learn.recall.headings import heading_of, nearest_target
from gcm_learn.scene import pack
from gcm_learn.scene.bodies import pose_at
from gcm_learn.situation import situation_to_json, write_situations
from gcm_learn.situation.laws import carried
from tests.judging import judge

FAMILY = "panda-easy"


@cache
def catches():
    """Situations of a Panda with their catches."""
    planner = get_planner("search")
    found = ((s, planner.plan(s)) for s in (families.draw(FAMILY, 7, k) for k in range(30)))
    return [(s, plan) for s, plan in found if plan.caught][:14]


@cache
def memory():
    """A memory of them."""
    situations = [situation for situation, _ in catches()]
    made = recall.Memory(recall.RawIndex.fit(situations), kind=CHAIN)
    made.add(situations, [recall.waypoints_of(situation, plan) for situation, plan in catches()])
    return made


def turned(situation, angle):
    """The situation turned about the axis of the Panda's first joint, and that joint with it."""
    c, s = math.cos(angle), math.sin(angle)
    turn, arm = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]), situation.arm
    bodies = tuple(
        replace(body, motion=carried(body.motion, turn, np.zeros(3))) for body in situation.bodies
    )
    joints = (arm.joints[0] + angle, *arm.joints[1:])
    return replace(situation, arm=replace(arm, joints=joints), bodies=bodies)


def fitting_turn(situation, plan):
    """A turn that keeps the first joint in its range on the plan."""
    low, high = situation.arm.joint_range[0]
    values = plan.trajectory.joints[:, 0]
    down, up = low - values.min(), high - values.max()
    return 0.9 * (up if up > -down else down)


def test_a_turn_about_the_first_joint_changes_nothing_but_its_range():
    for situation, plan in catches()[:5]:
        other = turned(situation, fitting_turn(situation, plan))
        ours, theirs = recall.raw_features(situation), recall.raw_features(other)
        same = np.arange(ours.size) // 2 != 7  # numbers 14 and 15 are the range
        assert np.allclose(ours[same], theirs[same], atol=1e-5)
        assert not np.allclose(ours[14:16], theirs[14:16], atol=1e-2)
        joints = plan.trajectory.joints.copy()
        joints[:, 0] += fitting_turn(situation, plan)
        its = recall.waypoints_of(
            other, replace(plan, trajectory=replace(plan.trajectory, joints=joints))
        )
        mine = recall.waypoints_of(situation, plan)
        assert np.allclose(its.knots[[0, -1]], mine.knots[[0, -1]], atol=1e-5)
        assert np.allclose(its.goal, mine.goal, atol=1e-5)


def test_the_target_is_ahead():
    for situation, _ in catches():
        scene, poses = pack(situation), np.zeros((len(situation.bodies), 12))
        heading = heading_of(scene.limb, scene)
        assert abs(scene.limb.start[0] - heading.shift[0]) <= math.pi
        pose_at(scene.bodies, nearest_target(scene, poses), 0.7 * situation.horizon, poses)
        ahead = (poses[:, :3] - heading.origin) @ heading.rows.T
        assert any(place[0] > 0.0 and abs(place[1]) < 1e-6 for place in ahead)


def test_memories_stay_with_arms_of_as_many_joints(tmp_path):
    memory().save(tmp_path / "panda")
    loaded = recall.Memory.load(tmp_path / "panda")
    assert loaded.kind == CHAIN and loaded.index.key == memory().index.key
    assert np.array_equal(loaded.knots, memory().knots) and loaded.columns == 9
    assert json.loads((tmp_path / "panda" / "manifest.json").read_text())["format"] == (
        "gcm-learn/memory@3"
    )
    other = family_from_dict({"family": "throw-chain", "arm": {"model": "ur5"}})
    with pytest.raises(ArmKindError, match="holds catches of 7 joints, this arm has 6; `"):
        recall.RecallPlanner(loaded).plan(other.draw(seeding.rng(3, 0), "other"))
    with pytest.raises(RecallError, match="planner 'search': takes no memory"):
        recall.with_memory("search", loaded)


@pytest.mark.slow
def test_the_command_solves_with_the_memory_of_a_folder(tmp_path, capsys):
    memory().save(tmp_path / "panda")
    situation = catches()[2][0]
    write_situations(tmp_path / "one.json", [situation])
    given = [str(tmp_path / "one.json"), "--planner", "recall", "--memory", str(tmp_path / "panda")]
    assert main(["solve", *given]) == 0
    solution = json.loads(capsys.readouterr().out)
    assert solution["status"] == "caught" and solution["planner"] == "recall"
    assert referee.judge(situation_to_json(situation), solution) == []


@pytest.mark.slow
def test_a_memory_of_a_chain_recalls_its_own_catches():
    planner, own = recall.RecallPlanner(memory()), 0
    for k, (situation, _) in enumerate(catches()):
        found = planner.recollect(situation)
        own += found.memory == k
        if found.plan.caught:
            assert judge(situation, found.plan) == []
    assert own > 0.7 * len(catches())


@pytest.mark.slow  # compiles recall for chains
def test_recall_and_hybrid_catch_in_situations_that_are_new():
    caught = {"recall": 0, "hybrid": 0}
    for name in caught:
        planner = recall.with_memory(name, memory())
        assert isinstance(planner, recall.HybridPlanner) == (name == "hybrid")
        for k in range(12):
            situation = families.draw(FAMILY, 8, k)
            plan = planner.plan(situation)
            assert plan.planner == name
            if plan.caught:
                caught[name] += 1
                assert judge(situation, plan) == []
    assert caught["hybrid"] >= caught["recall"] >= 3


@pytest.mark.slow
def test_a_memory_without_limits_serves_chains_with_limits_of_acceleration():
    planner, caught = recall.RecallPlanner(memory()), 0
    for k in range(24):
        situation = families.draw("panda-crowded-accelerated", 9, k)
        plan = planner.plan(situation)
        if plan.caught:
            caught += 1
            assert plan.trajectory.rates is not None and judge(situation, plan) == []
    assert caught >= 3
