"""Demonstrations: planned catches, acted out in the arena."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from gcm_learn.envs import kernels as k
from gcm_learn.envs.arena import Arena
from gcm_learn.envs.pool import Pool
from gcm_learn.envs.settings import Settings
from gcm_learn.motion.trajectory import Trajectory


@dataclass(frozen=True)
class Demonstrations:
    """What was told and what was done."""

    observations: np.ndarray
    """(m, width) float32."""
    actions: np.ndarray
    """(m, 2) float32: velocities in the frame of the moment, in hand speeds."""
    caught: np.ndarray
    """Which of the plans still catch when they are acted out in steps (n,)."""

    @classmethod
    def joined(cls, parts: Iterable[Demonstrations]) -> Demonstrations:
        """Several, one after the other."""
        columns = zip(*((p.observations, p.actions, p.caught) for p in parts), strict=True)
        return cls(*map(np.concatenate, columns))


def act_out(pool: Pool, ways: Sequence[Trajectory], settings: Settings) -> Demonstrations:
    """Follow plans step by step.

    Parameters
    ----------
    pool : Pool
    ways : sequence of Trajectory
        One for each situation of the pool, in canonical coordinates.
    settings : Settings

    Returns
    -------
    Demonstrations
        Only of episodes that end with a catch: what corners cut by steps spoil is left out.
    """
    told, done, whose, caught = [], [], [], np.zeros(len(pool), bool)
    for moves in _moves(pool, ways, settings):
        told.append(moves.told)
        done.append(moves.actions)
        whose.append(moves.arms)
        caught[moves.arms] = moves.outcomes == k.CAUGHT
    good = caught[np.concatenate(whose)]
    return Demonstrations(np.concatenate(told)[good], np.concatenate(done)[good], caught)


class Moves(NamedTuple):
    """One step of those arms whose episode is not over."""

    arms: np.ndarray
    """Which they are (m,)."""
    told: np.ndarray
    """Before (m, width) float32."""
    actions: np.ndarray
    """(m, 2) float32."""
    rewards: np.ndarray
    """(m,) float32."""
    following: np.ndarray
    """What is told after (m, width) float32."""
    outcomes: np.ndarray
    """As the arena codes them (m,)."""


def transitions(pool: Pool, ways: Sequence[Trajectory], settings: Settings) -> Moves:
    """All steps of following plans, one after the other, for learners with a replay buffer.

    What fails because steps cut corners is told, too: it comes with its reward.
    """
    return Moves(*map(np.concatenate, zip(*_moves(pool, ways, settings), strict=True)))


def _moves(pool: Pool, ways: Sequence[Trajectory], settings: Settings) -> Iterator[Moves]:
    """Follow plans, step by step."""
    n = len(pool)
    arena = Arena(pool, n, settings)
    arena.put(np.arange(n), np.arange(n))
    table = _Table(ways)
    speed = pool.world.arms[:, k.SPEED]
    alive = np.ones(n, bool)
    while alive.any():
        wanted = table.velocity(arena.state.time, arena.state.hand, settings.dt) / speed[:, None]
        actions = into_frame(arena.state.hand, wanted)
        arms, told = np.flatnonzero(alive), arena.observations[alive]
        outcomes = arena.move(actions)[arms]
        yield Moves(
            arms, told, actions[arms].astype(np.float32),
            arena.terms[arms].sum(axis=1).astype(np.float32), arena.observations[arms], outcomes,
        )  # fmt: skip
        alive[arms] = outcomes == k.RUNNING
        arena.state.time[~alive] = pool.world.arms[~alive, k.HORIZON]


def into_frame(hand: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Vectors (n, 2), turned into the frames in which hands (n, 2) are on the x axis."""
    r = np.maximum(np.hypot(*hand.T), 1e-12)
    c, s = hand[:, 0] / r, hand[:, 1] / r
    x, y = vectors.T
    return np.stack([c * x + s * y, c * y - s * x], axis=1)


class _Table:
    """Many ways side by side, the shorter ones filled up with their ends."""

    def __init__(self, ways: Sequence[Trajectory]) -> None:
        most = max(len(way.time) for way in ways)
        self.time = np.full((len(ways), most), np.inf)
        self.hand = np.empty((len(ways), most, 2))
        self.end = np.array([way.duration for way in ways])
        for row, way in enumerate(ways):
            self.time[row, : len(way.time)] = way.time
            self.hand[row] = way.hand[-1]
            self.hand[row, : len(way.time)] = way.hand

    def velocity(self, t: np.ndarray, hand: np.ndarray, dt: float) -> np.ndarray:
        """Velocities (n, 2) that bring hands to where they should be in a step, at most `dt` long.

        A step in which a way ends is as fast as its last piece, and goes on beyond it.
        """
        until = np.where(t < self.end - 1e-9, np.minimum(t + dt, self.end), t + dt)
        rows = np.arange(len(t))
        k1 = np.clip((self.time <= until[:, None]).sum(axis=1), 1, self.time.shape[1] - 1)
        t0, t1 = self.time[rows, k1 - 1], self.time[rows, k1]
        span = np.where(np.isfinite(t1), t1 - t0, 1.0)
        share = np.clip((until - t0) / np.where(span > 0.0, span, 1.0), 0.0, 1.0)[:, None]
        share[~np.isfinite(t1)] = 0.0
        goal = self.hand[rows, k1 - 1] * (1.0 - share) + self.hand[rows, k1] * share
        return (goal - hand) / np.maximum(until - t, 1e-9)[:, None]
