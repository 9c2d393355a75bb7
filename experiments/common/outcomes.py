"""Outcomes of single situations: files that every table of an experiment is computed from.

One row is the answer of one method to one situation. Rows are sorted and the compressed file has no
time stamp, so the same answers give the same bytes.
"""

from __future__ import annotations

import csv
import gzip
import io
import json
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from gcm_learn.storage import write_whole

COLUMNS = (
    "situation", "stratum", "family", "method", "seed", "caught", "catch_time", "ms", "checks",
    "looks", "bends", "complaints",
)  # fmt: skip
"""Columns of every file: `situation` is a name or number, `seed` that of the training if there are
several, `catch_time` in s, `ms` processor time, `complaints` how many the referee has. Checks,
looks and bends are counted where memories are tried. Other columns belong to an experiment."""
WORDS = ("situation", "stratum", "family", "method")
DIGITS = {"catch_time": 6, "ms": 3}
"""Decimals of numbers that are written."""


class Outcomes:
    """Rows of a file by column.

    Parameters
    ----------
    columns : dict of str to (n,) ndarray
        Words, `caught` as bool, and other numbers as float, NaN where there is none.
    """

    def __init__(self, columns: Mapping[str, np.ndarray]) -> None:
        self.columns = dict(columns)

    def __getitem__(self, name: str) -> np.ndarray:
        """Return a column (n,)."""
        return self.columns[name]

    def __len__(self) -> int:
        return len(self.columns["situation"])

    def where(self, kept: np.ndarray | None = None, **words: Any) -> Outcomes:
        """Return the rows of a mask (n,) whose columns have the words or one of several words."""
        kept = np.ones(len(self), bool) if kept is None else np.array(kept, bool)
        for name, word in words.items():
            kept &= np.isin(self[name], [word] if isinstance(word, str | int) else list(word))
        return Outcomes({name: column[kept] for name, column in self.columns.items()})

    def methods(self) -> list[str]:
        """Return the names of the methods, sorted."""
        return sorted(set(self["method"].tolist()))

    def by_situation(self, names: Sequence[str]) -> Iterator[Outcomes]:
        """Yield the rows of each method, for the situations that all of them answered."""
        rows = [self.where(method=name) for name in names]
        shared = set.intersection(*(set(one["situation"].tolist()) for one in rows))
        for one in rows:
            yield one.where(situation=shared)


def write(file: Path, rows: Iterable[Mapping[str, Any]]) -> None:
    """Write rows, sorted by situation, method and seed.

    Parameters
    ----------
    file : Path
        Ends with ``.csv.gz``.
    rows : iterable of dict
        Values by column; what is missing or None stays empty.
    """
    rows = [dict(row) for row in rows]
    more = sorted({name for row in rows for name in row} - set(COLUMNS))
    names = [*COLUMNS, *more]
    cells = sorted([_cell(name, row.get(name)) for name in names] for row in rows)
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([names, *cells])
    write_whole(file, gzip.compress(text.getvalue().encode("utf-8"), 9, mtime=0))


def kept(file: Path, make: Callable[[], Iterable[Mapping[str, Any]]]) -> list[dict[str, Any]]:
    """Read rows from a file of JSON lines; without the file make the rows and write it."""
    if not file.exists():
        file.parent.mkdir(parents=True, exist_ok=True)
        write_whole(file, "".join(json.dumps(row) + "\n" for row in make()))
        print(file.stem, flush=True)
    return [json.loads(line) for line in file.read_text("utf-8").splitlines()]


def cells(file: Path) -> list[dict[str, str]]:
    """Return the rows of a file as they are written; `write` takes them again."""
    with gzip.open(file, "rt", encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def read(file: Path) -> Outcomes:
    """Read the rows of a file."""
    with gzip.open(file, "rt", encoding="utf-8", newline="") as stream:
        names, *rows = csv.reader(stream)
    columns = zip(*rows, strict=True) if rows else ((),) * len(names)
    return Outcomes({name: _column(name, c) for name, c in zip(names, columns, strict=True)})


def _cell(name: str, value: Any) -> str:
    """Return a value as it is written."""
    if value is None or (isinstance(value, float) and not math.isfinite(value)):
        return ""
    if isinstance(value, bool | np.bool_):
        return str(int(value))
    if name in DIGITS and not isinstance(value, str):
        return f"{value:.{DIGITS[name]}f}".rstrip("0").rstrip(".")
    return str(value)


def _column(name: str, cells: Sequence[str]) -> np.ndarray:
    """Return a column as numbers where all of its cells are numbers or empty."""
    if name == "caught":
        return np.array([cell == "1" for cell in cells], bool)
    if name in WORDS:
        return np.array(cells, str)
    try:
        return np.array([float(cell) if cell else math.nan for cell in cells])
    except ValueError:
        return np.array(cells, str)
