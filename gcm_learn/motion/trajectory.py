"""A timed hand path and the joints that go with it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from gcm_learn.arms import SIDE, joints_of

REST = 0.01  # a hand rests when it is slower than this share of its greatest speed on the way


class Wait(NamedTuple):
    """A rest of the hand on its way."""

    x: float
    y: float
    """Where [forearm lengths]."""
    start: float
    end: float
    """From when until when [s]."""

    @property
    def duration(self) -> float:
        """[s]"""
        return self.end - self.start


@dataclass(frozen=True)
class Trajectory:
    """A movement of the arm, linear in the hand between samples."""

    time: np.ndarray
    """(n,) float: sample times [s], starting at 0, not decreasing."""
    hand: np.ndarray
    """(n, 2) float: hand positions [forearm lengths]."""
    joints: np.ndarray
    """(n, 2) float: direction of the upper arm (unwrapped) and forearm relative to it [rad]."""

    def __post_init__(self) -> None:
        n = self.time.shape[0]
        if self.time.shape != (n,) or self.hand.shape != (n, 2) or self.joints.shape != (n, 2):
            raise ValueError(
                f"trajectory needs shapes (n,), (n, 2), (n, 2), got "
                f"{self.time.shape}, {self.hand.shape}, {self.joints.shape}"
            )
        if n == 0 or (self.time[1:] < self.time[:-1]).any():
            raise ValueError("trajectory times must not decrease and there must be at least one")

    @classmethod
    def of_hand(
        cls, time: np.ndarray, hand: np.ndarray, upper_arm: float = 1.0, elbow: str = "right"
    ) -> Trajectory:
        """Build a trajectory from a hand path; the joints follow from the elbow's side."""
        return cls(time, hand, joints_of(hand, upper_arm, SIDE[elbow]))

    @property
    def duration(self) -> float:
        """Time of the last sample [s]."""
        return float(self.time[-1])

    @property
    def length(self) -> float:
        """Length of the hand's path [forearm lengths]."""
        return float(np.sqrt((np.diff(self.hand, axis=0) ** 2).sum(axis=1)).sum())

    def hand_at(self, t: float | np.ndarray) -> np.ndarray:
        """Hand position(s) (..., 2) at time(s) t, held before the first and after the last."""
        return np.stack([np.interp(t, self.time, self.hand[:, k]) for k in (0, 1)], axis=-1)

    def joints_at(self, t: float | np.ndarray) -> np.ndarray:
        """Joint angles (..., 2) at time(s) t, interpolated between samples."""
        return np.stack([np.interp(t, self.time, self.joints[:, k]) for k in (0, 1)], axis=-1)

    def waits(self, shortest: float = 0.0) -> list[Wait]:
        """Rests of the hand, in order of time.

        A hand that never moves rests all the time.  Samples within a rest do not cut it.

        Parameters
        ----------
        shortest : float
            Rests that last less are left out [s].
        """
        length = np.sqrt((np.diff(self.hand, axis=0) ** 2).sum(axis=1))
        span = np.diff(self.time)
        speed = np.divide(length, span, out=np.zeros_like(length), where=span > 0.0)
        rests = speed <= REST * speed.max(initial=0.0)
        rests[(span == 0.0) & (length > 0.0)] = False
        # +1 where a run of resting segments starts, -1 after its end
        edges = np.diff(np.concatenate([[False], rests, [False]]).astype(int))
        runs = zip(np.flatnonzero(edges == 1), np.flatnonzero(edges == -1), strict=True)
        found = [
            Wait(
                float(self.hand[a, 0]),
                float(self.hand[a, 1]),
                float(self.time[a]),
                float(self.time[b]),
            )
            for a, b in runs
        ]
        return [wait for wait in found if wait.duration > 0.0 and wait.duration >= shortest]
