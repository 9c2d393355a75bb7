"""Sources of the situations of episodes."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from gcm_learn import seeding
from gcm_learn.errors import ArenaError
from gcm_learn.families import PRESETS, Family, draw, family_names, get_family
from gcm_learn.situation import AnySituation, Situation, read_situations

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
    if isinstance(source, Family) or (isinstance(source, str) and source in PRESETS):
        root = int(seeding.rng(seed, SALT).integers(2**62))
        return [draw(source, root, k) for k in range(count)]
    if isinstance(source, str | Path):
        return _read(Path(source), count)
    found: list[AnySituation] = list(source)  # type: ignore[arg-type]
    if not found or not all(isinstance(s, Situation) for s in found):
        raise ArenaError("situations: must be situations, at least one")
    return found


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
