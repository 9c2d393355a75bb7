"""Arms in the plane that do at once what they are told: one, or many side by side."""

from __future__ import annotations

import numpy as np

from gcm_learn.arms import PlanarLimb
from gcm_learn.compiled import njit
from gcm_learn.execution.batch import Batch
from gcm_learn.execution.embedding import FARTHEST
from gcm_learn.execution.observation import EXTREME, observe
from gcm_learn.execution.pool import Pool
from gcm_learn.execution.settings import Settings
from gcm_learn.execution.stepping import step
from gcm_learn.execution.world import HORIZON, Options, State, Told, World, workspace_for

_HAND = PlanarLimb._fields.index("x")


class KinematicPlant(Batch):
    """Planar arms.

    Parameters
    ----------
    pool : Pool
    count : int
    settings : Settings
    threads : int
        As `Batch` has them.
    """

    commands = 2

    def __init__(self, pool: Pool, count: int, settings: Settings, threads: int = 1) -> None:
        self.pool, self.settings = pool.prepared(settings), settings
        super().__init__(count, settings.width + self.pool.embeddings.shape[1], threads)
        self.state = State(np.zeros(count, np.int64), np.zeros((count, 2)), np.zeros(count))
        # Plain tuples: of named ones, finding the types takes as long as a step.
        self._arms, self._options = tuple(self.state), settings.options
        self._told, self._world = tuple(self.told), tuple(self.pool.world)

    @property
    def bounds(self) -> np.ndarray:
        """As `Batch` says."""
        out = np.full(self.observations.shape[1], EXTREME, np.float32)
        out[self.settings.width :] = FARTHEST
        return out

    @property
    def posture(self) -> np.ndarray:
        """The hands (count, 2)."""
        return self.hand

    def put(self, arms: np.ndarray, places: np.ndarray) -> None:
        """As `Batch` says."""
        state, self._world = self.state, tuple(self.pool.world)  # the pool may be another now
        state.place[arms] = places
        state.hand[arms] = self.pool.world.limbs[places, _HAND:]
        state.time[arms] = 0.0
        self.observations[arms, self.settings.width :] = self.pool.embeddings[places]
        _observe_all(self._world, self._arms, arms, self._options, self.observations)

    def _play(self, actions: np.ndarray, first: int, last: int) -> None:
        _play(self._world, self._arms, actions, self._options, self._told, first, last)

    def hold(self, arms: np.ndarray) -> None:
        """As `Batch` says."""
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
