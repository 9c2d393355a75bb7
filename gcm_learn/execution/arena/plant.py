"""Arms without mass, which follow commands as nearly as their limits allow."""

from __future__ import annotations

from typing import Any

import numpy as np

from gcm_learn.execution.arena.batch import Batch
from gcm_learn.execution.arena.ways import way_of


class KinematicPlant(Batch):
    """Kinematic arms of any kind.

    Parameters
    ----------
    pool : Pool
    count : int
    settings : ArenaSettings
    threads : int
        As `Batch` has them.
    """

    def way(self, e: int, time: np.ndarray, posture: np.ndarray) -> Any:
        """As `Batch` says."""
        return way_of(self.pool.situations[self.state.place[e]].arm, time, posture)

    def _begin(self, arms: np.ndarray, places: np.ndarray) -> None:
        self.state.posture[arms] = self.pool.starts[places]

    def _play(self, actions: np.ndarray, first: int, last: int) -> None:
        self._kernels.play(self._world, self._arms, actions, self._options, self._told, first, last)
