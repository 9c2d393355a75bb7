"""Postures that a front finds on its way.

A cell gets the posture of the cell that the front came from, pulled until the hand is in this cell.
Of all turns of the joints that bring the hand there, the least is taken, in units of the joints'
speeds.  A cell that no front has entered yet has only the step by which a front may come, and its
earliest arrival.  The posture is found when the cell's turn comes; the arrival is then that of the
straight move of the joints, which may be later.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.arms.limbs import dof, hand_of, jacobian, place
from gcm_learn.collision.postures import distance_at, move_is_free
from gcm_learn.compiled import njit
from gcm_learn.wave.buckets import put
from gcm_learn.wave.posture_steps import (
    ACCEPTED,
    BUCKETS,
    NEIGHBOURS,
    NEVER,
    OPEN,
    START,
    hand_of_node,
    home_of,
    neighbour,
)

ROUNDS = 4  # of pulling a hand to a cell
NEAR = 0.05  # distance from the centre of a cell that is near enough [cells]
DAMPING = 1e-4  # share of a hand's way per turn of the joints, against singular postures
LONGEST = 0.5  # turn of a joint in one round [rad or lengths]


@njit(_nrt=False)
def _write_turns(nodes, weights, q, turns):
    """Write the least turn of the joints q (dof,) for a way of the hand into `turns` (dof, 3).

    Least in units of the joints' speeds, whose squares are `weights`; damped.
    """
    limb, slopes = nodes.limb, nodes.slopes
    jacobian(limb, q, slopes)
    a, b, c, d, e, f = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(q.size):
        x, y, z, w = slopes[0, j], slopes[1, j], slopes[2, j], weights[j]
        a, b, c = a + w * x * x, b + w * x * y, c + w * x * z
        d, e, f = d + w * y * y, e + w * y * z, f + w * z * z
    more = DAMPING * (a + d + f) + 1e-30
    a, d, f = a + more, d + more, f + more
    aa, bb, cc = d * f - e * e, c * e - b * f, b * e - c * d
    dd, ee, ff = a * f - c * c, b * c - a * e, a * d - b * b
    det = a * aa + b * bb + c * cc
    for j in range(q.size):
        x, y, z, w = slopes[0, j], slopes[1, j], slopes[2, j], weights[j] / det
        turns[j, 0] = w * (aa * x + bb * y + cc * z)
        turns[j, 1] = w * (bb * x + dd * y + ee * z)
        turns[j, 2] = w * (cc * x + ee * y + ff * z)


@njit(_nrt=False)
def _turn(nodes, q, way):
    """Turn joints q (dof,) to move the hand by `way` (3); hold joints at an end of their range."""
    limb, held, turns = nodes.limb, nodes.held, nodes.turned
    for j in range(q.size):
        held[j] = nodes.weights[j]
    for _ in range(3):
        _write_turns(nodes, held, q, turns)
        most, stopped = 0.0, False
        for j in range(q.size):
            step = turns[j, 0] * way[0] + turns[j, 1] * way[1] + turns[j, 2] * way[2]
            if (q[j] <= limb.low[j] and step < 0.0) or (q[j] >= limb.high[j] and step > 0.0):
                held[j], stopped = 0.0, True
            most = max(most, abs(step))
        if not stopped:
            break
    share = min(1.0, LONGEST / max(most, 1e-30))
    for j in range(q.size):
        step = turns[j, 0] * way[0] + turns[j, 1] * way[1] + turns[j, 2] * way[2]
        q[j] = min(max(q[j] + share * step * (held[j] > 0.0), limb.low[j]), limb.high[j])


@njit(_nrt=False)
def _pull(nodes, node, q):
    """Turn joints q (dof,) until the hand is in cell `node`, near the cell's centre if possible.

    Returns
    -------
    x, y, z : float
        The hand.
    there : bool
        Whether it is in the cell.
    """
    limb, h = nodes.limb, nodes.spacing
    cx, cy, cz = hand_of_node(nodes, node)
    x, y, z = hand_of(limb, place(limb, q))
    for _ in range(ROUNDS):
        u, v, w = cx - x, cy - y, cz - z
        if u * u + v * v + w * w <= NEAR * NEAR * h * h:
            break
        _turn(nodes, q, (u, v, w))
        x, y, z = hand_of(limb, place(limb, q))
    far = max(abs(cx - x), max(abs(cy - y), abs(cz - z)))
    return x, y, z, far <= 0.5 * h * (1.0 + 1e-9)


@njit(_nrt=False)
def _pull_from(nodes, home, node):
    """Pull joints from those of cell `home`, -1 for the start, until the hand is in cell `node`.

    The joints are written into ``nodes.pulled``; returns the values of `_pull`.
    """
    limb, q = nodes.limb, nodes.pulled
    for j in range(dof(limb)):
        q[j] = limb.start[j] if home < 0 else nodes.joints[home, j]
    if home >= 0:
        cx, cy, cz = hand_of_node(nodes, node)
        u, v, w = cx - nodes.hands[home, 0], cy - nodes.hands[home, 1], cz - nodes.hands[home, 2]
        turns = nodes.turns[home]
        for j in range(q.size):
            step = turns[j, 0] * u + turns[j, 1] * v + turns[j, 2] * w
            q[j] = min(max(q[j] + min(max(step, -LONGEST), LONGEST), limb.low[j]), limb.high[j])
    return _pull(nodes, node, q)


@njit(_nrt=False)
def _arrival_by(ask, field, home, q, hand):
    """Return the time [s] at which joints q (dof,) are reached from cell `home`, -1: the start."""
    nodes, limb, most = ask.nodes, ask.nodes.limb, 0.0
    if home < 0:
        for j in range(q.size):
            most = max(most, abs(q[j] - limb.start[j]) * ask.pace.slowness[j])
        return np.float32(most)
    for j in range(q.size):
        most = max(most, abs(q[j] - nodes.joints[home, j]) * ask.pace.slowness[j])
    u, v, w = (
        hand[0] - nodes.hands[home, 0], hand[1] - nodes.hands[home, 1],
        hand[2] - nodes.hands[home, 2],
    )  # fmt: skip
    fast = ask.pace.buckets * nodes.spacing
    return np.float32(field.arrival[home] + max(most, np.sqrt(u * u + v * v + w * w) / fast))


@njit(_nrt=False)
def _keep(nodes, node, code, hand):
    """Give a cell the posture that was just pulled there by a step."""
    for j in range(nodes.pulled.size):
        nodes.joints[node, j] = nodes.pulled[j]
    for i in range(3):
        nodes.hands[node, i] = hand[i]
    nodes.known[node] = code + 1


@njit(_nrt=False)
def pull_here(ask, field, node):
    """Find a cell's posture by the step that leads there; update the cell's arrival.

    The arrival never becomes earlier, so that steps are tried in order of time.

    Returns
    -------
    bool
        Whether there is a posture.
    """
    nodes, code = ask.nodes, field.via[node]
    home = home_of(nodes, ask.pace, node, code)
    if nodes.known[node] != code + 1:
        x, y, z, there = _pull_from(nodes, home, node)
        if not there:
            return False
        _keep(nodes, node, code, (x, y, z))
    hand = nodes.hands[node, 0], nodes.hands[node, 1], nodes.hands[node, 2]
    time = _arrival_by(ask, field, home, nodes.joints[node], hand)
    field.arrival[node] = max(time, field.arrival[node])
    return True


@njit(_nrt=False)
def _comes_earlier(ask, field, home, node, code):
    """Replace a cell's posture if a step leads to the cell earlier; return whether it does."""
    nodes = ask.nodes
    x, y, z, there = _pull_from(nodes, home, node)
    if not there:
        return False
    time = _arrival_by(ask, field, home, nodes.pulled, (x, y, z))
    if time >= field.arrival[node]:
        return False
    _keep(nodes, node, code, (x, y, z))
    field.via[node], field.arrival[node] = code, time
    return True


@njit(_nrt=False)
def time_of_step(ask, node, other, code):
    """Estimate the time [s] of a step from `node` to `other`, by the derivative of the posture."""
    nodes, pace = ask.nodes, ask.pace
    cx, cy, cz = hand_of_node(nodes, other)
    u, v, w = cx - nodes.hands[node, 0], cy - nodes.hands[node, 1], cz - nodes.hands[node, 2]
    turns, most = nodes.turns[node], 0.0
    for j in range(turns.shape[0]):
        step = turns[j, 0] * u + turns[j, 1] * v + turns[j, 2] * w
        most = max(most, abs(step) * pace.slowness[j])
    return np.float32(max(most, np.sqrt(u * u + v * v + w * w) / (pace.buckets * nodes.spacing)))


@njit(_nrt=False)
def offer(ask, field, node, bucket, queue):
    """Offer the front of an accepted cell to its neighbours.

    A neighbour that waits with a posture of its own gives it up only for an earlier arrival.
    """
    nodes, pace, now, arrival = ask.nodes, ask.pace, field.arrival[node], field.arrival
    place(nodes.limb, nodes.joints[node])
    _write_turns(nodes, nodes.weights, nodes.joints[node], nodes.turns[node])
    for code in range(NEIGHBOURS):
        other = neighbour(nodes, pace, node, code)
        if other < 0 or field.state[other] != OPEN:
            continue
        old, time = arrival[other], now + time_of_step(ask, node, other, code)
        if time >= old:
            continue
        if nodes.known[other] == field.via[other] + 1 and old < NEVER:
            if not _comes_earlier(ask, field, node, other, code):
                continue
        else:
            arrival[other], field.via[other] = time, code
        slot = int(arrival[other] * pace.buckets)
        if old == NEVER or slot != int(old * pace.buckets):
            put(other, min(max(slot, bucket), bucket + BUCKETS - 1) % BUCKETS, queue)


@njit(_nrt=False)
def judge(ask, field, node):
    """Return the new state of a cell to which the front has come: ACCEPTED, or OPEN.

    A cell in which a front froze stays open for those that come later from other cells, in other
    postures.
    """
    nodes, scene, now, code = ask.nodes, ask.scene, field.arrival[node], field.via[node]
    home, limb, since = home_of(nodes, ask.pace, node, code), nodes.limb, np.float32(0.0)
    if home >= 0:
        since = field.arrival[home]
    for j in range(dof(limb)):
        ask.near[j] = limb.start[j] if home < 0 else nodes.joints[home, j]
        ask.far[j] = nodes.joints[node, j]
    wide = ask.margin
    if ask.widening.size > 0:
        wide += ask.widening[node]
    touch = scene.limb.thickness
    if code != START:
        touch += 0.5 * wide * ask.pace.hops[code]
    if move_is_free(scene, ask.near, since, ask.far, now, touch, ask.desk):
        return ACCEPTED
    if nodes.refused[node] < 0.0 and distance_at(scene, ask.far, now, ask.desk) <= touch:
        nodes.refused[node] = now
    return OPEN
