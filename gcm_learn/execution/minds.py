"""Agents of the closed loop: planners that think once, always or when they must, and commands."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol

import numpy as np

from gcm_learn.arms import SpatialArm
from gcm_learn.errors import ArenaError
from gcm_learn.execution.closed_loop import Occasion
from gcm_learn.execution.episode import way_of
from gcm_learn.execution.exact import ExactPlant
from gcm_learn.execution.settings import SpatialSettings
from gcm_learn.execution.space.one_step import OneStep
from gcm_learn.execution.world import CAUGHT
from gcm_learn.motion import SpatialTrajectory
from gcm_learn.situation import Situation

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
    """An agent that tells its joints how fast to turn, anew in every period: a learned policy.

    It is told what the arena would tell it in the world that is believed, and what the arm's
    limits forbid is cut off as there.
    """

    policy: Callable[[np.ndarray], np.ndarray]
    """Commands (1, 4) under observations (1, width), in greatest joint speeds."""
    settings: SpatialSettings = field(default_factory=SpatialSettings)
    """What it is told; a command holds for a step."""

    def wants(self, occasion: Occasion) -> bool:
        """It always does."""
        return True

    def plan(self, believed: Situation[SpatialArm]) -> SpatialTrajectory | None:
        """The movement of the next step; after it the arm would come to rest."""
        step = OneStep(believed, self.settings)
        posture = np.stack([step.posture, step.after(self.policy(step.told)[0])])
        return way_of(believed.arm, np.array([0.0, self.settings.dt]), posture)
