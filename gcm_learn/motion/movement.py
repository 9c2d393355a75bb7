"""Timed movements of an arm."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from gcm_learn.arms import SIDE, forward_in_space, hands_along, joints_of

HAND_REST = 0.01  # a hand rests when it is slower than this share of its greatest speed on the way
REST = 1e-6  # joints that are slower than this rest [rad/s]
CREEP = 0.02  # of its fastest sample; a smooth curve that waits is slower, and never quite still


SAME = 1e-9  # instants that are this near are the same [s]


class Wait(NamedTuple):
    """A rest of the hand on its way in the plane."""

    x: float
    y: float
    """Position [forearm lengths]."""
    start: float
    end: float
    """First and last instant [s]."""

    @property
    def duration(self) -> float:
        """[s]"""
        return self.end - self.start


@dataclass(frozen=True)
class Movement:
    """A timed movement of an arm.

    Between samples a movement is linear in the joints, cubic in the joints (with `rates`), or
    linear in the hand (with `path`).
    """

    arm: Any
    """The arm that moves: its record."""
    time: np.ndarray
    """(n,) float: sample times [s], starting at 0; strictly increasing without a `path`."""
    joints: np.ndarray
    """(n, dof) float: [rad]; of a planar arm the direction of the upper arm (unwrapped) and the
    forearm relative to it."""
    rates: np.ndarray | None = None
    """(n, dof) float: of the joints at the samples [rad/s]; between them the joints are the cubic
    Hermite curves of both. None where joints are linear: without limits of acceleration always."""
    path: np.ndarray | None = None
    """(n, 2) float: hands of a planar arm [forearm lengths], which go straight between samples."""

    def __post_init__(self) -> None:
        self._check_shapes()
        steps = self.time[1:] - self.time[:-1]
        if self.time.size == 0 or (steps < 0.0).any():
            raise ValueError("movement: times must not decrease and there must be at least one")
        if self.path is None and (steps == 0.0).any():
            raise ValueError("movement: times must increase")
        if self.rates is not None and getattr(self.arm, "max_joint_acceleration", None) is None:
            raise ValueError("movement has rates, but its arm no max_joint_acceleration")

    def _check_shapes(self) -> None:
        """Refuse arrays that do not fit each other, or the arm."""
        n = self.time.shape[0] if self.time.ndim else 0
        shapes = {"time": (n,), "joints": (n, 2 if self.path is not None else len(self.arm.joints))}
        shapes |= {"rates": shapes["joints"], "path": (n, 2)}
        for name, shape in shapes.items():
            given = getattr(self, name)
            if given is not None and given.shape != shape:
                raise ValueError(f"movement: {name} needs shape {shape}, got {given.shape}")

    @classmethod
    def of_hand(cls, arm: Any, time: np.ndarray, hand: np.ndarray) -> Movement:
        """Build a movement of a planar arm from the path of its hand.

        The joints follow from the elbow's side.
        """
        return cls(arm, time, joints_of(hand, arm.upper_arm, SIDE[arm.elbow]), path=hand)

    @cached_property
    def elbow(self) -> np.ndarray:
        """(n, 3) float: elbows of a spatial arm, in the world."""
        return forward_in_space(self.arm, self.joints)[0]

    @cached_property
    def hand(self) -> np.ndarray:
        """(n, 2 or 3) float: hands, in the world."""
        return self._hands(self.joints) if self.path is None else self.path

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
        """True if the joints rest anywhere on the way; with `rates`, if they nearly do."""
        speed = np.abs(np.diff(self.joints, axis=0)).max(axis=1) / np.diff(self.time)
        slow = REST if self.rates is None else max(CREEP * speed.max(initial=0.0), REST)
        return bool((speed <= slow).any())

    def until(self, time: float) -> Movement:
        """Return the movement up to the sample at `time` [s]."""
        count = int(np.searchsorted(self.time, time - SAME, side="left")) + 1
        parts = {name: getattr(self, name) for name in ("time", "joints", "rates", "path")}
        cut = {name: None if rows is None else rows[:count] for name, rows in parts.items()}
        return Movement(self.arm, **cut)  # type: ignore[arg-type]

    def joints_at(self, t: float | np.ndarray) -> np.ndarray:
        """Joints (..., dof) at time(s) t, held before the first and after the last sample."""
        if self.rates is None or self.time.size == 1:
            return _interpolated(t, self.time, self.joints)
        from scipy.interpolate import CubicHermiteSpline

        curve = CubicHermiteSpline(self.time, self.joints, self.rates)
        return np.asarray(curve(np.clip(t, self.time[0], self.time[-1])))

    def states_at(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Joints, rates and accelerations (n, dof) at times t (n,); at rest after the last sample.

        At a sample they belong to the piece that begins there.
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
        """Hand position(s) (..., 2 or 3) at time(s) t, held before the first and after the last."""
        if self.path is not None:
            return _interpolated(t, self.time, self.path)
        return self._hands(self.joints_at(t))

    def elbow_at(self, t: float | np.ndarray) -> np.ndarray:
        """Elbow position(s) (..., 3) of a spatial arm at time(s) t."""
        return forward_in_space(self.arm, self.joints_at(t))[0]

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
        rests = speed <= HAND_REST * speed.max(initial=0.0)
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

    def _hands(self, joints: np.ndarray) -> np.ndarray:
        """Hands (..., 3) of joints (..., dof)."""
        return hands_along(self.arm, joints)[0].reshape(*joints.shape[:-1], 3)


def _interpolated(t: float | np.ndarray, time: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Columns of `values` (n, m) at time(s) t, linear between the samples at `time`."""
    return np.stack([np.interp(t, time, column) for column in values.T], axis=-1)
