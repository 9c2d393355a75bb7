"""The table of arenas: situations, pool, settings and plant of each registered environment."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, TypeGuard, cast

from gcm_learn import seeding
from gcm_learn.arms import Kind
from gcm_learn.errors import ArenaError, UnknownNameError
from gcm_learn.execution.arena.batch import Batch, KinematicPlant
from gcm_learn.execution.arena.pool import Pool, of_one_kind, stops
from gcm_learn.execution.arena.settings import (
    ArenaSettings,
    ChainSettings,
    Settings,
    SpatialSettings,
)
from gcm_learn.execution.body.arms import ChainPhysicalSettings, PhysicalArms, PhysicalSettings
from gcm_learn.execution.body.bodies import pool_with_bodies
from gcm_learn.families import (
    PRESETS,
    Family,
    SpatialFamily,
    draw,
    family_names,
    get_family,
    with_arm,
)
from gcm_learn.motion import start_clearance
from gcm_learn.registration import NAMESPACE
from gcm_learn.scene import pack
from gcm_learn.situation import AnyArmBody, AnySituation, Situation, read_situations

Source = str | Path | Family | AnySituation | Sequence[Any]
SALT = 77  # of the draws for pools, so that item k of a family is not in all of them


def found_in(source: Source, count: int, seed: int) -> Sequence[AnySituation]:
    """Return situations of any kind of arm.

    Parameters
    ----------
    source : str, Path, Family, Situation or sequence of Situation
        A family's name or configuration, or a preset's name, from which `count` are drawn; a file
        of situations (``.json``, ``.jsonl``) or the folder of a dataset, of which the first
        `count` training records are taken; or situations.
    count : int
    seed : int
        Of the draws.

    Raises
    ------
    ArenaError
        If it is none of these, or holds nothing.
    """
    if isinstance(source, Situation):
        return [source]
    source = named(source)
    if is_drawn(source):
        return [item(source, seed, k) for k in range(count)]
    if isinstance(source, str | Path):
        return _read(Path(source), count)
    found: list[AnySituation] = list(source)  # type: ignore[arg-type]
    if not found or not all(isinstance(s, Situation) for s in found):
        raise ArenaError("situations: must be situations, at least one")
    return found


def is_drawn(source: Source) -> TypeGuard[str | Family]:
    """Return whether a source is a family or a preset, of which an index is drawn by itself."""
    return isinstance(source, Family) or (isinstance(source, str) and source in PRESETS)


def item(source: str | Family, seed: int, index: int) -> AnySituation:
    """Draw the situation at an index of a pool."""
    return draw(source, int(seeding.rng(seed, SALT).integers(2**62)), index)


def named(source: Source) -> Source:
    """Return the family of a name; return everything else unchanged."""
    return get_family(source) if isinstance(source, str) and source in family_names() else source


def _read(path: Path, count: int) -> Sequence[AnySituation]:
    if path.is_dir():
        from gcm_learn import dataset  # needs pyarrow

        records = dataset.open(path).where(split="train")
        return [records[k].situation for k in range(min(count, len(records)))]
    if not path.exists():
        known = ", ".join(family_names())
        raise ArenaError(f"situations: {str(path)!r} is no file, folder or family ({known})")
    return read_situations(path)[:count]


AnyBody = AnyArmBody | str | Path | None


@dataclass(frozen=True)
class Arena:
    """Description of a registered environment: everything in which environments differ."""

    name: str
    """Name in Gymnasium."""
    settings: type[ArenaSettings]
    family: str
    """Family from which situations are drawn by default."""
    plant: Callable[..., Batch]
    """Class of the arms."""
    packed: Callable[[Sequence[AnySituation], Kind, AnyBody], Pool]
    """Pool of situations: (situations, kind, body)."""
    eligible: Callable[[Source, Any], Source] = lambda source, settings: source
    """Restriction of a source to arms that can take part: (source, settings)."""
    begins: Callable[[AnySituation, float], bool] = lambda situation, dt: True
    """Return whether an episode with steps of `dt` [s] can begin with a free limb."""
    followed: bool = True
    """True if arms follow plans step by step, so that catches can be demonstrated."""

    @property
    def kind(self) -> Kind:
        """Kind of the arms."""
        return self.settings.kind


def _without_bodies(situations: Sequence[AnySituation], kind: Kind, body: AnyBody) -> Pool:
    if body is not None:
        raise ArenaError("body: arms of this arena have no mass")
    return Pool.of(situations, kind)


def _with_bodies(situations: Sequence[Any], kind: Kind, body: AnyBody) -> Pool:
    return pool_with_bodies(situations, kind, body)


def _of_arms_with_bodies(source: Source, settings: ArenaSettings) -> Source:
    """Restrict a family to arms for which there is a body."""
    family = named(source)
    if not isinstance(family, SpatialFamily):
        return source
    human, nao = family.arm.human, family.arm.nao
    if human + nao <= 0.0:
        return family
    share = human / (human + nao)
    return replace(family, arm=replace(family.arm, human=share, nao=1.0 - share))


def _with_arm(source: Source, settings: ChainSettings) -> Source:
    """Give the arm of the settings to a family of chains that is named; others keep theirs."""
    family = named(source)
    if not isinstance(source, str) or not hasattr(getattr(family, "arm", None), "model"):
        return source
    return with_arm(cast(Family, family), settings.arm)


ARENAS = {
    arena.name: arena
    for arena in (
        Arena("CatchArm-v0", Settings, "random-planar", KinematicPlant, _without_bodies),
        Arena(
            "CatchArm3D-v0", SpatialSettings, "static-clutter-space", KinematicPlant,
            _without_bodies, begins=stops,
        ),
        Arena(
            "CatchChain-v0", ChainSettings, "throw-chain", KinematicPlant, _without_bodies,
            eligible=_with_arm, begins=stops,
        ),
        Arena(
            "CatchArmPhysics-v0", PhysicalSettings, "static-clutter-space", PhysicalArms,
            _with_bodies, eligible=_of_arms_with_bodies, followed=False,
        ),
        Arena(
            "CatchChainPhysics-v0", ChainPhysicalSettings, "throw-chain", PhysicalArms,
            _with_bodies, eligible=_with_arm, followed=False,
        ),
    )
}  # fmt: skip
"""By the name of the environment."""
_BY_SETTINGS = {arena.settings: arena for arena in ARENAS.values()}


def arena_named(name: str) -> Arena:
    """Return the arena of an environment, with or without Gymnasium's namespace.

    Raises
    ------
    UnknownNameError
        With the nearest name, or all of them.
    """
    bare = name.removeprefix(f"{NAMESPACE}/")
    if bare not in ARENAS:
        raise UnknownNameError.among("environment", name, ARENAS)
    return ARENAS[bare]


def arena_of(settings: ArenaSettings) -> Arena:
    """Return the arena that has settings of this class."""
    return _BY_SETTINGS[type(settings)]


def plant_of(pool: Pool, count: int, settings: ArenaSettings, threads: int = 1) -> Any:
    """Return so many arms of the settings' arena, in the situations of a pool of their kind."""
    return arena_of(settings).plant(pool, count, settings, threads)


def pool_for(
    settings: ArenaSettings, situations: Sequence[AnySituation], body: AnyBody = None
) -> Pool:
    """Pack situations for arms of the settings' arena; for `body` see `body_for`."""
    return arena_of(settings).packed(situations, settings.kind, body)


def situations_of(
    source: Source,
    count: int,
    seed: int,
    settings: ArenaSettings = Settings(),  # noqa: B008 -- frozen
) -> Sequence[AnySituation]:
    """Return situations to begin episodes in; of families only with arms that can take part.

    Parameters
    ----------
    source : str, Path, Family, Situation or sequence of Situation
        As `sources.found_in` has it.
    count : int
    seed : int
        Of the draws.
    settings : ArenaSettings
        Of the arms.

    Raises
    ------
    ArenaError
        If the source is none of these, or holds nothing.
    ArmKindError
        If an arm is of another kind than the settings'.
    """
    found = found_in(arena_of(settings).eligible(source, settings), count, seed)
    of_one_kind(found, settings.kind)
    return found


def pool_of(
    source: Source,
    count: int,
    seed: int,
    settings: ArenaSettings = Settings(),  # noqa: B008 -- frozen
    body: AnyBody = None,
) -> Pool:
    """Return a pool of situations; of several, only situations in which an episode can begin.

    Parameters
    ----------
    source, count, seed, settings
        As `situations_of` has them.
    body : ArmBody, ChainBody, str or Path, optional
        As `body_for` has it.

    Raises
    ------
    ArenaError
        If there is none.
    """
    found = situations_of(source, count, seed, settings)
    if not isinstance(source, Situation):
        found = [s for s in found if _can_begin(s, settings)]
        if not found:
            raise ArenaError(NONE)
    return pool_for(settings, found, body)


NONE = "situations: in none of them an episode can begin"


def _can_begin(situation: AnySituation, settings: ArenaSettings) -> bool:
    """Return whether the limb starts free, and the arm can be stopped."""
    begins = arena_of(settings).begins
    return start_clearance(pack(situation)) > 0.0 and begins(situation, settings.dt)


@dataclass(frozen=True)
class Reserve:
    """Situations of a family, each drawn and packed when an episode first begins in it."""

    source: str | Family
    count: int
    seed: int
    settings: ArenaSettings

    def __len__(self) -> int:
        return self.count

    @cached_property
    def _packed(self) -> dict[int, Pool]:
        return {}

    @cached_property
    def whole(self) -> Pool:
        """Pool of all situations, drawn ahead."""
        return self.settings.prepared(pool_of(self.source, self.count, self.seed, self.settings))

    def at(self, index: int) -> tuple[Pool, int]:
        """Return a pool with the situation at an index, and the situation's index in that pool.

        If no episode can begin there, the next situation in which one can is taken.
        """
        if index not in self._packed:
            after = ((index + k) % self.count for k in range(self.count))
            drawn = (item(self.source, self.seed, k) for k in after)
            free = next((s for s in drawn if _can_begin(s, self.settings)), None)
            if free is None:
                raise ArenaError(NONE)
            self._packed[index] = self.settings.prepared(pool_for(self.settings, [free]))
        return self._packed[index], 0


def reserve_of(
    source: Source | Pool, count: int, seed: int, settings: ArenaSettings, body: AnyBody = None
) -> Pool | Reserve:
    """Return a `Reserve` for a family of arms without mass, and a pool as `pool_of` otherwise."""
    if isinstance(source, Pool):
        return source
    arena = arena_of(settings)
    chosen = named(arena.eligible(source, settings))
    if is_drawn(chosen) and arena.packed is _without_bodies and body is None:
        return Reserve(chosen, count, seed, settings)
    return pool_of(source, count, seed, settings, body)
