"""Recall in space: memories of joints, adapted to other ends, arms and frames, and verified."""

from dataclasses import replace

import numpy as np
import pytest

from gcm_learn import families, get_planner, recall, solve
from gcm_learn.arms import SPATIAL
from gcm_learn.errors import ArmKindError, RecallError
from gcm_learn.recall.waypoints import EARLIEST, TIME
from gcm_learn.situation import canonical
from gcm_learn.situation.spatial_frame import _in_base, _mirrored
from tests.judging import judge
from tests.recall.worlds import FREE, LIMITED, catches_of, memory_of, times

SLOW = pytest.mark.slow  # compiles recall for spatial arms
WORLDS = pytest.mark.parametrize("world", [FREE, LIMITED], ids=["free", "limited"])


PLANNERS = {
    "recall": lambda memory: recall.RecallPlanner(memory),
    "recall-1": lambda memory: recall.RecallPlanner(memory, 1, "recall-1", novelty=0.0),
    "hybrid": lambda memory: recall.HybridPlanner(recall.RecallPlanner(memory, 3)),
    "recall-random": lambda memory: recall.RecallPlanner(memory.refiled(recall.RandomIndex())),
    "keep": lambda memory: recall.RecallPlanner(memory, how=recall.Adaptation(tempo="keep")),
    "once": lambda memory: recall.RecallPlanner(memory, how=recall.Adaptation(bends=0)),
    "shipped": lambda memory: get_planner("recall"),
}


@SLOW
@WORLDS
@pytest.mark.parametrize("name", PLANNERS)
def test_every_catch_keeps_the_promise_and_goes_on_with_the_rates_at_the_start(name, world):
    planner, caught, other = PLANNERS[name](memory_of(world)), 0, 0
    known = families.family_names("spatial")[:12]
    for k, situation in enumerate(world.drawn(world.seed + 2, 36, known)):
        plan = planner.plan(situation)
        assert plan.status in ("caught", "unreachable", "start_blocked")
        if plan.caught:
            caught, other = caught + 1, other + (known[k % 12] not in world.names)
            assert judge(situation, plan) == []
            if world.accelerates:
                assert tuple(plan.trajectory.rates[0]) == situation.arm.joint_rates
    assert caught > (1 if name == "recall-1" else 4) and other > 0


@SLOW
def test_what_was_met_before_is_recalled_from_itself():
    planner, own = recall.RecallPlanner(memory_of(FREE)), 0
    for k, (situation, _) in enumerate(catches_of(FREE)[:60]):
        found = planner.recollect(situation)
        own += found.memory == k and found.checked == 1
    assert own > 45


def mirrored(situation):
    """A canonical situation as a mirror shows it."""
    bodies = tuple(_in_base(situation, mirrored=True))
    return replace(situation, arm=_mirrored(situation.arm), bodies=bodies)


@SLOW
@WORLDS
def test_a_right_arm_recalls_what_a_left_one_does(world):
    """The memory and its timing always; the way, unless a change of it went to the other side."""
    planner, same, mirrors = recall.RecallPlanner(memory_of(world)), 0, 0
    seed, count = (315, 16) if world.accelerates else (174, 24)
    signs = np.array([1.0, -1.0, -1.0, -1.0])
    for drawn in world.drawn(seed, count):
        situation = canonical(drawn)[0]
        mine, other = (planner.recollect(s) for s in (situation, mirrored(situation)))
        assert (mine.memory, mine.checked) == (other.memory, other.checked)
        if mine.memory is None:
            continue
        same += 1
        one, two = mine.plan.trajectory, other.plan.trajectory
        assert one.time[-1] == pytest.approx(two.time[-1], rel=1e-9)
        equal = np.allclose(one.joints * signs, two.joints, atol=1e-8)
        mirrors += equal
        if equal and world.accelerates:
            assert np.allclose(one.rates * signs, two.rates, atol=1e-6)
    assert same >= 4 and mirrors >= 0.75 * same


def test_a_catch_is_kept_at_its_corners_and_waits():
    catches = catches_of(FREE)
    for situation, plan in catches:
        knots, path = recall.waypoints_of(situation, plan).knots, plan.trajectory
        joints = canonical(situation)[1].canonical_joints(path.joints_at(knots[:, TIME]))
        assert np.allclose(knots[:, :4], joints, atol=1e-3)
        there = np.stack([np.interp(path.time, knots[:, TIME], knots[:, j]) for j in range(4)], 1)
        off = np.abs(there - canonical(situation)[1].canonical_joints(path.joints)).max()
        assert off < 0.25
        waits = knots[:, EARLIEST] > 0.0
        assert (knots[waits, EARLIEST] == knots[waits, TIME]).all()
    assert any((recall.waypoints_of(s, p).knots[:, EARLIEST] > 0.0).any() for s, p in catches)


def test_memories_of_space_are_stored_and_never_mixed_with_others(tmp_path):
    memory, catches = memory_of(FREE), catches_of(FREE)
    memory.save(tmp_path / "recall")
    loaded = recall.Memory.load(tmp_path / "recall")
    assert loaded.kind == SPATIAL and '"gcm-learn/memory@2"' in (
        tmp_path / "recall" / "manifest.json"
    ).read_text("utf-8")
    assert np.array_equal(loaded.knots, memory.knots) and loaded[3].situation == memory[3].situation
    planar = families.draw("gate", 3, 1)
    with pytest.raises(ArmKindError, match="memory: holds catches of spatial arms, asked with a"):
        loaded.add([planar], [recall.Waypoints(np.zeros((24, 4)), np.zeros(2))])
    with pytest.raises(ArmKindError):
        recall.RecallPlanner(loaded).plan(planar)
    with pytest.raises(RecallError, match="knows maps of the plane only"):
        recall.PcaIndex.fit([catches[0][0]])


@SLOW
def test_planners_by_name_answer_both_kinds_of_arm(tmp_path, monkeypatch):
    from gcm_learn import artifacts
    from gcm_learn.recall import planners

    shipped = artifacts.folders("models")
    situation = catches_of(FREE)[3][0]
    planners._memory.cache_clear()
    monkeypatch.setattr(artifacts, "folders", lambda kind: [tmp_path, *shipped])
    memory_of(FREE).save(tmp_path / "recall-space")
    for name in ("recall", "recall-1", "recall-raw", "recall-random", "hybrid"):
        plan = solve(situation, name)
        assert plan.planner == name and (plan.caught or name in ("recall-1", "recall-random"))
        assert solve(families.draw("gate", 3, 1), get_planner(name)).planner == name
    planners._memory.cache_clear()


@SLOW
@WORLDS
def test_changes_save_catches_and_leave_free_movements_alone(world):
    """Pushes and holds, or more times of the end, help; what was free before stays as it is."""
    memory, situations, caught = memory_of(world), list(world.drawn(world.seed + 5, 32)), {}
    for bends in (0, 3):
        planner = recall.RecallPlanner(memory, 5, how=recall.Adaptation(bends=bends), novelty=0.0)
        found = [planner.recollect(situation) for situation in situations]
        caught[bends] = sum(f.plan.caught for f in found)
        assert max(f.checked for f in found) == 5
    assert caught[3] > caught[0]
    plain, changed = (times(situations[:12], memory, bends) for bends in (0, 3))
    assert np.array_equal(changed[plain >= 0.0], plain[plain >= 0.0])
    assert (changed >= 0.0).sum() > 1.2 * (plain >= 0.0).sum()
