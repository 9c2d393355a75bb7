"""Maps and plans as cells of a table, and back."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pyarrow as pa

from gcm_learn.arms import JOINTS, SpatialArm
from gcm_learn.handspace import Lattice
from gcm_learn.maps import CognitiveMap, Interception
from gcm_learn.motion import Failure, SpatialTrajectory, Trajectory
from gcm_learn.planners import AnyPlan, Plan
from gcm_learn.situation import AnySituation, Situation, planar
from gcm_learn.wave import WaveParams

UNREACHED = 65535  # step count of cells without an arrival
STEP = WaveParams().step  # [tau] a step count is one Euler step of the wave, whatever the engine

Types = Mapping[str, pa.DataType]
WORD, NUMBER, BITS, COUNT = pa.string(), pa.float64(), pa.binary(), pa.int32()
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
PLAN = pa.struct(
    {
        "status": WORD,
        "message": WORD,
        "catch_time": NUMBER,
        "catch_body": WORD,
        "clearance": NUMBER,
        "time": pa.list_(NUMBER),
        "hand": pa.list_(NUMBER),
    }
)
SPATIAL_PLAN = pa.struct(
    {
        "status": WORD,
        "message": WORD,
        "catch_time": NUMBER,
        "catch_body": WORD,
        "clearance": NUMBER,
        "time": pa.list_(NUMBER),
        "joints": pa.list_(NUMBER),
        "rates": pa.list_(NUMBER),
    }
)


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


def plan_cell(plan: AnyPlan) -> dict[str, Any]:
    """The cell of a plan, as PLAN has it, or SPATIAL_PLAN in space."""
    clearance = plan.clearance
    return {
        "status": plan.status,
        "message": plan.message,
        "catch_time": plan.catch_time,
        "catch_body": plan.catch_body,
        # without obstacles it has no value
        "clearance": None if clearance is None or math.isinf(clearance) else clearance,
        **_path_cells(plan.trajectory),
    }


def _path_cells(path: Trajectory | SpatialTrajectory | None) -> dict[str, Any]:
    """Time and hand, or time, joints and rates; nothing of what there is not."""
    if path is None:
        return {}
    if isinstance(path, Trajectory):
        return {"time": path.time, "hand": path.hand.ravel()}
    rates = None if path.rates is None else path.rates.ravel()
    return {"time": path.time, "joints": path.joints.ravel(), "rates": rates}


def plan_of(situation: AnySituation, planner: str, cells: Mapping[str, Any]) -> Plan[Any]:
    """The plan of a planner for a situation."""
    path, clearance = None, cells["clearance"]
    if cells["time"] is not None:
        path = _path_of(situation, cells)
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
    )


def _path_of(situation: AnySituation, cells: Mapping[str, Any]) -> Trajectory | SpatialTrajectory:
    arm, time = situation.arm, np.asarray(cells["time"], dtype=float)
    if isinstance(arm, SpatialArm):
        joints = np.asarray(cells["joints"], dtype=float).reshape(-1, JOINTS)
        rates = cells["rates"]
        if rates is not None:
            rates = np.asarray(rates, dtype=float).reshape(-1, JOINTS)
        return SpatialTrajectory(arm, time, joints, rates)
    hand = np.asarray(cells["hand"], dtype=float).reshape(-1, 2)
    arm = planar(situation, "a path of hands").arm
    return Trajectory.of_hand(time, hand, arm.upper_arm, arm.elbow)
