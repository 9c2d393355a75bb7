"""Planning by the wave that may wait: its ways, and what it catches next to other planners."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gcm_learn import seeding, solve
from gcm_learn.charts import chart_of
from gcm_learn.families import draw
from gcm_learn.families.examples import gate_scene
from gcm_learn.families.random_planar import random_planar
from gcm_learn.maps import explore
from gcm_learn.planners import get_planner
from gcm_learn.planners.layered_front import path_to
from gcm_learn.planners.layered_wave import CLOSE, EARLY, layered_wave, straightened
from gcm_learn.scene import pack
from gcm_learn.wave import WaveParams
from tests.judging import judge

NINE = WaveParams(laplacian=9)


def ways(seed, count, params=NINE, **arm):
    """Situations in which the wave meets a target, with its front and straightened front."""
    for k in range(count):
        situation = random_planar(seeding.rng(seed, k), (3, 6))
        situation = replace(situation, arm=replace(situation.arm, **arm))
        scene = pack(situation)
        front = explore(scene, chart_of(situation.arm, params.n), params, wait=True)
        if front.met_state > 0:
            yield situation, front, straightened(front, scene)


def bends(front):
    """Number of states on the way to where the target is met."""
    return len(front.chain())


def length(front, situation):
    """Length of the way there [forearm lengths]."""
    hand, _ = path_to(front, situation.arm, front.chain())
    return float(np.hypot(*np.diff(hand, axis=0).T).sum())


def test_ways_have_few_bends_and_are_short():
    alone, found = 0, 0
    for situation, front, straight in ways(91, 60):
        found += 1
        assert bends(straight) <= bends(front)
        assert length(straight, situation) <= length(front, situation) + 1e-9
        x, y = front.chart.hands[front.nodes[front.met_state]] - situation.arm.hand
        alone += length(straight, situation) < 1.001 * np.hypot(x, y)
        assert bends(straight) <= 12
    assert found > 20 and alone > 0.6 * found  # most of them with no bend at all


@pytest.mark.parametrize("limits", [None, (6.0, 8.0)])
def test_straight_pieces_run_through_excited_cells(limits):
    """At every point of the way the hand is where the wave says that it can be, or all but."""
    outside, points = 0, 0
    for situation, front, straight in ways(92, 40, max_joint_speed=limits):
        hand, wanted = path_to(straight, situation.arm, straight.chain())
        lattice = front.chart
        crossing = lattice.spacing / situation.arm.max_hand_speed
        step = max(int(CLOSE * lattice.spacing / 0.02), 1)
        for (x, y), t in zip(hand[1:-1:step], wanted[1:-1:step], strict=True):
            here = (front.cells == lattice.cell_of((x, y))).all(axis=1)
            reached = front.arrival[here] - EARLY * crossing <= t + 0.25 * crossing
            outside += not (reached & (t <= front.end[here] + 0.25 * crossing)).any()
            points += 1
    assert points > 300 and outside <= 0.02 * points


def test_the_gate_that_opens():
    """The published wave freezes at the gate; this one flows through when it has gone."""
    assert not solve(gate_scene(), "gcm").caught
    plan = solve(gate_scene(), "layered-wave")
    assert plan.caught and plan.catch_time > 0.7
    assert judge(gate_scene(), plan) == []
    assert sum(wait.duration for wait in plan.trajectory.waits()) > 0.1
    assert plan.map.later is not None and plan.map.interception is not None


def caught(planner, situations):
    """Which situations a planner solves, all plans before the referee."""
    found = set()
    for k, situation in enumerate(situations):
        plan = get_planner(planner).plan(situation)
        if plan.caught:
            assert judge(situation, plan) == []
            found.add(k)
    return found


def test_gates_are_waited_for_as_by_layered_marching():
    situations = [draw("gate", 93, k) for k in range(25)]
    wave, marched, plain = (caught(p, situations) for p in ("layered-wave", "layered", "gcm"))
    assert len(wave & marched) >= 0.95 * len(marched) > 15
    assert len(wave) >= len(plain) + 4


@pytest.mark.slow
@pytest.mark.parametrize("family", ["late-target", "behind-mover", "crossing-swarm", "gate-solid"])
def test_it_lies_between_the_published_wave_and_layered_marching(family):
    situations = [draw(family, 94, k) for k in range(60)]
    wave, marched, plain = (caught(p, situations) for p in ("layered-wave", "layered", "gcm"))
    assert len(wave) > len(plain) and len(wave) > 0.8 * len(marched)


def test_parameters_of_the_first_map_carry_over_to_the_others():
    planner = layered_wave(WaveParams(n=40, laplacian=5, start_radius=3.0))
    params = [level.params for level in planner.levels]
    assert [(p.n, p.margin) for p in params] == [(40, 1), (40, 0), (80, 1), (80, 0)]
    assert all(p.start_radius == 3.0 and p.laplacian == 5 for p in params)
