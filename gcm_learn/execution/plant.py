"""Arms that do at once what they are told: one, or many side by side, each in its situation."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from gcm_learn.compiled import njit
from gcm_learn.execution.embedding import FARTHEST
from gcm_learn.execution.observation import EXTREME, observe
from gcm_learn.execution.pool import Pool
from gcm_learn.execution.settings import Settings
from gcm_learn.execution.stepping import TERMS, step
from gcm_learn.execution.world import HORIZON, Options, State, Told, World, workspace_for
from gcm_learn.scene import Limb

_HAND = Limb._fields.index("x")


@dataclass
class KinematicPlant:
    """Arms that move, catch and touch; nothing of it is drawn at random.

    The arrays are renewed in place at every step: copy what is to be kept. One arm is a batch of
    one.
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
        self.state = State(np.zeros(n, np.int64), np.zeros((n, 2)), np.zeros(n))
        width = s.width + self.pool.embeddings.shape[1]
        self.told = Told(np.zeros(n, np.int64), np.zeros((n, TERMS)), np.zeros((n, width), "f4"))
        self.observations = self.told.observations
        """What the arms are told (count, width) float32."""
        self.terms = self.told.terms
        """Of the rewards of the last step (count, 4)."""
        self.time = self.state.time
        """How long the arms have been under way (count,) [s]."""
        self.hand = self.state.hand
        """Hands (count, 2), in canonical coordinates of t = 0 [forearm lengths]."""
        # Plain tuples: of named ones, finding the types takes as long as a step.
        self._arms, self._options, self._told = tuple(self.state), s.options, tuple(self.told)
        self._world = tuple(self.pool.world)
        marks = np.linspace(0, n, min(self.threads, n) + 1).astype(int).tolist()
        self._shares = list(pairwise(marks))
        self._crew: ThreadPoolExecutor | None = None

    def __getstate__(self) -> dict[str, Any]:
        """All but the threads."""
        return {**self.__dict__, "_crew": None}

    @property
    def bounds(self) -> np.ndarray:
        """Largest sizes of the numbers of an observation (width,) float32."""
        out = np.full(self.observations.shape[1], EXTREME, np.float32)
        out[self.settings.width :] = FARTHEST
        return out

    @property
    def rewards(self) -> np.ndarray:
        """Of the last step (count,)."""
        return self.terms.sum(axis=1)

    def put(self, arms: np.ndarray, places: np.ndarray) -> None:
        """Put arms (m,) at the start of situations (m,) of the pool, and observe."""
        state, self._world = self.state, tuple(self.pool.world)  # the pool may be another now
        state.place[arms] = places
        state.hand[arms] = self.pool.world.limbs[places, _HAND:]
        state.time[arms] = 0.0
        self.observations[arms, self.settings.width :] = self.pool.embeddings[places]
        _observe_all(self._world, self._arms, arms, self._options, self.observations)

    def move(self, actions: np.ndarray) -> np.ndarray:
        """One step of every arm, and what they are told then: the outcomes (count,).

        Parameters
        ----------
        actions : (count, 2) ndarray
            As `envs.CatchArm` has them.
        """
        if len(self._shares) == 1:
            self._play(actions, 0, self.count)
            return self.told.outcomes
        if self._crew is None:
            self._crew = ThreadPoolExecutor(len(self._shares) - 1)
        (first, last), *others = self._shares
        waiting = [self._crew.submit(self._play, actions, *share) for share in others]
        self._play(actions, first, last)
        for share in waiting:
            share.result()
        return self.told.outcomes

    def _play(self, actions: np.ndarray, first: int, last: int) -> None:
        """One step of some arms."""
        _play(self._world, self._arms, actions, self._options, self._told, first, last)

    def hold(self, arms: np.ndarray) -> None:
        """Let arms (m,) whose episode is over stay where they are, at little cost."""
        self.state.time[arms] = self.pool.world.limits[self.state.place[arms], HORIZON]


@njit(nogil=True)
def _observe_all(world, state, chosen, options, out):
    """Write what the arms `chosen` (k,) are told into their rows of `out`."""
    worlds, states, how = World(*world), State(*state), Options(*options)
    workspace = workspace_for(worlds, states, 0, states.place.size)
    for k in range(chosen.size):
        observe(worlds, states, chosen[k], how, out, workspace)


@njit(nogil=True)
def _play(world, state, actions, options, told, first, last):
    """Arms first to last - 1 make a step and are told of it."""
    worlds, states, how, out = World(*world), State(*state), Options(*options), Told(*told)
    workspace = workspace_for(worlds, states, first, last)
    for e in range(first, last):
        step(worlds, states, e, actions, how, out, workspace)
        observe(worlds, states, e, how, out.observations, workspace)
