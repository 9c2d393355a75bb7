"""The search without a map: what it queues, what it finds, and that a bound is kept."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gcm_learn import families, seeding
from gcm_learn.arms import Arm, elbow_of
from gcm_learn.charts import Lattice
from gcm_learn.collision.occupancy import passes_by
from gcm_learn.collision.sweep import DEEPEST, Sweep, least_distance, leg_is_free
from gcm_learn.families.random_planar import random_planar
from gcm_learn.planners import layered
from gcm_learn.planners.completion import Problem
from gcm_learn.planners.goal_directed import ground_of, searched
from gcm_learn.planners.meetings import aim_at
from gcm_learn.planners.plan import GAIN
from gcm_learn.scene import pack
from gcm_learn.scene.bodies import HAND, PART, TOP_SPEED, poses_at
from gcm_learn.wave import MarchingParams
from tests.judging import judge

N = 80
MIXED = [
    families.draw(name, 81, k)
    for name in ("random-planar", "gate", "crossing-swarm", "random-solid", "late-target")
    for k in range(4)
]
PLANNER = layered(MarchingParams(n=N))
MAPS = replace(PLANNER, find=None)


def test_it_catches_what_maps_catch_and_as_soon():
    found = [PLANNER.plan(s) for s in MIXED]
    mapped = [MAPS.plan(s) for s in MIXED]
    for s, ours, theirs in zip(MIXED, found, mapped, strict=True):
        assert ours.caught or not theirs.caught
        assert not ours.caught or judge(s, ours) == []
        if theirs.caught:  # paths from centre to centre are a little longer
            assert ours.catch_time <= theirs.catch_time + 2.0 * GAIN * s.horizon
    assert sum(p.caught for p in found) >= 12
    assert sum(p.caught and p.map is None for p in found) == sum(p.caught for p in found)


def test_a_bound_is_kept_and_loses_nothing():
    caught = [(s, plan.catch_time) for s in MIXED if (plan := PLANNER.plan(s)).caught]
    assert len(caught) >= 12
    for situation, when in caught:
        again = PLANNER.plan(situation, bound=1.02 * when)
        assert again.caught and again.catch_time <= 1.02 * when
        assert abs(again.catch_time - when) <= 2.0 * GAIN * situation.horizon
        sooner = PLANNER.plan(situation, bound=0.7 * when)
        assert not sooner.caught or sooner.catch_time <= 0.7 * when


@pytest.mark.parametrize("bound", [0.0, -1.0, float("nan")])
def test_a_bound_must_be_positive(bound):
    with pytest.raises(ValueError, match="bound"):
        PLANNER.plan(MIXED[0], bound=bound)


def test_nothing_is_queued_that_cannot_meet_a_target_before_the_bound():
    problems = [Problem(s, "search") for s in MIXED]
    counts = [queued_in_time(p) for p in problems if p.early_answer() is None]
    assert len(counts) >= 12 and min(counts) > 0


def queued_in_time(problem):
    """Check all labels of a search, and count them."""
    scene, end = problem.scene, problem.situation.horizon
    ground, labels, _ = searched(problem, N)
    queued = np.flatnonzero((labels.tent < 1e300) & (labels.node >= 0))
    instants = np.linspace(0.0, end, 400)
    poses, reach = np.zeros((len(scene.bodies.rows), 12)), np.full(len(queued), np.inf)
    rows = scene.bodies.rows
    for t in instants:
        poses_at(scene.bodies, t, poses)
        for b in np.flatnonzero(rows[:, PART] == HAND):
            place = ground.postures.limb[labels.node[queued], :2]
            away = np.hypot(np.hypot(*(place - poses[b, :2]).T), poses[b, 2])
            away -= scene.limits.grasp + rows[b, 5] + 3.0 * rows[b, TOP_SPEED] * end / 24
            late = away / scene.limits.speed + labels.tent[queued] - t
            reach = np.minimum(reach, late)
    assert (reach <= 1e-9).all()
    return len(queued)


def test_spans_are_shut_only_where_no_hand_can_be_at_a_target():
    rng, there, shut = seeding.rng(84), 0, 0
    for situation in MIXED:
        problem = Problem(situation, "meetings")
        scene, end = problem.scene, situation.horizon
        ground = ground_of(problem, Lattice(N, situation.arm.upper_arm, situation.arm.elbow))
        aim = aim_at(ground, end)
        shut += (aim.ways[..., 3] < 0.0).sum()
        targets = np.flatnonzero(scene.bodies.rows[:, PART] == HAND)
        poses = np.zeros((len(scene.bodies.rows), 12))
        for t in rng.uniform(0.0, end, 300):
            poses_at(scene.bodies, t, poses)
            for k, b in enumerate(targets):
                away = scene.limits.grasp * rng.uniform(-1.0, 1.0, 2)
                hand = poses[b, :2] + away
                if np.linalg.norm([*away, poses[b, 2]]) > scene.limits.grasp:
                    continue
                if not scene.limb.near + 0.02 < np.hypot(*hand) < scene.limb.far - 0.02:
                    continue
                if rests(scene, t, hand) < 0.03:
                    continue
                there += 1
                assert aim.ways[int(t / aim.step), k, 3] >= 0.0
    assert there > 500 and shut > 50


def rests(scene, t, hand):
    """Clearance of a limb at rest at t."""
    touch = scene.limb.thickness
    return least_distance(scene, np.array([t]), hand[None], -1.0, 1e-6)[0] - touch


@pytest.mark.parametrize("scenes", [range(5, 12), pytest.param(range(20), marks=pytest.mark.slow)])
def test_a_leg_is_free_when_its_least_distance_says_so(scenes):
    counts = np.sum([legs(k) for k in scenes], axis=0)
    assert counts[0] > 40 * len(scenes) and 50 < counts[1] < counts[0] - 50


def legs(k):
    """Compare legs of one scene; how many there were, and how many were free."""
    rng = seeding.rng(82, k)
    scene = pack(random_planar(rng, (2, 5)))
    floor, bodies = scene.limb.thickness + 1e-3, len(scene.bodies.rows)
    agreed, free = 0, 0
    for _ in range(60):
        time = np.sort(rng.uniform(0.0, scene.limits.horizon, 2))
        turn, radius = rng.uniform(-np.pi, np.pi), rng.uniform(scene.limb.near + 0.1, 1.8)
        start = radius * np.array([np.cos(turn), np.sin(turn)])
        hand = np.array([start, start + rng.uniform(-0.4, 0.4, 2)])
        if np.hypot(*hand[1]) > scene.limb.far or np.hypot(*hand[1]) < scene.limb.near:
            continue
        work = Sweep(time, hand, floor, 1e9, np.zeros((bodies, 12)), np.empty((DEEPEST + 2, 3)))
        ours = leg_is_free(scene, work, np.empty(64), np.full(1, 1000))
        least = least_distance(scene, time, hand, -1.0, 1e-6)[0]
        assert not ours or least > floor - 1e-9
        assert ours or least <= floor + 1e-3
        agreed, free = agreed + 1, free + ours
    return agreed, free


def test_what_passes_by_stays_away():
    passed = 0
    for k in range(30):
        rng = seeding.rng(83, k)
        situation = random_planar(rng, (3, 5))
        scene, arm = pack(situation), situation.arm
        assert isinstance(arm, Arm)
        poses = np.zeros((len(scene.bodies.rows), 12))
        hand = np.array(arm.hand)
        elbow = elbow_of(*hand, scene.limb.rho, scene.limb.side)
        t0, t1 = np.sort(rng.uniform(0.0, situation.horizon, 2))
        for b in range(len(scene.bodies.rows)):
            if not passes_by(scene.bodies, b, *hand, *elbow, 0.05, t0, t1, poses):
                continue
            passed += 1
            for t in np.linspace(t0, t1, 50):
                poses_at(scene.bodies, t, poses)
                away = np.hypot(*(poses[b, :2] - hand)) - scene.bodies.rows[b, 5]
                assert away > 0.05
    assert passed > 30


@pytest.mark.parametrize(
    ("family", "index"), [("late-target", 2), ("late-target", 12), ("behind-mover", 9)]
)
def test_joints_that_are_linear_between_samples_stay_on_a_last_leg_past_the_shoulder(family, index):
    """Near the shoulder joints turn far while the hand goes a little: that takes more samples."""
    situation = families.draw(family, 33, index)
    plan = PLANNER.plan(situation)
    assert plan.caught and judge(situation, plan) == []
