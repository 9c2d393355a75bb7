"""Search for a catch over a lattice of postures and the spans of time in which they are free.

A* over pairs of a node and a free span of it (Phillips and Likhachev, ICRA 2011), so that waiting
pays. The queue holds tries: unchecked moves from a posture that was reached to a node.  A node's
geometry is computed when it is first tried, a move is checked when its turn has come.  The first
try of a node comes straight from where its neighbour came from (lazy Theta*, Nash et al. 2010).

The key of a try is the time of the catch that it may lead to plus the motion that is left until
then. The second term breaks ties: whoever can still meet the target at the last moment is equal in
the first. Nodes that come too late for every goal are left out.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.arms.limbs import dof
from gcm_learn.charts.joint_lattice import neighbour, posture_of
from gcm_learn.collision.rests import free_spans
from gcm_learn.compiled import njit
from gcm_learn.planners.joints.goals import reach
from gcm_learn.planners.joints.moves import (
    NEVER,
    rest_is_free,
    time_of,
    timed_move_is_free,
    turning_time,
)

SPANS = 4  # of a node that are kept
DELAYS = 2  # with which a blocked move is tried again
ARITY = 4  # of the heap
MOMENTS = 200  # of a horizon: a block of a node that is shorter may be missed; waits are asked for
CLOSE = 1e-9  # of a span, by which it is entered late [s]


class Places(NamedTuple):
    """Nodes that were tried."""

    of_node: np.ndarray  # (nodes,) int32: index of a node in the other arrays, -1 if not tried
    tried: np.ndarray  # (nodes,) bool: whether a try of it was queued
    joints: np.ndarray  # (p, dof)
    spans: np.ndarray  # (p, SPANS, 2): in which it is free [s]
    found: np.ndarray  # (p,): how many spans there are
    closed: np.ndarray  # (p, SPANS): the state that reached it, -1 if none has
    size: np.ndarray  # (1,)


class States(NamedTuple):
    """Postures that were reached, each in a span."""

    place: np.ndarray  # (s,)
    via: np.ndarray  # (s,): the state that it was reached from, -1 for the start
    left: np.ndarray  # (s,): when that was left [s]
    time: np.ndarray  # (s,): when it was reached [s]
    until: np.ndarray  # (s,): end of the span [s]
    size: np.ndarray  # (1,)


class Tries(NamedTuple):
    """Moves to nodes that have yet to be checked, and a heap of them."""

    node: np.ndarray  # (t,)
    home: np.ndarray  # (t,): state that the move begins at
    via: np.ndarray  # (t,): state of the neighbour that proposed it
    leave: np.ndarray  # (t,) [s]
    arrive: np.ndarray  # (t,) [s]
    delays: np.ndarray  # (t,)
    key: np.ndarray  # (t,): of entries in the heap [s]
    entry: np.ndarray  # (t,): which tries they are
    size: np.ndarray  # (2,): tries, entries


class Tree(NamedTuple):
    """All that a search has found so far."""

    places: Places
    states: States
    tries: Tries


def new_tree(nodes: int, joints: int, most: int) -> Tree:
    """An empty tree.

    Parameters
    ----------
    nodes : int
        Of the lattice.
    joints : int
        Of the arm.
    most : int
        Tries that are checked before the search gives up.
    """
    queued = 9 * most + 64
    places = Places(
        np.full(nodes, -1, np.int32),
        np.zeros(nodes, np.bool_),
        np.empty((most + 1, joints)),
        np.empty((most + 1, SPANS, 2)),
        np.empty(most + 1, np.int8),
        np.empty((most + 1, SPANS), np.int32),
        np.zeros(1, np.int64),
    )
    place, via = np.empty((2, most + 1), np.int32)
    left, time, until = np.empty((3, most + 1))
    states = States(place, via, left, time, until, np.zeros(1, np.int64))
    node, home, proposer, entry = np.empty((4, queued), np.int32)
    leave, arrive, key = np.empty((3, queued))
    delays, size = np.empty(queued, np.int8), np.zeros(2, np.int64)
    tries = Tries(node, home, proposer, leave, arrive, delays, key, entry, size)
    return Tree(places, states, tries)


@njit(_nrt=False)
def _insert(tries, key, item):
    """Add an entry to the heap."""
    keys, entry, k = tries.key, tries.entry, tries.size[1]
    tries.size[1] = k + 1
    while k > 0:
        above = (k - 1) // ARITY
        if keys[above] <= key:
            break
        keys[k], entry[k] = keys[above], entry[above]
        k = above
    keys[k], entry[k] = key, item


@njit(_nrt=False)
def _remove(tries):
    """Take the entry with the smallest key out of the heap: the key and the try."""
    keys, entry, last = tries.key, tries.entry, tries.size[1] - 1
    tries.size[1] = last
    key, item = keys[0], entry[0]
    moved, what, k = keys[last], entry[last], 0
    while True:
        least, low = -1, moved
        for child in range(ARITY * k + 1, min(ARITY * k + 1 + ARITY, last)):
            if keys[child] < low:
                least, low = child, keys[child]
        if least < 0:
            break
        keys[k], entry[k] = keys[least], entry[least]
        k = least
    keys[k], entry[k] = moved, what
    return key, item


@njit(_nrt=False)
def prospect(study, goals, q, t, bound, weight):
    """The goal that a limb at joints q (dof,) at time t [s] does best to make for.

    Parameters
    ----------
    bound : float
        Goals from then on do not count [s].
    weight : float
        Of the motion that is left, beside the time of the catch.

    Returns
    -------
    goal : int
        -1 if none can be met in time.
    key : float
        [s]
    """
    rate, best, which = study.scene.limits.joint_speed, NEVER, -1
    for k in range(goals.size[0]):
        when = goals.time[k]
        if when < t:
            continue
        if when >= bound or when >= best:
            break
        left = turning_time(rate, q, goals.joints[k])
        if t + left <= when and when + weight * left < best:
            best, which = when + weight * left, k
    return which, best


@njit(_nrt=False)
def spans_at(study, places, k):
    """Find the spans in which the limb may be at place k and a movement can be there."""
    scene, q = study.scene, places.joints[k]
    end, away = scene.limits.horizon, turning_time(scene.limits.joint_speed, scene.limb.start, q)
    since, until = (0.0, end - away) if study.backward else (away, end)
    places.found[k] = 0
    if since <= until:
        places.found[k] = free_spans(
            scene, q, since, until, study.touch, end / MOMENTS, study.desk, places.spans[k]
        )
    for i in range(SPANS):
        places.closed[k, i] = -1


@njit(_nrt=False)
def span_of(places, k, time):
    """Index of the span of place k that holds a time, or of the next one; -1 after the last."""
    for i in range(places.found[k]):
        if time <= places.spans[k, i, 1]:
            return i
    return -1


@njit(_nrt=False)
def _place(study, lattice, places, node):
    """Index of a node among the places; its posture and free spans are found at its first use."""
    k = places.of_node[node]
    if k < 0:
        k = np.int32(places.size[0])
        places.size[0] = k + 1
        places.of_node[node] = k
        posture_of(lattice, node, places.joints[k])
        spans_at(study, places, k)
    return k


@njit(_nrt=False)
def queue(study, lattice, goals, tree, trial, bound, weight):
    """Queue a trial (node, home, via, leave, arrive, delays) if a goal can still be met from it."""
    node, home, via, leave, arrive, delays = trial
    tries, k = tree.tries, tree.tries.size[0]
    if k >= tries.node.size:
        return
    posture_of(lattice, node, study.posture)
    goal, key = prospect(study, goals, study.posture, arrive, bound, weight)
    if goal < 0:
        return
    tries.node[k], tries.home[k], tries.via[k] = node, home, via
    tries.leave[k], tries.arrive[k], tries.delays[k] = leave, arrive, delays
    tries.size[0] = k + 1
    _insert(tries, key, k)


@njit(_nrt=False)
def _settle(study, lattice, goals, tree, item, bound, weight):
    """Look at a try: the state that it reaches, -1 if it reaches none or is put off."""
    places, states, tries = tree.places, tree.states, tree.tries
    node, home, via = tries.node[item], tries.home[item], tries.via[item]
    leave, delays = tries.leave[item], tries.delays[item]
    k = _place(study, lattice, places, node)
    q, p = places.joints[states.place[home]], places.joints[k]
    took, pieces = time_of(study, q, p)
    arrive = max(tries.arrive[item], leave + took)
    span = span_of(places, k, arrive)
    if span < 0:
        return -1
    open_yet = places.closed[k, span] < 0
    if open_yet and arrive < places.spans[k, span, 0]:  # it has yet to become free
        opens = places.spans[k, span, 0] + CLOSE
        if opens - took <= states.until[home]:
            trial = (node, home, via, opens - took, opens, delays)
            queue(study, lattice, goals, tree, trial, bound, weight)
        elif home != via:
            trial = (node, via, via, states.time[via], states.time[via], delays)
            queue(study, lattice, goals, tree, trial, bound, weight)
        return -1
    free = open_yet and rest_is_free(study, q, states.time[home], leave)
    free = free and timed_move_is_free(study, q, leave, p, arrive, pieces)
    if open_yet and not free:
        if home != via:
            since = states.time[via]
            arrive = since + time_of(study, places.joints[states.place[via]], p)[0]
            trial = (node, via, via, since, arrive, delays)
            queue(study, lattice, goals, tree, trial, bound, weight)
        elif delays < DELAYS:
            later = leave + lattice.step * (delays + 1)
            if later <= states.until[home]:
                trial = (node, home, via, later, later + took, delays + 1)
                queue(study, lattice, goals, tree, trial, bound, weight)
    if span + 1 < places.found[k]:  # the next span as well, after a wait at the neighbour
        took = time_of(study, places.joints[states.place[via]], p)[0]
        opens = places.spans[k, span + 1, 0] + CLOSE
        if states.time[via] <= opens - took <= states.until[via]:
            trial = (node, via, via, opens - took, opens, delays)
            queue(study, lattice, goals, tree, trial, bound, weight)
    return note(tree, k, span, home, leave, arrive) if free else -1


@njit(_nrt=False)
def note(tree, place, span, via, left, time):
    """Note a state."""
    states, s = tree.states, tree.states.size[0]
    states.size[0] = s + 1
    states.place[s], states.via[s] = place, via
    states.left[s], states.time[s] = left, time
    states.until[s] = tree.places.spans[place, span, 1]
    tree.places.closed[place, span] = s
    return s


@njit(_nrt=False)
def _expand(study, lattice, goals, tree, state, node, bound, weight):
    """Queue moves from a state to the neighbours of its node."""
    places, states, rate = tree.places, tree.states, study.scene.limits.joint_speed
    for j in range(dof(study.scene.limb)):
        for way in (-1, 1):
            there = neighbour(lattice, node, j, way)
            if there < 0:
                continue
            home, leave, far = state, states.time[state], study.posture
            posture_of(lattice, there, far)
            if not places.tried[there]:
                places.tried[there] = True
                if states.via[state] >= 0:
                    home, leave = states.via[state], states.left[state]
            q = places.joints[states.place[home]]
            arrive, k = leave + turning_time(rate, q, far), places.of_node[there]
            if k >= 0:
                span = span_of(places, k, arrive)
                if span < 0 or places.closed[k, span] >= 0:
                    continue
            trial = (there, home, state, leave, arrive, 0)
            queue(study, lattice, goals, tree, trial, bound, weight)


@njit(_nrt=False)
def plant(study, lattice, goals, tree, bound, weight):
    """Begin a search at the start; returns whether the limb is free there."""
    k = _place(study, lattice, tree.places, lattice.start)
    if tree.places.found[k] == 0 or tree.places.spans[k, 0, 0] > 0.0:
        return False
    state = note(tree, k, 0, -1, 0.0, 0.0)
    tree.places.tried[lattice.start] = True
    _expand(study, lattice, goals, tree, state, lattice.start, bound, weight)
    return True


@njit
def search(study, lattice, goals, tree, most, bound, weight, ends):
    """Go on until a catch is found before `bound` [s], nothing is left or `most` tries were made.

    Parameters
    ----------
    ends : (2,) ndarray
        Gets when the move to the goal begins and ends [s].

    Returns
    -------
    state : int
        From which the move to the goal begins; -1 if there is none.
    goal : int
    left : int
        How many tries may still be made; 0 or less if that is why the search has ended.
    """
    places, states, tries = tree.places, tree.states, tree.tries
    while tries.size[1] > 0 and most > 0 and places.size[0] < places.found.size:
        _, item = _remove(tries)
        most -= 1
        node = tries.node[item]
        state = _settle(study, lattice, goals, tree, item, bound, weight)
        if state < 0:
            continue
        q, time = places.joints[states.place[state]], states.time[state]
        goal, _ = prospect(study, goals, q, time, bound, weight)
        if goal < 0:
            continue
        ends[0], ends[1] = reach(
            study, q, time, states.until[state], goals.joints[goal], goals.time[goal]
        )
        _expand(study, lattice, goals, tree, state, node, bound, weight)
        if ends[0] >= 0.0:
            return state, goal, most
    return -1, -1, most
