"""What can be chosen about arms that act step by step."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any, Literal

import numpy as np

from gcm_learn.errors import ArenaError
from gcm_learn.execution import fan as rays
from gcm_learn.execution import observation as o
from gcm_learn.execution.world import HAND_VELOCITY, JOINT_VELOCITY, Options

CONTROLS = {"hand": HAND_VELOCITY, "joint": JOINT_VELOCITY}
OUTCOMES = ("running", "caught", "touched", "late")  # by the kernels' codes
TERMS = ("catch", "touch", "haste", "guide")


@dataclass(frozen=True)
class Weights:
    """Of the terms of the reward; each is told in ``info["reward_terms"]``."""

    catch: float = 1.0
    """Given when the hand catches a target."""
    touch: float = 1.0
    """Taken when the limb touches an obstacle."""
    haste: float = 0.1
    """Taken for time: this much for a whole horizon."""
    guide: float = 0.0
    """Of the potential-based shaping (Ng, Harada and Russell, ICML 1999) by a cognitive map's
    time to go; see `guidance`."""

    def __post_init__(self) -> None:
        for f in fields(self):
            value = getattr(self, f.name)
            if not isinstance(value, (int, float)) or not 0.0 <= value < 1e6:
                raise ArenaError(f"weights.{f.name}: must be a number from 0 on (got {value!r})")


@dataclass(frozen=True)
class Settings:
    """What can be chosen; the defaults are those of ``CatchArm-v0``."""

    control: Literal["hand", "joint"] = "hand"
    """Whether actions are velocities of the hand or of the joints."""
    dt: float = 0.02
    """A step [s]; the last one of an episode may be shorter."""
    slots: int = 4
    """Obstacles that are told, those that come nearest on the straight way first."""
    fan: bool = False
    """Whether the observation ends with how far the hand can go in each of 24 directions."""
    embedding: bool = False
    """Whether the observation ends with an encoder's embedding of the situation."""
    joint_rate: float = 2.0
    """Fastest joint under joint control, if the situation has no limit [hand speeds / forearm]."""
    discount: float = 0.99
    """Of the learner, for the shaping."""
    weights: Weights = field(default_factory=Weights)

    def __post_init__(self) -> None:
        if self.control not in CONTROLS:
            raise ArenaError(f"control: {self.control!r} is not one of {', '.join(CONTROLS)}")
        if not 1e-4 <= self.dt <= 1.0:
            raise ArenaError(f"dt: must be from 0.0001 to 1 s (got {self.dt!r})")
        if not isinstance(self.slots, int) or not 0 <= self.slots <= 64:
            raise ArenaError(f"slots: must be a whole number from 0 to 64 (got {self.slots!r})")
        if not 0.0 < self.discount <= 1.0:
            raise ArenaError(f"discount: must be above 0 and at most 1 (got {self.discount!r})")
        if not 0.0 < self.joint_rate < 1e3:
            raise ArenaError(f"joint_rate: must be above 0 (got {self.joint_rate!r})")

    @property
    def width(self) -> int:
        """Length of an observation without an embedding."""
        fan = rays.RAYS * rays.RAY if self.fan else 0
        return o.ARM + o.TARGET + self.slots * o.OBSTACLE + fan

    @property
    def options(self) -> tuple[Any, ...]:
        """`Options`, as a plain tuple."""
        weights = np.array([float(getattr(self.weights, name)) for name in TERMS])
        made = Options(
            CONTROLS[self.control], self.joint_rate, self.dt, weights, self.discount, self.slots,
            self.fan,
        )  # fmt: skip
        return tuple(made)


def settings_of(
    settings: Settings | Mapping[str, Any] | None,
    control: str | None = None,
    fan: bool | None = None,
    embedding: bool | None = None,
) -> Settings:
    """Settings from their fields.

    Raises
    ------
    ArenaError
        With the field that is not known or out of its range.
    """
    if settings is None or isinstance(settings, Mapping):
        values = dict(settings or {})
        unknown = sorted(set(values) - set(Settings.__dataclass_fields__))
        if unknown:
            raise ArenaError(f"settings: {unknown[0]!r} is not a known field")
        weights = values.get("weights")
        if isinstance(weights, Mapping):
            strange = sorted(set(weights) - set(TERMS))
            if strange:
                raise ArenaError(f"settings.weights: {strange[0]!r} is not one of {TERMS}")
            values["weights"] = Weights(**weights)
        settings = Settings(**values)
    given: dict[str, Any] = {"control": control, "fan": fan, "embedding": embedding}
    return replace(settings, **{name: v for name, v in given.items() if v is not None})
