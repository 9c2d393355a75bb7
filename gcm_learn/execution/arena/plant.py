"""Arms without mass, which follow commands as nearly as their limits allow."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from gcm_learn.arms import PLANAR, SPATIAL, Arm, ByKind, SpatialArm
from gcm_learn.execution.arena.batch import Batch
from gcm_learn.motion import Movement


def way_of(arm: Any, time: np.ndarray, posture: np.ndarray) -> Any:
    """Return the trajectory of an arm from the times (m,) and the postures (m, k) of its plant."""
    return _WAYS.of(arm)(arm, time, posture)


def _way_of_hand(arm: Arm, time: np.ndarray, posture: np.ndarray) -> Movement:
    return Movement.of_hand(arm, time, posture)


def _way_of_joints(arm: SpatialArm, time: np.ndarray, posture: np.ndarray) -> Movement:
    new = np.append(True, np.diff(time) > 0.0)  # a catch at t = 0 takes no time
    dof = len(arm.joints)
    joints, rates = posture[new, :dof], posture[new, dof:]
    limited = arm.max_joint_acceleration is not None
    return Movement(arm, time[new], joints, rates if limited else None)


_WAYS: ByKind[Callable[[Any, np.ndarray, np.ndarray], Any]] = ByKind(
    {PLANAR: _way_of_hand, SPATIAL: _way_of_joints}, who="the arena"
)


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
