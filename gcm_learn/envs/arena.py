"""Many arms at once, each in a situation of its own: what both environments are made of."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gcm_learn.envs import kernels as k
from gcm_learn.envs.observation import observe_all, play_all
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

    def __post_init__(self) -> None:
        n, s = self.count, self.settings
        self.state = k.State(np.zeros(n, np.int64), np.zeros((n, 2)), np.zeros(n))
        self.outcomes = np.zeros(n, np.int64)
        self.terms = np.zeros((n, k.TERMS))
        """Terms of the reward of the last step (count, 4)."""
        self.observations = np.zeros((n, s.width), np.float32)
        self._everyone = np.arange(n)
        self._weights = s.weights.row
        self._control = CONTROLS[s.control]

    def put(self, arms: np.ndarray, places: np.ndarray) -> None:
        """Put arms (m,) at the start of situations (m,) of the pool, and observe."""
        state = self.state
        state.place[arms] = places
        state.hand[arms, 0] = self.pool.world.arms[places, k.START]
        state.hand[arms, 1] = 0.0
        state.time[arms] = 0.0
        self.observe(arms)

    def observe(self, arms: np.ndarray | None = None) -> np.ndarray:
        """Renew what arms are told; by default all."""
        s = self.settings
        chosen = self._everyone if arms is None else arms
        observe_all(self.pool.world, self.state, chosen, s.slots, s.fan, s.dt, self.observations)
        return self.observations

    def move(self, actions: np.ndarray) -> np.ndarray:
        """One step of every arm, and what they are told then: the outcomes (count,)."""
        s = self.settings
        play_all(
            self.pool.world, self.state, actions, self._control, s.joint_rate, s.dt,
            self._weights, s.discount, s.slots, s.fan, self.outcomes, self.terms,
            self.observations,
        )  # fmt: skip
        return self.outcomes
