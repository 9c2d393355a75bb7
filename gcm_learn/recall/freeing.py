"""Changes that free adapted paths of contact: a path is pushed aside or held back.

A quick check looks for contacts at instants in even steps. A path that touches is changed by a bump
at the first contact, no higher than needed, to one side or another. It may also leave later, slow
down before the contact, or drop its waits. The first change without a contact is taken, else the
one with the least, which is changed again. The exact check follows.
"""

from __future__ import annotations

import numpy as np

import gcm_learn.recall.hand_pushes as hand_pushes
import gcm_learn.recall.joint_pushes as joint_pushes
import gcm_learn.recall.timed_moves as timed_moves
from gcm_learn.compiled import by_type, njit
from gcm_learn.recall.hand_paths import HandQuery
from gcm_learn.recall.joint_moves import JointQuery
from gcm_learn.recall.meeting import copy_path, drop_waits, keep, meet
from gcm_learn.recall.styles import HURRY, PUSHED, SIDES, WIDTHS
from gcm_learn.recall.timed_moves import TimedQuery

_sweep = by_type({HandQuery: hand_pushes.sweep, JointQuery: joint_pushes.sweep})
_room = by_type({HandQuery: hand_pushes.room, JointQuery: joint_pushes.room})


@njit(_nrt=False)
def _quick_check(query, work, count, margin, most):
    """Find contacts of the best path; see `quick_check`."""
    how, cost, first, last, g = _sweep(query, work, count), 0.0, -1, -2, 0
    while g < how.end and (first < 0 or cost <= most):
        g += 1
        clearance = _room(query, work, count, g, how.enough)
        if clearance > how.enough:
            g += int(min((clearance - how.enough) / how.nearer, how.most))
            continue
        cost += how.enough - clearance
        if clearance <= how.touch + margin * how.unit:
            if first < 0:
                first, last = g, g
            elif last == g - 1:
                last = g
    return cost, first, last


@njit
def _again(query, body, style, work, since):
    """Meet the target anew and keep the path; return the instant or -1, and the sample count."""
    t = meet(query, body, style, work, since)
    return t, keep(work, t, body) if t >= 0.0 else 0


quick_check = by_type(
    {HandQuery: _quick_check, JointQuery: _quick_check, TimedQuery: timed_moves.quick_check}
)
"""Find contacts of the best path.

Returns
-------
cost : float
    Sum of what clearance lacks at all instants; partial where it is above `most`.
first, last : int
    Instants of the first contact, -1 if there is none.
"""
again = by_type({HandQuery: _again, JointQuery: _again, TimedQuery: timed_moves.again})
habits = by_type(
    {HandQuery: hand_pushes.habits, JointQuery: joint_pushes.habits, TimedQuery: timed_moves.habits}
)
_touch_of = by_type(
    {
        HandQuery: hand_pushes.touch_of,
        JointQuery: joint_pushes.touch_of,
        TimedQuery: timed_moves.touch_of,
    }
)
_pushed = by_type(
    {
        HandQuery: hand_pushes.pushed,
        JointQuery: joint_pushes.pushed,
        TimedQuery: joint_pushes.pushed,
    }
)
_hold = by_type(
    {HandQuery: hand_pushes.hold, JointQuery: joint_pushes.hold, TimedQuery: joint_pushes.hold}
)
_caught_at = by_type(
    {
        HandQuery: hand_pushes.caught_at,
        JointQuery: joint_pushes.caught_at,
        TimedQuery: joint_pushes.caught_at,
    }
)
_horizon = by_type(
    {
        HandQuery: hand_pushes.horizon,
        JointQuery: joint_pushes.horizon,
        TimedQuery: joint_pushes.horizon,
    }
)


@njit
def free(query, style, work, count, body, rounds):
    """Change the best path in the buffers until a quick check finds no contact.

    Parameters
    ----------
    query : HandQuery, JointQuery or TimedQuery
    style : Style
    work : HandWork or JointWork
    count, body : int
        Samples of the path, and the target at its end.
    rounds : int
        Changes at most, one upon the other.

    Returns
    -------
    count : int
        Samples of the path that is the best now.
    free : bool
        True if there is no contact at a quick check.
    """
    how = habits(query)
    cost, first, last = quick_check(query, work, count, 0.0, np.inf)
    for _ in range(rounds):
        if first < 0:
            return count, True
        copy_path(work.base, work.wanted, work.from_base, work.from_wanted)
        touch, side = _touch_of(query, work, count, first, last), np.zeros(work.base.shape[1])
        since, before, least, found = _caught_at(query, work), cost, cost, -1.0
        for change in range(how.changes):
            copy_path(work.from_base, work.from_wanted, work.base, work.wanted)
            if not _changed(query, style, work, touch, side, change):
                continue
            t, samples = again(query, body, style, work, since if change != PUSHED else 0.0)
            if t < 0.0:
                continue
            count = samples
            cost, first, last = quick_check(query, work, count, how.margin, least)
            if first < 0:
                return count, True
            if cost < least:
                least, found = cost, t
                copy_path(work.base, work.wanted, work.least_base, work.least_wanted)
        stuck = found < 0.0 or least > how.progress * before
        if stuck and not how.lenient:
            return count, False
        if stuck:
            copy_path(work.from_base, work.from_wanted, work.base, work.wanted)
        else:
            copy_path(work.least_base, work.least_wanted, work.base, work.wanted)
        t, samples = again(query, body, style, work, max(found, 0.0))
        if t < 0.0:
            return count, False
        count = samples
        cost, first, last = quick_check(query, work, count, how.margin, np.inf)
        if stuck:
            break
    if how.lenient:
        first = quick_check(query, work, count, 0.0, np.inf)[1]
    return count, first < 0


@njit
def _changed(query, style, work, touch, side, change):
    """Push the path aside, drop its waits, or hold it back; return whether the path is new."""
    if change < PUSHED:
        if change % SIDES == 0:
            side[:] = 0.0
        return _pushed(query, work, touch, WIDTHS[change // SIDES], side)
    if style.tempo != HURRY:
        return False
    if change == PUSHED:
        return drop_waits(work)
    sizes = (habits(query).changes - PUSHED - 1) // 2
    place, size = (change - PUSHED - 1) // sizes, (change - PUSHED - 1) % sizes
    return _held(query, work, touch, place, size)


@njit
def _held(query, work, touch, place, size):
    """Hold the path back before its contact or at its start; True if new and in the horizon."""
    k = touch.knots[place]
    if place == 1 and touch.knots[0] == k:
        return False
    late = touch.times[place] + _hold(query, size) * _horizon(query)
    work.wanted[k] = max(np.float64(work.wanted[k]), late)
    return late <= _horizon(query)
