"""Chains to draw: a model by name or file, and the ranges of what a situation gives it."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from gcm_learn.arms import Chain, ChainModel
from gcm_learn.checks import show
from gcm_learn.errors import FamilyError, FileFormatError, SituationError
from gcm_learn.families.paper import EARTH
from gcm_learn.families.ranges import Range, Ranges, number, pick, positives, span
from gcm_learn.situation import arm_from_json, read_arm, shipped_arm


@lru_cache(maxsize=32)
def model_of(name: str) -> ChainModel:
    """Return the model of an arm that ships, of an arm file, or of its text; read once.

    Raises
    ------
    FamilyError
        In one line that names the field, for an unknown name or a bad file.
    """
    try:
        if name.startswith("{"):
            return arm_from_json(json.loads(name))
        return read_arm(Path(name)) if name.endswith(".json") else shipped_arm(name)
    except (FileFormatError, SituationError) as error:
        raise FamilyError("model", str(error).removeprefix(": ")) from None


@dataclass(frozen=True)
class ChainArmRanges(Ranges):
    """Ranges of a chain and of the duration of situations; a reach is `Chain.reach`."""

    model: str = field(default="panda")
    """Name of an arm that ships, the path of an arm file, which ends in ``.json``, or its text."""
    metres: float = number(1.0, 1e-6, 1e6)
    """Length of the arm's unit [m]."""
    horizon: Range = span(1.0, 2.0, 1e-3)
    """Last moment at which a catch counts [s]."""
    grasp: Range = span(0.028, 0.028)
    """Distance at which the hand catches [reaches]."""
    hand_speed: Range = span(0.0, 0.0)
    """Limit of the hand's speed [reaches/s]; at 0 nothing limits it."""
    accelerations: tuple[float, ...] = positives()
    """Limits of the joints' accelerations; the model's when empty [rad/s^2 or lengths/s^2]."""
    moving: float = number(0.0, most=0.99)
    """Largest rate of a joint at t = 0 where accelerations are limited [of its full speed]."""
    floor: float = number(1.0)
    """Share of arms that stand on a floor; arms that are mostly below it have none."""
    floor_height: Range = span(0.0, 0.0, -10.0, 10.0)
    """Height of the floor above the base [reaches]."""

    def __post_init__(self) -> None:
        """Check the fields, the model and the number of limits."""
        super().__post_init__()
        dof = model_of(self.model).dof
        if self.accelerations and len(self.accelerations) != dof:
            reason = f"must have {dof} limits, one for each joint (got {show(self.accelerations)})"
            raise FamilyError("accelerations", reason)

    @property
    def gravity(self) -> float:
        """Acceleration of what falls [lengths/s^2]."""
        return EARTH / self.metres

    def arm(self, rng: np.random.Generator) -> Chain:
        """Draw a chain in any posture, its base at the origin."""
        model = model_of(self.model)
        middle = tuple(0.5 * (low + high) for low, high in model.ranges)
        given: dict[str, Any] = {}
        if self.accelerations:
            given["max_joint_acceleration"] = self.accelerations
        arm = Chain(model, middle, 0.0, **given)
        speed = pick(rng, self.hand_speed) * arm.reach
        return Chain(
            model,
            middle,
            pick(rng, self.grasp) * arm.reach,
            max_hand_speed=speed if speed > 0.0 else None,
            **given,
        )

    def rates(self, rng: np.random.Generator, arm: Chain) -> tuple[float, ...] | None:
        """Draw rates at t = 0 (n,) of an arm with limits of acceleration; else return None."""
        if arm.max_joint_acceleration is None:
            return None
        top = np.array(arm.max_joint_speed)
        return tuple((self.moving * top * rng.uniform(-1.0, 1.0, top.size)).tolist())
