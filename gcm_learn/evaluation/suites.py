"""Suites: situations that all are compared on, frozen by hash.

A suite is the specification of a dataset, or a stratum of what families draw in turns (`turns`),
drawn on demand; the oracle decides the strata. Drawn suites are kept as files of lines beside the
others, so each is drawn once; small ones come with the repository. The first situations of a suite,
as many as were frozen, must have the hash that is noted here. So two comparisons of one suite have
seen the same.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from gcm_learn import artifacts
from gcm_learn.errors import FileFormatError, SuiteError, UnknownNameError
from gcm_learn.evaluation import turns
from gcm_learn.families import family_names
from gcm_learn.processes import crew_of
from gcm_learn.situation import situation_from_json, situation_to_json
from gcm_learn.storage import content_hash, write_whole

if TYPE_CHECKING:
    from gcm_learn.dataset import DatasetSpec, Record

LARGEST = 1000  # situations of a suite
SHARD = 25
FOLDER = "suites"
FASTER = {"speed": [1.2, 2.4]}  # of bodies that are drawn anywhere [hand speeds]
LONG_ARM = {"arm": {"upper_arm": [1.3, 1.5]}}
_ALL: Mapping[str, Mapping[str, Any]] = {name: {} for name in turns.FAMILIES}
_SPACE: Mapping[str, Mapping[str, Any]] = {name: {} for name in family_names("spatial")}
_CHAINS: Mapping[str, Mapping[str, Any]] = {name: {} for name in family_names("chain")}
_ANYWHERE: Mapping[str, Mapping[str, Any]] = {"random-planar": {}}

FROZEN: Mapping[str, Mapping[int, str]] = {
    "demo": {50: "4b1d538bf1653227"},
    "natural": {50: "2de41ea9eaf316fd", 300: "be1df849b66b2fd6"},
    "L": {50: "3ac395991ed23ca4", 300: "f19fd5215733d8a8", 1000: "4226e9f8d556b75c"},
    "W": {50: "dc8f70954adff697", 300: "4ebc8c176236a29d", 1000: "43c6d9b088eb97d1"},
    "Q": {50: "ef81cd324814245e", 300: "499288c6b95524d9", 1000: "2e7b70fe03a83b11"},
    "U": {50: "987b0b57da941658", 300: "daceb4b193f594a7", 1000: "fedfd90da77a052a"},
    "families": {50: "97eb134a834594e9"},
    "faster": {50: "c6d42d41c7c3628f"},
    "long-arm": {50: "096d2277fc353126"},
    "static-clutter": {50: "bada7e7b1a81ba3d"},
    "static-clutter-solid": {50: "2bd1fd0fe973534f"},
    "moving-point": {50: "f36282d3c111fdda"},
    "moving-point-solid": {50: "b4fe1f551962771b"},
    "crossing-swarm": {50: "b771c4395433740e"},
    "crossing-swarm-solid": {50: "3a9ef8e2ba79167b"},
    "falling": {50: "277a4178cfd831fc"},
    "falling-solid": {50: "b85cb40e3fa029a8"},
    "spinning": {50: "48c8c194fe292060"},
    "spinning-solid": {50: "8d129276a4a3796b"},
    "pendulum": {50: "728f8ed8ace9ab4c"},
    "gate": {50: "2ca9521ace2d2ae0"},
    "gate-solid": {50: "d6350d0b892f3806"},
    "behind-mover": {50: "106ce373fc2f1055"},
    "behind-mover-solid": {50: "996bd78e5b18f85d"},
    "late-target": {50: "97df00a4b96dd2b8"},
    "late-target-solid": {50: "2aa501d480890729"},
    "random-planar": {50: "ab2a807df48a155e"},
    "random-solid": {50: "299ac5e405808408"},
}
"""Hashes of the first situations of a suite, by how many; a draw has to have all that fit."""


@dataclass(frozen=True)
class Suite:
    """Situations for a comparison."""

    summary: str
    seed: int
    families: Mapping[str, Mapping[str, Any]]
    """By name, with the ranges that differ from their own; drawn equally often."""
    strata: Mapping[str, float] | None = None
    label: Literal["oracle", "fast"] = "oracle"
    """Judge of the strata: for other arms than planar ones `straight` and `search`, since a
    yardstick takes seconds. These get better, so such suites are drawn anew and not frozen."""

    def spec(self, name: str, count: int) -> DatasetSpec:
        """The dataset that holds the first `count` of them."""
        from gcm_learn.dataset import DatasetSpec, FamilyShare  # needs pyarrow

        families = tuple(FamilyShare(f, 1.0, config) for f, config in self.families.items())
        return DatasetSpec(
            name=name, seed=self.seed, count=count, families=families, planners=self._planners,
            map="none", label=self.label, strata=self.strata, shard_size=SHARD,
        )  # fmt: skip

    @property
    def _planners(self) -> tuple[str, ...]:
        return ("straight",) if self.label == "oracle" else ("straight", "search")


SUITES: dict[str, Suite] = {
    "natural": Suite("bodies anywhere, as drawn", 9101, _ANYWHERE),
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
    "space": Suite("all families of spatial arms, as drawn", 9110, _SPACE, label="fast"),
    "space-demo": Suite(
        "equal parts of all strata, spatial arms",
        9111,
        _SPACE,
        {"L": 1.0, "W": 1.0, "Q": 1.0, "U": 1.0},
        label="fast",
    ),
    "chains": Suite("all families of chains, as drawn", 9112, _CHAINS, label="fast"),
} | {name: Suite(f"the family {name}", 9200, {name: {}}) for name in turns.FAMILIES}
SUITES |= {
    name: Suite(f"the family {name}", 9200, {name: {}}, label="fast")
    for name in (*_SPACE, "sequence-space")
}
SUITES |= {
    name: Suite(f"the family {name}", 9200, {name: {}}, label="fast")
    for name in (*_CHAINS, "sequence-chain")
}


@dataclass(frozen=True)
class Entry:
    """A situation of a suite."""

    suite: str
    index: int
    situation: Any
    """In its canonical form."""
    family: str
    stratum: str
    """By the oracle; of other arms than planar ones by two planners, see `Suite.label`."""
    earliest: float
    """Catch time of the oracle's plan, or of the first of these [s]; infinite without a catch."""


def suite_names() -> list[str]:
    """Names of the suites."""
    return [*SUITES, *turns.STRATA]


def suite_file(name: str) -> Path | None:
    """Return the file of a suite that is drawn or shipped, or None."""
    return artifacts.find("data", f"{FOLDER}/{name}.jsonl")


def check_suite(name: str, count: int) -> None:
    """Refuse what is no suite, or more situations than it can have."""
    if name not in suite_names():
        raise UnknownNameError.among("suite", name, suite_names())
    if not 1 <= count <= LARGEST:
        raise SuiteError(f"count: must be from 1 to {LARGEST} (got {count})")


def draw_suite(
    name: str,
    count: int,
    folder: Path | None = None,
    workers: int | None = None,
    *,
    cluster: str | None = None,
    progress: Callable[[int], None] = lambda records: None,
) -> list[Entry]:
    """The first situations of a suite; what is not in the folder yet is drawn.

    Parameters
    ----------
    name : str
    count : int
        At most 1000.
    folder : Path, optional
        Where suites are kept; by default they are found as `artifacts` says.
    workers, cluster
        Who draws, see `processes.crew_of`.

    Raises
    ------
    SuiteError
        If what is there, or drawn, is not what was frozen.
    """
    check_suite(name, count)
    kept = artifacts.kept("data") / FOLDER if folder is None else folder
    path = kept / f"{name}.jsonl"
    found = (suite_file(name) if folder is None else path) or path
    entries = _read(found) if found.exists() else []
    missing = len(entries) < count
    if missing:
        entries = _drawn(name, count, kept, workers, cluster, progress)
    check_frozen(name, entries)
    if missing:
        kept.mkdir(parents=True, exist_ok=True)
        write_whole(path, "".join(_line(entry) + "\n" for entry in entries))
    return entries[:count]


def check_frozen(name: str, entries: Sequence[Entry]) -> None:
    """Refuse entries whose first ones are not those that were frozen, as many as fit."""
    for count, wanted in sorted(FROZEN.get(name, {}).items()):
        if count <= len(entries) and (digest := hash_of(entries[:count])) != wanted:
            raise SuiteError(
                f"suite {name!r}: its first {count} have hash {digest}, and were frozen as {wanted}"
            )


def _drawn(
    name: str,
    count: int,
    folder: Path,
    workers: int | None,
    cluster: str | None,
    progress: Callable[[int], None],
) -> list[Entry]:
    """Draw a suite as a dataset, or from draws in turn; both go on where they were interrupted."""
    if name in turns.STRATA:
        with crew_of(workers, cluster) as crew:
            found = turns.first_of(name, count, folder, crew, progress)
        return [_entry({"suite": name, **values}) for values in found]
    from gcm_learn import dataset  # needs pyarrow

    spec = SUITES[name].spec(name, -(-count // SHARD) * SHARD)
    dataset.generate(spec, folder / name, workers, cluster=cluster, progress=progress)
    records = dataset.open(folder / name)
    entries = []
    for k in range(len(records)):
        record = records[k]
        earliest = _earliest(record)
        entries.append(
            Entry(name, record.index, record.situation, record.family, record.stratum, earliest)
        )
    return entries


def _earliest(record: Record) -> float:
    """Catch time of the oracle, or of the first of the plans if it was not run [s]."""
    if record.oracle is not None:
        return record.oracle.upper
    times = (plan.catch_time for plan in record.plans.values())
    return min((t for t in times if t is not None), default=math.inf)


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


def hash_of(entries: Sequence[Entry]) -> str:
    """Hash of situations and strata, in order.

    When the oracle catches is no part of it: that changes by a hair whenever it gets better.
    """
    lines = (f"{_line(replace(entry, earliest=math.inf))}\n" for entry in entries)
    return content_hash(*lines)[:16]
