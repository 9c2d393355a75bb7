"""Agents that follow plans."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from gcm_learn.arms import PLANAR, ByKind
from gcm_learn.execution.arena.pool import Pool
from gcm_learn.execution.loop.episode import Agent, Moment, into_frame
from gcm_learn.motion import Movement


class HandFollower:
    """Agent that follows trajectories of planar arms step by step.

    Parameters
    ----------
    plans : sequence of Movement
        One for each arm, in canonical coordinates.
    speed : (n,) ndarray
        Of the hands [forearms/s].
    dt : float
        Of a step [s].
    """

    def __init__(self, plans: Sequence[Movement], speed: np.ndarray, dt: float) -> None:
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


class JointFollower:
    """Agent that follows trajectories in the joints step by step.

    Parameters
    ----------
    plans : sequence of Movement
        One for each arm.
    dt : float
        Of a step [s].
    """

    def __init__(self, plans: Sequence[Movement], dt: float) -> None:
        self._dt = dt
        self._top = np.array([plan.arm.max_joint_speed for plan in plans])
        most = int(np.ceil(max(plan.duration for plan in plans) / dt)) + 1
        dof = self._top.shape[1]
        self._joints = np.empty((len(plans), most + 1, dof))
        self._rates = np.full((len(plans), most + 1, dof), np.nan)
        for row, plan in enumerate(plans):
            times = dt * np.arange(most + 1)
            inside = np.minimum(times, plan.duration)
            joints, rates, _ = plan.states_at(inside)
            # a step in which a plan ends goes on beyond it, as fast as its last piece
            over = np.argmax(times >= plan.duration)
            if over > 0 and times[over] > plan.duration:
                last = plan.duration - times[over - 1]
                joints[over:] = joints[over - 1] + (joints[over] - joints[over - 1]) * dt / last
            self._joints[row] = joints
            if plan.rates is not None:
                self._rates[row] = rates

    def act(self, moment: Moment) -> np.ndarray:
        """Rates (n, dof) that bring joints to where they should be in a step, in greatest speeds.

        Under limits of acceleration these are the rates of the plans at that time.
        """
        rows, dof = np.arange(len(moment.time)), self._top.shape[1]
        k = np.rint(moment.time / self._dt).astype(int) + 1
        k = np.minimum(k, self._joints.shape[1] - 1)
        even = (self._joints[rows, k] - moment.posture[:, :dof]) / self._dt
        rates = self._rates[rows, k]
        return np.where(np.isnan(rates), even, rates) / self._top


_FOLLOWERS: ByKind[Callable[[Any, Pool, float], Agent]] = ByKind(
    {PLANAR: lambda plans, pool, dt: HandFollower(plans, pool.speed, dt)},
    default=lambda plans, pool, dt: JointFollower(plans, dt),
    who="the arena",
)


def follower_of(plans: Sequence[Any], pool: Pool, dt: float) -> Agent:
    """Return an agent that follows trajectories step by step.

    Parameters
    ----------
    plans : sequence of Movement
        One for each situation of the pool, in its coordinates.
    pool : Pool
    dt : float
        Of a step [s].
    """
    return _FOLLOWERS.of(pool.kind)(plans, pool, dt)
