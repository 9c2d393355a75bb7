"""Marching over hand-space in space, against a plain search in order of time."""

from __future__ import annotations

import heapq
from dataclasses import replace

import numpy as np
import pytest

from gcm_learn import build_map
from gcm_learn.charts import PostureLattice
from gcm_learn.collision.postures import desk_of, distance_at, move_is_free
from gcm_learn.maps import CognitiveMap, chain_to, descend
from gcm_learn.motion.joint_interception import target_room
from gcm_learn.scene import HAND, PART, pack
from gcm_learn.situation import Body, SolidQuadratic, Sphere, read_situations
from gcm_learn.wave import MarchingParams
from gcm_learn.wave.causal import march_in_space as march
from tests.charts.steps import steps_of
from tests.spatial import EXAMPLES

pytestmark = pytest.mark.slow  # compiles a march for spatial arms
SITUATIONS = read_situations(EXAMPLES)
N = 16
FAR = SolidQuadratic((50.0, 50.0, 50.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
EVERYWHERE = MarchingParams(n=N, margin=0.0, until="horizon")
TO_CONTACT = MarchingParams(n=N, margin=0.0)


def explored(situation, horizon=3.0):
    """A situation in which nothing is met, so that the front goes everywhere."""
    obstacles = [body for body in situation.bodies if body.role == "obstacle"]
    target = Body("target", "far", Sphere(0.1), FAR)
    return replace(situation, bodies=(target, *obstacles), horizon=horizon)


def searched(scene, chart):
    """Arrivals (nodes,), infinite where there are none, and nodes that are frozen, label by label.

    A label is a node, when it is reached and from where.  It is frozen if the limb is touched then;
    a label whose step is not free is dropped.
    """
    steps, joints, desk = steps_of(chart, scene), chart.joints.astype(float), desk_of(scene)
    touch, arrival = scene.limb.thickness, np.full(chart.size, np.inf)
    frozen, heap = set(), [(t, int(node), -1) for node, t in zip(*chart.start(scene), strict=True)]
    heapq.heapify(heap)
    while heap:
        t, node, home = heapq.heappop(heap)
        if arrival[node] < np.inf or t > scene.limits.horizon:
            continue
        if distance_at(scene, joints[node], t, desk) <= touch:
            arrival[node] = t
            frozen.add(node)
            continue
        way = joints[home], arrival[home], joints[node], t
        if home >= 0 and not move_is_free(scene, *way, touch, desk):
            continue
        arrival[node] = t
        for k in range(steps.first[node], steps.first[node + 1]):
            heapq.heappush(heap, (t + steps.time[k], int(steps.to[k]), node))
    return arrival, frozen


@pytest.mark.parametrize("postures", [1, 2, 4])
@pytest.mark.parametrize("k", [0, 2, 4, 15, 20])
def test_it_is_what_a_plain_search_finds(k, postures):
    situation = explored(SITUATIONS[k])
    scene, chart = pack(situation), PostureLattice(situation.arm, N, postures)
    front = march(scene, chart, EVERYWHERE)
    arrival, frozen = searched(scene, chart)
    ours = np.where(front.arrival < 0.0, np.inf, front.arrival)
    assert (np.isfinite(ours) == np.isfinite(arrival)).mean() > 0.999
    both = np.isfinite(ours) & np.isfinite(arrival)
    assert both.sum() > 500
    assert (
        np.mean(np.abs(ours[both] - arrival[both]) < 1e-5) > 0.995
    )  # touches by a hair go either way
    assert len(set(np.flatnonzero(front.refused)) ^ frozen) <= 0.002 * both.sum()
    assert front.steps == np.count_nonzero(both & ~front.refused.ravel())


def test_frozen_nodes_are_touched_when_the_front_comes_and_others_are_not():
    situation = explored(SITUATIONS[15])
    scene, chart = pack(situation), PostureLattice(situation.arm, N)
    front, desk, joints = (
        march(scene, chart, EVERYWHERE),
        desk_of(scene),
        chart.joints.astype(float),
    )
    refused = front.refused.ravel()
    came = np.flatnonzero(front.arrival >= 0.0)
    away = np.array([distance_at(scene, joints[m], front.arrival[m], desk) for m in came])
    assert refused.sum() > 20
    assert (away[refused[came]] <= scene.limb.thickness).all()
    assert (away[~refused[came]] > scene.limb.thickness - 1e-9).all()
    wide = march(scene, chart, replace(EVERYWHERE, margin=1.0))
    assert wide.steps < front.steps  # a margin closes more
    widened = march(scene, chart, EVERYWHERE, widening=np.ones(chart.size))
    np.testing.assert_array_equal(widened.arrival, wide.arrival)


def moving_and_still(situation):
    """One obstacle on the other side of the shoulder, and the same as it leaves for outside."""
    arm, space = situation.arm, PostureLattice(situation.arm, N)
    out = -np.array(space.hand) / np.linalg.norm(space.hand)
    place, way = space.in_world(0.6 * arm.reach * out), space.in_world(out) - arm.base.origin
    size = Sphere(0.15 * arm.reach)
    still = Body("obstacle", "o", size, SolidQuadratic(tuple(place), (0.0,) * 3, (0.0,) * 3))
    leaves = SolidQuadratic(tuple(place), tuple(20.0 * arm.reach * way), (0.0,) * 3)
    return [
        explored(replace(situation, bodies=(*situation.bodies[:1], body)))
        for body in (still, replace(still, motion=leaves))
    ]


def test_what_has_passed_does_not_stop_the_front():
    still, moving = moving_and_still(SITUATIONS[0])
    chart = PostureLattice(still.arm, N)
    fronts = [march(pack(s), chart, EVERYWHERE) for s in (still, moving)]
    assert fronts[0].refused.sum() > fronts[1].refused.sum() + 50
    late = fronts[1].arrival > 0.1  # it is gone by then
    assert late.sum() > 500 and not (fronts[1].refused.ravel() & late).any()


@pytest.mark.parametrize("k", [0, 2, 4, 6, 18])
def test_the_first_node_near_a_target_is_met_and_the_way_there_holds(k):
    situation = SITUATIONS[k]
    scene, chart = pack(situation), PostureLattice(situation.arm, 24)
    made = build_map(situation, replace(TO_CONTACT, n=24), chart=chart)
    assert made.interception is not None and made.hand == chart.hand
    node = int(np.ravel_multi_index(made.interception.cell, chart.shape))
    contact, poses = max(scene.limits.grasp, 0.87 * chart.spacing), desk_of(scene).poses
    targets = np.flatnonzero(scene.bodies.rows[:, PART] == HAND)

    def meets(m, t):
        hand = chart.hand_at(m)
        return any(target_room(scene, b, *hand, t, poses) <= contact for b in targets)

    assert meets(node, made.interception.time)
    arrival = made.arrival.filled(np.inf).ravel()
    sooner = np.flatnonzero(arrival < made.interception.time - 1e-9)
    assert len(sooner) > 5
    assert not any(meets(m, arrival[m]) for m in sooner)
    points, times = descend(made)
    nodes = chain_to(made, node)
    np.testing.assert_allclose(points, chart.hands[nodes])
    assert (np.diff(times) > 0.0).all() and times[-1] == pytest.approx(made.interception.time)
    steps = steps_of(chart, scene)
    for a, b, taken in zip(nodes[:-1], nodes[1:], np.diff(times), strict=True):
        span = slice(*steps.first[a : a + 2])
        assert taken == pytest.approx(steps.time[span][steps.to[span] == b][0], abs=1e-5)
    later = build_map(situation, TO_CONTACT, ignore=made.interception.time + 0.02)
    assert later.interception is None or later.interception.time > made.interception.time


@pytest.mark.parametrize("postures", [1, 4])
def test_maps_are_kept_in_files(tmp_path, postures):
    situation = SITUATIONS[6]
    chart = PostureLattice(situation.arm, N, postures)
    made = build_map(situation, TO_CONTACT, chart=chart)
    read = CognitiveMap.load(made.save(tmp_path / "map"))
    assert read.chart == made.chart and read.hand == made.hand and read.met == made.met
    assert read.interception == made.interception and read.kappa == made.kappa
    assert read.sheets.shape == made.sheets.shape and made.later is None
    np.testing.assert_array_equal(read.sheets.filled(-1.0), made.sheets.filled(-1.0))
    np.testing.assert_array_equal(read.via, made.via)
    np.testing.assert_array_equal(read.effective_obstacles, made.effective_obstacles)
    for ours, theirs in zip(descend(read), descend(made), strict=True):
        np.testing.assert_array_equal(ours, theirs)
