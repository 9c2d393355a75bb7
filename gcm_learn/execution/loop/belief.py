"""Belief of an agent about the world, from all percepts: a Kalman filter for each body.

The filters know the laws of motion and nothing disturbs these, so what is believed becomes ever
more certain.  Kalman, Trans. ASME J. Basic Eng. 82 (1960), Eqs. 21-26; for pendulums the law is
linearised about what is believed (the extended filter).  Of piecewise and sampled motions only the
shift is inexact, so the filter is a mean of all looks.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from gcm_learn.errors import ArenaError
from gcm_learn.execution.loop.kinds import LEADS
from gcm_learn.execution.loop.perception import (
    Course,
    Percept,
    Perception,
    Quadratic,
    shifted,
    start_of,
)
from gcm_learn.scene import bodies_later, integrate_swing
from gcm_learn.situation import AnySituation, Body, Motion, Pendulum

ACCELERATION = 10.0  # standard deviation of each coordinate, before anything is seen [forearms/s^2]
_EXACT = 1e-9  # nothing is taken for more exact than this [forearms, rad]
_STEPS = 64  # in which a pendulum's angle is integrated between two looks
_NUDGE = 1e-5  # of angle and rate, for the law's derivatives [rad, rad/s]


@dataclass
class _Filter:
    """Estimate of the motion of one body at a time: mean and covariance."""

    body: Body
    """As it was seen last; of a pendulum, and of a piecewise or sampled motion the law is known."""
    rests: bool
    deviations: tuple[float, float]
    """Deviations of a look: place [lengths] and velocity [lengths/s], or angle and rate."""
    mean: np.ndarray
    """(3, axes): place, velocity, acceleration; (2, 1): angle and rate; (1, 3): place."""
    spread: np.ndarray
    """Square: covariance of the rows, the same for every column."""

    @classmethod
    def of(cls, body: Body, rests: bool, deviations: tuple[float, float], prior: float) -> _Filter:
        """Return the estimate after the first look."""
        place, fast = (max(deviation, _EXACT) ** 2 for deviation in deviations)
        if isinstance(body.motion, Pendulum):
            variances = [place, fast]
        elif isinstance(body.motion, Course):
            variances = [place]
        else:  # that a body rests is seen
            variances = [place, 0.0, 0.0] if rests else [place, fast, prior**2]
        return cls(body, rests, deviations, _numbers(body.motion), np.diag(variances))

    def later(self, span: float) -> tuple[np.ndarray, np.ndarray]:
        """Return mean and spread after `span` [s]."""
        motion = self.body.motion
        if isinstance(motion, Course):
            ahead: Any = bodies_later([self.body], span)[0].motion
            return self.mean + np.subtract(start_of(ahead), start_of(motion)), self.spread
        if isinstance(motion, Pendulum):
            angle, rate = self.mean[:, 0]
            nudges = ((0.0, 0.0), (_NUDGE, 0.0), (-_NUDGE, 0.0), (0.0, _NUDGE), (0.0, -_NUDGE))
            ends = np.array([_swung(motion, angle + a, rate + r, span) for a, r in nudges])
            shift = np.stack([ends[1] - ends[2], ends[3] - ends[4]], axis=1) / (2.0 * _NUDGE)
            return ends[0][:, None], shift @ self.spread @ shift.T
        shift = np.array([[1.0, span, 0.5 * span**2], [0.0, 1.0, span], [0.0, 0.0, 1.0]])
        return shift @ self.mean, shift @ self.spread @ shift.T

    def join(self, body: Body, span: float) -> float:
        """Update the estimate with a look `span` [s] later; return the surprise, see `Belief.join`.

        Place and velocity are joined one after the other, so no matrix is inverted and looks may
        be exact; their errors are independent.
        """
        mean, spread = self.later(span)
        seen, surprise = _numbers(body.motion), 0.0
        for k, deviation in enumerate(self.deviations[: 1 if self.rests else len(seen)]):
            variance = max(deviation, _EXACT) ** 2
            off, all_in_all = seen[k] - mean[k], spread[k, k] + variance
            gain = spread[:, k] / all_in_all
            mean = mean + np.outer(gain, off)
            keep = np.eye(len(gain))
            keep[:, k] -= gain  # in Joseph's form the spread stays positive
            spread = keep @ spread @ keep.T + variance * np.outer(gain, gain)
            surprise += float(off @ off) / all_in_all
        self.body, self.mean, self.spread = body, mean, spread
        return surprise

    def believed(self) -> Body:
        """The body, with the motion that is believed."""
        motion = self.body.motion
        if isinstance(motion, Course):
            off = self.mean[0] - np.array(start_of(motion))
            return replace(self.body, motion=shifted(motion, off))
        if isinstance(motion, Pendulum):
            angle, rate = self.mean[:, 0].tolist()
            return replace(self.body, motion=replace(motion, angle=angle, rate=rate))
        assert isinstance(motion, Quadratic)
        place, velocity, acceleration = (tuple(row) for row in self.mean.tolist())
        moves: Any = dict(position=place, velocity=velocity, acceleration=acceleration)
        return replace(self.body, motion=replace(motion, **moves))


class Belief:
    """All bodies as they are believed to be.

    A body is believed to rest as long as that is what is seen, and then only its place is inexact.
    Orientations and spins are those that were seen last.

    Parameters
    ----------
    situation : Situation
        Its bodies do not count.
    perception : Perception
        How inexact looks are.
    acceleration : float
        Standard deviation of each coordinate of accelerations before anything is seen, the mean
        is 0 [forearms/s^2].
    """

    def __init__(
        self, situation: AnySituation, perception: Perception, acceleration: float = ACCELERATION
    ) -> None:
        if not 0.0 <= acceleration < math.inf:
            raise ArenaError(f"acceleration: must be from 0 on (got {acceleration!r})")
        self.perception = perception
        self.forearm = LEADS.of(situation).forearm(situation.arm)
        self._situation: Any = situation
        self.looks = 0
        """Number of joined percepts."""
        self.time = 0.0
        """Of the last one [s]."""
        self._prior = acceleration * self.forearm
        self._filters: list[_Filter] = []

    def join(self, percept: Percept) -> np.ndarray:
        """Update the belief with a percept; return the surprise of each body.

        Returns
        -------
        (bodies,) ndarray
            Surprise: sum of the squared differences of look and prediction, each over its
            variance.  Chi-square distributed: 6 degrees of freedom for a body that flies, 3 for
            one that rests or has a piecewise or sampled motion, 2 for a pendulum.  All 0 for the
            first look.
        """
        span = percept.time - self.time
        self.looks, self.time = self.looks + 1, percept.time
        seen = list(zip(percept.bodies, percept.rests, strict=True))
        if self.looks == 1:
            self._filters = [self._begun(body, rests) for body, rests in seen]
            return np.zeros(len(seen))
        surprises = np.zeros(len(seen))
        for k, (body, rests) in enumerate(seen):
            if self._filters[k].rests == rests:
                surprises[k] = self._filters[k].join(body, span)
            else:
                self._filters[k] = self._begun(body, rests)
        return surprises

    def _begun(self, body: Body, rests: bool) -> _Filter:
        deviations = self.perception.deviations(body.motion, self.forearm)
        return _Filter.of(body, rests, deviations, self._prior)

    def situation(self, now: float, arm: Any) -> Any:
        """Return the believed situation from now on; its horizon is the time that is left.

        Parameters
        ----------
        now : float
            From the time of the last look to less than the horizon [s].
        arm : Arm or SpatialArm
            As it stands and moves now.

        Returns
        -------
        Situation
        """
        span = now - self.time
        bodies = bodies_later([body.believed() for body in self._filters], span)
        horizon = self._situation.horizon - self.time - span
        return replace(self._situation, arm=arm, bodies=bodies, horizon=horizon)

    def deviations(self, now: float) -> np.ndarray:
        """Standard deviations (bodies,) of each coordinate of their places now [lengths].

        Of pendulums that along the arc.
        """
        out = []
        for body in self._filters:
            motion, (_, spread) = body.body.motion, body.later(now - self.time)
            lever = motion.hang_distance if isinstance(motion, Pendulum) else 1.0
            out.append(lever * math.sqrt(max(spread[0, 0], 0.0)))
        return np.array(out)


def _numbers(motion: Motion) -> np.ndarray:
    """Return a motion's numbers in the shape of a filter's mean."""
    if isinstance(motion, Pendulum):
        return np.array([[motion.angle], [motion.rate]])
    if isinstance(motion, Course):
        return np.array([start_of(motion)])
    assert isinstance(motion, Quadratic)
    return np.array([motion.position, motion.velocity, motion.acceleration])


def _swung(motion: Pendulum, angle: float, rate: float, span: float) -> np.ndarray:
    """Angle and rate (2,) of a pendulum after `span` [s]."""
    table = integrate_swing(
        angle, rate, motion.gravity / motion.length, motion.damping, span / _STEPS, _STEPS + 1
    )
    return np.asarray(table[-1])
