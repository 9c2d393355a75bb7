"""Specifications of datasets: small files of which every record is a pure function.

Files, TOML or JSON, are read strictly: wrong ones are refused in one line.
"""

from __future__ import annotations

import dataclasses
import json
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, TypeVar

import numpy as np

from gcm_learn.arms import Kind, kind_named
from gcm_learn.charts import LARGEST_LATTICE, SMALLEST_LATTICE
from gcm_learn.dataset import checks
from gcm_learn.dataset.kinds import RECORDS
from gcm_learn.dataset.splits import Holdout, Split
from gcm_learn.errors import FamilyError, FileFormatError, SpecError, not_known
from gcm_learn.families import Family, family_from_dict, family_names
from gcm_learn.planners import declined, get_planner, planner_names, takes
from gcm_learn.situation import AnySituation
from gcm_learn.storage import content_hash

FORMAT = "gcm-learn/dataset-spec@1"
STRATA = ("L", "W", "Q", "U")
_Record = TypeVar("_Record")
GOLDEN = (5**0.5 - 1) / 2  # multiples of it fill (0, 1) evenly, whatever their number


@dataclass(frozen=True)
class FamilyShare:
    """A family of situations and its share of the draws."""

    family: str
    share: float = 1.0
    """Relative to the other families."""
    config: Mapping[str, Any] = field(default_factory=dict)
    """Ranges that differ from the family's own."""

    def __post_init__(self) -> None:
        checks.choice(self.family, "family", family_names())
        checks.positive(self.share, "share")
        if not isinstance(self.config, Mapping):
            raise SpecError("config", f"must be a table (got {self.config!r})")
        try:
            self.source  # noqa: B018  # made now, so that a wrong range is refused now
        except FamilyError as error:
            field = error.field.removeprefix(self.family).lstrip(".")
            raise SpecError(f"config.{field}".rstrip("."), error.reason) from None

    @cached_property
    def source(self) -> Family:
        """The family with its ranges; ``source.draw(rng, name)`` gives a situation."""
        return family_from_dict({**self.config, "family": self.family})

    def draw(self, rng: np.random.Generator, name: str) -> AnySituation:
        """Draw a situation."""
        return self.source.draw(rng, name)


@dataclass(frozen=True)
class DatasetSpec:
    """Specification of a dataset; it decides every record.

    `count` decides only the number of records: a larger count continues the same dataset.
    """

    name: str
    seed: int
    count: int
    families: tuple[FamilyShare, ...]
    planners: tuple[str, ...] = ("gcm", "layered")
    """Planners whose plans a record holds; each has to take the kind of arm."""
    rungs: int = 9
    """Of the ladder of ever more careful maps that front planners climb, `layered` after a search:
    2 stay on lattices of n cells, the last ones have twice as many. Also how hard the labels'
    planners try."""
    effort: float | None = None
    """In space: share of the moves that `search` checks before it gives up; all when absent."""
    map: Literal["wave", "marching", "layered", "none"] = "wave"
    """Engine of the map that a record holds; in space "marching" or "none"."""
    n: int = 80
    """Cells along a side of the map; in space at most 40."""
    label: Literal["fast", "oracle"] = "fast"
    """Judge of the stratum: the planners straight, marching and layered, in space straight
    and search (without waits first), or the oracle."""
    audit: float = 0.0
    """Share of the items that the oracle labels as well."""
    strata: Mapping[str, float] | None = None
    """Shares of the strata, filled by rejection; as drawn when absent."""
    attempts: int = 2000
    """Draws for one item; after that many it is recorded as failed."""
    shard_size: int = 1000
    split: Split = field(default_factory=Split)
    holdouts: tuple[Holdout, ...] = ()
    """Held-out splits: a record belongs to the first that fits; if none fits, `split` decides."""
    arm: str | None = None
    """Arm of all families, which are for chains: a name, or the text of an arm file. Files that a
    specification names are replaced by their text when it is read, so it decides the digest."""

    def __post_init__(self) -> None:
        checks.name(self.name, "name")
        checks.integer(self.seed, "seed", 0, 2**63 - 1)
        checks.integer(self.count, "count", 1, 10**9)
        if not self.families:
            raise SpecError("families", "must name at least one family")
        checks.distinct(self.planners, "planners", planner_names())
        checks.integer(self.rungs, "rungs", 1, 9)
        if self.effort is not None:
            checks.share(self.effort, "effort")
        checks.choice(self.map, "map", ("wave", "marching", "layered", "none"))
        checks.integer(self.n, "n", SMALLEST_LATTICE, LARGEST_LATTICE)
        checks.choice(self.label, "label", ("fast", "oracle"))
        checks.share(self.audit, "audit")
        if self.strata is not None:
            checks.shares(self.strata, "strata", STRATA)
        checks.integer(self.attempts, "attempts", 1, 10**6)
        checks.integer(self.shard_size, "shard_size", 1, 10**6)
        self._check_arms()

    def _check_arms(self) -> None:
        """Refuse arms of two kinds, and fields that are not for their kind."""
        kinds = [family.source.kind for family in self.drawn]
        for k, kind in enumerate(kinds):
            if kind != kinds[0]:
                raise SpecError(
                    f"families[{k}]", f"is for {kind} arms, and the first one for {kinds[0]} ones"
                )
        known = RECORDS.of(self.kind)
        if self.effort is not None and not known.efforts:
            others = (kind.plural for kind in RECORDS if RECORDS.of(kind).efforts)
            raise SpecError("effort", f"is for {' and '.join(others)}")
        if self.map != "none" and self.map not in known.engines:
            names = f"{' or '.join(map(repr, known.engines))} or 'none'"
            raise SpecError("map", f"must be {names} for {self.kind.plural} (got {self.map!r})")
        if self.map != "none" and self.n > known.largest:
            most = f"at most {known.largest} for maps of {self.kind.plural}"
            raise SpecError("n", f"must be {most} (got {self.n})")
        for name, asks in (("label", self.label == "oracle"), ("audit", self.audit > 0.0)):
            if asks and not known.oracle:
                raise SpecError(name, f"the oracle does not take {self.kind.plural}")
        for k, name in enumerate(self.planners):
            if not takes(get_planner(name), self.kind):
                raise SpecError(f"planners[{k}]", declined(name, self.kind))

    @property
    def kind(self) -> Kind:
        """Kind of arm of the dataset's situations."""
        return kind_named(self.families[0].source.kind)

    @property
    def persistent(self) -> str:
        """Planner that can wait; its catches tell stratum Q from U."""
        return RECORDS.of(self.kind).persistent

    @cached_property
    def drawn(self) -> tuple[FamilyShare, ...]:
        """The families with their arm."""
        if self.arm is None:
            return self.families
        arms = [{**share.config.get("arm", {}), "model": self.arm} for share in self.families]
        shares = zip(self.families, arms, strict=True)
        try:
            return tuple(replace(one, config={**one.config, "arm": arm}) for one, arm in shares)
        except SpecError as error:
            raise SpecError("arm", error.reason) from None

    @property
    def shards(self) -> int:
        """Number of files that the records fill."""
        return -(-self.count // self.shard_size)

    def indices(self, shard: int) -> range:
        """Indices of the items of a shard."""
        first = shard * self.shard_size
        return range(first, min(first + self.shard_size, self.count))

    def wanted(self, k: int) -> str | None:
        """Stratum that item k should have, None if any will do.

        Multiples of the golden ratio fill the unit interval evenly from the start, so the shares
        hold for every part of the dataset, and for one that grows.
        """
        if self.strata is None:
            return None
        place = (k + 0.5) * GOLDEN % 1.0 * sum(self.strata.values())
        for stratum in STRATA:
            place -= self.strata.get(stratum, 0.0)
            if place < 0.0:
                return stratum
        return next(s for s in reversed(STRATA) if self.strata.get(s, 0.0) > 0.0)

    def choose(self, rng: np.random.Generator) -> FamilyShare:
        """Draw a family at random, weighted by the families' shares."""
        place = rng.random() * sum(f.share for f in self.drawn)
        for family in self.drawn:
            place -= family.share
            if place < 0.0:
                return family
        return self.drawn[-1]

    @cached_property
    def digest(self) -> str:
        """Hash of all fields that decide the records: all but `count`."""
        content = spec_to_json(self)
        del content["count"]
        return content_hash(json.dumps(content, sort_keys=True))[:16]


def spec_to_json(spec: DatasetSpec) -> dict[str, Any]:
    """Return the specification as JSON values; `spec_from_json` restores an equal one."""
    given = dataclasses.asdict(
        spec, dict_factory=lambda members: {k: v for k, v in members if v is not None}
    )
    return {"format": FORMAT, **json.loads(json.dumps(given))}


def read_spec(path: str | Path) -> DatasetSpec:
    """Read a specification from a ``.toml`` or ``.json`` file.

    Raises
    ------
    FileFormatError
        One line: ``spec.toml: families[1].share: must be positive (got -1)``.
    """
    path = Path(path)
    if path.suffix.lower() not in (".toml", ".json"):
        raise FileFormatError(f"{path}: a specification ends in .toml or .json")
    try:
        text = path.read_bytes().decode("utf-8")
        toml = path.suffix.lower() == ".toml"
        content = tomllib.loads(text) if toml else json.loads(text)
        return spec_from_json(_with_files(content, path.parent))
    except OSError as error:
        raise FileFormatError(f"{path}: cannot be read ({error.strerror or error})") from None
    except UnicodeDecodeError as error:
        raise FileFormatError(f"{path}: is not UTF-8 text ({error.reason})") from None
    except SpecError as error:
        raise FileFormatError(f"{path}: {error}") from None
    except (tomllib.TOMLDecodeError, json.JSONDecodeError) as error:
        raise FileFormatError(f"{path}: {error}") from None


def _with_files(content: Any, folder: Path, key: str = "arm") -> Any:
    """Put the text of arm files, which lie relative to a folder, in place of their names."""
    if isinstance(content, list):
        return [_with_files(item, folder) for item in content]
    if isinstance(content, dict):
        return {name: _with_files(item, folder, name) for name, item in content.items()}
    if key not in ("arm", "model") or not str(content).endswith(".json"):
        return content
    try:
        found = json.loads((folder / content).read_text("utf-8"))
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise SpecError(key, f"{folder / content}: cannot be read ({reason})") from None
    return json.dumps(found, sort_keys=True)


def spec_from_json(obj: object) -> DatasetSpec:
    """Return the specification that parsed TOML or JSON describes.

    Raises
    ------
    SpecError
        With the path of the offending field.
    """
    members = dict(_table(obj, ""))
    if members.pop("format", None) != FORMAT:
        raise SpecError("format", f"must be {FORMAT!r}")
    parts: dict[str, Any] = {}
    if "families" in members:
        parts["families"] = _records(FamilyShare, members.pop("families"), "families")
    if "holdouts" in members:
        parts["holdouts"] = _records(Holdout, members.pop("holdouts"), "holdouts")
    if "split" in members:
        parts["split"] = _record(Split, members.pop("split"), "split")
    if isinstance(members.get("planners"), list):
        members["planners"] = tuple(members["planners"])
    return _record(DatasetSpec, members, "", parts)


def _records(record: type[_Record], obj: object, path: str) -> tuple[_Record, ...]:
    if not isinstance(obj, list):
        raise SpecError(path, f"must be a list of tables (got {obj!r})")
    return tuple(_record(record, entry, f"{path}[{k}]") for k, entry in enumerate(obj))


def _record(
    record: type[_Record], obj: object, path: str, parts: Mapping[str, Any] | None = None
) -> _Record:
    """Return a record of a table's members and of parts that are records already."""
    members = {**_table(obj, path), **(parts or {})}
    fields = dataclasses.fields(record)  # type: ignore[arg-type]
    known = {f.name: f for f in fields}
    for name in members:
        if name not in known:
            raise SpecError(_join(path, name), not_known(name, known))
    for name, f in known.items():
        needed = f.default is dataclasses.MISSING and f.default_factory is dataclasses.MISSING
        if needed and name not in members:
            raise SpecError(_join(path, name), "is missing")
    try:
        return record(**members)
    except SpecError as error:
        raise SpecError(_join(path, error.field), error.reason) from None


def _table(obj: object, path: str) -> Mapping[str, Any]:
    if not isinstance(obj, Mapping):
        raise SpecError(path, f"must be a table (got {obj!r})")
    return obj


def _join(path: str, name: str) -> str:
    return f"{path}.{name}" if path and name else path or name
