"""Straight lines in the joints to where a target can be met."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from gcm_learn.arms.curves import line
from gcm_learn.arms.limbs import hand_of, place, postures_at, reach_of
from gcm_learn.arms.swivels import BRANCHES
from gcm_learn.compiled import njit
from gcm_learn.motion import Failure, Movement, joint_interception
from gcm_learn.planners.completion import Attempt, JointProblem, checked
from gcm_learn.planners.joints.goals import PLACES, place_on
from gcm_learn.planners.joints.moves import Study, rest_is_free, time_of, timed_move_is_free
from gcm_learn.planners.joints.pull import met_from
from gcm_learn.planners.plan import Plan
from gcm_learn.scene.bodies import BALL, HAND, PART

SWIVELS = 12  # of the elbow that are tried for one place of the hand
INSTANTS = 48  # of the horizon at which interceptions are looked for
_HALVINGS = 8  # of an instant, to find the earliest interception
SHORTEST = 1e-9  # a leg that takes less is one piece [s]


class Goals(NamedTuple):
    """Postures that catch, in order of time."""

    time: np.ndarray  # (m,) [s]
    joints: np.ndarray  # (m, dof) [rad]
    body: np.ndarray  # (m,)
    size: np.ndarray  # (1,): how many there are


@njit(_nrt=False)
def _keep(study, goals, b, t, q):
    """Note the joints near q (dof,) that catch body b, if a straight move gets there by t [s]."""
    k = goals.size[0]
    if k == goals.time.size or met_from(study, study.scene.limb.start, 0.0, b, q, t) == 0:
        return
    for j in range(q.size):
        goals.joints[k, j] = study.goal[j]
    goals.time[k], goals.body[k] = t, b
    goals.size[0] = k + 1


@njit(_nrt=False)
def add_straight(study, goals, b, t, swivels):
    """Add postures that catch body b at t [s] and to which there is a straight move in time.

    One is pulled from the start.  The others come from the closed-form inverse for places of the
    target: they are put where the joints can be by then and pulled from there.
    """
    limb = study.scene.limb
    _keep(study, goals, b, t, limb.start)
    for which in range(1 if study.scene.bodies.rows[b, BALL] > 0.0 else PLACES):
        x, y, z, _ = place_on(study, b, t, which)
        for k in range(swivels):
            found = postures_at(
                limb, x, y, z, k + 0.5, swivels, study.low, study.high, study.branches
            )
            for i in range(found):
                _keep(study, goals, b, t, study.branches[i])


@njit
def meet_straight(study, goals, t, swivels):
    """Replace the goals by postures that catch any target at t [s]; see `add_straight`."""
    scene, poses = study.scene, study.desk.poses
    limb, speed = scene.limb, joint_interception.fastest_hand(scene)
    far = reach_of(limb)
    x, y, z = hand_of(limb, place(limb, limb.start))
    goals.size[0] = 0
    for b in range(scene.bodies.rows.shape[0]):
        if scene.bodies.rows[b, PART] != HAND:
            continue
        if joint_interception.target_room(scene, b, x, y, z, t, poses) > study.catch + speed * t:
            continue
        if joint_interception.target_room(scene, b, 0.0, 0.0, 0.0, t, poses) <= study.catch + far:
            add_straight(study, goals, b, t, swivels)


@njit
def hasten_straight(study, goals, before):
    """Make every goal as early as a straight move can, though not before `before` [s]."""
    start = study.scene.limb.start
    for k in range(goals.size[0]):
        low = before
        for _ in range(_HALVINGS):
            t = 0.5 * (low + goals.time[k])
            if met_from(study, start, 0.0, goals.body[k], goals.joints[k], t) > 0:
                goals.time[k] = t
                for j in range(start.size):
                    goals.joints[k, j] = study.goal[j]
            else:
                low = t


@njit
def straight_is_free(study, p, begin, end, until):
    """Return whether a wait, a straight move from start to joints p (dof,), and a wait are free.

    Parameters
    ----------
    begin, end : float
        Of the move [s].
    until : float
        Last instant of the second wait [s].
    """
    start = study.scene.limb.start
    if not rest_is_free(study, start, 0.0, begin) or not rest_is_free(study, p, end, until):
        return False
    _, pieces = time_of(study, start, p)
    return timed_move_is_free(study, start, begin, p, end, pieces)


def at_once(problem: JointProblem) -> Plan | None:
    """The catch of a target that is there at t = 0."""
    scene, poses = problem.scene, np.zeros((len(problem.situation.bodies), 12))
    body = joint_interception.met_at(scene, scene.limb.start, 0.0, problem.rules.catch, poses)
    if body < 0:
        return None
    rates = scene.limb.rates[None].copy() if problem.accelerates else None
    start = scene.limb.start[None].copy()
    rest = Movement(problem.situation.arm, np.zeros(1), start, rates)
    return checked(problem, Attempt(rest, int(body)))[0]


def earliest_straight(problem: JointProblem) -> Plan:
    """Plan a straight move to the earliest interception, to any posture that catches there."""
    plan, study = at_once(problem), problem.study
    if plan is not None:
        return plan
    goals, reason = _earliest(study), None
    for k in np.argsort(goals.time[: goals.size[0]], kind="stable"):
        t = goals.time[k]
        if reason is not None and not straight_is_free(study, goals.joints[k], 0.0, t, t):
            continue  # the first one's reason is enough
        attempt = _attempt(problem, study, goals, k, 0.0, goals.time[k])
        plan, why = checked(problem, attempt)
        if plan is not None:
            return plan
        reason = reason or why
    return problem.answer(reason or Failure.NO_STRAIGHT_LINE)


def soonest_straight(study: Study) -> float:
    """Return when a straight line that nothing hinders meets a target first, or 0 [s]."""
    goals = _earliest(study)
    return float(goals.time[: goals.size[0]].min()) if goals.size[0] else 0.0


def _earliest(study: Study) -> Goals:
    """The goals of the first instant that has some, each as early as can be."""
    goals = _room_for_goals(study)
    _first_goals(study, goals, INSTANTS)
    return goals


@njit
def _first_goals(study, goals, instants):
    """Add the goals of the first of some instants that has any, each as early as can be."""
    horizon = study.scene.limits.horizon
    for k in range(1, instants + 1):
        meet_straight(study, goals, horizon * (k / instants), SWIVELS)
        if goals.size[0] > 0:
            hasten_straight(study, goals, horizon * ((k - 1) / instants))
            return


def any_straight(
    problem: JointProblem, instants: int = INSTANTS, shares: tuple[float, ...] = ()
) -> Plan:
    """Plan by the first straight line that catches, evenly fast or with waits at its ends.

    Parameters
    ----------
    problem : JointProblem
    instants : int
        Of the horizon at which interceptions are tried, in all postures.
    shares : tuple of float
        Shares of the spare time that are spent before leaving; what is left of it after arriving.
        Without them the spare time is spread over the move.
    """
    plan, study = at_once(problem), problem.study
    if plan is not None:
        return plan
    start = problem.scene.limb.start
    for t, goals in _meetings(study, instants):
        for k in range(goals.size[0]):
            p = goals.joints[k]
            took = time_of(study, start, p)[0]
            spans = [(0.0, t), *((s * (t - took), s * (t - took) + took) for s in shares)]
            for begin, end in spans:
                end = min(end, t)
                if straight_is_free(study, p, begin, end, t):
                    attempt = _attempt(problem, study, goals, k, begin, end)
                    plan, _ = checked(problem, attempt)
                    if plan is not None:
                        return plan
    return problem.answer(Failure.NO_STRAIGHT_LINE)


def _meetings(study: Study, instants: int) -> Iterator[tuple[float, Goals]]:
    """Yield instants up to the horizon with the goals at each; the next instant overwrites them."""
    goals = _room_for_goals(study)
    for k in range(1, instants + 1):
        t = study.scene.limits.horizon * (k / instants)
        meet_straight(study, goals, t, SWIVELS)
        yield t, goals


def _room_for_goals(study: Study) -> Goals:
    """Arrays for all goals of an instant."""
    targets = int((study.scene.bodies.rows[:, PART] == HAND).sum())
    most = targets * (1 + PLACES * SWIVELS * BRANCHES)
    return Goals(
        np.empty(most), np.empty((most, study.goal.size)), np.empty(most, int), np.zeros(1, int)
    )


def _attempt(
    problem: JointProblem, study: Study, goals: Goals, k: int, begin: float, end: float
) -> Attempt:
    """The move to goal k from `begin` to `end` [s], with waits at both ends."""
    start, goal = problem.scene.limb.start, goals.joints[k]
    time = np.array([0.0, begin, end, goals.time[k]])
    return attempt_along(problem, study, time, np.stack([start, start, goal, goal]), goals.body[k])


def attempt_along(
    problem: JointProblem, study: Study, time: np.ndarray, joints: np.ndarray, body: int
) -> Attempt:
    """Straight legs between postures, up to the first target within reach.

    A leg takes the time it is given, and goes as evenly as the limit of the hand's speed lets it.

    Parameters
    ----------
    time : (n,) ndarray
        When the postures are reached; legs that take no time are left out [s].
    joints : (n, dof) ndarray
    body : int
        What is caught at the end, if nothing is before.
    """
    times, rows = [time[:1]], [joints[:1]]
    for k in np.flatnonzero(np.diff(time) > 0.0):
        q, p, span = joints[k], joints[k + 1], time[k + 1] - time[k]
        took, pieces = time_of(study, q, p)
        if span < SHORTEST:  # times of pieces would be equal
            pieces = 1
        shares = np.arange(1, pieces + 1) / pieces
        pace = study.pace[:pieces] / took if took > 0.0 else shares
        times += [time[k] + span * pace[:-1], time[k + 1 : k + 2]]
        rows += [q + shares[:-1, None] * (p - q), p[None]]
    return _cut(problem, study, np.concatenate(times), np.concatenate(rows), int(body))


def _cut(
    problem: JointProblem, study: Study, time: np.ndarray, joints: np.ndarray, body: int
) -> Attempt:
    """A timed path (n,), (n, dof), up to the first target within reach."""
    for k in range(len(time) - 1):
        line(joints[k], joints[k + 1], study.desk.curve)
        t, b = joint_interception.first_meeting(
            study.scene,
            study.desk.curve,
            time[k],
            time[k + 1],
            study.catch,
            study.instant,
            study.desk.poses,
        )
        if b >= 0 and t > time[k]:
            share = (t - time[k]) / (time[k + 1] - time[k])
            end = joints[k] + share * (joints[k + 1] - joints[k])
            time, joints, body = (
                np.append(time[: k + 1], t),
                np.vstack([joints[: k + 1], end]),
                int(b),
            )
            break
    return Attempt(Movement(problem.situation.arm, time, joints), body)
