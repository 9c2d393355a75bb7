"""The oracle against what is known exactly, against itself, and against all other planners."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from gcm_learn import seeding
from gcm_learn.arms import Arm
from gcm_learn.families.random_planar import random_planar
from gcm_learn.families.random_solid import random_solid
from gcm_learn.planners import get_planner
from gcm_learn.planners.completion import Problem
from gcm_learn.planners.oracle.bounds import OraclePlanner, bounds, earliest_catch, stratum
from gcm_learn.planners.oracle.moves import BETWEEN, MOVES, SHARES, STRETCH
from gcm_learn.planners.oracle.reachable_set import ReachableSet
from gcm_learn.situation import Body, Disc, PlanarQuadratic, Polygon, Situation
from tests.judging import judge

SPEED = 3.3
REST = ((0.0, 0.0), (0.0, 0.0))
RIVALS = ("straight", "straight-wait", "potential", "marching", "gcm", "layered")


def scene(*bodies, hand=(0.9, 0.0), horizon=1.2, **arm):
    return Situation("scene", horizon, Arm(hand, SPEED, **arm), bodies)


def goal(x, y, velocity=(0.0, 0.0)):
    return Body("target", "goal", Disc(0.05), PlanarQuadratic((x, y), velocity, (0.0, 0.0)))


def obstacle(name, shape, position=(0.0, 0.0), velocity=(0.0, 0.0)):
    return Body("obstacle", name, shape, PlanarQuadratic(position, velocity, (0.0, 0.0)))


def bar(low, high):
    """A bar along the x axis."""
    return Polygon(((low, -0.08), (high, -0.08), (high, 0.08), (low, 0.08)))


# A disc covers the target and moves off, outwards: before OPENS there is no room to catch it,
# since a hand within 0.1 of the target's centre is within 0.4 of the disc's.
OPENS = (0.4 - 0.05 - 0.05) / 0.5
GATE = scene(goal(1.5, 0.0), obstacle("gate", Disc(0.4), (1.5, 0.0), (0.5, 0.0)))
# Bars along the x axis, from near the shoulder to beyond the rim: no limb gets across. The ring has
# a hole: where hand and shoulder may meet, a cell around them is all the outer set needs to turn.
UPPER = 1.2
BARS = (obstacle("right bar", bar(0.3, 2.6)), obstacle("left bar", bar(-2.6, -0.3)))
WALL = scene(goal(0.7, 1.2), *BARS, hand=(0.7, -1.2), horizon=2.0, upper_arm=UPPER)
# The right one leaves.  An elbow gets across only beyond its inner end.
TIP = 0.8
LEAVES = (UPPER - 0.3) / TIP
OPENING = replace(
    WALL, bodies=(goal(0.7, 1.2), obstacle("right bar", bar(0.3, 2.6), (0, 0), (TIP, 0)), BARS[1])
)
# A post stands in the way of the hand.
POST = scene(goal(1.3, 0.5), obstacle("post", Disc(0.12), (1.3, 0.05)), hand=(1.3, -0.5))
AROUND = scene(goal(0.7, 1.2), obstacle("bar", bar(0.3, 2.6)), hand=(0.7, -1.2))


def test_moves_are_all_mirror_images_and_their_stretch_is_known():
    assert len({tuple(m) for m in MOVES.tolist()}) == 32
    for move, pairs, shares in zip(MOVES, BETWEEN, SHARES, strict=True):
        for (p, q), share in zip(pairs, shares, strict=True):
            if (p == 0).all() and (q == 0).all():
                continue
            cross = [move[0] * c[1] - move[1] * c[0] for c in (p, q)]
            assert cross[0] * cross[1] <= 0 and max(map(abs, cross)) <= np.abs(move).max()
            assert 0.0 < share < 1.0
    order = np.argsort(np.arctan2(*MOVES.T))
    stretch = 1.0
    for a, b in zip(MOVES[order], np.roll(MOVES[order], -1, axis=0), strict=True):
        shares = np.linspace(0.0, 1.0, 2001)[:, None]
        ways = shares * a / np.hypot(*a) + (1.0 - shares) * b / np.hypot(*b)
        stretch = max(stretch, (1.0 / np.hypot(*ways.T)).max())
    assert stretch <= STRETCH < stretch + 1e-4


def arrivals(situation, n, exact):
    """First arrival in every cell, infinite where there is none, and the set."""
    reached = ReachableSet(Problem(situation, "test"), n, exact=exact)
    for _ in reached.meetings():
        pass
    first = np.full(len(reached.grid.centre), np.inf)
    front = reached.front
    nodes = slice(0, int(front.total[0]))
    np.minimum.at(first, front.cell[nodes], front.came[nodes])
    return first, reached


@pytest.mark.slow
@pytest.mark.parametrize("n", [40, 80])
def test_arrivals_in_free_space_are_distances(n):
    situation = scene(goal(-1.2, 0.9), hand=(0.93, 0.31))
    h = 2.0 * situation.arm.reach / n
    for exact in (True, False):
        first, reached = arrivals(situation, n, exact)
        cells = np.flatnonzero(np.isfinite(first))
        assert len(cells) > 0.5 * len(reached.grid.cells)
        offset = reached.grid.centre[cells, :2] - situation.arm.hand
        true = np.hypot(*offset.T) / SPEED
        if exact:
            assert (first[cells] >= true * (1.0 - 1e-12)).all()
            # Moves skirt the shoulder: further round only by what a cell there takes.
            assert np.mean(first[cells] <= true * STRETCH + 1e-9) > 0.95
        else:
            assert (first[cells] <= true + 1e-12).all()
            assert (first[cells] >= true - math.sqrt(0.5) * h / SPEED - 1e-12).all()


@pytest.mark.parametrize("k", range(3))
def test_the_outer_set_holds_the_inner_one(k):
    situation = random_planar(seeding.rng(81, k), (3, 5))
    if Problem(situation, "test").early_answer() is not None:
        pytest.skip("nothing to reach")
    inner, _ = arrivals(situation, 50, True)
    outer, reached = arrivals(situation, 50, False)
    counted = np.flatnonzero(np.isfinite(inner) & (inner <= reached.front.useful))
    assert (outer[counted] <= inner[counted]).all()


def test_a_free_target_is_bounded_exactly():
    situation = scene(goal(1.3, 0.6), hand=(0.9, -0.4))
    exact = (math.hypot(0.4, 1.0) - 0.05 - 0.05) / SPEED
    found = bounds(situation)
    assert found.lower <= exact <= found.upper <= exact * (1.0 + 1e-3)
    assert found.lower >= exact * (1.0 - 1e-3)
    assert found.plan.planner == "oracle" and found.tight and found.decided


def test_a_gate_is_passed_when_it_opens():
    coarse, fine = bounds(GATE, (60,), None), bounds(GATE)
    for found in (coarse, fine):
        assert found.lower <= OPENS <= found.upper
        assert judge(GATE, found.plan) == []
    assert 0.7 * OPENS < coarse.lower < fine.lower
    assert fine.upper <= min(coarse.upper, OPENS * 1.01)


def test_a_wall_is_certainly_the_end():
    found = bounds(WALL)
    assert math.isinf(found.lower) and math.isinf(found.upper) and found.decided
    assert found.plan.status == "unreachable" and "certainly" in found.plan.message


def test_a_wall_that_leaves_is_awaited():
    found = bounds(OPENING)
    assert LEAVES <= found.upper <= LEAVES + 0.5
    assert 0.0 < found.lower <= LEAVES  # loose: the limbs fold at the rim of the hole, cells do not
    assert judge(OPENING, found.plan) == []


def test_finer_lattices_only_narrow_the_bounds():
    for situation in (GATE, OPENING, AROUND):
        before = bounds(situation, (40,), None)
        for sizes in ((40, 60), (40, 60, 90)):
            found = bounds(situation, sizes, None)
            assert before.lower <= found.lower <= found.upper <= before.upper
            before = found


@pytest.mark.parametrize(
    ("situation", "expected"),
    [
        (scene(goal(1.3, 0.6)), "L"),
        (AROUND, "W"),
        (POST, "W"),
        (GATE, "Q"),
        (WALL, "U"),
        (scene(goal(5.0, 5.0)), "U"),
        (scene(goal(1.3, 0.6), obstacle("on it", Disc(0.2), (0.45, -0.8))), "U"),
    ],
)
def test_strata(situation, expected):
    assert stratum(situation) == expected
    assert stratum(situation, bounds(situation)) == expected


def test_without_waiting_the_gate_stays_shut():
    problem = Problem(GATE, "test")
    assert earliest_catch(problem, 60, waiting=False) is None
    assert earliest_catch(problem, 60) is not None
    around = Problem(AROUND, "test")
    moving, waiting = (earliest_catch(around, 60, waiting=w) for w in (False, True))
    assert moving.catch_time == pytest.approx(waiting.catch_time, rel=0.01)


def test_messages_tell_certain_from_not_found():
    blind = OraclePlanner(sizes=(), last_size=None).plan(GATE)
    assert blind.status == "unreachable" and "none is ruled out" in blind.message
    assert "certainly" in OraclePlanner().plan(WALL).message
    blocked = scene(goal(1.3, 0.6), obstacle("on it", Disc(0.2), (0.45, -0.8)))
    assert OraclePlanner().plan(blocked).status == "start_blocked"
    assert math.isinf(bounds(blocked).lower)


def test_a_target_that_rushes_through_a_long_horizon_is_not_ruled_out():
    """Interceptions are looked for coarsely then: no claim may be built on that."""
    rushing = Situation("long", 1e6, Arm((1.0, 0.5), SPEED), (goal(1.6, -0.9, (0.1, 0.1)),))
    found = bounds(rushing)
    assert found.plan.caught or not found.decided


def test_joint_limits_are_kept():
    slow = replace(AROUND, horizon=4.0, arm=replace(AROUND.arm, max_joint_speed=(2.0, 3.0)))
    found = bounds(slow)
    assert found.plan.caught and judge(slow, found.plan) == []
    assert found.upper > bounds(AROUND).upper * 1.5


def contradictions(situations, rivals):
    """What does not fit together between the oracle and other planners, and the catches seen."""
    wrong, caught = [], 0
    for k, situation in enumerate(situations):
        found = bounds(situation)
        if found.lower > found.upper:
            wrong.append((k, "bounds", found.lower, found.upper))
        for name in rivals:
            plan = get_planner(name).plan(situation)
            if plan.caught:
                caught += 1
                if plan.catch_time < found.lower:
                    wrong.append((k, name, plan.catch_time, found.lower))
    return wrong, caught


@pytest.mark.parametrize(
    ("family", "seed", "count", "least"), [(random_planar, 82, 3, 4), (random_solid, 83, 2, 2)]
)
def test_no_planner_beats_the_lower_bound(family, seed, count, least):
    wrong, caught = contradictions([family(seeding.rng(seed, k)) for k in range(count)], RIVALS)
    assert wrong == [] and caught > least


@pytest.mark.slow
@pytest.mark.parametrize("part", range(5))
def test_no_planner_beats_the_lower_bound_in_crowds(part):
    seeds = range(200 * part, 200 * (part + 1))
    situations = [random_planar(seeding.rng(84, k), (4, 7)) for k in seeds]
    situations += [random_solid(seeding.rng(85, k)) for k in seeds[:60]]
    wrong, caught = contradictions(situations, RIVALS)
    assert wrong == [] and caught > 300


@pytest.mark.slow
def test_finer_lattices_hardly_improve_the_plan():
    """What the default sizes leave on the table, where a straight line does not do."""
    gains, misses = [], 0
    for k in range(300):
        situation = random_planar(seeding.rng(86, k), (3, 6))
        usual = bounds(situation)
        if usual.tight:
            continue
        fine = bounds(situation, (240,), None)
        misses += fine.plan.caught and not usual.plan.caught
        if usual.plan.caught and fine.plan.caught:
            gains.append(usual.upper / fine.upper)
    assert misses == 0 and len(gains) > 20
    assert np.median(gains) < 1.005 and max(gains) < 1.05
