"""Columns of a shard, and items as rows of them.  `data/README.md` explains each column."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pyarrow as pa

from gcm_learn.dataset.item import Found, Item
from gcm_learn.dataset.spec import DatasetSpec
from gcm_learn.maps import CognitiveMap
from gcm_learn.planners import Plan
from gcm_learn.situation import situation_to_json
from gcm_learn.wave import WaveParams

VERSION = "gcm-learn/record@1"
UNREACHED = 65535  # step count of cells without an arrival
STEP = WaveParams().step  # [tau] a step count is one Euler step of the wave, whatever the engine
REJECTS = ("L", "W", "Q", "U", "blocked", "other")
QUANTITIES = ("upper_arm", "max_hand_speed", "horizon", "obstacles", "top_speed", "largest")

PLAN = pa.struct(
    [
        ("status", pa.string()),
        ("message", pa.string()),
        ("catch_time", pa.float64()),
        ("catch_body", pa.string()),
        ("clearance", pa.float64()),
        ("time", pa.list_(pa.float64())),
        ("hand", pa.list_(pa.float64())),
    ]
)
_LABELS = [
    ("index", pa.int64()),
    ("family", pa.string()),
    ("stratum", pa.string()),
    ("split", pa.string()),
    ("structure", pa.string()),
    ("twin_key", pa.int64()),
    ("oracle_stratum", pa.string()),
    ("oracle_lower", pa.float64()),
    ("oracle_upper", pa.float64()),
    *((name, pa.float64()) for name in QUANTITIES),
    ("angle", pa.float64()),
    ("mirrored", pa.bool_()),
    ("attempts", pa.int32()),
    ("rejected", pa.struct([(name, pa.int32()) for name in REJECTS])),
    ("error", pa.string()),
]
_MAP = [
    ("arrival", pa.binary()),
    ("effective_obstacles", pa.binary()),
    ("effective_target", pa.binary()),
    ("later", pa.binary()),
    ("quantum", pa.float64()),
    ("kappa", pa.float64()),
    ("contact_cell", pa.int32()),
    ("contact_time", pa.float64()),
    ("contact_body", pa.string()),
]
LABELS = tuple(name for name, _ in _LABELS)
"""Columns that are cheap to read: all but the situation, its parameters, the map and the plans."""


def plan_column(planner: str) -> str:
    """Name of the column of a planner's plans."""
    return f"plan_{planner}"


def schema_of(spec: DatasetSpec) -> pa.Schema:
    """Arrow schema of a dataset's shards."""
    content = [("situation", pa.string()), ("parameters", pa.list_(pa.float32()))]
    plans = [(plan_column(name), PLAN) for name in spec.planners]
    return pa.schema([*_LABELS, *content, *(_MAP if spec.map != "none" else ()), *plans])


def rows_of(spec: DatasetSpec, items: Sequence[Item]) -> pa.Table:
    """The items as a table, without metadata."""
    schema = schema_of(spec)
    rows = [_row(spec, item) for item in items]
    columns = []
    for column in schema:
        values = [row.get(column.name) for row in rows]
        if column.name.startswith("plan_"):
            columns.append(_plans(values))
        else:
            columns.append(pa.array(values, type=column.type))
    return pa.Table.from_arrays(columns, schema=schema)


def _row(spec: DatasetSpec, item: Item) -> dict[str, Any]:
    row: dict[str, Any] = {
        "index": item.index,
        "attempts": item.attempts,
        "rejected": {name: item.rejected[name] for name in REJECTS},
        "error": item.error,
    }
    found = item.found
    if found is None:
        return row
    row |= {
        "family": found.family,
        "stratum": found.stratum,
        "split": found.split,
        "structure": found.structure,
        "twin_key": found.twin_key,
        "angle": found.frame.angle,
        "mirrored": found.frame.mirrored,
        "situation": _text(found),
        "parameters": found.parameters,
        **found.quantities,
    }
    if found.oracle is not None:
        row["oracle_stratum"] = found.oracle.stratum
        row["oracle_lower"], row["oracle_upper"] = found.oracle.lower, found.oracle.upper
    if found.map is not None:
        row |= _map_cells(found.map)
    row |= {plan_column(name): plan for name, plan in found.plans.items()}
    return row


def _text(found: Found) -> str:
    return json.dumps(situation_to_json(found.situation), separators=(",", ":"), allow_nan=False)


def _map_cells(made: CognitiveMap) -> dict[str, Any]:
    quantum = made.kappa * STEP
    cells: dict[str, Any] = {
        "arrival": counts_of(made.arrival, quantum).tobytes(),
        "effective_obstacles": np.packbits(made.effective_obstacles).tobytes(),
        "effective_target": np.packbits(made.effective_target).tobytes(),
        "quantum": quantum,
        "kappa": made.kappa,
    }
    if made.later is not None:
        cells["later"] = counts_of(made.later, quantum).tobytes()
    if made.contact is not None:
        iy, ix = made.contact.cell
        cells["contact_cell"] = iy * made.lattice.n + ix
        cells["contact_time"], cells["contact_body"] = made.contact.time, made.contact.body
    return cells


def counts_of(arrival: np.ma.MaskedArray, quantum: float) -> np.ndarray:
    """Arrivals as numbers of steps, little-endian uint16; masked ones are UNREACHED."""
    steps = np.rint(arrival.data / quantum)
    longest = UNREACHED - 1
    if np.any((steps > longest) & ~np.ma.getmaskarray(arrival)):
        raise OverflowError(f"a map's arrivals exceed {longest} steps of {quantum:.3g} s")
    return np.where(np.ma.getmaskarray(arrival), UNREACHED, steps).astype("<u2")


def _plans(plans: Sequence[Plan | None]) -> pa.Array:
    """Plans as an array of structs; null for items without."""
    known = [plan is not None for plan in plans]

    def each(take: Any, kind: pa.DataType) -> pa.Array:
        return pa.array([None if plan is None else take(plan) for plan in plans], type=kind)

    ways = [None if plan is None else plan.trajectory for plan in plans]
    columns = [
        each(lambda plan: plan.status, pa.string()),
        each(lambda plan: plan.message, pa.string()),
        each(lambda plan: plan.catch_time, pa.float64()),
        each(lambda plan: plan.catch_body, pa.string()),
        each(_clearance, pa.float64()),
        _lists([None if way is None else way.time for way in ways]),
        _lists([None if way is None else way.hand.ravel() for way in ways]),
    ]
    fields = [PLAN.field(k) for k in range(PLAN.num_fields)]
    mask = pa.array([not there for there in known])
    return pa.StructArray.from_arrays(columns, fields=fields, mask=mask)


def _clearance(plan: Plan) -> float | None:
    """Clearance of a catch; none without obstacles, where it has no value."""
    return None if plan.clearance is None or math.isinf(plan.clearance) else plan.clearance


def _lists(arrays: Sequence[np.ndarray | None]) -> pa.Array:
    """A list array of float64 arrays, null where there is none."""
    lengths = np.array([0 if a is None else len(a) for a in arrays])
    offsets = np.concatenate([[0], np.cumsum(lengths)]).astype(np.int32)
    parts = [a for a in arrays if a is not None]
    values = np.concatenate(parts) if parts else np.zeros(0)
    mask = pa.array([a is None for a in arrays])
    return pa.ListArray.from_arrays(pa.array(offsets), pa.array(values), mask=mask)
