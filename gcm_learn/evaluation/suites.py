"""Suites: situations that all are compared on, frozen by hash.

A suite is the specification of a dataset, or a stratum of what families draw in turns (`turns`),
drawn on demand; the oracle decides the strata. What has been drawn is kept as a file of lines
beside the others, so that it is drawn once; small ones come with the repository. Situations must
have the hash that is noted here, so two comparisons of one suite have seen the same.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gcm_learn.errors import FileFormatError, SuiteError, UnknownNameError
from gcm_learn.evaluation import turns
from gcm_learn.families import family_names
from gcm_learn.situation import Situation, situation_from_json, situation_to_json

if TYPE_CHECKING:
    from gcm_learn.dataset.spec import DatasetSpec

LARGEST = 1000  # situations of a suite
SHARD = 25
FASTER = {"speed": [1.2, 2.4]}  # of bodies that are drawn anywhere [hand speeds]
LONG_ARM = {"arm": {"upper_arm": [1.3, 1.5]}}
_ALL: Mapping[str, Mapping[str, Any]] = {name: {} for name in family_names()}
_ANYWHERE: Mapping[str, Mapping[str, Any]] = {"random-planar": {}}

FROZEN: Mapping[str, Mapping[int, str]] = {
    "demo": {50: "4b1d538bf1653227"},
    "natural": {300: "be1df849b66b2fd6"},
    "L": {300: "f19fd5215733d8a8"},
    "W": {300: "4ebc8c176236a29d"},
    "Q": {300: "499288c6b95524d9"},
    "U": {300: "daceb4b193f594a7"},
}
"""Hashes of the first situations of a suite, by how many."""


@dataclass(frozen=True)
class Suite:
    """Situations for a comparison."""

    summary: str
    seed: int
    families: Mapping[str, Mapping[str, Any]]
    """By name, with the ranges that differ from their own; drawn equally often."""
    strata: Mapping[str, float] | None = None

    def spec(self, name: str, count: int) -> DatasetSpec:
        """The dataset that holds the first `count` of them."""
        from gcm_learn.dataset.spec import DatasetSpec, FamilyShare  # needs pyarrow

        families = tuple(FamilyShare(f, 1.0, config) for f, config in self.families.items())
        return DatasetSpec(
            name=name, seed=self.seed, count=count, families=families, planners=("straight",),
            map="none", label="oracle", strata=self.strata, shard_size=SHARD,
        )  # fmt: skip


SUITES: Mapping[str, Suite] = {
    "natural": Suite("bodies anywhere, as drawn", 9101, _ANYWHERE),
    "detour": Suite("W: a way round is needed; all families", 9102, _ALL, {"W": 1.0}),
    "wait": Suite("Q: waiting is needed; all families", 9103, _ALL, {"Q": 1.0}),
    "families": Suite("all families, as drawn", 9104, _ALL),
    "faster": Suite("bodies anywhere, twice as fast", 9105, {"random-planar": FASTER}),
    "long-arm": Suite(
        "an upper arm longer than any in training",
        9106,
        dict.fromkeys(("random-planar", "crossing-swarm", "gate"), LONG_ARM),
    ),
    "demo": Suite(
        "equal parts of all strata and families",
        9107,
        _ALL,
        {"L": 1.0, "W": 1.0, "Q": 1.0, "U": 1.0},
    ),
} | {name: Suite(f"the family {name}", 9200, {name: {}}) for name in family_names()}


@dataclass(frozen=True)
class Entry:
    """A situation of a suite."""

    suite: str
    index: int
    situation: Situation
    """In its canonical form."""
    family: str
    stratum: str
    """By the oracle."""
    earliest: float
    """When the oracle's plan catches [s]; infinite if it does not."""


def suite_names() -> list[str]:
    """Names of the suites."""
    return [*SUITES, *turns.STRATA]


def suites_folder() -> Path:
    """Where the repository keeps suites."""
    return Path(__file__).parents[2] / "data" / "suites"


def check_suite(name: str, count: int) -> None:
    """Refuse what is no suite, or more situations than it can have."""
    if name not in suite_names():
        raise UnknownNameError(f"suite: {name!r} is not one of {', '.join(suite_names())}")
    if not 1 <= count <= LARGEST:
        raise SuiteError(f"count: must be from 1 to {LARGEST} (got {count})")


def draw_suite(
    name: str,
    count: int,
    folder: Path,
    workers: int | None = None,
    progress: Callable[[int], None] = lambda records: None,
) -> list[Entry]:
    """The first situations of a suite; what is not in the folder yet is drawn.

    Parameters
    ----------
    name : str
    count : int
        At most 1000.
    folder : Path
        Where suites are kept.

    Raises
    ------
    SuiteError
        If what is there, or drawn, is not what was frozen.
    """
    check_suite(name, count)
    path = folder / f"{name}.jsonl"
    entries = _read(path) if path.exists() else []
    if len(entries) < count:
        entries = _drawn(name, count, folder, workers, progress)
        folder.mkdir(parents=True, exist_ok=True)
        path.write_text("".join(_line(entry) + "\n" for entry in entries), "utf-8")
    entries = entries[:count]
    digest, wanted = hash_of(entries), FROZEN.get(name, {}).get(count)
    if wanted is not None and digest != wanted:
        raise SuiteError(f"suite {name!r}: its first {count} have hash {digest}, not {wanted}")
    return entries


def _drawn(
    name: str, count: int, folder: Path, workers: int | None, progress: Callable[[int], None]
) -> list[Entry]:
    """Draw a suite as a dataset, or from draws in turn; both go on where they were interrupted."""
    if name in turns.STRATA:
        found = turns.first_of(name, count, folder, workers, progress)
        return [_entry({"suite": name, **values}) for values in found]
    from gcm_learn import dataset  # needs pyarrow

    spec = SUITES[name].spec(name, -(-count // SHARD) * SHARD)
    dataset.generate(spec, folder / name, workers, progress=progress)
    records = dataset.open(folder / name)
    entries = []
    for k in range(len(records)):
        record = records[k]
        upper = record.row["oracle_upper"]
        earliest = float("inf") if upper is None else float(upper)
        entries.append(
            Entry(name, record.index, record.situation, record.family, record.stratum, earliest)
        )
    return entries


def _line(entry: Entry) -> str:
    """An entry as a line of JSON; a catch that there is not is null."""
    values = {
        "suite": entry.suite,
        "index": entry.index,
        "family": entry.family,
        "stratum": entry.stratum,
        "earliest": entry.earliest if math.isfinite(entry.earliest) else None,
        "situation": situation_to_json(entry.situation),
    }
    return json.dumps(values)


def _read(path: Path) -> list[Entry]:
    """Entries of a file."""
    entries = []
    for number, line in enumerate(path.read_text("utf-8").splitlines(), 1):
        try:
            entries.append(_entry(json.loads(line)))
        except (ValueError, KeyError, TypeError) as error:
            raise FileFormatError(f"{path}:{number}: is no entry of a suite ({error})") from None
    return entries


def _entry(values: dict[str, Any]) -> Entry:
    """An entry of its JSON values."""
    situation = situation_from_json(values["situation"])
    earliest = math.inf if values["earliest"] is None else values["earliest"]
    return Entry(**(values | {"situation": situation, "earliest": earliest}))


def hash_of(entries: list[Entry]) -> str:
    """Hash of situations and strata, in order.

    When the oracle catches is no part of it: that changes by a hair whenever it gets better.
    """
    digest = hashlib.sha256()
    for entry in entries:
        digest.update(f"{_line(replace(entry, earliest=math.inf))}\n".encode())
    return digest.hexdigest()[:16]
