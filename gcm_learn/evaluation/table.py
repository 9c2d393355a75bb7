"""Results as columns, in memory and in Parquet."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

FORMAT = "gcm-learn/comparison@1"


@dataclass(frozen=True)
class Results:
    """One row for every method and situation."""

    columns: Mapping[str, np.ndarray]
    """By name; `contest.row_of` gives the names."""
    given: Mapping[str, Any] = field(default_factory=dict)
    """Objects and references that were compared, by the names of their rows; not stored."""

    @classmethod
    def of(cls, rows: Sequence[Mapping[str, Any]]) -> Results:
        """Collect rows with the same keys; a missing value is None, or NaN."""
        names = list(rows[0]) if rows else []
        return cls({name: _column([row[name] for row in rows]) for name in names})

    def __len__(self) -> int:
        return len(next(iter(self.columns.values()), ()))

    def __getitem__(self, name: str) -> np.ndarray:
        return self.columns[name]

    @property
    def methods(self) -> list[str]:
        """In order of appearance."""
        return list(dict.fromkeys(self["entrant"].tolist()))

    @property
    def strata(self) -> list[str]:
        """Strata that occur, in the order L, W, Q, U."""
        there = set(self["stratum"].tolist())
        return [s for s in "LWQU" if s in there]

    @property
    def families(self) -> list[str]:
        """Families that occur."""
        return sorted(set(self["family"].tolist()))

    @classmethod
    def joined(cls, *parts: Results) -> Results:
        """Rows of several, one after the other; all have the same columns."""
        given = {name: made for part in parts for name, made in part.given.items()}
        columns = {n: np.concatenate([part[n] for part in parts]) for n in parts[0].columns}
        return cls(columns, given)

    def where(self, keep: np.ndarray) -> Results:
        """The rows of a mask (n,), or of indices (m,) in their order."""
        kept = {name: column[keep] for name, column in self.columns.items()}
        return replace(self, columns=kept)

    def of_method(self, name: str) -> Results:
        """The rows of a method, in order of situations: rows of two methods are paired."""
        mine = self.where(self["entrant"] == name)
        order = np.lexsort((mine["index"], mine["suite"].astype(str)))
        return mine.where(order)

    def save(self, path: Path) -> Path:
        """Write a Parquet file."""
        import pyarrow as pa
        import pyarrow.parquet as pq

        table = pa.table({name: _arrow(column) for name, column in self.columns.items()})
        pq.write_table(table.replace_schema_metadata({"gcm-learn": FORMAT}), path)
        return path

    @classmethod
    def load(cls, path: Path) -> Results:
        """Read it."""
        import pyarrow.parquet as pq

        table = pq.read_table(path)
        return cls({name: _column(table.column(name).to_pylist()) for name in table.column_names})


def _column(values: list[Any]) -> np.ndarray:
    """Numbers as floats or integers, all else as objects."""
    if all(isinstance(v, int) and not isinstance(v, bool) for v in values):
        return np.array(values, dtype=np.int64)
    if all(v is None or isinstance(v, (int, float)) for v in values) and any(
        v is not None for v in values
    ):
        return np.array([np.nan if v is None else float(v) for v in values])
    return np.array(values, dtype=object)


def _arrow(column: np.ndarray) -> Any:
    import pyarrow as pa

    if column.dtype == object:
        return pa.array(column.tolist())
    return pa.array(column, from_pandas=True)
