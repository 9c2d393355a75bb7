"""A record as it is read: labels at once, situation, map and plans when they are asked for."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, cast

import numpy as np
import pyarrow as pa

from gcm_learn.dataset.schema import LABELS, UNREACHED, plan_column
from gcm_learn.handspace.lattice import Lattice
from gcm_learn.maps import CognitiveMap
from gcm_learn.maps.cognitive_map import Contact
from gcm_learn.motion.trajectory import Trajectory
from gcm_learn.planners import Plan
from gcm_learn.situation import Situation, situation_from_json
from gcm_learn.situation.canonical import Frame


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


@dataclass(frozen=True)
class Record:
    """One record of a dataset.

    The situation is in its canonical form (hand on the positive x axis, elbow on the right); map
    and plans belong to it. `frame` tells how it lay when it was drawn.
    """

    row: Mapping[str, Any]
    """Its cells by column, as stored; see data/README.md."""
    n: int
    """Cells along a side of the map."""
    engine: str
    """Of the map: wave, marching, layered or none."""
    planners: tuple[str, ...]

    @property
    def index(self) -> int:
        """Position in the specification's sequence of items."""
        return int(self.row["index"])

    @property
    def labels(self) -> dict[str, Any]:
        """The cheap columns."""
        return {name: self.row[name] for name in LABELS}

    @property
    def stratum(self) -> str:
        """L, W, Q or U."""
        return cast(str, self.row["stratum"])

    @property
    def family(self) -> str:
        """Family that the situation was drawn from."""
        return cast(str, self.row["family"])

    @property
    def split(self) -> str:
        """train, validation, test, or the name of a held-out split."""
        return cast(str, self.row["split"])

    @cached_property
    def situation(self) -> Situation:
        """The situation, canonical."""
        return situation_from_json(json.loads(self.row["situation"]))

    @property
    def frame(self) -> Frame:
        """How the situation lay when it was drawn."""
        return Frame(self.row["angle"], self.row["mirrored"])

    @property
    def parameters(self) -> np.ndarray:
        """The situation as numbers (m,) float32; what they mean is the column `structure`."""
        return np.asarray(self.row["parameters"], dtype=np.float32)

    @property
    def counts(self) -> np.ndarray | None:
        """Arrivals (n, n) uint16 in steps of `quantum` seconds; 65535 where there is none."""
        cell = self.row.get("arrival")
        return None if cell is None else np.frombuffer(cell, "<u2").reshape(self.n, self.n)

    @cached_property
    def map(self) -> CognitiveMap | None:
        """The cognitive map, None if the record has none."""
        counts = self.counts
        if counts is None:
            return None
        arm, row, n = self.situation.arm, self.row, self.n
        contact = None
        lattice = Lattice(n, arm.upper_arm, arm.elbow)
        if row["contact_cell"] is not None:
            iy, ix = divmod(row["contact_cell"], n)
            position = (float(lattice.centres[ix]), float(lattice.centres[iy]))
            contact = Contact((iy, ix), position, row["contact_time"], row["contact_body"])
        later = row["later"]
        if later is not None:
            sheets = np.frombuffer(later, "<u2").reshape(-1, n, n)
        return CognitiveMap(
            lattice=lattice,
            hand=arm.hand,
            arrival=_arrival(counts, row["quantum"]),
            effective_obstacles=_bits(row["effective_obstacles"], n),
            effective_target=_bits(row["effective_target"], n),
            contact=contact,
            kappa=row["kappa"],
            engine=self.engine,
            later=None if later is None else _arrival(sheets, row["quantum"]),
        )

    @cached_property
    def plans(self) -> dict[str, Plan]:
        """The plans by planner."""
        return {name: self._plan(name, self.row[plan_column(name)]) for name in self.planners}

    def _plan(self, planner: str, cells: Mapping[str, Any]) -> Plan:
        arm, way, clearance = self.situation.arm, None, cells["clearance"]
        if cells["time"] is not None:
            hand = np.asarray(cells["hand"], dtype=float).reshape(-1, 2)
            time = np.asarray(cells["time"], dtype=float)
            way = Trajectory.of_hand(time, hand, arm.upper_arm, arm.elbow)
            clearance = math.inf if clearance is None else clearance
        return Plan(
            name=self.situation.name,
            planner=planner,
            status=cells["status"],
            message=cells["message"],
            planning_ms=math.nan,  # no record holds times: it would not be the same twice
            catch_time=cells["catch_time"],
            catch_body=cells["catch_body"],
            clearance=clearance,
            trajectory=way,
        )


def _arrival(counts: np.ndarray, quantum: float) -> np.ma.MaskedArray:
    return np.ma.MaskedArray(counts * quantum, mask=counts == UNREACHED)


def _bits(packed: bytes, n: int) -> np.ndarray:
    bits = np.unpackbits(np.frombuffer(packed, np.uint8), count=n * n)
    return bits.reshape(n, n).astype(bool)
