"""Bending adapted paths: a look that leaves nothing out, changes that help, verdicts that hold."""

import numpy as np
import pytest

from gcm_learn import Arm, recall, seeding
from gcm_learn.families import draw, get_family
from gcm_learn.families.random_planar import random_planar
from gcm_learn.planners import Problem, checked
from gcm_learn.planners.baselines.straight import StraightPlanner
from gcm_learn.recall import hand_pushes
from gcm_learn.recall.adaptation import INSTANTS, query_of
from gcm_learn.recall.freeing import free as freed, quick_check
from gcm_learn.recall.hand_paths import check, hand_work
from gcm_learn.recall.meeting import adapt_to_targets
from gcm_learn.recall.styles import HURRY, POLAR as POLAR_SPACE, Style
from gcm_learn.recall.waypoints import EARLIEST, TIME
from gcm_learn.scene.bodies import poses_at
from tests.recall.conftest import stacked
from tests.worlds import among, disc

BARE, BENT = recall.Adaptation(bends=0), recall.Adaptation()
POLAR = Style(POLAR_SPACE, HURRY)


def scene(*obstacles, horizon=2.0):
    """A hand at (1.4, -0.8), a target at (1.4, 0.8), and obstacles between or beside them."""
    ball = disc("ball", (1.4, 0.8), role="target", radius=0.06)
    return among(Arm((1.4, -0.8), 3.0), ball, *obstacles, horizon=horizon)


def straight():
    """The straight line of the empty scene, as memory keeps it."""
    empty = scene()
    plan = StraightPlanner().plan(empty)
    assert plan.caught
    return recall.waypoints_of(empty, plan)


def times(situation, trace, how):
    return recall.transfer(situation, trace.knots[None], trace.goal[None], how=how)[0]


def test_a_path_is_pushed_aside_of_what_stands_in_its_way():
    stone = disc("stone", (1.4, 0.0), radius=0.1)
    assert times(scene(), straight(), BARE) >= 0.0
    assert times(scene(stone), straight(), BARE) < 0.0
    assert times(scene(stone), straight(), BENT) >= 0.0


def test_a_path_is_held_back_until_it_is_free():
    """A wall as long as the arm, which no bump goes round, leaves while there is time."""
    leaves = [(f"w{k}", (0.6 + 0.2 * k, 0.0)) for k in range(9)]
    wall = [disc(*one, radius=0.13, acceleration=(6.0, 0.0)) for one in leaves]
    situation = scene(*wall)
    soonest = times(scene(), straight(), BARE)
    assert times(situation, straight(), BARE) < 0.0
    assert times(situation, straight(), BENT) > soonest + 0.1


def test_a_wait_that_would_be_too_long_is_left_out():
    trace = straight()
    knots = trace.knots.copy()
    knots[1:, TIME] += 3.0
    knots[1:, EARLIEST] = knots[1:, TIME]
    late = recall.Waypoints(knots, trace.goal)
    assert times(scene(), late, BARE) < 0.0
    assert times(scene(), late, BENT) == pytest.approx(times(scene(), trace, BARE), abs=1e-6)


def test_a_detour_that_would_be_too_long_is_cut():
    trace = straight()
    knots = trace.knots.copy()
    knots[:, 1] -= 0.45 * np.sin(np.linspace(0.0, np.pi, len(knots)))
    far = recall.Waypoints(knots.astype(np.float32), trace.goal)
    short = scene(horizon=1.15 * float(times(scene(), trace, BARE)))
    assert times(scene(), far, BARE) > short.horizon
    assert times(short, far, BARE) < 0.0
    assert 0.0 <= times(short, far, BENT) <= short.horizon


@pytest.mark.slow  # compiles parts of recall alone
def test_the_look_leaves_no_instant_out(traces):
    """It skips instants at which a hand cannot have come near; it finds what all would."""
    knots, goals = stacked(traces)
    touched = agreed = asked = 0
    for k in range(20):
        situation = random_planar(seeding.rng(78, k))
        problem = Problem(situation, "look")
        if problem.early_answer() is not None:
            continue
        query = query_of(problem)
        work = hand_work(query)
        for m in range(0, len(traces), 7):
            count, _ = adapt_to_targets((knots, goals), m, query, POLAR, work)
            if count < 2:
                continue
            _, first, _ = quick_check(query, work, count, 0.0, np.inf)
            step = situation.horizon / (INSTANTS - 1)
            end = int(work.best_time[count - 1] / step)
            gaps = []
            for g in range(1, end + 1):
                _, _, x, y = hand_pushes._at(query, work, count, g)
                gaps.append(hand_pushes._clearance(query, g, x, y, 1e300))
            touching = [g for g, gap in enumerate(gaps, 1) if gap <= query.rules.touch]
            asked, touched = asked + 1, touched + bool(touching)
            agreed += first == (touching[0] if touching else -1)
        for g in np.flatnonzero(~np.isnan(query.table[:, 0, 0])):
            poses = np.zeros((len(situation.bodies), 12))
            poses_at(problem.bodies, g * step, poses)
            known = ~np.isnan(query.table[g])
            np.testing.assert_allclose(query.table[g][known], poses[known], atol=1e-12)
    assert asked > touched > 20
    assert agreed >= 0.97 * asked  # elbows that race may come nearer than the hand's speed says


@pytest.mark.parametrize(("family", "situations"), [("crossing-swarm", 30), ("falling-solid", 25)])
def test_bending_makes_more_memories_valid_and_they_are_verified(traces, family, situations):
    knots, goals = stacked(traces)
    bare = bent = lost = good = 0
    for k in range(situations):
        rng = seeding.rng(74, k)
        problem = Problem(draw(get_family(family), 74, k), "bends")
        if problem.early_answer() is not None:
            continue
        some = rng.integers(len(traces), size=8)
        before, after = (
            recall.transfer(problem, knots, goals, some, how) >= 0.0 for how in (BARE, BENT)
        )
        bare, bent, lost = bare + before.sum(), bent + after.sum(), lost + (before & ~after).sum()
        for m in some[after & ~before].tolist():
            attempt = recall.adapt(problem, traces[m], BENT)
            good += attempt is not None and checked(problem, attempt)[0] is not None
    assert bent > 1.3 * bare > 10
    assert lost <= 0.01 * bare
    assert good > 0.97 * (bent - bare + lost)


def test_every_memory_is_checked_once_however_much_it_is_bent(catches, traces):
    """One try asks one memory; a path that still looks as if it touched counts as checked."""
    memory = recall.Memory(recall.RandomIndex())
    memory.add([situation for situation, _ in catches], traces)
    failed = 0
    for k in range(40):
        situation = random_planar(seeding.rng(79, k))
        for tries in (1, 3):
            found = recall.RecallPlanner(memory, tries, novelty=0.0, penalty=0.0).recollect(
                situation
            )
            assert found.checked <= tries
            if (
                found.plan.failure is not None
                and found.plan.status == "unreachable"
                and found.checked
            ):
                place = memory.index.embed_query(situation)
                chosen = memory.recall(place, tries)
                assert found.checked == tries
                assert (recall.transfer(situation, memory.knots, memory.goals, chosen) < 0.0).all()
                failed += 1
    assert failed > 10


@pytest.mark.slow
def test_a_path_may_pass_nearer_than_it_is_meant_to(traces):
    """Room is asked for while a path is bent; what has none left in the end is checked as well."""
    knots, goals = stacked(traces)
    near = bent = 0
    for k in range(40):
        problem = Problem(draw(get_family("gate"), 75, k), "near")
        if problem.early_answer() is not None:
            continue
        query = query_of(problem)
        work = hand_work(query)
        for m in range(0, len(traces), 5):
            count, body = adapt_to_targets((knots, goals), m, query, POLAR, work)
            if count < 2 or quick_check(query, work, count, 0.0, np.inf)[1] < 0:
                continue
            count, free = freed(query, POLAR, work, count, body, 5)
            if free and check(query, work, count, body)[1]:
                bent += 1
                near += quick_check(query, work, count, hand_pushes.MARGIN, np.inf)[1] >= 0
    assert near > 0 and bent > near
