"""Many arms at once, each in a situation of its own: what both environments are made of."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from gcm_learn.envs import kernels as k
from gcm_learn.envs.observation import observe_all, play
from gcm_learn.envs.pool import Pool
from gcm_learn.envs.settings import CONTROLS, Settings


@dataclass
class Arena:
    """Arms that move, catch and touch; nothing of it is drawn at random.

    The arrays are renewed in place at every step: copy what is to be kept.
    """

    pool: Pool
    count: int
    """Number of arms."""
    settings: Settings
    threads: int = 1
    """How many of them move the arms, each its share."""

    def __post_init__(self) -> None:
        n, s = self.count, self.settings
        self.pool = self.pool.prepared(s)
        self.state = k.State(np.zeros(n, np.int64), np.zeros((n, 2)), np.zeros(n))
        self.outcomes = np.zeros(n, np.int64)
        self.terms = np.zeros((n, k.TERMS))
        """Terms of the reward of the last step (count, 4)."""
        self.observations = np.zeros((n, s.width + self.pool.embeddings.shape[1]), np.float32)
        self._everyone = np.arange(n)
        self._arms = tuple(self.state)
        self._rest = (  # what `play` is told the same of at every step
            CONTROLS[s.control], s.joint_rate, s.dt, s.weights.row, s.discount, s.slots, s.fan,
            self.outcomes, self.terms, self.observations,
        )  # fmt: skip
        marks = np.linspace(0, n, min(self.threads, n) + 1).astype(int).tolist()
        self._shares = list(pairwise(marks))
        self._crew: ThreadPoolExecutor | None = None

    def __getstate__(self) -> dict[str, Any]:
        """All but the threads."""
        return {**self.__dict__, "_crew": None}

    def put(self, arms: np.ndarray, places: np.ndarray) -> None:
        """Put arms (m,) at the start of situations (m,) of the pool, and observe."""
        state = self.state
        state.place[arms] = places
        state.hand[arms, 0] = self.pool.world.arms[places, k.START]
        state.hand[arms, 1] = 0.0
        state.time[arms] = 0.0
        self.observations[arms, self.settings.width :] = self.pool.embeddings[places]
        self.observe(arms)

    def observe(self, arms: np.ndarray | None = None) -> np.ndarray:
        """Renew what arms are told; by default all."""
        s = self.settings
        chosen = self._everyone if arms is None else arms
        world = tuple(self.pool.world)
        observe_all(world, self._arms, chosen, s.slots, s.fan, s.dt, self.observations)
        return self.observations

    def move(self, actions: np.ndarray) -> np.ndarray:
        """One step of every arm, and what they are told then: the outcomes (count,)."""
        if len(self._shares) == 1:
            self._play(actions, 0, self.count)
            return self.outcomes
        if self._crew is None:
            self._crew = ThreadPoolExecutor(len(self._shares) - 1)
        (first, last), *others = self._shares
        waiting = [self._crew.submit(self._play, actions, *share) for share in others]
        self._play(actions, first, last)
        for share in waiting:
            share.result()
        return self.outcomes

    def _play(self, actions: np.ndarray, first: int, last: int) -> None:
        """One step of some arms."""
        play(tuple(self.pool.world), self._arms, actions, *self._rest, first, last)
