"""Suites: situations that all are compared on, frozen by hash.

Suites that ship are files in `data/benchmark`, each frozen as a whole. Drawn suites are made on
demand, from the specification of a dataset or by `turns`, and are kept as lines; of these the first
situations, as many as were frozen, must have the hash that is noted here.
"""

from __future__ import annotations

import gzip
import json
import math
import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

from gcm_learn import artifacts
from gcm_learn.errors import SuiteError
from gcm_learn.evaluation import turns
from gcm_learn.families import family_names
from gcm_learn.processes import crew_of
from gcm_learn.situation import situation_to_json
from gcm_learn.storage import content_hash, write_whole

if TYPE_CHECKING:
    from pathlib import Path

    from gcm_learn.dataset import DatasetSpec, Record

LARGEST = 1000  # situations of a drawn suite
SHARD = 25
FOLDER = "suites"


@dataclass(frozen=True)
class Suite:
    """A frozen file of situations that ships."""

    name: str
    version: int
    sha256: str
    """Of the file, unpacked."""
    count: int
    """Situations, without the warm-up."""
    card: str
    """Origin, use, and what is known of it."""
    licence: str

    @property
    def file(self) -> str:
        """Path of the file among the data."""
        return f"benchmark/{self.name}-{self.version}.jsonl.gz"

    def content(self) -> bytes:
        """Return the lines of the file.

        Raises
        ------
        SuiteError
            If the file is missing, or has another hash.
        """
        found = artifacts.find("data", self.file)
        if found is None:
            raise SuiteError(artifacts.missing("data", f"suite {self.file!r}"))
        content = gzip.decompress(found.read_bytes())
        digest = content_hash(content)
        if digest != self.sha256:
            raise SuiteError(
                f"suite {self.name!r}: version {self.version} has hash {digest[:16]}, "
                f"and was frozen as {self.sha256[:16]}"
            )
        return content


SHIPPED = {
    name: Suite(name, **values)
    for name, values in tomllib.loads(
        (artifacts.shipped("data") / "benchmark" / "suites.toml").read_text("utf-8")
    ).items()
}
OUTSIDE: dict[str, str] = {
    name: f"gcm-learn convert {name} SOURCE --out {name}.jsonl"
    for name in ("motionbenchmaker", "si-rrt", "table-tennis")
}
"""Suites of others, whose files are not ours to ship, and the commands that make them."""

FASTER = {"speed": [1.2, 2.4]}  # of bodies that are drawn anywhere [hand speeds]
LONG_ARM = {"arm": {"upper_arm": [1.3, 1.5]}}
_EACH = {"L": 1.0, "W": 1.0, "Q": 1.0, "U": 1.0}
FROZEN: Mapping[str, Mapping[int, str]] = {
    "demo": {50: "4b1d538bf1653227"},
    "natural": {50: "2de41ea9eaf316fd", 300: "be1df849b66b2fd6"},
    "L": {50: "3ac395991ed23ca4", 300: "f19fd5215733d8a8", 1000: "4226e9f8d556b75c"},
    "W": {50: "dc8f70954adff697", 300: "4ebc8c176236a29d", 1000: "43c6d9b088eb97d1"},
    "Q": {50: "ef81cd324814245e", 300: "499288c6b95524d9", 1000: "2e7b70fe03a83b11"},
    "U": {50: "987b0b57da941658", 300: "daceb4b193f594a7", 1000: "fedfd90da77a052a"},
    "faster": {50: "c6d42d41c7c3628f"},
    "long-arm": {50: "096d2277fc353126"},
    "held-out": {50: "728f8ed8ace9ab4c"},
}
"""Hashes of the first situations of a drawn suite, by how many; a draw has to have all that fit."""


@dataclass(frozen=True)
class SuiteDraw:
    """Specification of a drawn suite."""

    summary: str
    seed: int
    families: Mapping[str, Mapping[str, Any]]
    """By name, with the ranges that differ from their own; drawn equally often."""
    strata: Mapping[str, float] | None = None
    label: Literal["oracle", "fast"] = "oracle"
    """Judge of the strata: for spatial arms `straight` and `search`, since a yardstick takes
    seconds. These get better, so such suites are not frozen."""
    called: str = ""
    """Name in its file, where that differs from the suite's."""

    def spec(self, name: str, count: int) -> DatasetSpec:
        """Return the dataset that holds the first `count` of them."""
        from gcm_learn.dataset import DatasetSpec, FamilyShare  # needs pyarrow

        families = tuple(FamilyShare(f, 1.0, config) for f, config in self.families.items())
        planners = ("straight",) if self.label == "oracle" else ("straight", "search")
        return DatasetSpec(
            name=self.called or name, seed=self.seed, count=count, families=families,
            planners=planners, map="none", label=self.label, strata=self.strata, shard_size=SHARD,
        )  # fmt: skip


DRAWN: dict[str, SuiteDraw] = {
    "natural": SuiteDraw("bodies anywhere, as drawn", 9101, {"random-planar": {}}),
    "faster": SuiteDraw("bodies anywhere, twice as fast", 9105, {"random-planar": FASTER}),
    "long-arm": SuiteDraw(
        "an upper arm longer than any in training",
        9106,
        dict.fromkeys(("random-planar", "crossing-swarm", "gate"), LONG_ARM),
    ),
    "demo": SuiteDraw(
        "equal parts of all strata and families", 9107, {f: {} for f in turns.FAMILIES}, _EACH
    ),
    "space-demo": SuiteDraw(
        "equal parts of all strata, spatial arms",
        9111,
        {f: {} for f in family_names("spatial")},
        _EACH,
        label="fast",
    ),
    "held-out": SuiteDraw(
        "pendulums, which no shipped model met in training",
        9200,
        {"pendulum": {}},
        called="pendulum",
    ),
}
Line = dict[str, Any]
"""A line of a drawn suite's file: suite, index, family, stratum, earliest and situation."""


def drawn_names() -> list[str]:
    """Return the names of the drawn suites."""
    return [*DRAWN, *turns.STRATA]


def suite_file(name: str) -> Path | None:
    """Return the file of a drawn suite that is there already, or None."""
    return artifacts.find("data", f"{FOLDER}/{name}.jsonl")


def draw_suite(
    name: str,
    count: int,
    folder: Path | None = None,
    workers: int | None = 1,
    *,
    seed: int | None = None,
    cluster: str | None = None,
    progress: Callable[[int], None] = lambda new: None,
) -> list[Line]:
    """Return the first `count` situations of a drawn suite; draw those missing in the folder.

    Parameters
    ----------
    name : str
    count : int
        At most 1000.
    folder : Path, optional
        Where suites are kept; by default they are found as `artifacts` says.
    workers, cluster
        See `processes.crew_of`.
    seed : int, optional
        With it a suite is drawn anew, and not frozen.
    progress : callable
        Called with the number of new situations.

    Raises
    ------
    SuiteError
        If what is there, or drawn, is not what was frozen.
    """
    if not 1 <= count <= LARGEST:
        raise SuiteError(f"count: must be from 1 to {LARGEST} (got {count})")
    kept = artifacts.kept("data") / FOLDER if folder is None else folder
    if seed is not None:
        return _drawn(name, count, kept / f"{seed}", workers, cluster, progress, seed)[:count]
    path = kept / f"{name}.jsonl"
    found = (suite_file(name) if folder is None else path) or path
    lines: list[Line] = []
    if found.exists():
        lines = [json.loads(line) for line in found.read_text("utf-8").splitlines()]
    missing = len(lines) < count
    if missing:
        lines = _drawn(name, count, kept, workers, cluster, progress)
    check_frozen(name, lines)
    if missing:
        kept.mkdir(parents=True, exist_ok=True)
        write_whole(path, "".join(json.dumps(line) + "\n" for line in lines))
    return lines[:count]


def check_frozen(name: str, lines: Sequence[Line]) -> None:
    """Raise SuiteError unless the first lines have the hash with which they were frozen."""
    for count, wanted in sorted(FROZEN.get(name, {}).items()):
        if count <= len(lines) and (digest := hash_of(lines[:count])) != wanted:
            raise SuiteError(
                f"suite {name!r}: its first {count} have hash {digest}, and were frozen as {wanted}"
            )


def hash_of(lines: Sequence[Line]) -> str:
    """Return the hash of situations and strata, in order.

    When the oracle catches is no part of it: that changes by a hair whenever it gets better.
    """
    return content_hash(*(f"{json.dumps(line | {'earliest': None})}\n" for line in lines))[:16]


def _drawn(
    name: str,
    count: int,
    folder: Path,
    workers: int | None,
    cluster: str | None,
    progress: Callable[[int], None],
    seed: int | None = None,
) -> list[Line]:
    """Draw a suite as a dataset, or from draws in turn; both go on where they were interrupted."""
    if name in turns.STRATA:
        with crew_of(workers, cluster) as crew:
            of = turns.SEED if seed is None else seed
            lines = turns.first_of(name, count, folder, crew, of, progress)
        return [{"suite": name} | line for line in lines]
    from gcm_learn import dataset  # needs pyarrow

    draw = DRAWN[name] if seed is None else replace(DRAWN[name], seed=seed)
    spec = draw.spec(name, -(-count // SHARD) * SHARD)
    dataset.generate(spec, folder / name, workers, cluster=cluster, progress=progress)
    records = dataset.open(folder / name)
    return [_line(draw.called or name, records[k]) for k in range(len(records))]


def _line(name: str, record: Record) -> Line:
    """Return the line of a record."""
    if record.oracle is not None:
        earliest = record.oracle.upper
    else:
        times = (plan.catch_time for plan in record.plans.values())
        earliest = min((t for t in times if t is not None), default=math.inf)
    return {
        "suite": name,
        "index": record.index,
        "family": record.family,
        "stratum": record.stratum,
        "earliest": earliest if math.isfinite(earliest) else None,
        "situation": situation_to_json(record.situation),
    }
