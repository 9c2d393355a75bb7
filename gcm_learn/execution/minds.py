"""Agents of the closed loop: planners that think once, always or when they must, and commands."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, Protocol

import numpy as np

from gcm_learn.errors import ArenaError
from gcm_learn.execution.closed_loop import Occasion
from gcm_learn.execution.exact import ExactPlant
from gcm_learn.execution.perception import PERIOD
from gcm_learn.execution.world import CAUGHT
from gcm_learn.motion import SpatialTrajectory
from gcm_learn.situation import Situation, SpatialArm

HABITS = ("once", "always", "broken")


class SpatialPlanner(Protocol):
    """A planner of arms in space."""

    def plan(self, situation: Situation[SpatialArm]) -> Any:
        """Answer a situation; the answer's `trajectory` is None if there is no catch."""


@dataclass(frozen=True)
class Planning:
    """An agent that follows what a planner finds."""

    planner: SpatialPlanner
    habit: Literal["once", "always", "broken"] = "broken"
    """When it thinks: once; whenever it is done with the last thought; or when what is followed
    does not catch any more, in the world as it is believed to be."""

    def __post_init__(self) -> None:
        if self.habit not in HABITS:
            raise ArenaError(f"habit: must be one of {', '.join(HABITS)} (got {self.habit!r})")

    def wants(self, occasion: Occasion) -> bool:
        """Whether it thinks now."""
        if self.habit == "once":
            return occasion.thoughts == 0
        return self.habit == "always" or not holds(occasion)

    def plan(self, believed: Situation[SpatialArm]) -> SpatialTrajectory | None:
        """The planner's movement."""
        found: SpatialTrajectory | None = self.planner.plan(believed).trajectory
        return found


def holds(occasion: Occasion) -> bool:
    """Whether what is followed catches in the world that is believed.

    It is judged as what is done is judged: the limb over every instant until a target is met. The
    arm's own limits do not change with the world.
    """
    believed = ExactPlant(occasion.believed)
    believed.follow(occasion.left, occasion.believed.horizon)
    return believed.outcome == CAUGHT


@dataclass(frozen=True)
class Commanding:
    """An agent that tells its joints how fast to turn, anew in every period: a learned policy."""

    policy: Callable[[Situation[SpatialArm]], np.ndarray]
    """Wanted rates (4,) of the joints [rad/s]; what the arm's limits forbid is cut off."""
    period: float = PERIOD
    """For which a command holds [s]."""

    def wants(self, occasion: Occasion) -> bool:
        """It always does."""
        return True

    def plan(self, believed: Situation[SpatialArm]) -> SpatialTrajectory | None:
        """The movement of the next period; after it the arm would come to rest."""
        arm, span = believed.arm, self.period
        start, most = np.array(arm.joints), np.array(arm.max_joint_speed)
        wanted = np.clip(self.policy(believed), -most, most)
        low, high = np.array(arm.joint_range).T
        if arm.max_joint_acceleration is None:
            end = np.clip(start + span * wanted, low, high)
            return SpatialTrajectory(arm, np.array([0.0, span]), np.stack([start, end]))
        rates, force = np.array(arm.joint_rates), np.array(arm.max_joint_acceleration)
        up = _fastest(high - start - 0.5 * span * rates, force, span)
        down = _fastest(start - low + 0.5 * span * rates, force, span)
        change = np.clip(np.clip(wanted, -down, up) - rates, -force * span, force * span)
        end = np.clip(start + span * (rates + 0.5 * change), low, high)
        return SpatialTrajectory(
            arm, np.array([0.0, span]), np.stack([start, end]), np.stack([rates, rates + change])
        )


def _fastest(room: np.ndarray, force: np.ndarray, span: float) -> np.ndarray:
    """Rates v (4,) from which a joint can still stop: v span + v^2 / (2 force) is the room.

    That is what it turns until it has that rate, what it takes to brake, and half a period's way
    since it is told in periods.
    """
    return force * (np.sqrt(span * span + 2.0 * np.maximum(room, 0.0) / force) - span)
