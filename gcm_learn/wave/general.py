"""Marching over any chart, by steps from node to node: what other charts than the plane's use.

It is label setting over nodes and their safe intervals (Phillips and Likhachev, ICRA 2011), in
order of time.  Marching in the plane (`wave.marching`, `wave.layered`) means the same and is faster
and more exact: its fronts run straight in every direction, these along the steps of the chart.
Times are in seconds.
"""

from __future__ import annotations

from heapq import heappop, heappush
from typing import NamedTuple

import numpy as np

from gcm_learn.collision.chains import Chains, Spans, spans_of
from gcm_learn.collision.intervals import INSTANTS, NEVER, target_ways
from gcm_learn.compiled import njit
from gcm_learn.handspace import Chart
from gcm_learn.scene import Scene
from gcm_learn.scene.bodies import HAND, PART
from gcm_learn.wave.front import Front
from gcm_learn.wave.kernels import Terms
from gcm_learn.wave.limits import contact_distance, gaps, terms_of
from gcm_learn.wave.params import MarchingParams

SHORTEST = 0.03  # resolution of safe intervals, in steps of the hand
ROUNDING = 1e-12  # of times [s]
NONE = np.int64(-1)


class Nodes(NamedTuple):
    """What is known of the nodes before the front sets out."""

    free: Spans  # spans in which no obstacle is near
    near: Spans  # spans in which a target is near the hand
    target: np.ndarray  # (s,): which one, for every span of `near`
    useful: np.ndarray  # (nodes,): until when a target can still be met from there
    wait: bool  # whether the hand may wait for a span to begin
    lookback: float  # share of a step during which a node must have been free


class Labels(NamedTuple):
    """What the front leaves behind."""

    arrival: np.ndarray  # (s,): in every span of `Nodes.free`, NEVER if it was not reached
    via: np.ndarray  # (s,): span that it came from, -1 for the start
    came: np.ndarray  # (nodes,): first arrival or refusal, NEVER if there was none
    refused: np.ndarray  # (nodes,) bool
    met: np.ndarray  # (nodes,) bool


def spread(
    scene: Scene,
    chart: Chart,
    params: MarchingParams,
    wait: bool,
    ignore: float = 0.0,
    widening: np.ndarray | None = None,
) -> Front:
    """March over the nodes of a chart, with waits or without; see `wave.march`."""
    terms = terms_of(scene, chart, params, 1.0, ignore)
    terms = terms._replace(shortest=SHORTEST * chart.spacing / terms.speed)
    nodes = _nodes(scene, chart, params, terms, wait, widening)
    count, spans = chart.inside.size, len(nodes.free.times)
    labels = Labels(
        np.full(spans, NEVER),
        np.full(spans, -1),
        np.full(count, NEVER),
        np.zeros(count, dtype=np.bool_),
        np.zeros(count, dtype=np.bool_),
    )
    steps, start = chart.steps(scene.limits), chart.start(scene)
    met = _spread(steps, nodes, terms, start, labels)
    return (_layers if wait else _first)(scene, chart, nodes, labels, met)


def _nodes(
    scene: Scene,
    chart: Chart,
    params: MarchingParams,
    terms: Terms,
    wait: bool,
    widening: np.ndarray | None,
) -> Nodes:
    """Ask for every node of a chart when it is free, and when a target is near."""
    bodies, end = scene.bodies, scene.limits.horizon
    parts, limbs = bodies.rows[:, PART], chart.limbs
    scratch = np.zeros((len(parts), 12))
    gap = gaps(scene, chart.strides, params.margin, widening)
    obstacles = np.flatnonzero(parts != HAND)
    free = spans_of(Chains(bodies, obstacles, limbs, gap, scratch, terms.shortest), end, False)
    hands = np.repeat(limbs[:, -1:], 2, axis=1)
    gap = np.full(len(limbs), contact_distance(scene, chart, params))
    found = [
        spans_of(Chains(bodies, np.array([b]), hands, gap, scratch, terms.shortest), end, True)
        for b in np.flatnonzero(parts == HAND)
    ]
    node = np.concatenate([np.repeat(np.arange(len(limbs)), np.diff(s.first)) for s in found])
    target = np.repeat(np.flatnonzero(parts == HAND), [len(s.times) for s in found])
    times, order = np.concatenate([s.times for s in found]), np.argsort(node, kind="stable")
    first = np.searchsorted(node[order], np.arange(len(limbs) + 1))
    near = Spans(first, times[order])
    useful = _useful_until(scene, chart, terms)
    return Nodes(free, near, target[order], useful, wait, terms.lookback)


def _useful_until(scene: Scene, chart: Chart, terms: Terms) -> np.ndarray:
    """Last moment (nodes,) from which a target can still be met before the horizon, never early."""
    end = scene.limits.horizon
    last = np.full(chart.inside.size, -1.0)
    for i, targets in enumerate(target_ways(scene.bodies, terms.grasp, end)):
        late = min(end / INSTANTS * (i + 1), end)
        for way in targets:
            last = np.maximum(last, late - chart.lower_bound(way[:3], way[3], scene.limits))
    return last


@njit
def meeting(nodes, node, since, until, when):
    """Earliest time in [since, until] before `when` at which a target is near, and which one."""
    body = -1
    for i in range(nodes.near.first[node], nodes.near.first[node + 1]):
        t = max(since, nodes.near.times[i, 0])
        if t <= min(until, nodes.near.times[i, 1]) and t < when:
            when, body = t, nodes.target[i]
    return when, body


@njit
def entries(nodes, q, leave, until, step, heap, home):
    """Queue the spans of node q that can be entered from a neighbour.

    The hand may leave it from `leave` on, until `until`, and takes a `step` [s].  Where an obstacle
    is when it could come first, that is queued as well.
    """
    first, before, blocked = leave + step, nodes.lookback * step, True
    for i in range(nodes.free.first[q], nodes.free.first[q + 1]):
        opens = nodes.free.times[i, 0]
        since = opens + before if opens > 0.0 else 0.0  # what was before t = 0 does not matter
        t = max(first, since) if nodes.wait else first
        if since <= t <= min(nodes.free.times[i, 1], until + step) + ROUNDING:
            heappush(heap, (t, i, q, home))
            blocked = blocked and t > first
    if blocked:
        heappush(heap, (first, NONE, q, home))


@njit
def _spread(steps, nodes, terms, start, labels):
    """Fill labels in order of time; returns where (span, -1 if none), when and what is met."""
    arrival, free, wait = labels.arrival, nodes.free, nodes.wait
    met, body, when = NONE, NONE, terms.end
    heap = [(0.0, NONE, NONE, NONE)]
    heappop(heap)
    for i in range(start[0].size):
        entries(nodes, start[0][i], 0.0, 0.0, start[1][i], heap, NONE)
    while len(heap) > 0:
        time, span, node, home = heappop(heap)
        if time > (terms.end if terms.explore else when):
            break
        if not wait and labels.came[node] < NEVER:
            continue
        labels.came[node] = min(labels.came[node], time)
        labels.refused[node] |= span < 0
        if span < 0 or arrival[span] < NEVER or (not terms.explore and time > nodes.useful[node]):
            continue
        arrival[span], labels.via[span] = time, home
        until = free.times[span, 1] if wait else time
        soonest, target = meeting(nodes, node, max(time, terms.ignore), until, NEVER)
        if target >= 0:
            labels.met[node] |= not wait
            if soonest < when or met < 0:
                met, body, when = span, target, soonest
            if not wait:
                continue
        for e in range(steps.first[node], steps.first[node + 1]):
            q, step = steps.to[e], steps.time[e]
            entries(nodes, q, time, until, step, heap, span)
    return met, body, when


def _first(
    scene: Scene, chart: Chart, nodes: Nodes, labels: Labels, met: tuple[int, int, float]
) -> Front:
    """The front of one sheet."""
    span, body, time = met
    came, shape = labels.came, chart.shape
    node_of = np.repeat(np.arange(came.size), np.diff(nodes.free.first))
    via, reached = np.full(came.size, -1), np.flatnonzero(labels.arrival < NEVER)
    home = labels.via[reached]
    via[node_of[reached]] = np.where(home >= 0, node_of[home], -1)
    return Front(
        chart=chart,
        waits=False,
        nodes=np.arange(came.size),
        via=via,
        arrival=np.where(came < NEVER, came, -1.0),
        end=np.broadcast_to(scene.limits.horizon, came.shape),
        refused=labels.refused.reshape(shape),
        met=labels.met.reshape(shape),
        met_state=int(node_of[span]) if span >= 0 else -1,
        met_body=body,
        met_time=time,
        steps=int((labels.arrival < NEVER).sum()),
    )


def _layers(
    scene: Scene, chart: Chart, nodes: Nodes, labels: Labels, met: tuple[int, int, float]
) -> Front:
    """The front of states, in order of arrival."""
    span, body, time = met
    order = np.argsort(labels.arrival, kind="stable")
    order = order[: int((labels.arrival < NEVER).sum())]
    rank = np.full(len(labels.arrival) + 1, -1)  # the last entry is that of "none", -1
    rank[order] = np.arange(len(order))
    node = np.repeat(np.arange(chart.inside.size), np.diff(nodes.free.first))[order]
    where = labels.met.copy()
    if span >= 0:
        where[node[rank[span]]] = True
    return Front(
        chart=chart,
        waits=True,
        nodes=node,
        via=rank[labels.via[order]],
        arrival=labels.arrival[order],
        end=nodes.free.times[order, 1],
        refused=labels.refused.reshape(chart.shape),
        met=where.reshape(chart.shape),
        met_state=int(rank[span]),
        met_body=body,
        met_time=time,
        steps=len(order),
    )
