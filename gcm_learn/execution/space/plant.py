"""Arms in space that do at once what they are told, as nearly as their limits let them."""

from __future__ import annotations

import numpy as np

from gcm_learn.arms.spatial_limb import limb_at
from gcm_learn.compiled import njit
from gcm_learn.execution.batch import Batch
from gcm_learn.execution.pool import SpatialPool
from gcm_learn.execution.settings import SpatialSettings
from gcm_learn.execution.space.observation import EXTREME, observe_in_space
from gcm_learn.execution.space.stepping import step_in_space
from gcm_learn.execution.space.world import (
    HORIZON,
    SpatialOptions,
    SpatialState,
    SpatialWorld,
    view_in,
    views_for,
)
from gcm_learn.execution.world import Told

_START = slice(23, 31)  # columns of a world's limbs: joints and rates at t = 0


class SpatialPlant(Batch):
    """Arms in space.

    Parameters
    ----------
    pool : SpatialPool
    count : int
    settings : SpatialSettings
    threads : int
        As `Batch` has them.
    """

    commands = 4

    def __init__(
        self, pool: SpatialPool, count: int, settings: SpatialSettings, threads: int = 1
    ) -> None:
        self.pool, self.settings = pool.prepared(settings), settings
        super().__init__(count, settings.width, threads)
        self.state = SpatialState(
            np.zeros(count, np.int64), np.zeros((count, 8)), np.zeros((count, 3)), np.zeros(count)
        )
        self._arms, self._options = tuple(self.state), settings.options
        self._told, self._world = tuple(self.told), tuple(self.pool.world)

    @property
    def bounds(self) -> np.ndarray:
        """As `Batch` says."""
        return np.full(self.settings.width, EXTREME, np.float32)

    @property
    def posture(self) -> np.ndarray:
        """Joints [rad] and their rates [rad/s] (count, 8)."""
        return self.state.posture

    def put(self, arms: np.ndarray, places: np.ndarray) -> None:
        """As `Batch` says."""
        state, self._world = self.state, tuple(self.pool.world)  # the pool may be another now
        state.place[arms] = places
        state.posture[arms] = self.pool.world.limbs[places, _START]
        state.time[arms] = 0.0
        observe_all(self._world, self._arms, arms, self._options, self.observations)

    def _play(self, actions: np.ndarray, first: int, last: int) -> None:
        _play(self._world, self._arms, actions, self._options, self._told, first, last)

    def hold(self, arms: np.ndarray) -> None:
        """As `Batch` says."""
        self.state.time[arms] = self.pool.world.limits[self.state.place[arms], HORIZON]


@njit(nogil=True)
def observe_all(world, state, chosen, options, out):
    """Write what the arms `chosen` (k,) are told into their rows of `out`, and where hands are."""
    worlds, states, how = SpatialWorld(*world), SpatialState(*state), SpatialOptions(*options)
    room = views_for(worlds, states, 0, states.place.size)
    for k in range(chosen.size):
        e = chosen[k]
        view = view_in(worlds, states.place[e], room)
        observe_in_space(view, states.time[e], states.posture, e, how, out[e])
        _, _, _, x, y, z = limb_at(view.scene.limb, view.joints[0])
        states.hand[e, 0], states.hand[e, 1], states.hand[e, 2] = x, y, z


@njit(nogil=True)
def _play(world, state, actions, options, told, first, last):
    """Arms first to last - 1 make a step and are told of it."""
    worlds, states, how = SpatialWorld(*world), SpatialState(*state), SpatialOptions(*options)
    out = Told(*told)
    room = views_for(worlds, states, first, last)
    for e in range(first, last):
        view = step_in_space(worlds, states, e, actions, how, out, room)
        row = out.observations[e]
        observe_in_space(view, states.time[e], states.posture, e, how, row)
