"""Sheets: tables of judged answers, in memory and in Parquet."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from gcm_learn.errors import FileFormatError, MissingExtraError
from gcm_learn.storage import whole_file

FORMAT = "gcm-learn/sheet@1"
PROTOCOL = 2
"""Version of the protocol in docs/benchmark.md."""
OUTCOMES = ("caught", "declined", "start_blocked", "late", "touched", "broken", "error")
"""Words for what became of a situation, see docs/benchmark.md."""
TEXTS = (
    "suite", "name", "key", "family", "stratum", "entrant", "thinking", "outcome", "reason",
    "part", "situation", "solution",
)  # fmt: skip
NUMBERS = (
    "earliest", "charged", "noise", "limit", "ms", "factor", "catch_time", "clearance", "path",
    "peak_hand", "peak_joint",
)  # fmt: skip
COUNTS = ("seed", "nodes", "targets", "wanted")
COLUMNS = (*TEXTS, *NUMBERS, *COUNTS)
ASKED = ("entrant", "suite", "key", "seed", "thinking", "noise")
"""Columns that tell rows apart."""
LARGEST_FACTOR = 1e6


@dataclass(frozen=True)
class Sheet:
    """Table of answers, with one row for every case, entrant, condition and seed."""

    columns: Mapping[str, np.ndarray]
    """By the names of `COLUMNS`; docs/benchmark.md explains them."""
    runs: Sequence[Mapping[str, Any]] = field(default=())
    """Of each run: entrants, package, protocol, machine and calibration."""
    entrants: Mapping[str, str] = field(default_factory=dict)
    """What each entrant is, in one line."""

    @classmethod
    def of(cls, rows: Sequence[Mapping[str, Any]], **more: Any) -> Sheet:
        """Collect rows; a missing number is None, or NaN."""
        columns: dict[str, np.ndarray] = {}
        for name in COLUMNS:
            values = [row.get(name) for row in rows]
            if name in TEXTS:
                columns[name] = np.array(["" if v is None else v for v in values], dtype=object)
            elif name in COUNTS:
                columns[name] = np.array([v or 0 for v in values], dtype=np.int64)
            else:
                columns[name] = np.array([np.nan if v is None else v for v in values], dtype=float)
        return cls(columns, **more)

    @classmethod
    def joined(cls, *parts: Sheet) -> Sheet:
        """Return one sheet with the rows of several sheets, in their order.

        An entrant gets a number if another entrant of its name has answered the same question.
        """
        seen: set[tuple[Any, ...]] = set()
        made = [part._told_apart(seen) for part in parts]
        columns = {n: np.concatenate([part[n] for part in made]) for n in COLUMNS}
        runs = [run for part in made for run in part.runs]
        words = {name: line for part in made for name, line in part.entrants.items()}
        return cls(columns, runs, words)

    def _told_apart(self, seen: set[tuple[Any, ...]]) -> Sheet:
        """Return the sheet, numbering entrants with questions in `seen`; add all to `seen`."""
        asked, names = list(zip(*(self[name] for name in ASKED), strict=True)), {}
        for name in self.each("entrant"):
            mine, number, told = [row[1:] for row in asked if row[0] == name], 1, name
            while any((told, *row) in seen for row in mine):
                number += 1
                told = f"{name} ({number})"
            names[name] = told
            seen |= {(told, *row) for row in mine}
        entrants = np.array([names[name] for name in self["entrant"]], dtype=object)
        runs = [
            {**run, "entrants": [names.get(name, name) for name in run["entrants"]]}
            for run in self.runs
        ]
        words = {names.get(name, name): line for name, line in self.entrants.items()}
        return Sheet({**self.columns, "entrant": entrants}, runs, words)

    def __len__(self) -> int:
        return len(self.columns["key"])

    def __getitem__(self, name: str) -> np.ndarray:
        return self.columns[name]

    def each(self, name: str) -> list[Any]:
        """Return the values of a column, in order of appearance."""
        return list(dict.fromkeys(self[name].tolist()))

    def where(self, keep: np.ndarray | None = None, **words: Any) -> Sheet:
        """Return the rows in a mask (n,) whose columns equal a value or one of several."""
        kept = np.ones(len(self), bool) if keep is None else np.array(keep, bool)
        for name, word in words.items():
            wanted = [word] if isinstance(word, (str, int, float)) else list(word)
            kept &= np.isin(self[name], np.array(wanted, dtype=self[name].dtype))
        return replace(self, columns={n: column[kept] for n, column in self.columns.items()})

    def paired(self) -> Sheet:
        """Return the rows in the order of seeds and cases."""
        order = np.lexsort((self["key"].astype(str), self["suite"].astype(str), self["seed"]))
        return replace(self, columns={n: column[order] for n, column in self.columns.items()})

    @property
    def caught(self) -> np.ndarray:
        """(n,) bool: True for catches."""
        return np.asarray(self["outcome"] == "caught")

    @property
    def reachable(self) -> Sheet:
        """Rows of situations that are not known to be out of reach."""
        return self.where(self["stratum"] != "U")

    def save(self, path: str | Path) -> Path:
        """Write a Parquet file that appears whole or not at all."""
        try:
            import pyarrow as pa
            import pyarrow.parquet as pq
        except ModuleNotFoundError as error:
            raise MissingExtraError(str(path), str(error.name), "data") from None
        columns = {
            name: pa.array(column.tolist() if name in TEXTS else column, from_pandas=True)
            for name, column in self.columns.items()
        }
        about = {"format": FORMAT, "runs": list(self.runs), "entrants": dict(self.entrants)}
        table = pa.table(columns).replace_schema_metadata({"gcm-learn": json.dumps(about)})
        with whole_file(path) as place:
            pq.write_table(table, place, compression="zstd", compression_level=12)
        return Path(path)

    @classmethod
    def load(cls, path: str | Path) -> Sheet:
        """Read a file that `save` wrote.

        Raises
        ------
        FileFormatError
            One line: the file, the field and the reason.
        """
        try:
            import pyarrow as pa
            import pyarrow.parquet as pq
        except ModuleNotFoundError as error:
            raise MissingExtraError(str(path), str(error.name), "data") from None
        try:
            table = pq.read_table(path)
            about = json.loads((table.schema.metadata or {}).get(b"gcm-learn", b"{}"))
        except (OSError, ValueError, pa.ArrowException) as error:
            reason = " ".join(str(getattr(error, "strerror", None) or error).split())
            raise FileFormatError(f"{path}: is no sheet ({reason})") from None
        if not isinstance(about, dict) or about.get("format") != FORMAT:
            raise FileFormatError(f"{path}: format: is not {FORMAT!r}")
        try:
            rows = {n: table.column(n).to_pylist() for n in COLUMNS if n in table.column_names}
            return cls.of(_rows(rows), runs=about["runs"], entrants=about["entrants"])._checked()
        except (KeyError, TypeError, ValueError) as error:
            reason = f"{error.args[0]}: is missing" if isinstance(error, KeyError) else str(error)
            raise FileFormatError(f"{path}: {reason}") from None

    def _checked(self) -> Sheet:
        """Raise ValueError, which names the column, unless all values can be."""
        strangers = set(self["outcome"].tolist()) - set(OUTCOMES)
        if strangers:
            raise ValueError(f"outcome: {min(strangers)!r} is not one of {', '.join(OUTCOMES)}")
        for name in TEXTS:
            if not all(isinstance(value, str) for value in self[name]):
                raise ValueError(f"{name}: must be text")
        for name, most in (("ms", 1e9), ("factor", LARGEST_FACTOR), ("charged", 1e9)):
            if not np.all((self[name] >= 0.0) & (self[name] <= most)):
                raise ValueError(f"{name}: must be from 0 to {most:g}")
        for name in COUNTS:
            if not np.all(self[name] >= 0):
                raise ValueError(f"{name}: must be from 0 on")
        for run in self.runs:
            if run["protocol"] not in (1, PROTOCOL):
                raise ValueError(f"protocol: must be at most {PROTOCOL} (got {run['protocol']})")
        return self


def _rows(columns: Mapping[str, list[Any]]) -> list[dict[str, Any]]:
    """Return the rows of columns, all of which must be there."""
    for name in COLUMNS:
        if name not in columns:
            raise KeyError(name)
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
