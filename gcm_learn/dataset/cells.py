"""Maps and plans as cells of a table, and back; maps as training reads them.

A Parquet file is decoded a hundred records at a time, which suits streams but not training that
jumps about.  So there is a cache of plain arrays, built once and shared by all processes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from gcm_learn.arms import Kind
from gcm_learn.charts import chart_of
from gcm_learn.dataset.kinds import RECORDS
from gcm_learn.maps import MAPS, CognitiveMap, Interception, chain_to
from gcm_learn.motion import Failure
from gcm_learn.planners import Catch, Plan
from gcm_learn.seeding import rng
from gcm_learn.situation import AnySituation
from gcm_learn.storage import whole_folder
from gcm_learn.wave import WaveParams

UNREACHED = 65535  # step count of cells without an arrival
STEP = WaveParams().step  # [tau] a step count is one Euler step of the wave, whatever the engine


def map_cells(made: CognitiveMap) -> Sequence[Any]:
    """Return the table cells of a map, in the order of the map's columns."""
    quantum, later, contact = made.kappa * STEP, made.later, made.interception
    cells = (
        counts_of(made.arrival, quantum).tobytes(),
        np.packbits(made.effective_obstacles).tobytes(),
        np.packbits(made.effective_target).tobytes(),
        None if later is None else counts_of(later, quantum).tobytes(),
        quantum,
        made.kappa,
        None if contact is None else made.met,
        None if contact is None else contact.time,
        None if contact is None else contact.body,
    )
    return cells if made.via is None else (*cells, *_way_cells(made))


def _way_cells(made: CognitiveMap) -> tuple[bytes, bytes | None]:
    """Return how far back the front came from to each node, and the postures to the contact."""
    assert made.via is not None
    via, way = made.via.ravel(), None
    if made.joints is not None and made.interception is not None:
        way = made.joints[chain_to(made, made.met)].astype("<f4").tobytes()
    return np.where(via < 0, 0, via - np.arange(via.size)).astype("<i2").tobytes(), way


def counts_of(arrival: np.ma.MaskedArray, quantum: float) -> np.ndarray:
    """Convert arrivals to numbers of steps, little-endian uint16; masked arrivals to UNREACHED."""
    steps = np.rint(arrival.data / quantum)
    longest = UNREACHED - 1
    if np.any((steps > longest) & ~np.ma.getmaskarray(arrival)):
        raise OverflowError(f"a map's arrivals exceed {longest} steps of {quantum:.3g} s")
    return np.where(np.ma.getmaskarray(arrival), UNREACHED, steps).astype("<u2")


def map_of(situation: AnySituation, engine: str, n: int, cells: Sequence[Any]) -> CognitiveMap:
    """The map of n cells a side that an engine made for a situation."""
    arrival, obstacles, target, later, quantum, kappa, met, time, body, *way = cells
    chart, contact = chart_of(situation, n), None
    if met is not None:
        cell = tuple(int(i) for i in np.unravel_index(met, chart.shape))
        contact = Interception(cell, chart.hand_at(met), time, body)
    made = CognitiveMap(
        chart=chart,
        hand=MAPS.of(chart.kind).hand(situation.arm, chart),
        arrival=_arrival(arrival, quantum, chart.shape),
        effective_obstacles=_bits(obstacles, chart.shape),
        effective_target=_bits(target, chart.shape),
        interception=contact,
        kappa=kappa,
        engine=engine,
        later=None if later is None else _arrival(later, quantum, (-1, *chart.shape)),
    )
    return _with_way(made, *way) if way else made


def _with_way(made: CognitiveMap, via: bytes, way: bytes | None) -> CognitiveMap:
    """Return a map with each node's predecessor, and the stored postures up to the contact."""
    back = np.frombuffer(via, "<i2").astype(int)
    nodes = np.where(back == 0, -1, back + np.arange(back.size))
    made = replace(made, via=nodes.reshape(made.chart.shape))
    if way is None:
        return made
    postures = np.frombuffer(way, "<f4").reshape(-1, len(made.chart.arm.joints))  # type: ignore[attr-defined]
    joints = np.full((back.size, postures.shape[1]), np.nan)
    joints[chain_to(made, made.met)] = postures
    return replace(made, joints=joints)


def _arrival(cell: bytes, quantum: float, shape: tuple[int, ...]) -> np.ma.MaskedArray:
    counts = np.frombuffer(cell, "<u2").reshape(shape)
    return np.ma.MaskedArray(counts * quantum, mask=counts == UNREACHED)


def _bits(packed: bytes, shape: tuple[int, ...]) -> np.ndarray:
    bits = np.unpackbits(np.frombuffer(packed, np.uint8), count=math.prod(shape))
    return bits.reshape(shape).astype(bool)


def plan_cell(kind: Kind, plan: Plan) -> dict[str, Any]:
    """Return the cell of a plan for a kind of arm."""
    clearance, path, known = plan.clearance, plan.trajectory, RECORDS.of(kind)
    return {
        "status": plan.exchanged,
        "message": plan.message,
        "catch_time": plan.catch_time,
        "catch_body": plan.catch_body,
        # without obstacles it has no value
        "clearance": None if clearance is None or math.isinf(clearance) else clearance,
        **({} if path is None else known.path_cells(path)),
        **(_catches(plan) if known.several else {}),
    }


def _catches(plan: Plan) -> dict[str, Any]:
    """Return the cells of all catches, in order of time."""
    columns = {"caught_bodies": "body", "caught_times": "time", "placed_times": "placed"}
    return {name: [one.get(key) for one in plan.catches] for name, key in columns.items()}


def _caught(situation: AnySituation, cells: Mapping[str, Any]) -> list[Catch]:
    """Return all catches in order of time; records of chains alone list several, and places."""
    bodies, times = ([cells[name]] for name in ("catch_body", "catch_time"))
    if cells.get("caught_bodies") is not None:
        bodies, times = cells["caught_bodies"], cells["caught_times"]
    placed = cells.get("placed_times")
    placed = [None] * len(bodies) if placed is None else placed
    holds = {target.name: target.hold for target in situation.targets}
    found = []
    for body, time, when in zip(bodies, map(float, times), placed, strict=True):
        until = None if (hold := holds.get(body)) is None else time + hold.seconds
        gone = None if when is None or math.isnan(when) else float(when)
        found.append(Catch(str(body), time, until, gone))
    return found


def plan_of(situation: AnySituation, planner: str, cells: Mapping[str, Any]) -> Plan:
    """Return the plan of a planner for a situation."""
    path, clearance = None, cells["clearance"]
    if cells["time"] is not None:
        path = RECORDS.of(situation).path(situation.arm, cells)
        clearance = math.inf if clearance is None else clearance
    caught = _caught(situation, cells) if cells["catch_body"] is not None else []
    return Plan(
        name=situation.name,
        planner=planner,
        status=cells["status"],
        message=cells["message"],
        failure=Failure.of(cells["message"]),
        planning_ms=math.nan,  # no record holds times: it would not be the same twice
        catch_time=cells["catch_time"],
        catch_body=cells["catch_body"],
        clearance=clearance,
        trajectory=path,
        on_the_way=tuple(caught[:-1]),
        held_until=caught[-1].held_until if caught else None,
        placed=caught[-1].placed if caught else None,
        format=situation.format,
    )


COLUMNS = ("index", "arrival", "effective_obstacles", "quantum", "horizon")
"""Columns of an example."""
CHANNELS = ("reached", "arrival", "obstacle")
FILES = ("index", "arrival", "obstacles", "quantum", "horizon")
"""The arrays of a cache, in the order of COLUMNS."""
WINDOW = 4000  # examples among which the next one of a stream is drawn


@dataclass(frozen=True, slots=True)
class Example:
    """Arrivals and obstacles of a record's map: enough to learn from, not to plan on."""

    index: int
    """Of the record's item."""
    arrival: np.ndarray
    """(n, n) uint16: steps of `quantum` seconds, 65535 where there is no arrival."""
    obstacles: np.ndarray
    """(n * n / 8,) uint8: bits of the effective obstacles, row by row."""
    quantum: float
    """[s]"""
    horizon: float
    """[s]"""
    labels: Mapping[str, Any]
    """The requested columns."""

    def image(self) -> np.ndarray:
        """The map as a picture (3, n, n) float32 of CHANNELS; arrivals are shares of the horizon.

        Cells without an arrival have 0, so that every number is within [0, 1].
        """
        n = self.arrival.shape[0]
        out = np.empty((len(CHANNELS), n, n), dtype=np.float32)
        np.less(self.arrival, UNREACHED, out=out[0])
        np.multiply(self.arrival, np.float32(self.quantum / self.horizon), out=out[1])
        out[1] *= out[0]
        out[2] = np.unpackbits(self.obstacles, count=n * n).reshape(n, n)
        return out


class MapCache(Sequence[Example]):
    """Random access to the maps of a dataset, or of a part of the dataset.

    Parameters
    ----------
    folder : Path
        Folder of the arrays.
    rows : (m,) ndarray of int
        Rows of the arrays.
    labels : mapping of str to ndarray
        Columns (m,) that examples carry.
    """

    def __init__(self, folder: Path, rows: np.ndarray, labels: dict[str, np.ndarray]) -> None:
        self.folder, self._rows, self._labels = folder, rows, labels
        arrays = {name: np.load(folder / f"{name}.npy", mmap_mode="r") for name in FILES}
        # Plain arrays over the same memory: what numpy does for a memmap costs more than the read.
        self.arrival = arrays["arrival"].view(np.ndarray)
        """(m, n, n) uint16: arrivals of all records of the cache."""
        self.obstacles = arrays["obstacles"].view(np.ndarray)
        """(m, n * n / 8) uint8: bits of their effective obstacles."""
        self._small = {name: np.array(arrays[name]) for name in ("quantum", "horizon", "index")}

    def __len__(self) -> int:
        return len(self._rows)

    def __getitem__(self, k: Any) -> Any:
        """Return example k, or the examples of a slice as a cache."""
        labels = {name: column[k] for name, column in self._labels.items()}
        if isinstance(k, slice):
            return MapCache(self.folder, self._rows[k], labels)
        row, small = self._rows[k], self._small
        return Example(
            index=int(small["index"][row]),
            arrival=self.arrival[row],
            obstacles=self.obstacles[row],
            quantum=float(small["quantum"][row]),
            horizon=float(small["horizon"][row]),
            labels=labels,
        )

    def __reduce__(self) -> tuple[Any, ...]:
        """Other processes map the same files."""
        return MapCache, (self.folder, self._rows, self._labels)


def build_cache(place: Path, n: int, count: int, tables: Iterable[pa.Table]) -> None:
    """Copy maps into arrays; they appear all at once.

    Parameters
    ----------
    place : Path
        Where they are to be.
    n : int
        Cells along a side.
    count : int
        How many maps there are.
    tables : iterable of Table
        COLUMNS of all of them, some at a time.
    """
    kinds = ("i8", "<u2", "u1", "f8", "f8")
    shapes: tuple[tuple[int, ...], ...] = ((), (n, n), (-(-n * n // 8),), (), ())
    with whole_folder(place) as folder:
        files = [
            np.lib.format.open_memmap(folder / f"{name}.npy", "w+", kind, (count, *shape))
            for name, kind, shape in zip(FILES, kinds, shapes, strict=True)
        ]
        first = 0
        for table in tables:
            for name, file in zip(COLUMNS, files, strict=True):
                file[first : first + len(table)] = _values(table[name], file)
            first += len(table)
        for file in files:
            file.flush()


def _values(column: pa.ChunkedArray, like: np.ndarray) -> np.ndarray:
    """A column as an array; binary cells become rows."""
    if pa.types.is_binary(column.type):
        cells = b"".join(column.to_pylist())
        return np.frombuffer(cells, like.dtype).reshape(-1, *like.shape[1:])
    return column.to_numpy()


def stream(
    read: Callable[[int], pa.Table],
    groups: int,
    seed: int,
    epoch: int,
    *,
    window: int,
    labels: Sequence[str],
    part: tuple[int, int],
) -> Iterator[Example]:
    """Yield every map once: groups in random order, maps shuffled within a window.

    Parameters
    ----------
    read : callable
        ``read(k)`` gives COLUMNS and labels of the k-th group of records.
    groups : int
        Number of groups.
    seed, epoch, window, labels, part
        See `Dataset.stream`.

    Yields
    ------
    Example
    """
    order = rng(seed, epoch, 0).permutation(groups)  # the same in all parts, which share it out
    draw = rng(seed, epoch, 1, *part)
    held: list[Example] = []
    for k in order[part[0] :: part[1]]:
        for example in _examples(read(k), labels):
            if len(held) < window:
                held.append(example)
                continue
            place = int(draw.integers(window))
            held[place], example = example, held[place]
            yield example
    for k in draw.permutation(len(held)):
        yield held[k]


def _examples(table: pa.Table, labels: Sequence[str]) -> Iterator[Example]:
    columns = {name: table[name].to_pylist() for name in table.column_names}
    for k in range(len(table)):
        arrival = np.frombuffer(columns["arrival"][k], "<u2")
        n = round(len(arrival) ** 0.5)
        yield Example(
            index=columns["index"][k],
            arrival=arrival.reshape(n, n),
            obstacles=np.frombuffer(columns["effective_obstacles"][k], np.uint8),
            quantum=columns["quantum"][k],
            horizon=columns["horizon"][k],
            labels={name: columns[name][k] for name in labels},
        )
