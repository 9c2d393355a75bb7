"""Maps laid out for random access: plain arrays in files that are mapped into memory.

A Parquet file is decoded a hundred records at a time, which is right for streams and wrong for
training that jumps about.  The cache is built once and shared by all processes.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pyarrow as pa

from gcm_learn.dataset.examples import Example
from gcm_learn.dataset.schema import VERSION
from gcm_learn.errors import DatasetError
from gcm_learn.storage import content_hash, whole_folder

if TYPE_CHECKING:
    from gcm_learn.dataset.reader import Dataset

FILES = ("arrival", "obstacles", "quantum", "horizon", "index")
BLOCK = 1000  # records that are copied at a time


class MapCache(Sequence[Example]):
    """The maps of a dataset, or of a part of one, at random.

    Parameters
    ----------
    folder : Path
        Where the arrays are.
    rows : (m,) ndarray of int
        Which of their rows.
    labels : mapping of str to ndarray
        Columns (m,) that examples carry.
    """

    def __init__(self, folder: Path, rows: np.ndarray, labels: dict[str, np.ndarray]) -> None:
        self.folder, self._rows, self._labels = folder, rows, labels
        self._open()

    def _open(self) -> None:
        arrays = {name: np.load(self.folder / f"{name}.npy", mmap_mode="r") for name in FILES}
        # Plain arrays over the same memory: what numpy does for a memmap costs more than the read.
        self.arrival = arrays["arrival"].view(np.ndarray)
        """(m, n, n) uint16: arrivals of all records of the cache."""
        self.obstacles = arrays["obstacles"].view(np.ndarray)
        """(m, n * n / 8) uint8: bits of their effective obstacles."""
        self._small = {name: np.array(arrays[name]) for name in ("quantum", "horizon", "index")}

    def __len__(self) -> int:
        return len(self._rows)

    def __getitem__(self, k: Any) -> Any:
        """Example k, or those of a slice as a cache."""
        if isinstance(k, slice):
            labels = {name: column[k] for name, column in self._labels.items()}
            return MapCache(self.folder, self._rows[k], labels)
        row, small = self._rows[k], self._small
        return Example(
            index=int(small["index"][row]),
            arrival=self.arrival[row],
            obstacles=self.obstacles[row],
            quantum=float(small["quantum"][row]),
            horizon=float(small["horizon"][row]),
            labels={name: column[k] for name, column in self._labels.items()},
        )

    def __getstate__(self) -> tuple[Path, np.ndarray, dict[str, np.ndarray]]:
        """Other processes map the same files."""
        return self.folder, self._rows, self._labels

    def __setstate__(self, state: tuple[Path, np.ndarray, dict[str, np.ndarray]]) -> None:
        self.folder, self._rows, self._labels = state
        self._open()


def cached(
    records: Dataset, whole: Dataset, folder: str | os.PathLike[str] | None, labels: Sequence[str]
) -> MapCache:
    """The cache of some records; built for all of the dataset's if it is not there.

    Parameters
    ----------
    records : Dataset
        Those that are wanted.
    whole : Dataset
        All of the dataset.
    folder : path-like, optional
        Where caches are kept; by default within the dataset's folder, if that is on this machine.
    labels : sequence of str
        Label columns that examples carry.
    """
    if records.spec.map == "none":
        raise DatasetError(f"{records.folder.url}: its records hold no maps")
    if folder is None and records.folder.local is None:
        raise DatasetError(f"{records.folder.url}: is not on this machine; name a folder for it")
    indices = whole.column("index")
    key = content_hash(f"{VERSION} {records.spec.digest}", indices.tobytes())
    place = Path(folder or records.folder.path("cache")) / key[:16]
    if not place.exists():
        with whole_folder(place) as empty:
            _fill(whole, empty)
    rows = np.searchsorted(indices, records.column("index"))
    return MapCache(place, rows, {name: records.column(name) for name in labels})


def _fill(whole: Dataset, folder: Path) -> None:
    """Copy the maps of a dataset into arrays."""
    n, count = whole.spec.n, len(whole)
    shapes = {
        "arrival": ((count, n, n), "<u2"),
        "obstacles": ((count, -(-n * n // 8)), "u1"),
        "quantum": ((count,), "f8"),
        "horizon": ((count,), "f8"),
        "index": ((count,), "i8"),
    }
    files = {
        name: np.lib.format.open_memmap(folder / f"{name}.npy", "w+", kind, shape)
        for name, (shape, kind) in shapes.items()
    }
    columns = ["arrival", "effective_obstacles", "quantum", "horizon", "index"]
    for first in range(0, count, BLOCK):
        table = whole[first : first + BLOCK].table(columns)
        block = slice(first, first + len(table))
        for name, column in zip(FILES, columns, strict=True):
            files[name][block] = _values(table[column], *shapes[name])
    for array in files.values():
        array.flush()


def _values(column: pa.ChunkedArray, shape: tuple[int, ...], kind: str) -> np.ndarray:
    """A column as an array; binary cells become rows."""
    if pa.types.is_binary(column.type):
        cells = b"".join(column.to_pylist())
        return np.frombuffer(cells, kind).reshape(-1, *shape[1:])
    return column.to_numpy()
