"""Catches under limits of acceleration.

A straight dash to a posture that catches comes first.  If every dash is blocked, a way is planned
for slower joints that ignore these limits.  It is tracked as nearly as the limits allow: the slower
the joints, the nearer.  Either is verified like everything else.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from gcm_learn.arms import SpatialArm
from gcm_learn.arms.curves import hermite
from gcm_learn.arms.limbs import dof
from gcm_learn.collision.postures import least_on
from gcm_learn.compiled import njit
from gcm_learn.motion import Failure, Movement, Reason
from gcm_learn.motion.acceleration import dash, tracked
from gcm_learn.motion.joint_verification import NOTHING, piece_fault
from gcm_learn.planners.completion import Attempt, SpatialProblem, checked
from gcm_learn.planners.joints.goals import CENTRE, Goals, add_goals
from gcm_learn.planners.plan import Plan
from gcm_learn.scene.bodies import HAND as TARGET, PART
from gcm_learn.situation import Situation

PACES = (
    (1.0, 1.0),
    (0.9, 0.9),
    (0.85, 0.72),
    (0.75, 0.64),
    (0.65, 0.55),
    (0.55, 0.47),
    (0.45, 0.38),
    (0.35, 0.3),
    (0.25, 0.21),
)
"""Shares of the speeds, of the joints and of the hand, that a way is planned with in turn."""
MISSES = 2
"""Of these for which there is no way, before the slower ones are left out."""
ROOM = 0.05
"""Clearance of such a way where it can have it, since it is not tracked exactly [forearms]."""
TURNS = 0.03
"""And to the ends of the joints' ranges [rad]."""
HURRIES = (1.0, 0.7, 0.45)
"""Shares of the time until a catch that are spent on a dash, after a rest."""


class Dash(NamedTuple):
    """Buffers for the samples of a dash."""

    joints: np.ndarray  # (3, dof) [rad]
    rates: np.ndarray  # (3, dof) [rad/s]
    time: np.ndarray  # (3,) [s]


def plan_accelerated(
    problem: SpatialProblem,
    tried: tuple[Goals, np.ndarray],
    swivels: int,
    unlimited: Callable[[Situation[SpatialArm]], Plan],
) -> Plan:
    """Plan a catch that keeps the arm's limits of acceleration.

    Parameters
    ----------
    problem : SpatialProblem
    tried : (Goals, (n,) ndarray)
        Room for postures that catch, and when interceptions are tried, increasing [s].
    swivels : int
        How many postures are tried at each.
    unlimited : callable
        Plans for an arm without such limits.
    """
    reason: Reason | None = None
    for attempt in _attempts(problem, tried, swivels, unlimited):
        plan, reason = checked(problem, attempt)
        if plan is not None:
            return plan
    if problem.over:
        return problem.answer(Failure.OUT_OF_TIME)
    return problem.answer(reason or Failure.NO_INTERCEPTION)


def _attempts(
    problem: SpatialProblem,
    tried: tuple[Goals, np.ndarray],
    swivels: int,
    unlimited: Callable[[Situation[SpatialArm]], Plan],
) -> Iterator[Attempt]:
    arm, scene = problem.situation.arm, problem.scene
    study = problem.study
    joints, rates = np.zeros((2, 3, len(arm.joints)))
    found = Dash(joints, rates, np.zeros(3))
    body = first_dash(study, *tried, swivels, np.array(HURRIES), found)
    if body >= 0:
        yield Attempt(_samples(arm, found), int(body))
    names = [body.name for body in problem.situation.bodies]
    room = min(ROOM * scene.limb.length, 0.5 * problem.start_clearance)
    misses = 0
    for pace in PACES:
        for kept in (0.0, room):
            if problem.over:
                return
            plan = unlimited(replace(problem.situation, arm=_eased(arm, pace, kept)))
            path = plan.trajectory
            if path is None or path.time.size == 1:
                break
            curve = tracked(
                path.time, path.joints, scene.limb.rates, scene.limits.joint_acceleration
            )
            yield Attempt(Movement(arm, *curve), names.index(str(plan.catch_body)))
        misses += path is None and kept == 0.0
        if misses == MISSES:
            return


def _samples(arm: SpatialArm, found: Dash) -> Movement:
    """A dash, without samples that another one has the time of."""
    keep = np.concatenate([[True], np.diff(found.time) > 0.0])
    return Movement(arm, found.time[keep], found.joints[keep], found.rates[keep])


def _eased(arm: SpatialArm, pace: tuple[float, float], room: float) -> SpatialArm:
    """The arm with a share of its speeds, thicker, and without limits of acceleration."""
    first, second, third, fourth = (pace[0] * speed for speed in arm.max_joint_speed)
    ranges = tuple(
        (min(low + TURNS, angle), max(high - TURNS, angle))
        for angle, (low, high) in zip(arm.joints, arm.joint_range, strict=True)
    )
    return replace(
        arm,
        thickness=arm.thickness + room,
        joint_range=ranges,
        max_joint_speed=(first, second, third, fourth),
        max_hand_speed=None if arm.max_hand_speed is None else pace[1] * arm.max_hand_speed,
        max_joint_acceleration=None,
        joint_rates=None,
    )


@njit
def first_dash(study, goals, times, swivels, hurries, found):
    """First free dash to a posture that catches, by goals that are added on the way.

    Parameters
    ----------
    times : (n,) ndarray
        When interceptions are tried, increasing [s].
    hurries : (m,) ndarray
        Shares of the time that a dash takes; the rest is a rest, where the arm rests at t = 0.
    found : Dash
        Gets its samples.

    Returns
    -------
    int
        The body that is caught, -1 if there is no such dash.
    """
    scene, moving = study.scene, False
    for j in range(dof(scene.limb)):
        moving = moving or scene.limb.rates[j] != 0.0
    for n in range(times.size):
        k = goals.size[0]
        for b in range(scene.bodies.rows.shape[0]):
            if scene.bodies.rows[b, PART] == TARGET:
                add_goals(study, goals, b, times[n], swivels, 0.5 * (n % 2), CENTRE)
        while k < goals.size[0]:
            for m in range(1 if moving else hurries.size):
                took = times[n] * hurries[m]
                if _dash_is_free(study, goals.joints[k], times[n] - took, took, found):
                    return goals.body[k]
            k += 1
    return -1


@njit(_nrt=False)
def _dash_is_free(study, goal, leave, took, found):
    """Return if a dash that begins at `leave` and takes `took` [s] keeps limits and is free."""
    scene, desk = study.scene, study.desk
    switch = dash(scene, goal, took, found.joints, found.rates)
    if switch < 0.0:
        return False
    if leave > 0.0:
        # the rest is the first piece: an acceleration all the way leaves no third one
        if switch < took:
            return False
        for j in range(dof(scene.limb)):
            found.joints[1, j], found.rates[1, j] = found.joints[0, j], 0.0
        found.time[1] = leave
    else:
        found.time[1] = switch
    found.time[0], found.time[2] = 0.0, leave + took
    for k in range(2):
        since, until = found.time[k], found.time[k + 1]
        if until > since:
            hermite(
                found.joints[k],
                found.rates[k],
                found.joints[k + 1],
                found.rates[k + 1],
                until - since,
                desk.curve,
            )
            if piece_fault(scene, desk.curve, until - since, desk.joints) != NOTHING:
                return False
            best, _ = least_on(scene, since, until, study.touch, 1e300, 1e300, desk)
            if best <= study.touch:
                return False
    return True
