"""Records by kind of arm: columns of plans, frames, the arm as numbers, cases."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pyarrow as pa

from gcm_learn.arms import CHAIN, PLANAR, SPATIAL, Arm, Base, ByKind, Chain, Kind, SpatialArm
from gcm_learn.charts import LARGEST_LATTICE
from gcm_learn.motion import Movement, fastest_hand
from gcm_learn.scene import pack
from gcm_learn.situation import Frame, Situation, SpatialFrame, arm_to_json
from gcm_learn.storage import content_hash

Types = Mapping[str, pa.DataType]
WORD, NUMBER, BITS, COUNT = pa.string(), pa.float64(), pa.binary(), pa.int32()
_ANSWER = {
    "status": WORD,
    "message": WORD,
    "catch_time": NUMBER,
    "catch_body": WORD,
    "clearance": NUMBER,
    "time": pa.list_(NUMBER),
}
HAND_PLAN = pa.struct(_ANSWER | {"hand": pa.list_(NUMBER)})
JOINT_PLAN = pa.struct(_ANSWER | {"joints": pa.list_(NUMBER), "rates": pa.list_(NUMBER)})
CHAIN_PLAN = pa.struct(
    [
        *JOINT_PLAN,
        pa.field("caught_bodies", pa.list_(WORD)),
        pa.field("caught_times", pa.list_(NUMBER)),
        pa.field("placed_times", pa.list_(NUMBER)),
    ]
)
MAP: Types = {
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
MAP_IN_SPACE: Types = {**MAP, "via": BITS, "way": BITS}
COARSE = 40  # cells along a side of a map in space at most: 64,000 cells
BASE: Types = {"origin": pa.list_(NUMBER), "rotation": pa.list_(NUMBER)}


# --- paths -----------------------------------------------------------------------------------


def hand_cells(path: Movement) -> dict[str, Any]:
    """Return the cells of a hand path."""
    return {"time": path.time, "hand": path.hand.ravel()}


def joint_cells(path: Movement) -> dict[str, Any]:
    """Return the cells of a joint movement."""
    rates = None if path.rates is None else path.rates.ravel()
    return {"time": path.time, "joints": path.joints.ravel(), "rates": rates}


def hand_path(arm: Arm, cells: Mapping[str, Any]) -> Movement:
    """Return the hand path in the cells of a plan."""
    time, hand = (np.asarray(cells[name], dtype=float) for name in ("time", "hand"))
    return Movement.of_hand(arm, time, hand.reshape(-1, 2))


def joint_path(arm: Chain, cells: Mapping[str, Any]) -> Movement:
    """Return the joint movement in the cells of a plan."""
    time, joints = (np.asarray(cells[name], dtype=float) for name in ("time", "joints"))
    rates, dof = cells["rates"], len(arm.joints)
    if rates is not None:
        rates = np.asarray(rates, dtype=float).reshape(-1, dof)
    return Movement(arm, time, joints.reshape(-1, dof), rates)


# --- frames ----------------------------------------------------------------------------------


def planar_frame(base: Base | None, angle: float | None, mirrored: bool) -> Frame:
    """Return the frame of a planar arm."""
    assert angle is not None
    return Frame(angle, mirrored)


def spatial_frame(base: Base | None, angle: float | None, mirrored: bool) -> SpatialFrame:
    """Return the frame of a spatial arm."""
    assert base is not None
    return SpatialFrame(base, mirrored)


# --- the arm as numbers ----------------------------------------------------------------------


def planar_word(situation: Situation) -> str:
    """Return the word for the arm in a situation's structure."""
    joints = "" if situation.arm.max_joint_speed is None else "+joints"
    return f"{'solid' if situation.is_solid else 'planar'}{joints}"


def spatial_word(situation: Situation[SpatialArm]) -> str:
    """Return the word for the arm in a situation's structure."""
    arm = situation.arm
    hand = "" if arm.max_hand_speed is None else "+hand"
    return f"space{hand}{'' if arm.max_joint_acceleration is None else '+acceleration'}"


def chain_word(situation: Situation[Chain]) -> str:
    """Return the word for a chain in a situation's structure; a hash identifies the arm's model."""
    arm = situation.arm
    model = content_hash(json.dumps(arm_to_json(arm.model), sort_keys=True))[:8]
    hand = "" if arm.max_hand_speed is None else "+hand"
    limits = "" if arm.max_joint_acceleration is None else "+acceleration"
    several = "" if situation.catch == "any" else f"+{situation.catch}"
    return f"chain-{model}{hand}{limits}{several}"


def planar_numbers(arm: Arm, horizon: float) -> list[float]:
    """Return the parameters of an arm."""
    joints = arm.max_joint_speed or ()
    numbers = [arm.hand[0], arm.upper_arm, arm.max_hand_speed * horizon, arm.thickness, arm.grasp]
    return [*numbers, *(limit * horizon for limit in joints)]


def spatial_numbers(arm: SpatialArm, horizon: float) -> list[float]:
    """Return the parameters of an arm; angles count as way of the hand about the elbow."""
    unit = spatial_forearm(arm)
    ends = [end for ends in arm.joint_range for end in ends]
    turns = [*arm.joints, *ends, *(limit * horizon for limit in arm.max_joint_speed)]
    if arm.max_joint_acceleration is not None:
        turns += [0.5 * limit * horizon**2 for limit in arm.max_joint_acceleration]
        turns += [rate * horizon for rate in arm.joint_rates or ()]
    hand = [] if arm.max_hand_speed is None else [arm.max_hand_speed * horizon]
    bones = [*arm.upper_arm, *arm.forearm, *hand, arm.thickness, arm.grasp]
    return bones + [unit * turn for turn in turns]


def chain_numbers(arm: Chain, horizon: float) -> list[float]:
    """Return the parameters of an arm; angles count as way of a hand at full reach."""
    units = [1.0 if joint.type == "prismatic" else arm.reach for joint in arm.model.coordinates]
    rows = [arm.joints]
    if arm.max_joint_acceleration is not None:
        rows.append(tuple(0.5 * limit * horizon**2 for limit in arm.max_joint_acceleration))
        rows.append(tuple(rate * horizon for rate in arm.joint_rates or ()))
    hand = [] if arm.max_hand_speed is None else [arm.max_hand_speed * horizon]
    turns = [unit * turn for row in rows for unit, turn in zip(units, row, strict=True)]
    return [*hand, arm.grasp, arm.reach * horizon, *turns]


def planar_forearm(arm: Arm) -> float:
    """Return the length of the forearm: the unit of planar situations."""
    return 1.0


def spatial_forearm(arm: SpatialArm) -> float:
    """Return the length of the forearm in the situation's unit."""
    return math.hypot(*arm.forearm)


def chain_reach(arm: Chain) -> float:
    """Return the bound of the hand's distance, the unit of lengths of chains."""
    return arm.reach


def planar_sizes(situation: Situation) -> tuple[float, float]:
    """Return the length of the upper arm and the top speed of the hand."""
    return situation.arm.upper_arm, situation.arm.max_hand_speed


def spatial_sizes(situation: Situation[SpatialArm]) -> tuple[float, float]:
    """Return the length of the upper arm and the top speed of the hand."""
    return math.hypot(*situation.arm.upper_arm), float(fastest_hand(pack(situation)))


def chain_sizes(situation: Situation[Chain]) -> tuple[float, float]:
    """Return the reach, which is the unit, and the top speed of the hand."""
    return situation.arm.reach, float(fastest_hand(pack(situation)))


@dataclass(frozen=True)
class RecordKind:
    """Records of situations with one kind of arm."""

    version: str
    """Format of records."""
    plan: pa.StructType
    """Columns of a plan."""
    base: Types
    """Columns of the arm's base, empty without a base."""
    path_cells: Callable[[Any], dict[str, Any]]
    """Cells of a plan's path."""
    path: Callable[[Any, Mapping[str, Any]], Any]
    """Path of an arm, from its cells."""
    frame: Callable[..., Frame | SpatialFrame]
    """Frame of base, angle and mirroring."""
    word: Callable[[Any], str]
    """Name of the arm in a situation's structure."""
    numbers: Callable[[Any, float], list[float]]
    """Parameters of an arm, for a horizon [s]."""
    forearm: Callable[[Any], float]
    """Length of an arm's forearm."""
    sizes: Callable[[Any], tuple[float, float]]
    """Length of the upper arm and top speed of the hand of a situation's arm."""
    persistent: str
    """Planner that can wait; its catches tell stratum Q from U."""
    map: Types
    """Columns of a map."""
    engines: tuple[str, ...]
    """Engines that may make the map."""
    largest: int
    """Cells along a side of a map at most."""
    efforts: bool
    """True if the effort of a search may be limited."""
    oracle: bool = True
    """True if there is an oracle that labels."""
    several: bool = False
    """True if a plan may have several catches."""


_CHAIN = RecordKind(
    version="gcm-learn/record@3",
    plan=CHAIN_PLAN,
    base=BASE,
    path_cells=joint_cells,
    path=joint_path,
    frame=spatial_frame,
    word=chain_word,
    numbers=chain_numbers,
    forearm=chain_reach,
    sizes=chain_sizes,
    persistent="search",
    map=MAP_IN_SPACE,
    engines=("marching",),
    largest=COARSE,
    efforts=True,
    oracle=False,
    several=True,
)
RECORDS = ByKind(
    {
        PLANAR: RecordKind(
            version="gcm-learn/record@1",
            plan=HAND_PLAN,
            base={},
            path_cells=hand_cells,
            path=hand_path,
            frame=planar_frame,
            word=planar_word,
            numbers=planar_numbers,
            forearm=planar_forearm,
            sizes=planar_sizes,
            persistent="layered",
            map=MAP,
            engines=("wave", "marching", "layered"),
            largest=LARGEST_LATTICE,
            efforts=False,
        ),
        SPATIAL: replace(
            _CHAIN,
            version="gcm-learn/record@2",
            plan=JOINT_PLAN,
            word=spatial_word,
            numbers=spatial_numbers,
            forearm=spatial_forearm,
            sizes=spatial_sizes,
            oracle=True,
            several=False,
        ),
        CHAIN: _CHAIN,
    },
    who="dataset",
)
VERSIONS = tuple(kind.version for kind in RECORDS.entries())


def kind_of_version(version: str) -> Kind:
    """Return the kind of arm whose records have the format `version`."""
    return next(kind for kind in RECORDS if RECORDS.of(kind).version == version)
