"""Shards: files of records that are made whole, once, and never changed."""

from __future__ import annotations

import gc
import io
import json
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass, field
from functools import lru_cache
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from gcm_learn import __version__, compiled
from gcm_learn.dataset.folder import SHARDS, Folder
from gcm_learn.dataset.item import make_item
from gcm_learn.dataset.kinds import RECORDS, VERSIONS
from gcm_learn.dataset.record import LABELS, Record, plan_column, rows_of, version_of
from gcm_learn.dataset.spec import DatasetSpec, spec_to_json
from gcm_learn.errors import DatasetError
from gcm_learn.storage import UNFINISHED

KEY = b"gcm-learn"
ROW_GROUP = 100  # records that are read together
BETWEEN_PARTS = 5.0  # [s] after which finished items of a shard are kept
MOST_ERRORS = 20  # that a summary quotes
_WORDS = ("family", "stratum", "split", "structure", "oracle_stratum", "contact_body")
_MADE_BY = (
    "situation",
    "scene",
    "collision",
    "motion",
    "charts",
    "wave",
    "maps",
    "planners",
    "families",
    "dataset",
)


class DamagedShardError(DatasetError):
    """A shard's file cannot be read, or is not that of the manifest."""


@dataclass(frozen=True)
class ShardInfo:
    """Summary of a shard, stored in the metadata of its file."""

    shard: int
    rows: int
    spec: str
    """Digest of the specification."""
    code: str
    """Version of the code that made it."""
    strata: dict[str, dict[str, int]] = field(default_factory=dict)
    """Records by family and stratum."""
    splits: dict[str, int] = field(default_factory=dict)
    attempts: int = 0
    """Situations drawn."""
    rejected: dict[str, int] = field(default_factory=dict)
    caught: dict[str, int] = field(default_factory=dict)
    """Catches by planner."""
    audited: dict[str, int] = field(default_factory=dict)
    """Records with an oracle's label, by "stratum/oracle's stratum"."""
    undecided: int = 0
    """Of them, those in which the oracle neither found a catch nor ruled it out."""
    failed: dict[str, str] = field(default_factory=dict)
    """Errors by index, the first few."""
    failures: int = 0


def shard_name(shard: int) -> str:
    """Name of a shard's file within the dataset's folder."""
    return f"{SHARDS}/shard-{shard:06d}.parquet"


@lru_cache(maxsize=1)
def code_version() -> str:
    """Version of the package and of the sources that decide a record's bytes."""
    return f"{__version__}+{compiled.sources_hash(_MADE_BY)}"


@contextmanager
def uncollected() -> Iterator[None]:
    """Let no collector of garbage look through a growing heap again and again."""
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()


def make_shard(spec: DatasetSpec, shard: int, url: str) -> ShardInfo:
    """Make the items of a shard and write its file.

    Finished items are kept every few seconds, so that a stopped shard goes on from there.
    """
    folder, told = Folder(url), time.monotonic()
    # Items are trees: nothing of them is left to a collector that would visit all of them again
    # and again.
    with uncollected():
        records = _kept(spec, shard, folder)
        table = rows_of(spec, records)
        for k in spec.indices(shard)[len(records) :]:
            records.append(make_item(spec, k))
            if time.monotonic() - told > BETWEEN_PARTS:
                table = _grown(spec, table, records)
                info = ShardInfo(shard, len(records), spec.digest, code_version())
                folder.write(_part_name(shard), file_of(spec, table, info))
                told = time.monotonic()
        table = _grown(spec, table, records)
        return write_shard(spec, shard, records, url, table)


def _part_name(shard: int) -> str:
    """Return the name of the file that holds the first items of an unfinished shard."""
    return f"{SHARDS}/.shard-{shard:06d}{UNFINISHED}"


def _kept(spec: DatasetSpec, shard: int, folder: Folder) -> list[Record]:
    """Return the first items of a shard that was stopped; none if other code made them."""
    name = _part_name(shard)
    if not 0 < _rows_kept(spec, folder, name) <= len(spec.indices(shard)):
        return []
    try:
        return [Record(spec, {}, row) for row in read_columns(folder, name).to_pylist()]
    except DamagedShardError:
        return []


def _rows_kept(spec: DatasetSpec, folder: Folder, name: str) -> int:
    """Return the number of items that a stopped shard's file has from this code."""
    if folder.exists(name):
        with suppress(DatasetError):
            info = info_of(folder, name)
            return info.rows if (info.spec, info.code) == (spec.digest, code_version()) else 0
    return 0


def kept(spec: DatasetSpec, folder: Folder) -> int:
    """Return how many items of shards that were stopped are there to go on with."""
    names = [name for name in folder.names(SHARDS) if name.startswith(".shard-")]
    return sum(_rows_kept(spec, folder, f"{SHARDS}/{name}") for name in names)


def _grown(spec: DatasetSpec, table: pa.Table, records: Sequence[Record]) -> pa.Table:
    """Return a table of the first records, extended by rows for the remaining records."""
    return pa.concat_tables([table, rows_of(spec, records[len(table) :])]).combine_chunks()


def write_shard(
    spec: DatasetSpec,
    shard: int,
    records: Sequence[Record],
    url: str,
    table: pa.Table | None = None,
) -> ShardInfo:
    """Write the records of a shard to its file; `table`, if given, holds the same records."""
    info, folder = _summary(spec, shard, records), Folder(url)
    folder.write(shard_name(shard), file_of(spec, table or rows_of(spec, records), info))
    folder.remove(_part_name(shard))
    return info


def file_of(spec: DatasetSpec, table: pa.Table, info: ShardInfo) -> memoryview:
    """Return the content of a shard's file."""
    content = spec_to_json(spec)
    del content["count"]  # a larger dataset has the same shards
    header = {"format": version_of(spec), "info": asdict(info), "spec": content}
    metadata = {KEY: json.dumps(header, sort_keys=True).encode()}
    sink = io.BytesIO()
    pq.write_table(
        table.replace_schema_metadata(metadata),
        sink,
        compression="zstd",
        row_group_size=ROW_GROUP,
        use_dictionary=[*(c for c in _WORDS if c in table.column_names), *_plan_words(spec)],
        column_encoding=_encodings(spec),
        write_statistics=list(LABELS),
    )
    return sink.getbuffer()


def _plan_words(spec: DatasetSpec) -> list[str]:
    """Columns of plans that hold few different words."""
    fields = ("status", "message", "catch_body")
    return [f"{plan_column(name)}.{word}" for name in spec.planners for word in fields]


def _encodings(spec: DatasetSpec) -> dict[str, str]:
    """Numbers of paths are stored byte by byte: the high bytes of neighbours are alike."""
    plan = RECORDS.of(spec.kind).plan
    lists = [part.name for part in plan if part.type == pa.list_(pa.float64())]
    columns = [f"{plan_column(name)}.{part}" for name in spec.planners for part in lists]
    return {f"{column}.list.element": "BYTE_STREAM_SPLIT" for column in columns}


def _summary(spec: DatasetSpec, shard: int, records: Sequence[Record]) -> ShardInfo:
    found = [record for record in records if record.error is None]
    failed = {str(one.index): one.error for one in records if one.error is not None}
    rejected = sum((Counter(one.rejected) for one in records), Counter[str]())
    strata: dict[str, Counter[str]] = {}
    for one in found:
        strata.setdefault(one.family, Counter())[one.stratum] += 1
    audited = [(one.stratum, one.oracle) for one in found if one.oracle is not None]
    caught = Counter(n for one in found for n, plan in one.plans.items() if plan.caught)
    return ShardInfo(
        shard=shard,
        rows=len(records),
        spec=spec.digest,
        code=code_version(),
        strata={family: dict(sorted(strata[family].items())) for family in sorted(strata)},
        splits=dict(sorted(Counter(one.split for one in found).items())),
        attempts=sum(one.attempts for one in records),
        rejected=dict(sorted(rejected.items())),
        caught={name: caught[name] for name in spec.planners},
        audited=dict(sorted(Counter(f"{s}/{o.stratum}" for s, o in audited).items())),
        undecided=sum(not o.decided for _, o in audited),
        failed=dict(list(failed.items())[:MOST_ERRORS]),
        failures=len(failed),
    )


def read_columns(
    folder: Folder, name: str, columns: Sequence[str] | None = None, group: int | None = None
) -> pa.Table:
    """Read columns of a shard, or of one of its row groups; by default all columns.

    Without Arrow's threads: training reads in many processes as it is, and a short process may end
    while such threads are still being started, which aborts it.
    """
    names = None if columns is None else list(columns)
    with _opened(folder, name) as file:
        if group is None:
            return file.read(names, use_threads=False)
        return file.read_row_group(group, names, use_threads=False)


@contextmanager
def _opened(folder: Folder, name: str) -> Iterator[pq.ParquetFile]:
    """Open a shard's file; raise an error with the file's name if it cannot be read."""
    try:
        with folder.open(name) as stream:
            yield pq.ParquetFile(stream, pre_buffer=False)
    except (OSError, pa.ArrowException, ValueError) as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise DamagedShardError(f"{folder.where(name)}: not a shard ({reason})") from None


def header_of(folder: Folder, name: str) -> dict[str, Any]:
    """Return the header of a shard's file.

    Raises
    ------
    DatasetError
        If it is no shard, or one of another version of the schema.
    """
    with _opened(folder, name) as file:
        metadata, rows = file.schema_arrow.metadata or {}, file.metadata.num_rows
        header = json.loads(metadata.get(KEY, b"{}"))
    if header.get("format") not in VERSIONS:
        is_, known = header.get("format", "none"), " and ".join(VERSIONS)
        raise DatasetError(f"{folder.where(name)}: schema is {is_}, this version reads {known}")
    if header["info"]["rows"] != rows:
        raise DatasetError(f"{folder.where(name)}: {rows} rows, not {header['info']['rows']}")
    return header


def info_of(folder: Folder, name: str) -> ShardInfo:
    """Return the summary of a shard that exists."""
    return ShardInfo(**header_of(folder, name)["info"])
