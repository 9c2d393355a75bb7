"""Verification of datasets: bytes, plans and items are checked anew."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

from gcm_learn.dataset.folder import Folder
from gcm_learn.dataset.generation import crew_for
from gcm_learn.dataset.item import make_item, warmed
from gcm_learn.dataset.manifest import faults_of, read_manifest, spec_of
from gcm_learn.dataset.reader import Dataset, open_shard
from gcm_learn.dataset.record import Record, rows_of
from gcm_learn.dataset.shards import code_version, info_of, shard_name
from gcm_learn.dataset.spec import DatasetSpec
from gcm_learn.dataset.splits import lot_of
from gcm_learn.errors import DatasetError, GcmError
from gcm_learn.planners import broken_promise
from gcm_learn.processes import cores

MOST_FAULTS = 20  # that a report quotes
REMAKE = 2  # salt of the lot that decides which item of a shard is made again


@dataclass(frozen=True)
class DatasetReport:
    """Result of the verification of a dataset, or of a part."""

    records: int = 0
    plans: int = 0
    """Catches whose whole path was verified anew."""
    remade: int = 0
    """Items that were made again and compared."""
    faults: int = 0
    quoted: tuple[str, ...] = ()
    """The first few faults, one line each."""

    def __add__(self, other: DatasetReport) -> DatasetReport:
        return DatasetReport(
            self.records + other.records,
            self.plans + other.plans,
            self.remade + other.remade,
            self.faults + other.faults,
            (self.quoted + other.quoted)[:MOST_FAULTS],
        )


def verify_dataset(
    path: str | os.PathLike[str],
    workers: int | None = None,
    *,
    progress: Callable[[int], None] = lambda records: None,
) -> DatasetReport:
    """Check a dataset against its manifest, and its plans against the world.

    Parameters
    ----------
    path : path-like
        Folder or URL.
    workers : int, optional
        Processes; by default one for each core that this one may use.
    progress : callable
        Told the number of records that have been checked.

    Returns
    -------
    DatasetReport
        Faults: a shard that is missing or whose bytes changed, a catch that does not hold, an item
        that is not made again as it is stored (one of each shard that this code has made).
    """
    folder = Folder(path)
    manifest = read_manifest(folder)
    if manifest is None:
        raise DatasetError(f"{folder.url}: has no manifest to check it against")
    spec = spec_of(folder)
    work = partial(warmed, spec, partial(verify_shard, spec, url=folder.url))
    expected = {entry["name"] for entry in manifest["shards"]}
    shards = [k for k in range(spec.shards) if folder.exists(shard_name(k))]
    report = sum(map(_fault, faults_of(folder, hashes=True)), DatasetReport())
    with crew_for(folder, workers or cores()) as crew:
        for part in crew.map(work, shards):
            report += part
            progress(part.records)
    if len(expected) < spec.shards:
        report += _fault(f"{spec.shards - len(expected)} of {spec.shards} shards are missing")
    return report


def verify_shard(spec: DatasetSpec, shard: int, url: str) -> DatasetReport:
    """Check the records of a shard."""
    folder, name = Folder(url), shard_name(shard)
    try:
        info, records = info_of(folder, name), open_shard(folder, spec, name)
    except (GcmError, OSError) as error:
        return _fault(f"{name}: {error}")
    report = DatasetReport(records=len(records))
    if info.spec != spec.digest:
        report += _fault(f"{name}: is of another specification")
    for record in records:
        report += _checked(record, name)
    if info.code == code_version():
        report += _remade(spec, shard, records, name)
    return report


def _checked(record: Record, name: str) -> DatasetReport:
    """Verify the catches of a record."""
    where = f"{name}: item {record.index}"
    try:
        faults = list(_broken_plans(record))
        caught = sum(plan.caught for plan in record.plans.values())
    except (GcmError, ValueError, KeyError, TypeError) as error:
        return _fault(f"{where}: cannot be read ({error})")
    report = DatasetReport(plans=caught)
    for fault in faults:
        report += _fault(f"{where}: {fault}")
    return report


def _broken_plans(record: Record) -> Iterator[str]:
    for name, plan in record.plans.items():
        fault = broken_promise(record.situation, plan)
        if fault is not None:
            yield f"the plan of {name} does not hold: {fault}"
    if record.stratum == "U" and any(plan.caught for plan in record.plans.values()):
        yield "the stratum is U, but there is a catch"


def _remade(spec: DatasetSpec, shard: int, records: Dataset, name: str) -> DatasetReport:
    """Make one item of a shard again, and compare the result with the stored record."""
    indices = spec.indices(shard)
    k = indices[int(lot_of(spec.seed, shard, REMAKE) * len(indices))]
    fresh = rows_of(spec, [make_item(spec, k)])
    stored = records[records.column("index") == k].table(fresh.column_names)
    same = not len(stored) or stored.replace_schema_metadata(None).equals(fresh)
    report = DatasetReport(remade=1)
    return report if same else report + _fault(f"{name}: item {k} is made differently now")


def _fault(text: str) -> DatasetReport:
    return DatasetReport(faults=1, quoted=(text,))
