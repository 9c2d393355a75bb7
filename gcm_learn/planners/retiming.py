"""A plan's path under a limit of acceleration: slower off the mark, rounder at the corners.

A plan's hand starts at full speed and turns on the spot.  Here it is followed by its own average
over the last moments,

    p(t) = 1/w (integral of q from t - w to t),    q the plan's hand, at rest before t = 0,

whose acceleration is (q'(t) - q'(t - w)) / w, and which is never faster than q.  It comes half a
window late.  If the plan has time to spare, q is sent ahead by that much.  Otherwise the hand meets
the target later, in a straight line from some point of the path.  Obstacles move meanwhile and
corners are cut, so the result is verified like every plan, or dropped.

The bound is on the hand's acceleration: along the motion p, and so in the second differences of
the trajectory, which samples p at equal steps.  The acceleration of joints is unbounded, and so is
the end, where the hand may be as fast as it likes.

TOPP-RA (Pham and Pham 2018), the usual tool, does not fit.  It finds the fastest timing of a given
smooth path, and ours are made of straight pieces.  Its world stands still.  The support of its
Python package is to be dropped, as its README says.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from gcm_learn.checks import positive
from gcm_learn.motion import (
    Failure,
    Movement,
    Reason,
    first_interception,
    keep_limits,
    refine,
    straight_path,
)
from gcm_learn.planners.completion import Attempt, Problem, attempt_of, checked, first_catch_on
from gcm_learn.planners.plan import Plan
from gcm_learn.situation import Situation

CHORD = 1e-4  # what is linear between samples keeps that near to the motion [forearm lengths]
FEWEST_SAMPLES = 50
MOST_SAMPLES = 5000
SHORTEST = 1e-4  # window, against rounding [of the plan's time]
GROWTH = 1.15  # of the window until the acceleration is small enough
LEAVES = 12  # points of the path from which the target is tried in a straight line


@dataclass(frozen=True)
class Motion:
    """A hand that is linear between samples, at rest before the first and after the last."""

    time: np.ndarray
    """(n,) float: increasing, from 0 [s]."""
    hand: np.ndarray
    """(n, 2) float [forearm lengths]."""

    @property
    def velocity(self) -> np.ndarray:
        """Between the samples (n - 1, 2) [forearm lengths / s]."""
        return np.diff(self.hand, axis=0) / np.diff(self.time)[:, None]

    def velocity_at(self, t: np.ndarray) -> np.ndarray:
        """Velocities (m, 2) at times (m,)."""
        still = np.zeros((1, 2))
        return np.vstack([still, self.velocity, still])[np.searchsorted(self.time, t)]

    def averaged(self, window: float, t: np.ndarray) -> np.ndarray:
        """Mean hands (m, 2) over the last `window` seconds at times (m,)."""
        return self.hand[0] + (self._integral(t) - self._integral(t - window)) / window

    def acceleration(self, window: float) -> float:
        """Largest acceleration of the mean."""
        edges = np.unique(np.concatenate([self.time, self.time + window]))
        middles = 0.5 * (edges[1:] + edges[:-1])
        change = self.velocity_at(middles) - self.velocity_at(middles - window)
        return float(np.hypot(*change.T).max() / window)

    def _integral(self, t: np.ndarray) -> np.ndarray:
        """Integral (m, 2) of the path from the start, from 0 to t."""
        path, span = self.hand - self.hand[0], np.diff(self.time)[:, None]
        pieces = 0.5 * span * (path[1:] + path[:-1])
        total = np.vstack([np.zeros((1, 2)), np.cumsum(pieces, axis=0)])
        t = np.maximum(t, 0.0)
        k = np.clip(np.searchsorted(self.time, t, side="right") - 1, 0, len(self.time) - 1)
        late = (t - self.time[k])[:, None]
        speed = np.vstack([self.velocity, np.zeros((1, 2))])[k]
        return total[k] + late * path[k] + 0.5 * late**2 * speed


def retime(plan: Plan, situation: Situation, max_acceleration: float) -> Plan:
    """Follow a plan with a hand of limited acceleration that starts at rest.

    Parameters
    ----------
    plan : Plan
        A catch; a plan without one is returned as it is.
    situation : Situation
        The one that the plan is for.
    max_acceleration : float
        Of the hand, above zero [forearm lengths / s^2].

    Returns
    -------
    Plan
        A verified catch, mostly later than the plan's, or "unreachable" with the reason.
    """
    positive(max_acceleration, "max_acceleration")
    if plan.trajectory is None or plan.trajectory.duration == 0.0:
        return plan
    problem = Problem(situation, plan.planner)
    reason: Reason | None = Reason(Failure.NO_TARGET_MET)
    answer: Plan | None = None
    attempts = (_attempt(problem, *m) for m in _motions(problem, plan.trajectory, max_acceleration))
    for attempt in sorted(filter(None, attempts), key=lambda a: a.trajectory.duration):
        answer, reason = checked(problem, attempt)
        if answer is not None:
            break
    if answer is None:
        answer = problem.answer(
            Failure.TOO_SLOW.with_numbers(limit=max_acceleration, reason=reason)
        )
    elapsed = problem.elapsed_ms
    return replace(answer, planning_ms=plan.planning_ms + elapsed)


def _motions(problem: Problem, path: Movement, most: float) -> Iterator[tuple[Motion, float]]:
    """Motions to be averaged, and their windows: the target is dashed for from many points."""
    leaves = np.linspace(0.0, path.duration, LEAVES)
    for k in sorted(set(np.searchsorted(path.time, leaves).tolist())):
        window = max(problem.situation.arm.max_hand_speed / most, SHORTEST * path.duration)
        longest = 2.0 * window * GROWTH  # a reversal takes two
        while window <= longest:
            motion = _ahead(problem, path.time[: k + 1], path.hand[: k + 1], 0.5 * window)
            if motion is None:
                break
            if motion.acceleration(window) <= most:
                yield motion, window
                break
            window *= GROWTH


def _ahead(problem: Problem, time: np.ndarray, hand: np.ndarray, lead: float) -> Motion | None:
    """The path up to a point, sent ahead, and on to where the hand will meet a target.

    Parameters
    ----------
    time, hand : (n,), (n, 2) ndarray
        The path of the plan up to there.
    lead : float
        By how much the average will be late [s].
    """
    arm, situation = problem.situation.arm, problem.situation
    time = keep_limits(arm, hand, time - lead)
    leave = float(time[-1]) + lead  # when the average is about there
    t, _, x, y = first_interception(
        problem.scene, problem.rules, *hand[-1], leave, leave, situation.horizon
    )
    if t < 0.0:
        return None
    # Going on beyond it for as long as the average is late keeps the average on the line.
    leg = straight_path(hand[-1], np.array([x, y]))
    span = max(float(t) - leave, problem.rules.instant)
    beyond = leg[-1] + (leg[-1] - leg[0]) * 2.0 * lead / span
    times = float(time[-1]) + np.linspace(0.0, span, len(leg))[1:]
    time = np.concatenate([time, times, [times[-1] + 2.0 * lead]])
    hand = np.vstack([hand, leg[1:], [beyond]])
    kept = np.concatenate([[True], np.diff(time) > 1e-12])
    return Motion(time[kept], hand[kept])


def _attempt(problem: Problem, motion: Motion, window: float) -> Attempt | None:
    """Sample the average up to the first catch."""
    end = min(float(motion.time[-1]), problem.situation.horizon)
    count = FEWEST_SAMPLES
    while True:
        time = np.linspace(0.0, end, count + 1)
        hand = motion.averaged(window, time)
        hand[0] = problem.situation.arm.hand
        bent = np.abs(hand[2:] - 2.0 * hand[1:-1] + hand[:-2]).max() / 8.0
        smooth = bent <= CHORD and len(refine(problem.situation.arm, time, hand)[0]) == len(time)
        if smooth or 2 * count > MOST_SAMPLES:
            break
        count *= 2
    t, body = first_catch_on(problem, time, hand)
    if body < 0:
        return None
    k = int(np.searchsorted(time, t, side="left"))
    last = [np.interp(t, time, hand[:, a]) for a in (0, 1)]
    return attempt_of(problem, np.append(time[:k], t), np.vstack([hand[:k], [last]]), body)
