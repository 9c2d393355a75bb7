"""Maps and plans as cells of a table, and back."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from gcm_learn.arms import Kind
from gcm_learn.charts import Lattice
from gcm_learn.dataset.arm_columns import BITS, COUNT, NUMBER, WORD
from gcm_learn.dataset.kinds import RECORDS
from gcm_learn.maps import CognitiveMap, Interception
from gcm_learn.motion import Failure
from gcm_learn.planners import Plan
from gcm_learn.situation import AnySituation, Situation
from gcm_learn.wave import WaveParams

UNREACHED = 65535  # step count of cells without an arrival
STEP = WaveParams().step  # [tau] a step count is one Euler step of the wave, whatever the engine

MAP = {
    "arrival": BITS,
    "effective_obstacles": BITS,
    "effective_target": BITS,
    "later": BITS,
    "quantum": NUMBER,
    "kappa": NUMBER,
    "contact_cell": COUNT,
    "contact_time": NUMBER,
    "contact_body": WORD,
}


def map_cells(made: CognitiveMap) -> Sequence[Any]:
    """The cells of a map, in the order of MAP."""
    quantum, later, contact = made.kappa * STEP, made.later, made.interception
    where = None if contact is None else contact.cell[0] * made.lattice.n + contact.cell[1]
    return (
        counts_of(made.arrival, quantum).tobytes(),
        np.packbits(made.effective_obstacles).tobytes(),
        np.packbits(made.effective_target).tobytes(),
        None if later is None else counts_of(later, quantum).tobytes(),
        quantum,
        made.kappa,
        where,
        None if contact is None else contact.time,
        None if contact is None else contact.body,
    )


def counts_of(arrival: np.ma.MaskedArray, quantum: float) -> np.ndarray:
    """Arrivals as numbers of steps, little-endian uint16; masked ones are UNREACHED."""
    steps = np.rint(arrival.data / quantum)
    longest = UNREACHED - 1
    if np.any((steps > longest) & ~np.ma.getmaskarray(arrival)):
        raise OverflowError(f"a map's arrivals exceed {longest} steps of {quantum:.3g} s")
    return np.where(np.ma.getmaskarray(arrival), UNREACHED, steps).astype("<u2")


def map_of(situation: Situation, engine: str, n: int, cells: Sequence[Any]) -> CognitiveMap:
    """The map of n x n cells that an engine made for a situation."""
    arrival, obstacles, target, later, quantum, kappa, cell, time, body = cells
    arm, contact = situation.arm, None
    lattice = Lattice(n, arm.upper_arm, arm.elbow)
    if cell is not None:
        iy, ix = divmod(cell, n)
        position = (float(lattice.centres[ix]), float(lattice.centres[iy]))
        contact = Interception((iy, ix), position, time, body)
    return CognitiveMap(
        chart=lattice,
        hand=arm.hand,
        arrival=_arrival(arrival, quantum, (n, n)),
        effective_obstacles=_bits(obstacles, n),
        effective_target=_bits(target, n),
        interception=contact,
        kappa=kappa,
        engine=engine,
        later=None if later is None else _arrival(later, quantum, (-1, n, n)),
    )


def _arrival(cell: bytes, quantum: float, shape: tuple[int, ...]) -> np.ma.MaskedArray:
    counts = np.frombuffer(cell, "<u2").reshape(shape)
    return np.ma.MaskedArray(counts * quantum, mask=counts == UNREACHED)


def _bits(packed: bytes, n: int) -> np.ndarray:
    bits = np.unpackbits(np.frombuffer(packed, np.uint8), count=n * n)
    return bits.reshape(n, n).astype(bool)


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
    columns = {"caught_bodies": "body", "caught_times": "time"}
    return {name: [one[key] for one in plan.catches] for name, key in columns.items()}


def _on_the_way(cells: Mapping[str, Any]) -> tuple[tuple[str, float], ...]:
    """Return the catches before the last one."""
    if cells.get("caught_bodies") is None:
        return ()
    pairs = zip(cells["caught_bodies"], cells["caught_times"], strict=True)
    return tuple((str(body), float(time)) for body, time in pairs)[:-1]


def plan_of(situation: AnySituation, planner: str, cells: Mapping[str, Any]) -> Plan:
    """Return the plan of a planner for a situation."""
    path, clearance = None, cells["clearance"]
    if cells["time"] is not None:
        path = RECORDS.of(situation).path(situation.arm, cells)
        clearance = math.inf if clearance is None else clearance
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
        on_the_way=_on_the_way(cells),
        format=situation.format,
    )
