"""Records of a dataset: the one table of all columns, with how each is filled and read.

`data/README.md` explains each column.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import astuple
from typing import Any, Generic, TypeVar, overload

import numpy as np
import pyarrow as pa

from gcm_learn.arms import PLANAR, Base
from gcm_learn.dataset.cases import OracleLabel
from gcm_learn.dataset.cells import map_cells, map_of, plan_cell, plan_of
from gcm_learn.dataset.kinds import COUNT, NUMBER, RECORDS, WORD, Types
from gcm_learn.dataset.spec import STRATA, DatasetSpec
from gcm_learn.dataset.splits import QUANTITIES
from gcm_learn.maps import CognitiveMap
from gcm_learn.planners import Plan
from gcm_learn.situation import (
    AnySituation,
    Frame,
    SpatialFrame,
    situation_from_json,
    situation_to_json,
)

REJECTS = (*STRATA, "blocked", "other")

_ORACLE = {"oracle_stratum": WORD, "oracle_lower": NUMBER, "oracle_upper": NUMBER}
Value = TypeVar("Value")


def version_of(spec: DatasetSpec) -> str:
    """Return the format of a dataset's records."""
    return RECORDS.of(spec.kind).version


def plan_column(planner: str) -> str:
    """Name of the column of a planner's plans."""
    return f"plan_{planner}"


class Part(Generic[Value]):
    """Part of a record: its columns, and the conversions between its value and their cells.

    Parameters
    ----------
    types : DataType, mapping of str to DataType or callable
        Type of one column of the part's name, types of columns by name, or a function that makes
        these of a specification.
    pack : callable
        ``pack(record, value)`` gives a cell for each column. For None all cells are empty.
    unpack : callable
        ``unpack(record, *cells)`` gives the value back. If all cells are empty, it is None.
    label : bool
        Whether it is cheap to read: all but the situation, its parameters, the map and the plans.
    """

    def __init__(
        self,
        types: pa.DataType | Types | Callable[[DatasetSpec], Types],
        pack: Callable[[Record, Any], Sequence[Any]] = lambda record, value: (value,),
        unpack: Callable[..., Value] = lambda record, cell: cell,
        label: bool = True,
    ) -> None:
        self._types, self.pack, self.unpack, self.label = types, pack, unpack, label

    def __set_name__(self, owner: type, name: str) -> None:
        self.name, kind = name, self._types
        self.fixed: Types = {name: kind} if isinstance(kind, pa.DataType) else {}
        """Types that do not depend on the specification."""
        if isinstance(kind, Mapping):
            self.fixed = kind

    def types(self, spec: DatasetSpec) -> Types:
        """Arrow types of the columns by name, in the order of the file."""
        return self._types(spec) if callable(self._types) else self.fixed

    def cells(self, record: Record) -> dict[str, Any]:
        """The value of a record as cells by column."""
        names, value = self.types(record.spec), record.values.get(self.name)
        cells = [None] * len(names) if value is None else self.pack(record, value)
        return dict(zip(names, cells, strict=True))

    @overload
    def __get__(self, record: None, owner: type) -> Part[Value]: ...

    @overload
    def __get__(self, record: Record, owner: type) -> Value: ...

    def __get__(self, record: Record | None, owner: type) -> Any:
        """Return the part's value in a record, unpacked from the cells at first use."""
        if record is None:
            return self
        if self.name not in record.values:
            cells = [record.row.get(name) for name in self.types(record.spec)]
            empty = bool(cells) and all(cell is None for cell in cells)
            record.values[self.name] = None if empty else self.unpack(record, *cells)
        return record.values[self.name]


def _situation_cell(_: Record, situation: AnySituation) -> tuple[str]:
    return (json.dumps(situation_to_json(situation), separators=(",", ":"), allow_nan=False),)


def _frame_cells(_: Record, frame: Frame | SpatialFrame) -> tuple[Any, ...]:
    return getattr(frame, "angle", None), frame.mirrored


def _frame_of(record: Record, angle: float | None, mirrored: bool) -> Frame | SpatialFrame:
    return RECORDS.of(record.spec.kind).frame(record.base, angle, mirrored)


class Record:
    """Record of a dataset, newly made or read from a shard.

    Its parts are the columns of a shard, in their order. The situation is in its canonical form,
    and map and plans belong to that. The hand is on the positive x axis and the elbow on the right;
    in space the base is at the origin, and the arm a left one.

    Parameters
    ----------
    spec : DatasetSpec
    values : mapping of str to object
        Parts that are known.
    row : mapping of str to object, optional
        Cells by column, as stored, from which the other parts are made.
    """

    index = Part[int](pa.int64())
    """Position in the specification's sequence of items."""
    family = Part[str](WORD)
    """Family that the situation was drawn from."""
    stratum = Part[str](WORD)
    """L, W, Q or U."""
    split = Part[str](WORD)
    """train, validation, test, or the name of a held-out split."""
    structure = Part[str](WORD)
    """Meaning of `parameters`."""
    twin_key = Part[int](pa.int64())
    """Equal for twins: see `parameters.twin_key`."""
    oracle = Part[OracleLabel | None](
        _ORACLE, lambda _, label: astuple(label), lambda _, *cells: OracleLabel(*cells)
    )
    """The oracle's label, if there was an audit."""
    quantities = Part[dict[str, float]](
        dict.fromkeys(QUANTITIES, NUMBER),
        lambda _, quantities: [quantities[name] for name in QUANTITIES],
        lambda _, *cells: dict(zip(QUANTITIES, cells, strict=True)),
    )
    """Numbers that range splits compare."""
    spec: DatasetSpec
    base = Part[Base | None](
        lambda spec: RECORDS.of(spec.kind).base,
        lambda _, base: (list(base.origin), list(base.rotation)),
        lambda _, *cells: Base(*map(tuple, cells)) if cells else None,
        label=False,
    )
    """Base of a spatial arm when it was drawn, None for a planar one."""
    frame = Part[Any]({"angle": NUMBER, "mirrored": pa.bool_()}, _frame_cells, _frame_of)
    """Frame of the situation when it was drawn: a `Frame`, or a `SpatialFrame` without an angle."""
    attempts = Part[int](COUNT)
    """Situations drawn."""
    rejected = Part[Mapping[str, int]](
        pa.struct([(name, COUNT) for name in REJECTS]),
        lambda _, counts: [{name: counts[name] for name in REJECTS}],
    )
    """Number of unwanted draws, by stratum; also "blocked" (the limb touches an obstacle at
    t = 0) and "other" (not the wanted stratum, and not classified further)."""
    error = Part[str | None](WORD)
    """Reason of a failure; the record then has index, attempts and rejected only."""
    situation = Part[Any](
        WORD, _situation_cell, lambda _, text: situation_from_json(json.loads(text)), label=False
    )
    """The situation, canonical; all situations of a dataset have the same kind of arm."""
    parameters = Part[np.ndarray](
        pa.list_(pa.float32()), unpack=lambda _, cell: np.asarray(cell, np.float32), label=False
    )
    """The situation as numbers (m,) float32; `structure` gives their meaning."""
    map = Part[CognitiveMap | None](
        lambda spec: {} if spec.map == "none" else RECORDS.of(spec.kind).map,
        lambda _, made: map_cells(made),
        lambda record, *cells: (
            map_of(record.situation, record.spec.map, record.n, cells) if cells else None
        ),
        label=False,
    )
    """The cognitive map, or None."""
    plans = Part[dict[str, Plan]](
        lambda spec: dict.fromkeys(map(plan_column, spec.planners), RECORDS.of(spec.kind).plan),
        lambda record, plans: [plan_cell(record.spec.kind, plan) for plan in plans.values()],
        lambda record, *cells: {
            name: plan_of(record.situation, name, cell)
            for name, cell in zip(record.planners, cells, strict=True)
        },
        label=False,
    )
    """The plans by planner."""

    def __init__(
        self, spec: DatasetSpec, values: Mapping[str, Any], row: Mapping[str, Any] | None = None
    ) -> None:
        self.spec, self.values, self._row = spec, dict(values), row

    @property
    def row(self) -> Mapping[str, Any]:
        """Cells of the record by column, as stored; see data/README.md."""
        if self._row is not None:
            return self._row
        return {name: cell for part in PARTS for name, cell in part.cells(self).items()}

    @property
    def labels(self) -> dict[str, Any]:
        """The cheap columns."""
        return {name: self.row[name] for name in LABELS}

    @property
    def n(self) -> int:
        """Cells along a side of the map."""
        return self.spec.n

    @property
    def planners(self) -> tuple[str, ...]:
        """Planners whose plans the record holds."""
        return self.spec.planners

    def earliest(self, planner: str = "") -> Plan | None:
        """Return the plan with the earliest catch, of `planner` or of all; None without a catch."""
        names = (planner,) if planner else self.planners
        caught = [self.plans[name] for name in names if self.plans[name].caught]
        return min(caught, key=lambda plan: plan.catch_time or 0.0) if caught else None

    @property
    def counts(self) -> np.ndarray | None:
        """Arrivals (n, n) uint16 in steps of `quantum` seconds; 65535 without arrival."""
        cell, shape = self.row.get("arrival"), (self.n,) * (2 if self.spec.kind is PLANAR else 3)
        return None if cell is None else np.frombuffer(cell, "<u2").reshape(shape)


PARTS: tuple[Part[Any], ...] = tuple(p for p in vars(Record).values() if isinstance(p, Part))
LABELS = tuple(name for part in PARTS if part.label for name in part.fixed)
"""Columns that are cheap to read: all but the situation, its parameters, the map and the plans."""


def schema_of(spec: DatasetSpec) -> pa.Schema:
    """Arrow schema of a dataset's shards."""
    return pa.schema([column for part in PARTS for column in part.types(spec).items()])


def rows_of(spec: DatasetSpec, records: Sequence[Record]) -> pa.Table:
    """Records as a table, without metadata."""
    schema, rows = schema_of(spec), [record.row for record in records]
    columns = [pa.array([row[c.name] for row in rows], type=c.type) for c in schema]
    return pa.Table.from_arrays(columns, schema=schema)


class Row(Mapping[str, Any]):
    """A row of a table, whose cells are turned into Python values only when they are read.

    Binary cells are buffers and lists are arrays, both without a copy where possible.
    """

    def __init__(self, batch: pa.RecordBatch, k: int) -> None:
        self._batch, self._k = batch, k

    def __getitem__(self, name: str) -> Any:
        return _value(self._batch.column(name)[self._k])

    def __iter__(self) -> Iterator[str]:
        return iter(self._batch.schema.names)

    def __len__(self) -> int:
        return int(self._batch.num_columns)


def _value(cell: pa.Scalar) -> Any:
    if not cell.is_valid:
        return None
    if pa.types.is_binary(cell.type):
        return cell.as_buffer()
    if pa.types.is_list(cell.type):
        return cell.values.to_numpy(zero_copy_only=False)
    if pa.types.is_struct(cell.type):
        return {name: _value(member) for name, member in cell.items()}
    return cell.as_py()
