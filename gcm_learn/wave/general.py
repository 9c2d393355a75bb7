"""Marching over any chart, by steps from node to node: what other charts than hand-spaces use.

It is label setting over nodes and their safe intervals (Phillips and Likhachev, ICRA 2011), in
order of time.  When a node is free is asked when the front first comes next to it.  Marching in the
plane (`wave.marching`, `wave.layered`) means the same and is faster and more exact: its fronts run
straight in every direction, these along the steps of the chart.  Times are in seconds.
"""

from __future__ import annotations

from heapq import heappop, heappush
from typing import NamedTuple

import numpy as np

from gcm_learn.collision.chains import Chains, add_spans, room_of
from gcm_learn.collision.intervals import INSTANTS, NEVER, target_ways
from gcm_learn.compiled import njit
from gcm_learn.handspace import Chart
from gcm_learn.scene import Scene
from gcm_learn.scene.bodies import HAND, PART, TOP_SPEED
from gcm_learn.wave.front import Front, first_arrivals
from gcm_learn.wave.kernels import Terms
from gcm_learn.wave.limits import contact_distance, gaps, terms_of
from gcm_learn.wave.params import MarchingParams

SHORTEST = 0.03  # resolution of safe intervals, in steps of the hand
ROUNDING = 1e-12  # of times [s]
NONE = np.int64(-1)


class Nodes(NamedTuple):
    """The nodes, and what is asked of them."""

    free: Chains  # the limbs at nodes, and the obstacles
    near: Chains  # the hands at nodes, and the targets
    useful: np.ndarray  # (nodes,): until when a target can still be met from there
    wait: bool  # whether the hand may wait for a span to begin
    lookback: float  # share of a step during which a node must have been free
    end: float  # horizon [s]


class Labels(NamedTuple):
    """What the front leaves behind at the nodes."""

    first: np.ndarray  # (nodes,): the first of a node's spans, -1 if they are not known yet
    last: np.ndarray  # (nodes,): the one after its last
    came: np.ndarray  # (nodes,): first arrival or refusal, NEVER if there was none
    refused: np.ndarray  # (nodes,) bool
    met: np.ndarray  # (nodes,) bool


class Book(NamedTuple):
    """Spans in which no obstacle is near a node, as they become known; there is room for more."""

    times: np.ndarray  # (m, 2): begin and end [s]
    node: np.ndarray  # (m,)
    arrival: np.ndarray  # (m,): NEVER if it was not reached
    via: np.ndarray  # (m,): span that it came from, -1 for the start
    size: np.ndarray  # (1,): how many are known


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
    nodes, count = _nodes(scene, chart, params, terms, wait, widening), chart.inside.size
    labels = Labels(
        np.full(count, -1),
        np.full(count, -1),
        np.full(count, NEVER),
        np.zeros(count, dtype=np.bool_),
        np.zeros(count, dtype=np.bool_),
    )
    steps, start = chart.steps(scene.limits), chart.start(scene)
    *met, book = _spread(steps, nodes, terms, start, labels)
    known = int(book.size[0])
    book = Book(*(array[:known] for array in book))
    return (_layers if wait else _first)(scene, chart, book, labels, tuple(met))


def _nodes(
    scene: Scene,
    chart: Chart,
    params: MarchingParams,
    terms: Terms,
    wait: bool,
    widening: np.ndarray | None,
) -> Nodes:
    """What is to be asked of a chart's nodes: when they are free, and when a target is near."""
    bodies, parts, limbs = scene.bodies, scene.bodies.rows[:, PART], chart.limbs
    scratch = np.zeros((len(parts), 12))
    gap = gaps(scene, chart.strides, params.margin, widening)
    free = Chains(bodies, np.flatnonzero(parts != HAND), limbs, gap, scratch, terms.shortest)
    hands = np.repeat(limbs[:, -1:], 2, axis=1)
    gap = np.full(len(limbs), contact_distance(scene, chart, params))
    near = Chains(bodies, np.flatnonzero(parts == HAND), hands, gap, scratch, terms.shortest)
    useful = _useful_until(scene, chart, terms)
    return Nodes(free, near, useful, wait, terms.lookback, scene.limits.horizon)


def _useful_until(scene: Scene, chart: Chart, terms: Terms) -> np.ndarray:
    """Last moment (nodes,) from which a target can still be met before the horizon, never early."""
    end = scene.limits.horizon
    last = np.full(chart.inside.size, -1.0)
    for i, targets in enumerate(target_ways(scene.bodies, terms.grasp, end)):
        late = min(end / INSTANTS * (i + 1), end)
        for way in targets:
            last = np.maximum(last, late - chart.lower_bound(way[:3], way[3], scene.limits))
    return last


@njit(_nrt=False)
def meeting(nodes, node, since, until):
    """Earliest time in [since, until] at which a target is near a node, and which one; or -1."""
    t = since
    while t <= until:
        step = NEVER
        for i in range(nodes.near.which.size):
            b = nodes.near.which[i]
            speed, room = nodes.near.bodies.rows[b, TOP_SPEED], room_of(nodes.near, node, b, t)
            if room <= 0.0:
                return t, b
            step = min(step, room / speed if speed > 0.0 else NEVER)
        if t >= until:
            break
        t = min(t + max(step, nodes.near.shortest), until)
    return NEVER, -1


@njit
def known(nodes, q, labels, book):
    """Ask when node q is free, unless that is known; returns the book, which may have grown."""
    if labels.first[q] >= 0:
        return book
    before = book.size[0]
    total, times = add_spans(nodes.free, q, nodes.end, False, book.times, before)
    labels.first[q], labels.last[q], book.size[0] = before, total, total
    if times.shape[0] > book.node.size:
        more = np.zeros(times.shape[0] - book.node.size, dtype=np.int64)
        node, via = np.concatenate((book.node, more)), np.concatenate((book.via, more))
        arrival = np.concatenate((book.arrival, np.zeros(more.size)))
        book = Book(times, node, arrival, via, book.size)
    for k in range(before, total):
        book.node[k], book.arrival[k], book.via[k] = q, NEVER, -1
    return book


@njit
def entries(nodes, labels, book, q, leave, until, step, heap, home):
    """Queue the spans of node q that can be entered from a neighbour.

    The hand may leave it from `leave` on, until `until`, and takes a `step` [s].  Where an obstacle
    is when it could come first, that is queued as well.  Returns the book.
    """
    book = known(nodes, q, labels, book)
    first, before, blocked = leave + step, nodes.lookback * step, True
    for i in range(labels.first[q], labels.last[q]):
        opens = book.times[i, 0]
        since = opens + before if opens > 0.0 else 0.0  # what was before t = 0 does not matter
        t = max(first, since) if nodes.wait else first
        if since <= t <= min(book.times[i, 1], until + step) + ROUNDING:
            heappush(heap, (t, i, q, home))
            blocked = blocked and t > first
    if blocked:
        heappush(heap, (first, NONE, q, home))
    return book


@njit
def _spread(steps, nodes, terms, start, labels):
    """Fill labels in order of time; returns where (span, -1 if none), when and what is met."""
    book, wait = _new_book(), nodes.wait
    met, body, when = NONE, NONE, terms.end
    heap = [(0.0, NONE, NONE, NONE)]
    heappop(heap)
    for i in range(start[0].size):
        book = entries(nodes, labels, book, start[0][i], 0.0, 0.0, start[1][i], heap, NONE)
    while len(heap) > 0:
        time, span, node, home = heappop(heap)
        if time > (terms.end if terms.explore else when):
            break
        if not wait and labels.came[node] < NEVER:
            continue
        labels.came[node] = min(labels.came[node], time)
        labels.refused[node] |= span < 0
        if span < 0 or book.arrival[span] < NEVER:
            continue
        if not terms.explore and time > nodes.useful[node]:
            continue
        book.arrival[span], book.via[span] = time, home
        until = book.times[span, 1] if wait else time
        soonest, target = meeting(nodes, node, max(time, terms.ignore), until)
        if target >= 0:
            labels.met[node] |= not wait
            if soonest < when or met < 0:
                met, body, when = span, target, soonest
            if not wait:
                continue
        for e in range(steps.first[node], steps.first[node + 1]):
            q, step = steps.to[e], steps.time[e]
            if wait or labels.came[q] == NEVER:
                book = entries(nodes, labels, book, q, time, until, step, heap, span)
    return met, body, when, book


@njit
def _new_book():
    """No span is known yet."""
    room = 1024
    return Book(
        np.empty((room, 2)),
        np.empty(room, dtype=np.int64),
        np.empty(room),
        np.empty(room, dtype=np.int64),
        np.zeros(1, dtype=np.int64),
    )


def _first(
    scene: Scene, chart: Chart, book: Book, labels: Labels, met: tuple[int, int, float]
) -> Front:
    """The front of one sheet."""
    span, body, time = met
    came = labels.came
    via, reached = np.full(came.size, -1), np.flatnonzero(book.arrival < NEVER)
    home = book.via[reached]
    via[book.node[reached]] = np.where(home >= 0, book.node[home], -1)
    return first_arrivals(
        chart,
        np.where(came < NEVER, came, -1.0),
        labels.refused,
        labels.met,
        (int(book.node[span]) if span >= 0 else -1, body, time),
        horizon=scene.limits.horizon,
        steps=len(reached),
        via=via,
    )


def _layers(
    scene: Scene, chart: Chart, book: Book, labels: Labels, met: tuple[int, int, float]
) -> Front:
    """The front of states, in order of arrival."""
    span, body, time = met
    order = np.argsort(book.arrival, kind="stable")
    order = order[: int((book.arrival < NEVER).sum())]
    rank = np.full(len(book.arrival) + 1, -1)  # the last entry is that of "none", -1
    rank[order] = np.arange(len(order))
    node = book.node[order]
    where = labels.met.copy()
    if span >= 0:
        where[node[rank[span]]] = True
    return Front(
        chart=chart,
        waits=True,
        nodes=node,
        via=rank[book.via[order]],
        arrival=book.arrival[order],
        end=book.times[order, 1],
        refused=labels.refused.reshape(chart.shape),
        met=where.reshape(chart.shape),
        met_state=int(rank[span]),
        met_body=body,
        met_time=time,
        steps=len(order),
    )
