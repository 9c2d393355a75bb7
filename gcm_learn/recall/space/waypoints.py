"""Waypoints of a spatial arm: catches as memory keeps them, in the joints of a left arm."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.arms import SpatialArm
from gcm_learn.motion import SpatialTrajectory, opening
from gcm_learn.planners import Plan, study_of
from gcm_learn.recall.space.kernels import (
    COLUMNS,
    EARLIEST,
    KNOTS,
    TIME,
    centre_of,
    least_times,
)
from gcm_learn.recall.waypoints import SLOW, knot_times
from gcm_learn.scene import pack
from gcm_learn.situation import Situation, canonical

CLOSE = 1e-2  # knots are put where the joints would be farther off than this [rad]
RESTS = 10.0  # as `SLOW`, of a movement that takes time to come to its speed
LOOKS = 97  # at a curved movement, for where it bends
GOAL = 6


class SpatialWaypoints(NamedTuple):
    """A catch of a spatial arm as memory keeps it."""

    knots: np.ndarray
    """(KNOTS, 6) float32: joints of the left arm [rad], time [s], and the earliest time at which
    they should be there [s]: that time after a wait, else 0."""
    goal: np.ndarray
    """(6,) float32: where the target's centre is when it is caught, and the hand from it, in the
    frame of the left arm's base [reaches]."""

    @property
    def catch_time(self) -> float:
        """Of the last knot [s]."""
        return float(self.knots[-1, TIME])


def waypoints_in_space(
    situation: Situation[SpatialArm], plan: Plan[SpatialTrajectory]
) -> SpatialWaypoints:
    """The catch of a plan as memory keeps it."""
    path = plan.trajectory
    if path is None or plan.catch_body is None:
        raise ValueError(f"plan: {plan.status}, only catches can be remembered")
    turned, frame = canonical(situation)
    seen = path.time if path.rates is None else np.linspace(0.0, path.duration, LOOKS)
    time = knot_times(seen, frame.canonical_joints(path.joints_at(seen)), KNOTS, CLOSE)
    knots = np.zeros((KNOTS, COLUMNS), dtype=np.float32)
    at = frame.canonical_joints(path.joints_at(time))
    knots[:, :4], knots[:, TIME] = at, time
    scene = pack(turned)
    least = least_times(study_of(scene, opening(scene).rules), at)
    slow = np.diff(time) > (SLOW if path.rates is None else RESTS) * least + 1e-6
    knots[1:, EARLIEST] = np.where(slow, time[1:], 0.0)
    body = [b.name for b in situation.bodies].index(plan.catch_body)
    hand, centre = frame.canonical(path.hand[-1]), centre_of(scene.bodies, body, path.duration)
    goal = np.concatenate([centre, hand - centre]) / situation.arm.reach
    return SpatialWaypoints(knots, goal.astype(np.float32))
