"""Datasets as they are read: by index, by label, as a table."""

from __future__ import annotations

import os
from collections import OrderedDict
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, overload

import numpy as np
import pyarrow as pa

from gcm_learn.arms import PLANAR
from gcm_learn.dataset.cells import COLUMNS, WINDOW, Example, MapCache, build_cache, stream
from gcm_learn.dataset.folder import SHARDS, Folder
from gcm_learn.dataset.manifest import Manifest, read_manifest, spec_of
from gcm_learn.dataset.record import LABELS, Record, Row, version_of
from gcm_learn.dataset.shards import ROW_GROUP, header_of, read_columns
from gcm_learn.dataset.spec import DatasetSpec
from gcm_learn.errors import DatasetError, UnknownNameError
from gcm_learn.storage import content_hash

if TYPE_CHECKING:
    from pandas import DataFrame

BLOCK = 1000  # records that are copied into a cache at a time
GROUPS_KEPT = 16  # row groups that stay decoded, for readers that stay near


class Group(NamedTuple):
    """Records that stand together in a shard."""

    shard: int
    """Position of the shard among the dataset's."""
    group: int
    """Row group within the shard."""
    offsets: np.ndarray
    """Positions of the records within the row group (m,)."""


class _Shelf:
    """Shards of a dataset, with caches of the labels and row groups that have been read."""

    def __init__(self, folder: Folder, spec: DatasetSpec, names: list[str]) -> None:
        self.folder, self.spec, self.names = folder, spec, names
        self._labels: dict[str, np.ndarray] = {}
        self._groups: OrderedDict[tuple[int, int], pa.RecordBatch] = OrderedDict()
        rows = [len(self.read(shard, ["index"])) for shard in range(len(names))]
        self.starts = np.concatenate([[0], np.cumsum(rows)])
        """Place of the first item of every shard, and of the end."""

    def read(self, shard: int, columns: list[str] | None = None) -> pa.Table:
        """Columns of a shard."""
        return read_columns(self.folder, self.names[shard], columns)

    def read_group(self, shard: int, group: int, columns: list[str] | None = None) -> pa.Table:
        """Columns of a row group of a shard."""
        return read_columns(self.folder, self.names[shard], columns, group)

    def column(self, name: str) -> np.ndarray:
        """A label column of all shards, failed items included (m,)."""
        if name not in LABELS:
            raise UnknownNameError.among("column", name, LABELS)
        if name not in self._labels:
            parts = [self.read(shard, [name]) for shard in range(len(self.names))]
            self._labels[name] = pa.concat_tables(parts)[name].to_numpy()
        return self._labels[name]

    def row(self, place: int) -> Row:
        """The item at a place, counted over all shards."""
        shard = int(np.searchsorted(self.starts, place, side="right")) - 1
        group, offset = divmod(place - int(self.starts[shard]), ROW_GROUP)
        key = (shard, group)
        if key not in self._groups:
            table = self.read_group(shard, group)
            self._groups[key] = table.combine_chunks().to_batches()[0]
            if len(self._groups) > GROUPS_KEPT:
                self._groups.popitem(last=False)
        self._groups.move_to_end(key)
        return Row(self._groups[key], offset)

    def __getstate__(self) -> dict[str, Any]:
        """Decoded records stay in their process."""
        return self.__dict__ | {"_groups": OrderedDict(), "_labels": {}}


class Dataset(Sequence[Record]):
    """Records that can be counted, indexed, sliced and filtered.

    Items that failed and twins are left out. Slices and `where` give datasets over the same files;
    neither reads a map.
    """

    def __init__(
        self, shelf: _Shelf, places: np.ndarray, everything: np.ndarray | None = None
    ) -> None:
        self._shelf = shelf
        self._places = places
        """Position of every record among all items of the shards (m,)."""
        self._all = places if everything is None else everything
        """Places of all records of the dataset of which this is a part."""

    @property
    def spec(self) -> DatasetSpec:
        """Specification of the dataset."""
        return self._shelf.spec

    @property
    def manifest(self) -> Manifest | None:
        """Manifest that was written last, or None."""
        return read_manifest(self._shelf.folder)

    @property
    def folder(self) -> Folder:
        """Folder of the dataset."""
        return self._shelf.folder

    @property
    def files(self) -> list[str]:
        """Paths of the dataset's shards: Parquet files that other libraries can read."""
        return [self._shelf.folder.path(name) for name in self._shelf.names]

    def __len__(self) -> int:
        return len(self._places)

    @overload
    def __getitem__(self, k: int) -> Record: ...

    @overload
    def __getitem__(self, k: slice | np.ndarray) -> Dataset: ...

    def __getitem__(self, k: int | slice | np.ndarray) -> Record | Dataset:
        """Return record k, or the records of a slice, of positions, or of an array of bool."""
        if isinstance(k, slice | np.ndarray):
            return Dataset(self._shelf, self._places[k], self._all)
        return Record(self.spec, {}, self._shelf.row(int(self._places[k])))

    def part(self, rows: np.ndarray) -> Dataset:
        """Records by position (m,) as a dataset of their own, light enough to be sent elsewhere."""
        return Dataset(self._shelf, self._places[rows])

    def __iter__(self) -> Iterator[Record]:
        return (self[k] for k in range(len(self)))

    def column(self, name: str) -> np.ndarray:
        """A label of every record (m,), without reading anything else."""
        return self._shelf.column(name)[self._places]

    def where(self, **labels: object) -> Dataset:  # the one place where names are the message
        """The records with these labels: ``where(stratum="Q", family=("gate", "pendulum"))``.

        Parameters
        ----------
        **labels
            A column's value, several of which any will do, or a function of the column (m,) that
            returns truth values (m,).
        """
        keep = np.ones(len(self), dtype=bool)
        for name, wanted in labels.items():
            column = self.column(name)
            if callable(wanted):
                keep &= np.asarray(wanted(column), dtype=bool)
            elif isinstance(wanted, tuple | list | set | frozenset):
                keep &= np.isin(column, list(wanted))
            else:
                keep &= column == wanted
        return self[keep]

    def cache(
        self, folder: str | os.PathLike[str] | None = None, labels: Sequence[str] = ()
    ) -> MapCache:
        """The maps for random access, from files that are written the first time.

        Parameters
        ----------
        folder : path-like, optional
            Where caches are kept; by default see `Folder.caches`.
        labels : sequence of str
            Label columns that the examples carry.
        """
        self._check_maps()
        if folder is None and self.folder.local is None:
            raise DatasetError(f"{self.folder.url}: is not on this machine; name a folder for it")
        whole = Dataset(self._shelf, self._all)
        indices = whole.column("index")
        key = content_hash(f"{version_of(self.spec)} {self.spec.digest}", indices.tobytes())
        place = Path(folder or self.folder.caches()) / key[:16]
        if not place.exists():
            blocks = (whole[k : k + BLOCK].table(COLUMNS) for k in range(0, len(whole), BLOCK))
            build_cache(place, self.spec.n, len(whole), blocks)
        rows = np.searchsorted(indices, self.column("index"))
        return MapCache(place, rows, {name: self.column(name) for name in labels})

    def stream(
        self,
        seed: int = 0,
        epoch: int = 0,
        *,
        window: int = WINDOW,
        labels: Sequence[str] = (),
        part: tuple[int, int] = (0, 1),
    ) -> Iterator[Example]:
        """All maps once, in an order that seed, epoch and part decide.

        Row groups are read in a random order, and every example that is read takes the place of a
        random one in the window, which is given out. With a window as large as the dataset every
        order is equally likely.

        Parameters
        ----------
        seed, epoch : int
            Non-negative.
        window : int
            Examples that are held in memory, 13 KB each at 80 x 80 cells.
        labels : sequence of str
            Label columns that examples carry.
        part : (int, int)
            (i, n): the i-th of n parts, which together are the whole.
        """
        self._check_maps()
        groups = self.groups()
        return stream(
            lambda k: self.read_group(groups[k], [*COLUMNS, *labels]),
            len(groups), seed, epoch, window=window, labels=labels, part=part,
        )  # fmt: skip

    def _check_maps(self) -> None:
        """Refuse records without maps, and maps in space."""
        if self.spec.map == "none":
            raise DatasetError(f"{self.folder.url}: its records hold no maps")
        if self.spec.kind is not PLANAR:
            raise DatasetError(f"{self.folder.url}: caches and streams are of maps of the plane")

    def groups(self) -> list[Group]:
        """Return the row groups that hold the records, for readers of whole row groups."""
        shelf = self._shelf
        shards = np.searchsorted(shelf.starts, self._places, side="right") - 1
        within = self._places - shelf.starts[shards]
        keys = shards * (int(within.max(initial=0)) // ROW_GROUP + 1) + within // ROW_GROUP
        cuts = np.flatnonzero(np.diff(keys)) + 1
        parts = np.split(np.arange(len(keys)), cuts) if len(keys) else []
        return [
            Group(int(shards[p[0]]), int(within[p[0]]) // ROW_GROUP, within[p] % ROW_GROUP)
            for p in parts
        ]

    def read_group(self, group: Group, columns: Sequence[str]) -> pa.Table:
        """Columns of the records of a row group."""
        names = list(dict.fromkeys(columns))
        return self._shelf.read_group(group.shard, group.group, names).take(group.offsets)

    def table(self, columns: Sequence[str] | None = None) -> pa.Table:
        """Columns of the records as an Arrow table; by default all, maps and plans included."""
        names = None if columns is None else list(columns)
        shelf, parts = self._shelf, []
        shards = np.searchsorted(shelf.starts, self._places, side="right") - 1
        for shard in np.unique(shards):
            within = self._places[shards == shard] - shelf.starts[shard]
            parts.append(shelf.read(int(shard), names).take(within))
        return pa.concat_tables(parts) if parts else shelf.read(0, names).slice(0, 0)

    def to_pandas(self, columns: Sequence[str] | None = None) -> DataFrame:
        """Columns of the records as a data frame; by default the labels."""
        return self.table(LABELS if columns is None else columns).to_pandas()


def open_dataset(path: str | os.PathLike[str]) -> Dataset:
    """Open a dataset for reading.

    Parameters
    ----------
    path : path-like
        Its folder, or a URL that fsspec understands. It may be unfinished.

    Raises
    ------
    DatasetError
        If there is none, or it is of another version of the schema.
    """
    folder = Folder(path)
    spec = spec_of(folder)
    names = [f"{SHARDS}/{n}" for n in folder.names(SHARDS) if n.endswith(".parquet")]
    if not names:
        raise DatasetError(f"{folder.url}: holds no shards yet")
    header_of(folder, names[0])  # refuses another version
    manifest = read_manifest(folder) or {}
    return _opened(_Shelf(folder, spec, names), manifest.get("twins", {}).get("removed", []))


def open_shard(folder: Folder, spec: DatasetSpec, name: str) -> Dataset:
    """Open the records of one shard, twins included."""
    return _opened(_Shelf(folder, spec, [name]), [])


def _opened(shelf: _Shelf, removed: list[int]) -> Dataset:
    twins = np.isin(shelf.column("index"), removed)
    good = np.array([error is None for error in shelf.column("error")])
    return Dataset(shelf, np.flatnonzero(good & ~twins))
