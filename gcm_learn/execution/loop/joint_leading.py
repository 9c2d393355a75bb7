"""Spatial arms and chains that are led along trajectories.

Trajectories are on the world's clock here: the first sample is the beginning.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, TypeVar

import numpy as np

from gcm_learn.arms import Chain, SpatialArm
from gcm_learn.motion import Movement, braked

Led = TypeVar("Led", SpatialArm, Chain)


def begun(arm: Led, plan: Movement, since: float) -> Movement:
    """A plan that begins at a time [s]; after its end the arm brakes to rest."""
    clocked = replace(plan, arm=arm, time=plan.time + since)
    if arm.max_joint_acceleration is None:
        return clocked
    return braked(clocked, np.array(arm.max_joint_acceleration))


def at_first(arm: Led) -> Movement:
    """Return the trajectory of an arm without a plan: it rests, or comes to rest."""
    rates = None if arm.joint_rates is None else np.array([arm.joint_rates])
    return begun(arm, Movement(arm, np.zeros(1), np.array([arm.joints]), rates), 0.0)


def led(arm: Led, trajectory: Movement, t: float) -> Led:
    """The arm as it stands and moves at a time [s] of a trajectory.

    Rounding beyond its limits is cut off.  Without limits of acceleration it may rest
    at any time, so its rates do not count.
    """
    joints, rates, _ = trajectory.states_at(np.array([t]))
    low, high = np.array(arm.joint_range).T
    there: Any = tuple(np.clip(joints[0], low, high).tolist())
    if arm.max_joint_acceleration is None:
        return replace(arm, joints=there)
    most = np.array(arm.max_joint_speed)
    moving: Any = tuple(np.clip(rates[0], -most, most).tolist())
    return replace(arm, joints=there, joint_rates=moving)


def gap(arm: Led, trajectory: Movement, t: float) -> float:
    """Largest difference between an arm's joints and a trajectory's at a time [rad]."""
    return float(np.abs(trajectory.joints_at(t) - np.array(arm.joints)).max())


def rest_of(trajectory: Movement, now: float) -> Movement:
    """Return the rest of a trajectory from now on [s], on a clock that begins now."""
    joints, rates, _ = trajectory.states_at(np.array([now]))
    after, moving = trajectory.time > now, None
    if trajectory.rates is not None:
        moving = np.vstack([rates.reshape(1, -1), trajectory.rates[after]])
    return Movement(
        trajectory.arm,
        np.append(0.0, trajectory.time[after] - now),
        np.vstack([joints, trajectory.joints[after]]),
        moving,
    )
