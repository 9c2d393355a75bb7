"""Marching with waits over hand-space in space: nodes and the spans of time in which they are free.

A state is a node and one of its spans (Phillips and Likhachev, ICRA 2011).  Fronts go as in
`wave.posture_marching`, from whose neighbours and steps they are made, and may wait for a span to
begin.  A node's posture and spans are found when the front is first next to it.

A step is checked over all of its time.  Without a free step at the time of a state, the hand waits
beside it and tries again, twice as long each time.  So shorter openings may be missed.
Times are in seconds.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.arms.limbs import dof
from gcm_learn.charts.posture_lattice import hand_of_node, is_there
from gcm_learn.collision.intervals import NEVER, last_use, target_ways
from gcm_learn.collision.postures import move_is_free
from gcm_learn.collision.rests import free_spans
from gcm_learn.compiled import njit
from gcm_learn.motion.joint_interception import target_room
from gcm_learn.scene.bodies import HAND, PART, TOP_SPEED
from gcm_learn.wave.buckets import grown, left_in, put, queue_of, take
from gcm_learn.wave.posture_marching import step
from gcm_learn.wave.posture_steps import BUCKETS, NEIGHBOURS, START, Ask, before, neighbour

SPANS = 8  # of a node that are kept
UNKNOWN = -1  # spans of a node that have not been asked for
USELESS = 255  # instead of their number: no posture, or no target can be met from there any more
ACCEPTED = 255  # tries of a state that the front has reached
MOST_TRIES = 12  # of a state at later times
BUCKET, EMPTY = 0, 1  # of a clock: the bucket whose turn it is, and how many before it were empty
LATEST = 1e-9  # by which a step may come late: rounding [s]


class Table(NamedTuple):
    """Nodes and the numbers of their states."""

    first: np.ndarray  # (nodes,) int32: the first of a node's states, UNKNOWN
    found: np.ndarray  # (nodes,) uint8: how many there are, or USELESS
    refused: np.ndarray  # (nodes,) bool: an obstacle was there when a front came
    ways: np.ndarray  # (instants, targets, 4): where targets are; none if that does not matter


class States(NamedTuple):
    """Nodes in their spans, as they become known, and space for more."""

    span: np.ndarray  # (m, 2): begin and end [s]
    node: np.ndarray  # (m,) int32
    arrival: np.ndarray  # (m,): earliest so far, NEVER [s]
    via: np.ndarray  # (m,) int32: state that the front comes from, -1 for the start
    code: np.ndarray  # (m,) uint8: step by which it comes
    tries: np.ndarray  # (m,) uint8: at later times, or ACCEPTED
    size: np.ndarray  # (1,): how many there are


class Contact(NamedTuple):
    """The first contact."""

    which: np.ndarray  # (2,): state and target, -1 if there is none
    when: np.ndarray  # (1,): horizon if there is none [s]


def new_table(ask: Ask, count: int) -> Table:
    """A table of so many nodes of which nothing is known."""
    return Table(
        np.full(count, UNKNOWN, np.int32),
        np.zeros(count, np.uint8),
        np.zeros(count, np.bool_),
        target_ways(ask.scene.bodies, ask.terms.grasp, ask.terms.end),
    )


@njit
def states_of(room):
    """Make arrays for so many states, of which none is known yet."""
    return States(
        np.empty((room, 2)),
        np.empty(room, np.int32),
        np.empty(room),
        np.empty(room, np.int32),
        np.empty(room, np.uint8),
        np.empty(room, np.uint8),
        np.zeros(1, np.int64),
    )


@njit
def _grown(states):
    """Return the same states in arrays for twice as many."""
    out, m = states_of(2 * states.node.size), states.size[0]
    out.span[:m], out.node[:m], out.arrival[:m] = (
        states.span[:m], states.node[:m], states.arrival[:m]
    )  # fmt: skip
    out.via[:m], out.code[:m], out.tries[:m] = states.via[:m], states.code[:m], states.tries[:m]
    out.size[0] = m
    return out


@njit(_nrt=False)
def look(ask, table, states, node, now):
    """Find the spans in which a node is free from `now` on, if it is of use for a contact."""
    terms, k = ask.terms, states.size[0]
    table.first[node], table.found[node] = k, USELESS
    if not is_there(ask.nodes, node):
        return
    if not terms.explore:
        x, y, z = hand_of_node(ask.nodes, node)
        if now > last_use(table.ways, terms.end, terms.speed, x, y, z):
            return
    for j in range(dof(ask.scene.limb)):
        ask.far[j] = ask.nodes.joints[node, j]
    touch, room = ask.scene.limb.thickness, states.span[k : k + SPANS]
    found = free_spans(ask.scene, ask.far, now, terms.end, touch, terms.shortest, ask.desk, room)
    table.found[node], states.size[0] = found, k + found
    for i in range(k, k + found):
        states.node[i], states.arrival[i], states.tries[i] = node, NEVER, 0
        if states.span[i, 0] > now:  # no step ends where it just touches
            states.span[i, 0] = min(states.span[i, 0] + terms.shortest, states.span[i, 1])


@njit(_nrt=False, forceinline=True)
def _await(s, time, pace, bucket, queue):
    """Let a state wait in the bucket of a time."""
    slot = max(int(time * pace.buckets), bucket)
    put(s, min(slot, bucket + BUCKETS - 1) % BUCKETS, queue)


@njit(_nrt=False)
def offer(ask, table, states, s, bound, bucket, queue):
    """Offer the front of state `s` to its neighbours, until `bound` [s]."""
    nodes, pace, now = ask.nodes, ask.pace, states.arrival[s]
    node, until = states.node[s], states.span[s, 1]
    for code in range(NEIGHBOURS + (2 if nodes.rule.postures > 1 else 0)):
        other = neighbour(nodes, pace, node, code)
        if other < 0 or now + pace.hand[code] > bound:
            continue
        if table.first[other] == UNKNOWN:
            look(ask, table, states, other, now)
        k, count = table.first[other], table.found[other]
        if count == USELESS:
            continue
        soonest, last = now + pace.hand[code], k + count - 1
        if count > 0 and states.arrival[last] <= soonest and states.span[last, 0] <= soonest:
            if states.span[last, 1] >= bound:
                continue  # it has been reached, and earlier spans have ended
        took, _, _ = step(nodes, pace, node, other, code)
        first = now + np.float64(took)
        if first > bound:
            continue
        refused = True
        for i in range(k, k + count):
            time = max(first, states.span[i, 0])
            refused = refused and not states.span[i, 0] <= first <= states.span[i, 1]
            if time > min(states.span[i, 1], until + took) + LATEST or time > bound:
                continue
            if time < states.arrival[i] and states.tries[i] != ACCEPTED:
                states.arrival[i], states.via[i], states.code[i] = time, s, code
                _await(i, time, pace, bucket, queue)
        table.refused[other] |= refused


@njit(_nrt=False)
def _step_is_free(ask, states, home, s, time, code):
    """Return whether the limb is free on the step from state `home` to `s`, ending at `time`."""
    node, other = states.node[home], states.node[s]
    took, moved, _ = step(ask.nodes, ask.pace, node, other, code)
    wide = ask.margin
    if ask.widening.size > 0:
        wide += ask.widening[other]
    touch = ask.scene.limb.thickness + 0.5 * wide * moved
    for j in range(dof(ask.scene.limb)):
        ask.near[j], ask.far[j] = ask.nodes.joints[node, j], ask.nodes.joints[other, j]
    return move_is_free(ask.scene, ask.near, time - took, ask.far, time, touch, ask.desk)


@njit(_nrt=False)
def enter(ask, table, states, s):
    """Return whether state `s` can be entered at its time; else its time is the next try, or NEVER.

    First it is tried from where its front comes, then from wherever else the hand may be by then.
    """
    nodes, pace, node, time = ask.nodes, ask.pace, states.node[s], states.arrival[s]
    home = states.via[s]
    if home < 0 or _step_is_free(ask, states, home, s, time, states.code[s]):
        return True
    later, pause = NEVER, 2.0 ** states.tries[s] / pace.buckets
    for code in range(NEIGHBOURS + (2 if nodes.rule.postures > 1 else 0)):
        other = before(nodes, pace, node, code)
        if other < 0 or table.first[other] == UNKNOWN or table.found[other] == USELESS:
            continue
        took = np.float64(step(nodes, pace, other, node, code)[0])
        for i in range(table.first[other], table.first[other] + table.found[other]):
            if states.tries[i] != ACCEPTED:
                continue
            first, last = states.arrival[i] + took, states.span[i, 1] + took
            if i != home and first <= time <= last + LATEST:
                if _step_is_free(ask, states, i, s, time, code):
                    states.via[s], states.code[s] = i, code
                    return True
            soon = first if first > time else time + pause
            if soon <= min(last, states.span[s, 1]) and soon < later:
                later, states.via[s], states.code[s] = soon, i, code
    states.tries[s] += 1
    states.arrival[s] = later if states.tries[s] <= MOST_TRIES else NEVER
    return False


@njit(_nrt=False)
def meeting(ask, node, since, until):
    """Earliest time in [since, until] at which a target is near a node's hand, and which one."""
    scene, poses, t = ask.scene, ask.desk.poses, since
    x, y, z = hand_of_node(ask.nodes, node)
    while t <= until:
        pause = NEVER
        for b in range(scene.bodies.rows.shape[0]):
            if scene.bodies.rows[b, PART] != HAND:
                continue
            room = target_room(scene, b, x, y, z, t, poses) - ask.terms.grasp
            if room <= 0.0:
                return t, b
            speed = scene.bodies.rows[b, TOP_SPEED]
            pause = min(pause, room / speed if speed > 0.0 else NEVER)
        if t >= until:
            break
        t = min(t + max(pause, ask.terms.shortest), until)
    return NEVER, -1


@njit(_nrt=False)
def _begin(ask, table, states, node, time, queue):
    """Let the front begin in a node at some time, if the limb is free there."""
    if table.first[node] == UNKNOWN:
        look(ask, table, states, node, 0.0)
    if table.found[node] == USELESS:
        return
    blocked = True
    for i in range(table.first[node], table.first[node] + table.found[node]):
        if states.span[i, 0] <= time <= states.span[i, 1]:
            states.arrival[i], states.via[i], states.code[i], blocked = time, -1, START, False
            _await(i, time, ask.pace, 0, queue)
    table.refused[node] |= blocked


@njit(_nrt=False)
def _go_on(ask, table, states, agenda, contact):
    """March until the end; return False if the arrays have to grow first."""
    pace, terms, (queue, clock) = ask.pace, ask.terms, agenda
    while clock[EMPTY] <= BUCKETS:
        bucket = clock[BUCKET]
        bound = terms.end if terms.explore else contact.when[0]
        if bucket > bound * pace.buckets:
            break
        slot = bucket % BUCKETS
        clock[EMPTY] += 1
        while queue.heads[slot] >= 0:
            most = (NEIGHBOURS + 4) * SPANS
            if left_in(queue) < most or states.node.size - states.size[0] < most:
                return False
            clock[EMPTY], s = 0, take(slot, queue)
            time = states.arrival[s]
            bound = terms.end if terms.explore else contact.when[0]
            if states.tries[s] == ACCEPTED or time > bound:
                continue
            if int(time * pace.buckets) > bucket or not enter(ask, table, states, s):
                if states.arrival[s] <= bound:
                    _await(s, states.arrival[s], pace, bucket, queue)
                continue
            states.tries[s] = ACCEPTED
            _touch(ask, states, s, contact)
            bound = terms.end if terms.explore else contact.when[0]
            offer(ask, table, states, s, bound, bucket, queue)
        clock[BUCKET] += 1
    return True


@njit(_nrt=False)
def _touch(ask, states, s, contact):
    """Note the earliest contact in a state if none is known that is earlier."""
    since = max(states.arrival[s], ask.terms.ignore)
    time, body = meeting(ask, states.node[s], since, min(states.span[s, 1], contact.when[0]))
    if body >= 0 and (contact.which[0] < 0 or time < contact.when[0]):
        contact.which[0], contact.which[1], contact.when[0] = s, body, time


@njit
def march_layers(ask, start, table):
    """March over the states.

    Parameters
    ----------
    ask : Ask
    start : tuple of ndarray
        Nodes (k,) that are reached straight from the arm's posture at t = 0, and when (k,) [s].
    table : Table

    Returns
    -------
    contact : Contact
    states : States
        Those that were reached have ACCEPTED instead of the number of tries.
    """
    states, contact = states_of(4096), Contact(np.full(2, -1), np.full(1, ask.terms.end))
    queue, clock = queue_of(4096, BUCKETS), np.zeros(2, np.int64)
    for i in range(start[0].size):
        _begin(ask, table, states, start[0][i], start[1][i], queue)
    while not _go_on(ask, table, states, (queue, clock), contact):
        queue, states = grown(queue), _grown(states)
    return contact, states
