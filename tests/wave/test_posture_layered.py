"""Marching with waits over hand-space in space, against a plain search over nodes and spans."""

from __future__ import annotations

import heapq
from dataclasses import replace

import numpy as np
import pytest

from gcm_learn import build_map
from gcm_learn.arms.spatial_limb import limb_at
from gcm_learn.charts import PostureLattice
from gcm_learn.collision.postures import desk_of, distance_at, move_is_free
from gcm_learn.collision.rests import free_spans
from gcm_learn.maps import chain_to, descend
from gcm_learn.scene import pack
from gcm_learn.situation import Body, SolidQuadratic, Sphere, read_situations
from gcm_learn.wave import MarchingParams, fastest, march, march_layers
from tests.charts.steps import steps_of
from tests.spatial import EXAMPLES
from tests.wave.test_posture_marching import EVERYWHERE, TO_CONTACT, N, explored

SITUATIONS = read_situations(EXAMPLES)
STILL = (0.0, 0.0, 0.0)


def searched(scene, chart):
    """Arrivals (nodes, spans), infinite where there are none, label by label.

    A label is a node, one of its spans, when it is reached and from where.  If its step is not free
    it is tried again after a pause, and after twice as long, and so on, as long as both spans last.
    """
    steps, joints, desk = steps_of(chart, scene), chart.joints.astype(float), desk_of(scene)
    touch, end = scene.limb.thickness, scene.limits.horizon
    crossing = chart.spacing / fastest(scene)
    spans, arrival = {}, {}

    def spans_of(node):
        if node not in spans:
            out = np.empty((8, 2))
            found = free_spans(scene, joints[node], 0.0, end, touch, 0.03 * crossing, desk, out)
            spans[node] = [tuple(s) for s in out[:found]]
        return spans[node]

    heap = [(t, int(node), 0, None, 0) for node, t in zip(*chart.start(scene), strict=True)
            if spans_of(int(node)) and spans_of(int(node))[0][0] == 0.0]  # fmt: skip
    heapq.heapify(heap)
    while heap:
        t, node, k, home, tries = heapq.heappop(heap)
        if (node, k) in arrival or t > min(end, spans[node][k][1]):
            continue
        if home is not None:
            since, until, took = arrival[home[:2]], spans[home[0]][home[1]][1], home[2]
            if t - took > until:
                continue
            way = joints[home[0]], t - took, joints[node], t
            if not move_is_free(scene, *way, touch, desk):
                heapq.heappush(heap, (t + 2.0**tries * crossing, node, k, home, tries + 1))
                continue
            assert since <= t - took + 1e-9
        arrival[node, k] = t
        for e in range(steps.first[node], steps.first[node + 1]):
            other, took = int(steps.to[e]), float(steps.time[e])
            for i, (opens, _) in enumerate(spans_of(other)):
                time = max(t + took, opens + 0.03 * crossing if opens > 0.0 else 0.0)
                if (other, i) not in arrival and time - took <= spans[node][k][1]:
                    heapq.heappush(heap, (time, other, i, (node, k, took), 0))
    return arrival


@pytest.mark.parametrize(("k", "postures"), [(0, 1), (2, 1), (15, 1), (15, 2), (2, 4)])
def test_it_is_what_a_plain_search_finds(k, postures):
    situation = explored(SITUATIONS[k], SITUATIONS[k].horizon)
    scene, chart = pack(situation), PostureLattice(situation.arm, N, postures)
    front = march_layers(scene, chart, EVERYWHERE)
    wanted = searched(scene, chart)
    ours = sorted(zip(front.nodes.tolist(), front.arrival.tolist(), strict=True))
    theirs = sorted((node, t) for (node, _), t in wanted.items())
    assert abs(len(ours) - len(theirs)) <= 0.003 * len(theirs) and len(theirs) > 500
    crossing, close = chart.spacing / fastest(scene), 0
    times = {}
    for node, t in theirs:
        times.setdefault(node, []).append(t)
    for node, t in ours:
        close += any(abs(t - other) < 0.1 * crossing for other in times.get(node, ()))
    assert close > 0.99 * len(ours)
    assert len(front.sheets()[0]) >= 2  # there are nodes that it comes to twice


def touches(scene, desk, joints, since, others, until, count=12):
    """Whether the limb is touched at one of some instants of a move."""
    for s in np.linspace(0.0, 1.0, count):
        q = joints + s * (others - joints)
        if distance_at(scene, q, since + s * (until - since), desk) <= scene.limb.thickness - 1e-9:
            return True
    return False


@pytest.mark.parametrize("k", [0, 2, 15])
def test_states_are_reached_by_free_steps_after_free_waits(k):
    situation = explored(SITUATIONS[k], SITUATIONS[k].horizon)
    scene, chart = pack(situation), PostureLattice(situation.arm, N, 2)
    front, desk = march_layers(scene, chart, EVERYWHERE), desk_of(scene)
    joints, steps = chart.joints.astype(float), steps_of(chart, scene)
    assert (np.diff(front.arrival) >= 0.0).all() and (front.end >= front.arrival).all()
    waits = 0
    for s in range(0, len(front.nodes), 7):
        if front.via[s] < 0:
            continue
        home = front.via[s]
        a, b, t = front.nodes[home], front.nodes[s], front.arrival[s]
        span = slice(*steps.first[a : a + 2])
        took = steps.time[span][steps.to[span] == b][0]
        leaves = t - took
        assert front.arrival[home] <= leaves + 1e-5 and leaves <= front.end[home] + 1e-5
        assert not touches(scene, desk, joints[a], front.arrival[home], joints[a], leaves)
        assert not touches(scene, desk, joints[a], leaves, joints[b], t)
        waits += leaves > front.arrival[home] + took
    if k == 15:
        assert waits > 5


@pytest.mark.parametrize("postures", [1, 4])
def test_where_nothing_moves_it_is_marching_without_waits(postures):
    situation = SITUATIONS[2]
    bodies = [
        replace(b, motion=SolidQuadratic(b.motion.position, STILL, STILL))
        for b in situation.bodies
        if isinstance(b.motion, SolidQuadratic)
    ]
    situation = explored(replace(situation, bodies=tuple(bodies)))
    scene, chart = pack(situation), PostureLattice(situation.arm, N, postures)
    plain, patient = (f(scene, chart, EVERYWHERE) for f in (march, march_layers))
    first = np.where(plain.refused, -1.0, plain.first)
    both = (first >= 0.0) & (patient.first >= 0.0)
    assert both.sum() > 500 and np.count_nonzero((first >= 0.0) ^ (patient.first >= 0.0)) <= 2
    later = (patient.first - first)[both]
    assert later.max() < 1e-5 and np.mean(later > -1e-5) > 0.99  # it tries all neighbours at once
    assert len(patient.sheets()[0]) == 1


def test_a_margin_widens_steps():
    situation = explored(SITUATIONS[15])
    scene, chart = pack(situation), PostureLattice(situation.arm, N)
    bare, wide = (march_layers(scene, chart, replace(EVERYWHERE, margin=m)) for m in (0.0, 1.0))
    widened = march_layers(scene, chart, EVERYWHERE, widening=np.ones(chart.size))
    assert wide.steps < bare.steps
    np.testing.assert_array_equal(widened.arrival, wide.arrival)


def behind_a_post(situation):
    """A target at rest that is wrapped in a ball, which leaves it after a while."""
    arm, chart = situation.arm, PostureLattice(situation.arm, N)
    joints = 0.5 * (np.array(arm.joint_range)[:, 0] + np.array(arm.joint_range)[:, 1])
    place = chart.in_world(np.array(limb_at(chart.limb, joints)[3:]))
    away = place - np.array(arm.base.origin)
    leaves = 1.5 * arm.reach * away / np.linalg.norm(away)
    target = Body(
        "target", "goal", Sphere(0.02 * arm.reach), SolidQuadratic(tuple(place), *[STILL] * 2)
    )
    post = Body(
        "obstacle",
        "post",
        Sphere(0.25 * arm.reach),
        SolidQuadratic(tuple(place), STILL, tuple(leaves)),
    )
    return replace(situation, bodies=(target, post), horizon=1.5)


def test_a_wait_meets_what_a_front_that_cannot_wait_does_not():
    situation = behind_a_post(SITUATIONS[0])
    chart = PostureLattice(situation.arm, 24)
    plain, patient = (
        build_map(situation, replace(TO_CONTACT, n=24), chart=chart, wait=wait)
        for wait in (False, True)
    )
    assert plain.interception is None
    assert patient.interception is not None and patient.engine == "layered"
    points, times = descend(patient)
    chain = chain_to(patient, patient.met)
    np.testing.assert_allclose(times, patient.sheets.ravel()[chain].filled(np.nan))
    np.testing.assert_allclose(points, chart.hands[np.array(chain) % chart.size])
    assert (np.diff(times) > 0.0).all() and times[-1] <= patient.interception.time
    step = chart.spacing / fastest(pack(situation))
    assert np.diff(times).max() > 5.0 * step  # it waits


def test_it_ends_with_the_contact_and_leaves_out_what_cannot_meet_a_target():
    situation = SITUATIONS[15]
    scene, chart = pack(situation), PostureLattice(situation.arm, 24)
    some, all_of = (
        march_layers(scene, chart, MarchingParams(n=24, margin=0.0, until=until))
        for until in ("contact", "horizon")
    )
    assert some.met_state >= 0
    assert (some.met_body, some.met_time) == (all_of.met_body, all_of.met_time)
    assert len(some.nodes) < len(all_of.nodes)
    assert some.nodes[some.chain()].tolist() == all_of.nodes[all_of.chain()].tolist()
    late = march_layers(scene, chart, MarchingParams(n=24, margin=0.0), ignore=some.met_time + 0.05)
    assert late.met_state < 0 or late.met_time >= some.met_time + 0.05
