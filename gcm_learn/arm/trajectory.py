"""A timed hand path and the joints that go with it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gcm_learn.arm.kinematics import SIDE, joints_of


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
        if n == 0 or np.any(np.diff(self.time) < 0.0):
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
