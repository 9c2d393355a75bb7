"""Marching over the cells and postures of hand-space in space: first arrivals, in order of time.

A front goes from a cell to its 26 neighbours in the same posture, and to the two postures beside it
in the same cell.  A step takes as long as the hand or the joint that has farthest to turn.  So the
speed depends on the direction, and arrivals are the shortest ways over such steps.  A node is
accepted if the limb is clear of obstacles at that moment, and was on the whole step there.  If it
is touched then, the node is frozen.

A limb is not checked where it surely stays clear: by the clearance at the node before, less the
motion of limb and obstacles since.  Nodes wait in buckets no wider than the shortest step, so nodes
of one bucket may come in any order.  Times are in seconds.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.arms.limbs import dof
from gcm_learn.charts.posture_lattice import THERE, hand_of_node, is_there
from gcm_learn.collision.postures import distance_at, move_is_free
from gcm_learn.compiled import by_type, njit
from gcm_learn.motion.joint_interception import target_room
from gcm_learn.scene.bodies import HAND, PART, REACH, TOP_SPEED, centre_at
from gcm_learn.wave.buckets import grown, left_in, put, queue_of, take
from gcm_learn.wave.posture_steps import (
    ACCEPTED,
    BUCKETS,
    FROZEN,
    LOST,
    MET,
    NEIGHBOURS,
    NEVER,
    OPEN,
    RING,
    START,
    PulledAsk,
    before,
    home_of,
    neighbour,
)
from gcm_learn.wave.pulled_postures import (
    judge_pulled,
    offer_pulled,
    pull_here,
    refused_pulled,
    time_pulled,
)


@njit(_nrt=False)
def step(nodes, pace, node, other, code):
    """Time of a step between two nodes, or NEVER, and bounds of the limb's way.

    Returns
    -------
    time : float32
        [s]
    moved : float
        Bound of the way of all points of the limb.
    bent : float
        Bound of their distance from a straight way.  It follows from the acceleration, which is at
        most the sum of the joints' rates squared times the reach.
    """
    q = nodes.joints
    a, b = abs(q[other, 0] - q[node, 0]), abs(q[other, 1] - q[node, 1])
    c, d = abs(q[other, 2] - q[node, 2]), abs(q[other, 3] - q[node, 3])
    s = pace.slowness
    if max(max(a, b), max(c, d)) > (np.float32(nodes.leap) if code < RING else pace.leap):
        return NEVER, 0.0, 0.0
    time = max(max(a * s[0], b * s[1]), max(c * s[2], d * s[3]))
    limb, turn = nodes.rule.limb, a + b + c + d
    bent = 0.125 * (limb.rho + limb.length) * turn * turn
    moved = max(pace.hops[code], limb.rho * np.sqrt(a * a + b * b))
    return max(time, pace.hand[code]), moved, bent


@njit(_nrt=False)
def _offer_known(ask, field, node, bucket, queue):
    """Offer the front of an accepted node to its neighbours.

    It spells out `step`, because nearly all of the time that marching takes is spent here.
    Nodes without a posture get an arrival that none is earlier than, and are passed over.
    """
    nodes, pace, arrival = ask.nodes, ask.pace, field.arrival
    q, known, s, hand = nodes.joints, nodes.known, pace.slowness, pace.hand
    now, K, n, leap = arrival[node], nodes.rule.postures, nodes.n, np.float32(nodes.leap)
    q0, q1, q2, q3 = q[node, 0], q[node, 1], q[node, 2], q[node, 3]
    row = node // K // n
    z = row // n
    x, y = node // K - row * n, row - z * n
    inner = 0 < x < n - 1 and 0 < y < n - 1 and 0 < z < n - 1
    for code in range(NEIGHBOURS + (2 if K > 1 else 0)):
        if inner and code < RING:
            other = node + pace.ahead[code]
        else:
            other = neighbour(nodes, pace, node, code)
            if other < 0:
                continue
            if code >= RING:
                leap = pace.leap
        old = arrival[other]
        if now + hand[code] >= old:
            continue
        if known[other] != THERE and not is_there(nodes, other):
            arrival[other] = LOST
            continue
        a, b = abs(q[other, 0] - q0), abs(q[other, 1] - q1)
        c, d = abs(q[other, 2] - q2), abs(q[other, 3] - q3)
        if max(max(a, b), max(c, d)) > leap:
            continue
        took = max(max(a * s[0], b * s[1]), max(c * s[2], d * s[3]))
        time = now + max(took, hand[code])
        if time < old:
            slot = int(time * pace.buckets)
            arrival[other], field.via[other] = time, code
            if old == NEVER or slot != int(old * pace.buckets):
                put(other, min(max(slot, bucket), bucket + BUCKETS - 1) % BUCKETS, queue)


@njit(_nrt=False, forceinline=True)
def _time_known(ask, node, other, code):
    return step(ask.nodes, ask.pace, node, other, code)[0]


time_of_step = by_type({None: _time_known, PulledAsk: time_pulled})
"""Least time of a step from a node to another, or NEVER [s]."""
offer = by_type({None: _offer_known, PulledAsk: offer_pulled})
"""Offer the front of an accepted node to its neighbours."""


@njit(_nrt=False)
def retry(ask, field, node, bucket, queue):
    """Wait for the next front that may come to a node, the last one having been held up."""
    late, nodes, pace = field.arrival[node], ask.nodes, ask.pace
    field.arrival[node] = NEVER
    for code in range(NEIGHBOURS + (2 if nodes.rule.postures > 1 else 0)):
        other = before(nodes, pace, node, code)
        if other >= 0 and field.state[other] == ACCEPTED:
            time = np.float32(field.arrival[other] + time_of_step(ask, other, node, code))
            if late < time < field.arrival[node]:
                field.arrival[node], field.via[node] = time, code
    if field.arrival[node] < NEVER:
        slot = max(int(field.arrival[node] * pace.buckets), bucket)
        put(node, min(slot, bucket + BUCKETS - 1) % BUCKETS, queue)


@njit(_nrt=False, forceinline=True)
def least_between(before, after, ways):
    """Distance that is kept at least between two ends that are at most `ways` from each other."""
    return 0.5 * (max(before, after - ways) + after - ways)


@njit(_nrt=False)
def _judge_known(ask, field, node):
    """Return the new state of a node to which the front has come: ACCEPTED, FROZEN, or OPEN.

    It stays open if the limb was touched on the step there only.
    """
    nodes, scene, now = ask.nodes, ask.scene, field.arrival[node]
    home = home_of(nodes, ask.pace, node, field.via[node])
    touch, moved, bent, room = scene.limb.thickness, 0.0, 0.0, -1.0
    if home >= 0:
        _, moved, bent = step(nodes, ask.pace, home, node, field.via[node])
        ways = moved + ask.quick * (now - field.arrival[home])
        room = field.room[home] - ways
    wide = ask.margin
    if ask.widening.size > 0:
        wide += ask.widening[node]
    touch += 0.5 * wide * moved
    if room - bent <= touch:
        for j in range(dof(scene.limb)):
            ask.far[j] = nodes.joints[node, j]
        room = distance_at(scene, ask.far, now, ask.desk)
        if room <= touch:
            return FROZEN
        if home >= 0 and least_between(field.room[home], room, ways) - bent <= touch:
            since = field.arrival[home]
            for j in range(dof(scene.limb)):
                ask.near[j] = nodes.joints[home, j]
            field.room[home] = distance_at(scene, ask.near, since, ask.desk)
            if least_between(field.room[home], room, ways) - bent <= touch:
                if not move_is_free(scene, ask.near, since, ask.far, now, touch, ask.desk):
                    return OPEN
    field.room[node] = room
    return ACCEPTED


@njit(_nrt=False, forceinline=True)
def _sets_out_known(ask, field, node):
    return is_there(ask.nodes, node)


@njit(_nrt=False, forceinline=True)
def _comes_known(ask, field, node):
    return True


sets_out = by_type({None: _sets_out_known, PulledAsk: pull_here})
"""Return whether a node next to the start has a posture."""
comes = by_type({None: _comes_known, PulledAsk: pull_here})
"""Return whether a node that waits has a posture; a chain's is found now, and its arrival."""
judge = by_type({None: _judge_known, PulledAsk: judge_pulled})
"""Return the new state of a node to which the front has come: ACCEPTED, FROZEN, or OPEN.

It stays open if the limb was touched on the step there only.
"""


@njit(_nrt=False)
def target_at(ask, node, now):
    """Target in contact with the hand at a node at some time, -1 without one."""
    scene, poses, contact = ask.scene, ask.desk.poses, ask.terms.grasp
    rows = scene.bodies.rows
    if now < ask.terms.ignore:
        return -1
    x, y, z = hand_of_node(ask.nodes, node)
    for b in range(rows.shape[0]):
        if rows[b, PART] != HAND:
            continue
        centre_at(scene.bodies, b, now, poses)
        dx, dy, dz = x - poses[b, 0], y - poses[b, 1], z - poses[b, 2]
        near = rows[b, REACH] + contact
        if dx * dx + dy * dy + dz * dz <= near * near:
            if target_room(scene, b, x, y, z, now, poses) <= contact:
                return b
    return -1


@njit(_nrt=False)
def fastest_obstacle(scene):
    """Top speed of any point of an obstacle [lengths/s]."""
    fastest, rows = 0.0, scene.bodies.rows
    for b in range(rows.shape[0]):
        if rows[b, PART] != HAND:
            fastest = max(fastest, rows[b, TOP_SPEED])
    return fastest


@njit(_nrt=False)
def empty_bucket(ask, field, bucket, queue):
    """Judge the nodes of a bucket until it is empty, or the queue has to grow.

    Returns
    -------
    node, body : int
        First contact among them, -1 if none.
    time : float
        When [s].
    accepted : int
    """
    pace, end, state, slot = ask.pace, ask.terms.end, field.state, bucket % BUCKETS
    met, body, when, accepted = -1, -1, end, 0
    while queue.heads[slot] >= 0 and left_in(queue) >= NEIGHBOURS + 4:
        node = take(slot, queue)
        if state[node] != OPEN or field.arrival[node] > end:
            continue
        if not comes(ask, field, node):
            retry(ask, field, node, bucket, queue)
            continue
        now = field.arrival[node]
        if now > end:
            continue
        ahead = int(now * pace.buckets)
        if ahead > bucket:  # it was too far ahead for the buckets, or was held up
            put(node, min(ahead, bucket + BUCKETS - 1) % BUCKETS, queue)
            continue
        state[node] = judge(ask, field, node)
        if state[node] == OPEN:
            retry(ask, field, node, bucket, queue)
        if state[node] != ACCEPTED:
            continue
        accepted += 1
        target = target_at(ask, node, now)
        if target >= 0:
            state[node] = MET
            if met < 0 or now < when:
                met, body, when = node, target, float(now)
        else:
            offer(ask, field, node, bucket, queue)
    return met, body, when, accepted


@njit
def march(ask, start, field):
    """March over the nodes.

    Parameters
    ----------
    ask : Ask
    start : tuple of ndarray
        Nodes (k,) that are reached straight from the arm's posture at t = 0, and when (k,) [s].
    field : Field
        Its arrivals are NEVER where the front never came.

    Returns
    -------
    node, body : int
        First contact, -1 if none.
    time : float
        When [s].
    accepted : int
    """
    pace, terms = ask.pace, ask.terms
    queue = queue_of(4096, BUCKETS)
    for i in range(start[0].size):
        field.arrival[start[0][i]], field.via[start[0][i]] = start[1][i], START
        slot = min(int(start[1][i] * pace.buckets), BUCKETS - 1)
        if sets_out(ask, field, start[0][i]):
            put(start[0][i], slot, queue)
    met, body, when, accepted, bucket, empty = -1, -1, terms.end, 0, 0, 0
    while empty <= BUCKETS and bucket <= terms.end * pace.buckets and (met < 0 or terms.explore):
        empty += 1
        while queue.heads[bucket % BUCKETS] >= 0:
            if left_in(queue) < NEIGHBOURS + 4:
                queue = grown(queue)
            empty = 0
            node, target, now, count = empty_bucket(ask, field, bucket, queue)
            accepted += count
            if node >= 0 and (met < 0 or now < when):
                met, body, when = node, target, now
        bucket += 1
    return met, body, when, accepted


@njit(_nrt=False, forceinline=True)
def _refused_known(ask, node):
    return LOST


refused = by_type({None: _refused_known, PulledAsk: refused_pulled})
"""Return when the first front froze in a node that is open [s], negative if none did."""


@njit(_nrt=False)
def finish(ask, field, via):
    """Mark nodes where the front never came, and write where it came from into via (nodes,)."""
    for node in range(via.size):
        via[node] = -1
        if field.state[node] == OPEN:
            field.arrival[node] = refused(ask, node)
            if field.arrival[node] >= 0.0:
                field.state[node] = FROZEN
        else:
            via[node] = home_of(ask.nodes, ask.pace, node, field.via[node])
