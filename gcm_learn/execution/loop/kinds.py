"""The table of arms that are led along trajectories."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Protocol

from gcm_learn.arms import CHAIN, PLANAR, SPATIAL, ByKind
from gcm_learn.execution.loop import hand_leading, joint_leading
from gcm_learn.scene import Scene


class Events(Protocol):
    """Events of an arm that follows trajectories exactly."""

    def first(self, trajectory: Any, since: float, until: float, /) -> tuple[int, float, int]:
        """Return outcome, time [s] and target of the first event between two times, or RUNNING."""


@dataclass(frozen=True)
class LedArm:
    """Functions of an arm that is led along trajectories on the world's clock."""

    forearm: Callable[[Any], float]
    """Length of an arm's forearm, the unit of perception."""
    begun: Callable[[Any, Any, float], Any]
    """Return the plan of an arm that begins at a time [s], with the way to rest after it."""
    at_first: Callable[[Any], Any]
    """Return the trajectory of an arm without a plan."""
    led: Callable[[Any, Any, float], Any]
    """Return an arm as it stands and moves at a time [s] of a trajectory."""
    gap: Callable[[Any, Any, float], float]
    """Return how far an arm is from a trajectory at a time [s], in rad or lengths."""
    rest_of: Callable[[Any, float], Any]
    """Return the rest of a trajectory from a time [s] on, on a clock that begins then."""
    events: Callable[[Scene], Events]


_SPATIAL = LedArm(
    lambda arm: math.hypot(*arm.forearm), joint_leading.begun, joint_leading.at_first,
    joint_leading.led, joint_leading.gap, joint_leading.rest_of, joint_leading.JointEvents,
)  # fmt: skip
LEADS = ByKind(
    {
        PLANAR: LedArm(
            lambda arm: 1.0, hand_leading.begun, hand_leading.at_first, hand_leading.led,
            hand_leading.gap, hand_leading.rest_of, hand_leading.HandEvents,
        ),
        SPATIAL: _SPATIAL,
        CHAIN: replace(_SPATIAL, forearm=lambda arm: 0.5 * arm.reach),
    },
    who="the closed loop",
)  # fmt: skip


def forearm_of(arm: Any) -> float:
    """Return the length of an arm's forearm; of a chain half its reach."""
    return LEADS.of(arm).forearm(arm)
