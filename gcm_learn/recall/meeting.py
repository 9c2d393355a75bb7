"""Adapted paths meet targets: the earliest instant, by conservative advancement.

A hand path and a joint movement differ in how they are loaded, moved and timed. Their kernels are
entries of tables here; everything above calls them by the type of the query.
"""

from __future__ import annotations

import gcm_learn.recall.hand_paths as hand_paths
import gcm_learn.recall.joint_moves as joint_moves
from gcm_learn.compiled import by_type, njit
from gcm_learn.recall.hand_paths import HandQuery, HandWork
from gcm_learn.recall.joint_moves import JointQuery, JointWork
from gcm_learn.recall.styles import HURRY, POLAR
from gcm_learn.scene.bodies import HAND, PART

SHORTER = (0.6, 0.3)  # shares of its detours that a late path keeps
LONGEST = 60.0  # times the lateness that a step may be long

load = by_type({HandQuery: hand_paths.load, JointQuery: joint_moves.load})
chase = by_type({HandQuery: hand_paths.chase, JointQuery: joint_moves.chase})
away = by_type({HandQuery: hand_paths.away, JointQuery: joint_moves.away})
lateness = by_type({HandQuery: hand_paths.lateness, JointQuery: joint_moves.lateness})
keep = by_type({HandWork: hand_paths.keep, JointWork: joint_moves.keep})
cut = by_type({HandQuery: hand_paths.cut, JointQuery: joint_moves.cut})
bodies_of = by_type({HandQuery: hand_paths.bodies_of, JointQuery: joint_moves.bodies_of})


@njit
def meet(query, b, style, work, since):
    """Adapt and time the path so that it meets target b as early as possible.

    The earliest instant is the best. A hand that comes late by some time needs at least the part
    of it in which hand and target can close the gap. Most steps compare lengths alone.

    Parameters
    ----------
    query : HandQuery or JointQuery
    b : int
    style : Style
    work : HandWork or JointWork
        The path's last knot is where the hand catches.
    since : float
        Joint movements end no earlier [s].

    Returns
    -------
    float
        Instant [s], -1 if there is none.
    """
    how = chase(query, b, since)
    t, rough, before, late_before = how.since, True, -1.0, 0.0
    for _ in range(how.most):
        if t > how.horizon:
            return -1.0
        wait = away(query, b, t, how.speed, work)
        if wait > how.close:
            t, before = t + wait, -1.0
            continue
        late, rough, found = lateness(query, b, t, rough, how.close, style, work)
        if not found:
            t, before = t + how.stride, -1.0
            continue
        if late <= 0.0:
            return t
        step = late * how.closing
        if before >= 0.0 and late < late_before:  # the secant, where hand gains on target
            step = max(step, late * min((t - before) / (late_before - late), LONGEST))
        before, late_before = t, late
        t += max(step, how.instant)
    return -1.0


@njit
def meet_any(query, style, work):
    """Adapt the path to the target that can be caught first, and keep the path as the best.

    Returns
    -------
    count : int
        Samples until a target is within reach, 0 if no target can be met in time.
    body : int
    """
    best, body, rows = -1.0, -1, bodies_of(query).rows
    for b in range(rows.shape[0]):
        if rows[b, PART] == HAND:
            t = meet(query, b, style, work, 0.0)
            if t >= 0.0 and (best < 0.0 or t < best):
                best, body = t, b
                keep(work, t, b)
    if best < 0.0:
        return 0, -1
    return cut(query, work, body)


@njit
def adapt_to_targets(paths, m, query, style, work):
    """Adapt memory m to the target that can be caught first; return as `meet_any` does.

    Parameters
    ----------
    paths : (ndarray, ndarray)
        Knots and goals of all memories, float32.
    m : int
    query : HandQuery or JointQuery
    style : Style
    work : HandWork or JointWork
    """
    load(query, paths, m, style, work)
    return meet_any(query, style, work)


@njit
def hasten(query, style, work):
    """Change a path that is late for all targets: drop waits, then shorten detours.

    Returns what `meet_any` does.
    """
    if style.space != POLAR or style.tempo != HURRY:
        return 0, -1
    if drop_waits(work):
        count, body = meet_any(query, style, work)
        if count > 0:
            return count, body
    copy_path(work.base, work.wanted, work.from_base, work.from_wanted)
    base, last = work.from_base, work.share.size - 1
    for part in SHORTER:
        for k in range(1, last):
            for i in range(base.shape[1]):
                straight = base[0, i] + work.share[k] * (base[last, i] - base[0, i])
                work.base[k, i] = straight + part * (base[k, i] - straight)
        count, body = meet_any(query, style, work)
        if count > 0:
            return count, body
    return 0, -1


@njit(_nrt=False)
def drop_waits(work):
    """Drop the waits of a path; return whether there were any."""
    changed = False
    for k in range(work.wanted.size):
        changed = changed or work.wanted[k] > 0.0
        work.wanted[k] = 0.0
    return changed


@njit(_nrt=False)
def copy_path(base, wanted, to_base, to_wanted):
    """Copy the base and the earliest times of a path."""
    for k in range(wanted.size):
        to_wanted[k] = wanted[k]
        for i in range(base.shape[1]):
            to_base[k, i] = base[k, i]
