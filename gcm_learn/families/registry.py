"""Families by name, and their configurations as plain dictionaries."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeVar

from gcm_learn import seeding
from gcm_learn.checks import show
from gcm_learn.errors import FamilyError, FileFormatError, UnknownNameError, not_known
from gcm_learn.families import clutter, flights
from gcm_learn.families.chain.belts import ConveyorChain, TurntableChain
from gcm_learn.families.chain.boxes import DrawerChain, ShelfChain
from gcm_learn.families.chain.company import HandoverChain, OtherArmChain, PersonChain
from gcm_learn.families.chain.flights import FallingChain, SequenceChain, SwarmChain, ThrowChain
from gcm_learn.families.chain.pendulum import PendulumChain
from gcm_learn.families.chain.walls import GateChain, WindowChain
from gcm_learn.families.family import Family
from gcm_learn.families.gate import Gate, GateSolid
from gcm_learn.families.pendulum import PendulumFamily
from gcm_learn.families.presets import PRESETS
from gcm_learn.families.random_planar import RandomPlanar
from gcm_learn.families.random_solid import RandomSolid
from gcm_learn.families.ranges import Ranges
from gcm_learn.families.space.bench import BenchSpace
from gcm_learn.families.space.boxes import CrateSpace, TraySpace
from gcm_learn.families.space.clutter import BehindPostSpace, CrossingSwarmSpace, StaticClutterSpace
from gcm_learn.families.space.flights import (
    FallingSpace,
    LateTargetSpace,
    OverShelfSpace,
    SequenceSpace,
)
from gcm_learn.families.space.pendulum import PendulumSpace
from gcm_learn.families.space.walls import DoorSpace, WindowSpace
from gcm_learn.situation import AnySituation, JsonTextError, RepeatedField, line_of, parse

_Record = TypeVar("_Record", bound=Ranges)

_FAMILIES: dict[str, type[Family]] = {
    family.name: family
    for family in (
        clutter.StaticClutter, clutter.StaticClutterSolid, clutter.MovingPoint,
        clutter.MovingPointSolid, clutter.CrossingSwarm, clutter.CrossingSwarmSolid,
        flights.Falling, flights.FallingSolid, flights.Spinning, flights.SpinningSolid,
        PendulumFamily, Gate, GateSolid, clutter.BehindMover, clutter.BehindMoverSolid,
        flights.LateTarget, flights.LateTargetSolid, RandomPlanar, RandomSolid,
        StaticClutterSpace, CrossingSwarmSpace, BehindPostSpace, WindowSpace, DoorSpace, CrateSpace,
        TraySpace, OverShelfSpace, FallingSpace, LateTargetSpace, PendulumSpace, BenchSpace,
        SequenceSpace,
        ThrowChain, ConveyorChain, WindowChain, PendulumChain, SwarmChain, ShelfChain,
        TurntableChain, OtherArmChain, DrawerChain, FallingChain, GateChain, HandoverChain,
        SequenceChain, PersonChain,
    )
}  # fmt: skip


def family_names(kind: str | None = None) -> list[str]:
    """Return names of all registered families, or of those for "planar", "spatial" or "chain" arms.

    By kind, families whose situations all ask for several catches are left out.
    """
    return [
        name
        for name, family in _FAMILIES.items()
        if kind is None or (kind == family.kind and not family.several)
    ]


@functools.cache
def get_family(name: str) -> Family:
    """Return a family with its default ranges; raise UnknownNameError with the known names."""
    return _class_of(name)()


@functools.cache
def with_arm(family: Family, model: str) -> Family:
    """Return a family for chains with another arm `model`, under that model's own limits."""
    if family.kind != "chain":
        raise FamilyError("arm", f"{family.name} is for {family.kind} arms, an arm file is a chain")
    chain: Any = family
    arm = dataclasses.replace(chain.arm, model=model, accelerations=(), jerks=())
    return dataclasses.replace(chain, arm=arm)


def draw(family: str | Family, seed: int, index: int, *, arm: str = "") -> AnySituation:
    """Draw item `index` of a family under a seed: the same whatever else is drawn.

    Parameters
    ----------
    family : str or Family
        A registered name, for the default ranges, a preset's name, or a configuration.
    seed, index : int
        Non-negative.
    arm : str
        Arm of families for chains, see `with_arm`; by default the family's own.

    Returns
    -------
    Situation
        Named after family and index, e.g. ``gate-0000042``; a preset's items are also named after
        their families, e.g. ``panda-easy-0000042-throw-chain``.

    Examples
    --------
    >>> from gcm_learn import families
    >>> families.draw("gate", 0, 42).name
    'gate-0000042'
    """
    source = seeding.rng(seed, index)
    if isinstance(family, str) and family in PRESETS:
        members = preset_families(family)
        config = members[index % len(members)]
        name = f"{family}-{index:07d}-{config.name}"
    else:
        config = get_family(family) if isinstance(family, str) else family
        name = item_name(config, index)
    return (with_arm(config, arm) if arm else config).draw(source, name)


@functools.cache
def preset_families(name: str) -> tuple[Family, ...]:
    """Families of a preset with their ranges; raises UnknownNameError with the known names."""
    if name not in PRESETS:
        raise UnknownNameError.among("preset", name, list(PRESETS))
    return tuple(map(family_from_dict, PRESETS[name].families))


def item_name(family: Family, index: int) -> str:
    """Name of item `index` of a family."""
    return f"{family.name}-{index:07d}"


def family_to_dict(family: Family) -> dict[str, Any]:
    """A configuration as plain values for JSON or TOML, with the family's name under "family"."""
    return {"family": family.name, **_plain(family)}


def family_from_dict(values: object) -> Family:
    """Return the family that a dictionary configures; missing fields keep their defaults.

    Parameters
    ----------
    values : mapping
        As from JSON or TOML: ``{"family": "gate", "opening": [0.5, 0.8], "arm": {"right": 1.0}}``

    Raises
    ------
    FamilyError
        One line, with the path of the field that is unknown or out of its range.
    """
    if not isinstance(values, Mapping):
        raise FamilyError("family", f"must be an object (got {show(values)})")
    if "family" not in values:
        raise FamilyError("family", f"is missing (known: {', '.join(family_names())})")
    record = _class_of(values["family"])
    if isinstance(values, RepeatedField):
        raise FamilyError(f"{record.name}.{values.key}", "is given twice")
    given = {key: value for key, value in values.items() if key != "family"}
    return _made(record(), given, record.name)


def read_family(path: str | Path) -> Family:
    """The configuration in a JSON file.

    Raises
    ------
    FileFormatError
        One line: ``gate.json:3: gate.opening: low 0.8 is above high 0.3``.
    """
    text = ""
    try:
        text = Path(path).read_text("utf-8")
        return family_from_dict(parse(text))
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "is not UTF-8 text"
        raise FileFormatError(f"{path}: cannot be read ({reason})") from None
    except JsonTextError as error:
        raise FileFormatError(f"{path}:{error.line}: not valid JSON: {error.reason}") from None
    except UnknownNameError as error:
        raise FileFormatError(f"{path}:{line_of(text, 'family')}: {error}") from None
    except FamilyError as error:
        line = line_of(text, error.field.partition(".")[2])  # the first part is the family's name
        raise FileFormatError(f"{path}:{line}: {error}") from None


def _class_of(name: object) -> type[Family]:
    if not isinstance(name, str) or name not in _FAMILIES:
        raise UnknownNameError.among("family", name, family_names())
    return _FAMILIES[name]


def _plain(record: Ranges) -> dict[str, Any]:
    """Fields of a record: numbers, lists and nested dictionaries."""
    out: dict[str, Any] = {}
    for field in dataclasses.fields(record):
        value = getattr(record, field.name)
        if isinstance(value, Ranges):
            out[field.name] = _plain(value)
        else:
            out[field.name] = list(value) if isinstance(value, tuple) else value
    return out


def _made(record: _Record, values: object, path: str) -> _Record:
    """Return a record with the given fields replaced, nested fields too."""
    if not isinstance(values, Mapping):
        raise FamilyError(path, f"must be an object (got {show(values)})")
    if isinstance(values, RepeatedField):
        raise FamilyError(f"{path}.{values.key}", "is given twice")
    known = {field.name for field in dataclasses.fields(record)}
    changes: dict[str, Any] = {}
    for key, value in values.items():
        if key not in known:
            raise FamilyError(f"{path}.{key}", not_known(key, known))
        old = getattr(record, key)
        changes[key] = _made(old, value, f"{path}.{key}") if isinstance(old, Ranges) else value
    try:
        return dataclasses.replace(record, **changes)
    except FamilyError as error:
        raise FamilyError(f"{path}.{error.field}", error.reason) from None
