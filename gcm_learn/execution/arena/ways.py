"""Trajectories of arms from the samples of their plants."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from gcm_learn.arms import PLANAR, SPATIAL, Arm, ByKind, SpatialArm
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
