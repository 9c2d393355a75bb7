"""What can be chosen about arms that act step by step."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any, Literal, TypeVar

import numpy as np

from gcm_learn.errors import ArenaError
from gcm_learn.execution import fan as rays
from gcm_learn.execution import observation as o
from gcm_learn.execution.physics.model import STEP
from gcm_learn.execution.space import fan as space_fan
from gcm_learn.execution.space import observation as space
from gcm_learn.execution.space.world import SpatialOptions
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
class CommonSettings:
    """What can be chosen about arms in the plane and in space."""

    dt: float = 0.02
    """A step [s]; the last one of an episode may be shorter."""
    slots: int = 4
    """Obstacles that are told: in the plane those that come nearest on the straight way, in space
    those that are nearest to the limb."""
    discount: float = 0.99
    """Of the learner, for the shaping."""
    weights: Weights = field(default_factory=Weights)

    def __post_init__(self) -> None:
        if not 1e-4 <= self.dt <= 1.0:
            raise ArenaError(f"dt: must be from 0.0001 to 1 s (got {self.dt!r})")
        if not isinstance(self.slots, int) or not 0 <= self.slots <= 64:
            raise ArenaError(f"slots: must be a whole number from 0 to 64 (got {self.slots!r})")
        if not 0.0 < self.discount <= 1.0:
            raise ArenaError(f"discount: must be above 0 and at most 1 (got {self.discount!r})")

    @property
    def weighted(self) -> np.ndarray:
        """The weights (4,), in the order of TERMS."""
        return np.array([float(getattr(self.weights, name)) for name in TERMS])


@dataclass(frozen=True)
class Settings(CommonSettings):
    """What can be chosen; the defaults are those of ``CatchArm-v0``."""

    control: Literal["hand", "joint"] = "hand"
    """Whether actions are velocities of the hand or of the joints."""
    fan: bool = False
    """Whether the observation ends with how far the hand can go in each of 24 directions."""
    embedding: bool = False
    """Whether the observation ends with an encoder's embedding of the situation."""
    joint_rate: float = 2.0
    """Fastest joint under joint control, if the situation has no limit [hand speeds / forearm]."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.control not in CONTROLS:
            raise ArenaError(f"control: {self.control!r} is not one of {', '.join(CONTROLS)}")
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
        made = Options(
            CONTROLS[self.control], self.joint_rate, self.dt, self.weighted, self.discount,
            self.slots, self.fan,
        )  # fmt: skip
        return tuple(made)


@dataclass(frozen=True)
class SpatialSettings(CommonSettings):
    """What can be chosen about arms in space; the defaults are those of ``CatchArm3D-v0``."""

    fan: bool = False
    """Whether the observation goes on with what becomes of 30 commands about the straight one."""

    @property
    def width(self) -> int:
        """Length of an observation."""
        fan = space_fan.FRAME + space_fan.COMMANDS * space_fan.RAY if self.fan else 0
        return self.fan_at + fan

    @property
    def fan_at(self) -> int:
        """Where the fan begins in an observation, with its frame."""
        return space.ARM + space.TARGET + self.slots * space.OBSTACLE

    @property
    def straight(self) -> int:
        """Where the command that goes straight begins in an observation."""
        return space.AIM

    @property
    def options(self) -> tuple[Any, ...]:
        """`SpatialOptions`, as a plain tuple."""
        return tuple(SpatialOptions(self.dt, self.weighted, self.discount, self.slots, self.fan))


@dataclass(frozen=True)
class PhysicalSettings(SpatialSettings):
    """What can be chosen about arms with mass; the defaults are those of ``CatchArmPhysics-v0``."""

    control: Literal["joint", "torque"] = "joint"
    """Whether actions are rates of the joints, which motors servo, or torques."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.control not in ("joint", "torque"):
            raise ArenaError(f"control: {self.control!r} is not one of joint, torque")
        if abs(self.dt / STEP - round(self.dt / STEP)) > 1e-9:
            raise ArenaError(f"dt: must be whole steps of physics, of {STEP} s (got {self.dt!r})")

    @property
    def width(self) -> int:
        """Length of an observation."""
        return super().width + (8 if self.control == "torque" else 0)

    @property
    def straight(self) -> int:
        """Where the command that goes straight begins."""
        return self.width - 4 if self.control == "torque" else super().straight


Chosen = TypeVar("Chosen", Settings, SpatialSettings, PhysicalSettings)


def settings_of(
    settings: Settings | Mapping[str, Any] | None,
    control: str | None = None,
    fan: bool | None = None,
    embedding: bool | None = None,
) -> Settings:
    """Settings in the plane from their fields.

    Raises
    ------
    ArenaError
        With the field that is not known or out of its range.
    """
    given: dict[str, Any] = {"control": control, "fan": fan, "embedding": embedding}
    known = {name: value for name, value in given.items() if value is not None}
    return replace(made_of(Settings, settings), **known)


def made_of(kind: type[Chosen], settings: Chosen | Mapping[str, Any] | None) -> Chosen:
    """Settings of a kind from their fields; raises as `settings_of`."""
    if isinstance(settings, kind):
        return settings
    if not isinstance(settings, Mapping | None):
        raise ArenaError(f"settings: must be {kind.__name__} (got {type(settings).__name__})")
    values: dict[str, Any] = dict(settings or {})
    unknown = sorted(set(values) - set(kind.__dataclass_fields__))
    if unknown:
        raise ArenaError(f"settings: {unknown[0]!r} is not a known field")
    weights = values.get("weights")
    if isinstance(weights, Mapping):
        strange = sorted(set(weights) - set(TERMS))
        if strange:
            raise ArenaError(f"settings.weights: {strange[0]!r} is not one of {TERMS}")
        values["weights"] = Weights(**weights)
    return kind(**values)
