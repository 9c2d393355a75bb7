"""Where the situations of episodes come from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from gcm_learn import seeding
from gcm_learn.arms import SpatialArm
from gcm_learn.errors import ArenaError
from gcm_learn.execution.physics.pool import PhysicalPool
from gcm_learn.execution.pool import Pool, SpatialPool, stops
from gcm_learn.families import Family, SpatialFamily, draw, family_names, get_family
from gcm_learn.motion import start_clearance
from gcm_learn.scene import pack
from gcm_learn.situation import AnySituation, ArmBody, Situation, planar, read_situations, spatial

Source = str | Path | Family | AnySituation | Sequence[Situation] | Sequence[Situation[SpatialArm]]
SALT = 77  # of the draws for pools, so that item k of a family is not in all of them


def situations_of(source: Source, count: int, seed: int) -> list[Situation]:
    """Situations to begin episodes in.

    Parameters
    ----------
    source : str, Path, Family, Situation or sequence of Situation
        A family's name or configuration, from which `count` are drawn; a file of situations
        (``.json``, ``.jsonl``) or the folder of a dataset, of which the first `count` training
        records are taken; or situations.
    count : int
    seed : int
        Of the draws.

    Raises
    ------
    ArenaError
        If it is none of these, or holds nothing.
    ArmKindError
        If an arm is spatial.
    """
    return [planar(situation, "the arena") for situation in _found(source, count, seed)]


def spatial_situations_of(source: Source, count: int, seed: int) -> list[Situation[SpatialArm]]:
    """The same of arms in space; planar ones are refused."""
    return [spatial(made, "the arena in space") for made in _found(source, count, seed)]


def physical_situations_of(source: Source, count: int, seed: int) -> list[Situation[SpatialArm]]:
    """The same of arms with mass: of families only arms are drawn for which there is a body."""
    family = get_family(source) if isinstance(source, str) and source in family_names() else source
    if isinstance(family, SpatialFamily):
        human, nao = family.arm.human, family.arm.nao
        if human + nao > 0.0:
            share = human / (human + nao)
            family = replace(family, arm=replace(family.arm, human=share, nao=1.0 - share))
    return spatial_situations_of(family, count, seed)


def _found(source: Source, count: int, seed: int) -> Sequence[AnySituation]:
    if isinstance(source, Situation):
        return [source]
    if isinstance(source, Family):
        return _drawn(source, count, seed)
    if isinstance(source, str) and source in family_names():
        return _drawn(get_family(source), count, seed)
    if isinstance(source, str | Path):
        return _read(Path(source), count)
    found: list[AnySituation] = list(source)
    if not found or not all(isinstance(s, Situation) for s in found):
        raise ArenaError("situations: must be situations, at least one")
    return found


def pool_of(source: Source, count: int, seed: int) -> Pool:
    """A pool of situations, without those of several in which the limb does not start free."""
    found = situations_of(source, count, seed)
    if not isinstance(source, Situation):
        found = [s for s in found if start_clearance(pack(s)) > 0.0]
    return Pool.of(found)


def spatial_pool_of(source: Source, count: int, seed: int, dt: float) -> SpatialPool:
    """The same of arms in space, also without those that move too fast to stop in steps of `dt`."""
    found = spatial_situations_of(source, count, seed)
    if not isinstance(source, Situation):
        found = [s for s in found if start_clearance(pack(s)) > 0.0 and stops(s, dt)]
    return SpatialPool.of(found)


def physical_pool_of(
    source: Source, count: int, seed: int, body: ArmBody | str | Path | None = None
) -> PhysicalPool:
    """A pool of arms with mass; `body` as `body_for` has it, the rest as `pool_of`."""
    found = physical_situations_of(source, count, seed)
    if not isinstance(source, Situation):
        found = [s for s in found if start_clearance(pack(s)) > 0.0]
    return PhysicalPool.of(found, body)


def _drawn(family: Family, count: int, seed: int) -> list[AnySituation]:
    root = int(seeding.rng(seed, SALT).integers(2**62))
    return [draw(family, root, k) for k in range(count)]


def _read(path: Path, count: int) -> Sequence[AnySituation]:
    if path.is_dir():
        from gcm_learn import dataset  # needs pyarrow

        records = dataset.open(path).where(split="train")
        return [records[k].situation for k in range(min(count, len(records)))]
    if not path.exists():
        known = ", ".join(family_names())
        raise ArenaError(f"situations: {str(path)!r} is no file, folder or family ({known})")
    return read_situations(path)[:count]
