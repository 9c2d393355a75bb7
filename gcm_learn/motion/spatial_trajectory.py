"""A timed movement of a spatial arm, given by its joints."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from gcm_learn.arms import SPATIAL, ByKind, forward_in_space, hands_along

REST = 1e-6  # joints that are slower than this rest [rad/s]
CREEP = 0.02  # of its fastest sample; a smooth curve that waits is slower, and never quite still


_HANDS = ByKind(
    {SPATIAL: lambda arm, joints: forward_in_space(arm, joints)[1]},
    default=lambda arm, joints: hands_along(arm, joints)[0],
)


@dataclass(frozen=True)
class SpatialTrajectory:
    """A movement of a spatial arm: linear in the joints between samples, or cubic with rates."""

    arm: Any
    """SpatialArm, Chain or another arm that moves in its joints."""
    time: np.ndarray
    """(n,) float: sample times [s], starting at 0, strictly increasing."""
    joints: np.ndarray
    """(n, dof) float [rad]"""
    rates: np.ndarray | None = None
    """(n, dof) float: of the joints at the samples [rad/s]; between them the joints are the cubic
    Hermite curves of both. None where joints are linear: without limits of acceleration always."""

    def __post_init__(self) -> None:
        n, rates = self.time.shape[0], self.joints if self.rates is None else self.rates
        dof = len(self.arm.joints)
        if not (self.time.shape == (n,) and self.joints.shape == rates.shape == (n, dof)):
            raise ValueError(
                f"trajectory needs shapes (n,), (n, {dof}), (n, {dof}), got "
                f"{self.time.shape}, {self.joints.shape}, {rates.shape}"
            )
        if n == 0 or (self.time[1:] <= self.time[:-1]).any():
            raise ValueError("trajectory times must increase and there must be at least one")
        if self.rates is not None and self.arm.max_joint_acceleration is None:
            raise ValueError("trajectory has rates, but its arm no max_joint_acceleration")

    @cached_property
    def elbow(self) -> np.ndarray:
        """(n, 3) float: elbows of a spatial arm, in the world."""
        return forward_in_space(self.arm, self.joints)[0]

    @cached_property
    def hand(self) -> np.ndarray:
        """(n, 3) float: hands, in the world."""
        return _HANDS.of(self.arm)(self.arm, self.joints)

    @property
    def duration(self) -> float:
        """Time of the last sample [s]."""
        return float(self.time[-1])

    @property
    def length(self) -> float:
        """Length of the hand's path, straight between samples."""
        return float(np.sqrt((np.diff(self.hand, axis=0) ** 2).sum(axis=1)).sum())

    @property
    def rests(self) -> bool:
        """Whether the arm rests anywhere on its way; with `rates`, whether it does so nearly."""
        speed = np.abs(np.diff(self.joints, axis=0)).max(axis=1) / np.diff(self.time)
        slow = REST if self.rates is None else max(CREEP * speed.max(initial=0.0), REST)
        return bool((speed <= slow).any())

    def joints_at(self, t: float | np.ndarray) -> np.ndarray:
        """Joint angles (..., dof) at time(s) t, held before the first and after the last sample."""
        if self.rates is None or self.time.size == 1:
            return np.stack(
                [np.interp(t, self.time, self.joints[:, j]) for j in range(self.joints.shape[1])],
                axis=-1,
            )
        from scipy.interpolate import CubicHermiteSpline

        curve = CubicHermiteSpline(self.time, self.joints, self.rates)
        return np.asarray(curve(np.clip(t, self.time[0], self.time[-1])))

    def states_at(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Joints, rates and accelerations (n, dof) at times t (n,); at rest after the last sample.

        At a sample they are those of the piece that begins there.
        """
        inside = (t >= self.time[0]) & (t < self.time[-1])
        if self.rates is None or self.time.size == 1 or not inside.any():
            joints = self.joints_at(t)
        if self.time.size == 1 or not inside.any():
            return joints, np.zeros_like(joints), np.zeros_like(joints)
        k = np.clip(np.searchsorted(self.time, t, side="right") - 1, 0, self.time.size - 2)
        span = np.diff(self.time)[k][:, None]
        rise = np.diff(self.joints, axis=0)[k]
        if self.rates is None:
            return joints, np.where(inside[:, None], rise / span, 0.0), np.zeros_like(joints)
        first, last = self.rates[k], self.rates[k + 1]
        c, d = 3.0 * rise / span - 2.0 * first - last, first + last - 2.0 * rise / span
        s = np.clip((t - self.time[k])[:, None] / span, 0.0, 1.0)
        joints = self.joints[k] + span * s * (first + s * (c + s * d))
        rates, forces = first + s * (2.0 * c + 3.0 * s * d), (2.0 * c + 6.0 * s * d) / span
        return joints, np.where(inside[:, None], rates, 0.0), np.where(inside[:, None], forces, 0.0)

    def hand_at(self, t: float | np.ndarray) -> np.ndarray:
        """Hand position(s) (..., 3) in the world at time(s) t."""
        joints = self.joints_at(t)
        return _HANDS.of(self.arm)(self.arm, joints).reshape(*joints.shape[:-1], 3)

    def elbow_at(self, t: float | np.ndarray) -> np.ndarray:
        """Elbow position(s) (..., 3) in the world at time(s) t."""
        return forward_in_space(self.arm, self.joints_at(t))[0]
