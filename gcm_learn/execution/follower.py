"""An agent that follows plans."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gcm_learn.execution.episode import Moment, into_frame
from gcm_learn.motion import Trajectory


class Follower:
    """Follows trajectories step by step, one of each arm.

    Parameters
    ----------
    plans : sequence of Trajectory
        One for each arm, in canonical coordinates.
    speed : (n,) ndarray
        Of the hands [forearms/s].
    dt : float
        Of a step [s].
    """

    def __init__(self, plans: Sequence[Trajectory], speed: np.ndarray, dt: float) -> None:
        most = max(len(plan.time) for plan in plans)
        self._speed, self._dt = speed, dt
        self._end = np.array([plan.duration for plan in plans])
        # Shorter ones are filled up with their ends.
        self._time = np.full((len(plans), most), np.inf)
        self._hand = np.empty((len(plans), most, 2))
        for row, plan in enumerate(plans):
            self._time[row, : len(plan.time)] = plan.time
            self._hand[row] = plan.hand[-1]
            self._hand[row, : len(plan.time)] = plan.hand

    def act(self, moment: Moment) -> np.ndarray:
        """Velocities (n, 2) that bring hands to where they should be in a step."""
        wanted = self._velocity(moment.time, moment.hand) / self._speed[:, None]
        return into_frame(moment.hand, wanted)

    def _velocity(self, t: np.ndarray, hand: np.ndarray) -> np.ndarray:
        """Velocities (n, 2) [forearms/s].

        A step in which a plan ends is as fast as its last piece, and goes on beyond it.
        """
        until = np.where(t < self._end - 1e-9, np.minimum(t + self._dt, self._end), t + self._dt)
        rows = np.arange(len(t))
        k1 = np.clip((self._time <= until[:, None]).sum(axis=1), 1, self._time.shape[1] - 1)
        t0, t1 = self._time[rows, k1 - 1], self._time[rows, k1]
        span = np.where(np.isfinite(t1), t1 - t0, 1.0)
        share = np.clip((until - t0) / np.where(span > 0.0, span, 1.0), 0.0, 1.0)[:, None]
        share[~np.isfinite(t1)] = 0.0
        goal = self._hand[rows, k1 - 1] * (1.0 - share) + self._hand[rows, k1] * share
        return (goal - hand) / np.maximum(until - t, 1e-9)[:, None]
