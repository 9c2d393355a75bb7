"""Settings of arms that act step by step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cache, cached_property
from typing import TYPE_CHECKING, Any, ClassVar, Literal, TypeVar

import numpy as np

from gcm_learn import artifacts
from gcm_learn.arms import CHAIN, PLANAR, SPATIAL, ChainModel, Kind
from gcm_learn.errors import ArenaError, EncoderError, GcmError, not_known
from gcm_learn.execution.arena.kernels.world import HAND_VELOCITY, JOINT_VELOCITY, Options
from gcm_learn.execution.arena.kinds import KERNELS, Layout, sizes_of
from gcm_learn.execution.arena.pool import Pool, of_one_kind, stops
from gcm_learn.situation import Situation, read_arm, shipped_arm

if TYPE_CHECKING:
    from gcm_learn.recall import Encoder


FARTHEST = 100.0  # number of an embedding


@cache
def encoder() -> Encoder:
    """Return the encoder among the models; raise EncoderError if it is missing."""
    from gcm_learn.recall import CONFIG, load_encoder

    folder = artifacts.model("encoder", CONFIG)
    if folder is None:
        make = f"gcm-learn train encoder DATASET --out {artifacts.own('models') / 'encoder'}"
        raise EncoderError(artifacts.missing("models", "encoder", make))
    return load_encoder(folder)


def embeddings_of(situations: Sequence[Situation]) -> np.ndarray:
    """Embeddings (s, dim) float32 of situations."""
    found = np.array([encoder().embed_situation(situation) for situation in situations])
    return np.clip(found, -FARTHEST, FARTHEST)


CONTROLS = {"hand": HAND_VELOCITY, "joint": JOINT_VELOCITY}
OUTCOMES = ("running", "caught", "touched", "late")  # by the kernels' codes
TERMS = ("catch", "touch", "haste", "guide")


@dataclass(frozen=True)
class Weights:
    """Weights of the terms of the reward, each of which is in ``info["reward_terms"]``."""

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
class ArenaSettings:
    """Settings of arms of every kind."""

    kind: ClassVar[Kind]
    """Kind of the arms."""
    has_fan: ClassVar[bool] = True
    """True if observations may end with a fan."""

    dt: float = 0.02
    """Length of a step [s]; the last one of an episode may be shorter."""
    slots: int = 4
    """Obstacles in an observation: for planar arms those that come nearest on the straight way,
    for other arms those that are nearest to the limb."""
    discount: float = 0.99
    """Of the learner, for the shaping."""
    weights: Weights = field(default_factory=Weights)
    fan: bool = False
    """If true, the observation ends with the fan: for planar arms the free way in each of 24
    directions, for spatial arms the results of 30 commands about the straight one."""

    def __post_init__(self) -> None:
        if not 1e-4 <= self.dt <= 1.0:
            raise ArenaError(f"dt: must be from 0.0001 to 1 s (got {self.dt!r})")
        if not isinstance(self.slots, int) or not 0 <= self.slots <= 64:
            raise ArenaError(f"slots: must be a whole number from 0 to 64 (got {self.slots!r})")
        if not 0.0 < self.discount <= 1.0:
            raise ArenaError(f"discount: must be above 0 and at most 1 (got {self.discount!r})")
        if self.fan and not self.has_fan:
            raise ArenaError(f"fan: {self.kind.plural} have none")

    @property
    def pushed(self) -> bool:
        """Return whether actions are torques."""
        return False

    @cached_property
    def model(self) -> ChainModel | None:
        """Model of the arms, for kinds with varying numbers of joints and links; else None."""
        return None

    @cached_property
    def layout(self) -> Layout:
        """Counts of the numbers of actions and observations."""
        return KERNELS.of(self.kind).layout(self.model)

    @property
    def commands(self) -> int:
        """Numbers that command an arm."""
        return self.layout.commands

    @property
    def weighted(self) -> np.ndarray:
        """Weights (4,), in the order of TERMS."""
        return np.array([float(getattr(self.weights, name)) for name in TERMS])

    @property
    def fan_at(self) -> int:
        """Index in an observation at which the fan begins."""
        layout = self.layout
        return layout.arm + layout.target + self.slots * layout.obstacle

    @property
    def width(self) -> int:
        """Length of an observation without an embedding."""
        return self.fan_at + (self.layout.fan if self.fan else 0)

    @property
    def straight(self) -> int:
        """Index of the direction, or of the command, that leads straight to the target."""
        return self.layout.straight

    @property
    def options(self) -> tuple[Any, ...]:
        """`Options`, as a plain tuple."""
        return tuple(Options(self.dt, self.weighted, self.discount, self.slots, self.fan))

    def prepared(self, pool: Pool) -> Pool:
        """Return a pool with everything that episodes under these settings need.

        Raises
        ------
        ArenaError
            If an episode cannot begin in one of its situations.
        """
        return pool


@dataclass(frozen=True)
class Settings(ArenaSettings):
    """Settings of planar arms, with the defaults of ``CatchArm-v0``."""

    kind: ClassVar[Kind] = PLANAR

    control: Literal["hand", "joint"] = "hand"
    """Actions are velocities of the hand, or of the joints."""
    embedding: bool = False
    """If true, the observation ends with an encoder's embedding of the situation."""
    joint_rate: float = 2.0
    """Fastest joint under joint control, if the situation has no limit [hand speeds / forearm]."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.control not in CONTROLS:
            raise ArenaError(f"control: {self.control!r} is not one of {', '.join(CONTROLS)}")
        if not 0.0 < self.joint_rate < 1e3:
            raise ArenaError(f"joint_rate: must be above 0 (got {self.joint_rate!r})")

    @property
    def options(self) -> tuple[Any, ...]:
        """`Options`, as a plain tuple."""
        common = Options(*super().options)
        return tuple(common._replace(control=CONTROLS[self.control], joint_rate=self.joint_rate))

    def prepared(self, pool: Pool) -> Pool:
        """Add maps' times to go and embeddings, if the settings want them."""
        of_one_kind(pool.situations[:1], self.kind)
        if self.weights.guide != 0.0 and not len(pool.world.fields):
            from gcm_learn.execution.arena.guidance import fields_of

            pool = pool.guided(fields_of(pool.situations))
        if self.embedding and not pool.embeddings.shape[1]:
            pool = replace(pool, embeddings=embeddings_of(pool.situations))
        return pool


@dataclass(frozen=True)
class SpatialSettings(ArenaSettings):
    """Settings of spatial arms, with the defaults of ``CatchArm3D-v0``."""

    kind: ClassVar[Kind] = SPATIAL

    def prepared(self, pool: Pool) -> Pool:
        """Refuse arms that are too fast at t = 0 to be stopped in steps as long as these."""
        of_one_kind(pool.situations[:1], self.kind)
        for situation in pool.situations:
            if not stops(situation, self.dt):
                name, dt = situation.name, self.dt
                raise ArenaError(f"situation {name!r}: the arm cannot stop in steps of {dt} s")
        return pool


@dataclass(frozen=True)
class ChainSettings(SpatialSettings):
    """Settings of chains, with the defaults of ``CatchChain-v0``."""

    kind: ClassVar[Kind] = CHAIN
    has_fan: ClassVar[bool] = False

    arm: str = "panda"
    """Name of an arm that ships, or the path of an arm file, which ends in ``.json``."""

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "arm", str(self.arm))
        assert self.model

    @cached_property
    def model(self) -> ChainModel:
        """Model of the arms; its joints and links determine the length of observations."""
        try:
            return read_arm(self.arm) if self.arm.endswith(".json") else shipped_arm(self.arm)
        except GcmError as error:
            raise ArenaError(f"arm: {str(error).removeprefix(': ')}") from None

    def prepared(self, pool: Pool) -> Pool:
        """Refuse arms of other sizes than the model's, and arms that cannot stop."""
        of_one_kind(pool.situations[:1], self.kind)
        found, wanted = sizes_of(pool.situations[0].arm.model), sizes_of(self.model)
        if found != wanted:
            reason = f"has {wanted}, that of situation {pool.situations[0].name!r} {found}"
            raise ArenaError(f"arm: {self.arm!r} {reason}")
        return super().prepared(pool)


Chosen = TypeVar("Chosen", bound=ArenaSettings)


def settings_of(
    made: type[Chosen], settings: ArenaSettings | Mapping[str, Any] | None = None, **more: Any
) -> Chosen:
    """Return settings from their fields.

    Parameters
    ----------
    made : type
        Class of the settings.
    settings : ArenaSettings or mapping, optional
        Settings of that class, or fields of them; those of `Weights` under "weights".
    **more
        Fields that count instead, where they are not None.

    Raises
    ------
    ArenaError
        With the field that is not known or out of its range.
    """
    known = {f.name for f in fields(made)}
    given = {name: value for name, value in more.items() if value is not None}
    if isinstance(settings, made):
        _check_names("settings", given, known)
        return replace(settings, **given)
    if not isinstance(settings, Mapping | None):
        raise ArenaError(f"settings: must be {made.__name__} (got {type(settings).__name__})")
    values = dict(settings or {}) | given
    _check_names("settings", values, known)
    weights = values.get("weights")
    if isinstance(weights, Mapping):
        _check_names("settings.weights", weights, set(TERMS))
        values["weights"] = Weights(**weights)
    return made(**values)


def _check_names(where: str, values: Mapping[str, Any], known: set[str]) -> None:
    """Refuse fields that are not known."""
    unknown = sorted(set(values) - known)
    if unknown:
        raise ArenaError(f"{where}: {unknown[0]!r} {not_known(unknown[0], known)}")
