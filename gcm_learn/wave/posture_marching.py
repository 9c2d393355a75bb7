"""Marching over the cells of hand-space in space: first arrivals, in order of time.

A front goes from a cell to its 26 neighbours, and takes its posture along (`pulled_postures`).  A
step takes as long as the hand or the joint that has farthest to turn.  So the speed depends on the
direction, and arrivals are the shortest ways over such steps.  A cell is accepted if the limb is
clear of obstacles on the whole step there.

Cells wait in buckets no wider than the shortest step, so cells of one bucket may come in any order.
Times are in seconds.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.compiled import njit
from gcm_learn.motion.joint_interception import target_room
from gcm_learn.scene.bodies import HAND, PART, REACH, centre_at
from gcm_learn.wave import posture_steps
from gcm_learn.wave.buckets import grown, left_in, put, queue_of, take
from gcm_learn.wave.pulled_postures import judge, offer, pull_here, time_of_step


@njit(_nrt=False)
def retry(ask, field, node, bucket, queue):
    """Queue a node for the next later front of a neighbour, after the last front failed there."""
    late, nodes, pace = field.arrival[node], ask.nodes, ask.pace
    field.arrival[node] = posture_steps.NEVER
    for code in range(posture_steps.NEIGHBOURS):
        other = posture_steps.before(nodes, pace, node, code)
        if other >= 0 and field.state[other] == posture_steps.ACCEPTED:
            time = np.float32(field.arrival[other] + time_of_step(ask, other, node, code))
            if late < time < field.arrival[node]:
                field.arrival[node], field.via[node] = time, code
    if field.arrival[node] < posture_steps.NEVER:
        slot = max(int(field.arrival[node] * pace.buckets), bucket)
        put(node, min(slot, bucket + posture_steps.BUCKETS - 1) % posture_steps.BUCKETS, queue)


@njit(_nrt=False)
def target_at(ask, node, now):
    """Return the target in contact with the hand at a node at time `now` [s]; -1 if none."""
    scene, poses, contact = ask.scene, ask.desk.poses, ask.terms.grasp
    rows = scene.bodies.rows
    if now < ask.terms.ignore:
        return -1
    x, y, z = posture_steps.hand_of_node(ask.nodes, node)
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
    pace, end, state, slot = ask.pace, ask.terms.end, field.state, bucket % posture_steps.BUCKETS
    met, body, when, accepted = -1, -1, end, 0
    while queue.heads[slot] >= 0 and left_in(queue) >= posture_steps.NEIGHBOURS + 4:
        node = take(slot, queue)
        if state[node] != posture_steps.OPEN or field.arrival[node] > end:
            continue
        if not pull_here(ask, field, node):
            retry(ask, field, node, bucket, queue)
            continue
        now = field.arrival[node]
        if now > end:
            continue
        ahead = int(now * pace.buckets)
        if ahead > bucket:  # it was too far ahead for the buckets, or was held up
            put(node, min(ahead, bucket + posture_steps.BUCKETS - 1) % posture_steps.BUCKETS, queue)
            continue
        state[node] = judge(ask, field, node)
        if state[node] == posture_steps.OPEN:
            retry(ask, field, node, bucket, queue)
        if state[node] != posture_steps.ACCEPTED:
            continue
        accepted += 1
        target = target_at(ask, node, now)
        if target >= 0:
            state[node] = posture_steps.MET
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
    start : (k,) ndarray
        Nodes that are reached straight from the arm's posture at t = 0.
    field : NodeArrivals
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
    queue = queue_of(4096, posture_steps.BUCKETS)
    for node in start:
        field.arrival[node], field.via[node] = 0.0, posture_steps.START
        if pull_here(ask, field, node):
            put(node, 0, queue)
    met, body, when, accepted, bucket, empty = -1, -1, terms.end, 0, 0, 0
    while (
        empty <= posture_steps.BUCKETS
        and bucket <= terms.end * pace.buckets
        and (met < 0 or terms.explore)
    ):
        empty += 1
        while queue.heads[bucket % posture_steps.BUCKETS] >= 0:
            if left_in(queue) < posture_steps.NEIGHBOURS + 4:
                queue = grown(queue)
            empty = 0
            node, target, now, count = empty_bucket(ask, field, bucket, queue)
            accepted += count
            if node >= 0 and (met < 0 or now < when):
                met, body, when = node, target, now
        bucket += 1
    return met, body, when, accepted


@njit(_nrt=False)
def finish(ask, field, via):
    """Mark nodes left OPEN as unreached or FROZEN; write the others' sources into via (nodes,)."""
    for node in range(via.size):
        via[node] = -1
        if field.state[node] == posture_steps.OPEN:
            field.arrival[node] = ask.nodes.refused[node]
            if field.arrival[node] >= 0.0:
                field.state[node] = posture_steps.FROZEN
        else:
            via[node] = posture_steps.home_of(ask.nodes, ask.pace, node, field.via[node])
