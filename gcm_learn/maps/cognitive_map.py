"""The generalized cognitive map: a dynamic situation made static (Eq. 12)."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from gcm_learn.arms import CHAIN, PLANAR, SPATIAL, Base, ByKind, Chain, SpatialArm
from gcm_learn.charts import Chart, HandLattice, Lattice, lattice_of
from gcm_learn.errors import FileFormatError
from gcm_learn.situation import arm_from_json, arm_to_json
from gcm_learn.storage import whole_file
from gcm_learn.wave import MarchingParams, WaveParams

IN_SPACE = MarchingParams(n=40, margin=0.0)
"""Moves in space are judged for what they are, so that cells need no margin."""


class MapKind(NamedTuple):
    """Differences between maps of several kinds of arms."""

    format: str
    """Format of files."""
    header: Callable[[Any], dict[str, Any]]
    """Entries of a file's header for a chart."""
    chart: Callable[[dict[str, Any]], Chart]
    """Chart of a file's header."""
    hand: Callable[[Any, Any], tuple[float, ...]]
    """Hand of an arm at t = 0 in the frame of a chart."""
    params: WaveParams | MarchingParams
    """Default of `build_map`."""


def _space(header: dict[str, Any]) -> HandLattice:
    if "postures" in header:
        raise FileFormatError("postures: the map is over another lattice, which is no longer read")
    arm = header["arm"] | {"base": Base(**header["arm"]["base"])}
    return HandLattice(SpatialArm(**arm), header["n"])


def _space_header(chart: HandLattice) -> dict[str, Any]:
    given = asdict(chart.arm)
    return {"n": chart.n, "arm": {f.name: given[f.name] for f in fields(chart.arm) if f.init}}


def _chain_header(chart: HandLattice) -> dict[str, Any]:
    arm = chart.arm
    given = {"joints": arm.joints, "grasp": arm.grasp, "base": asdict(arm.base)}
    return {"n": chart.n, "arm": given | {"model": arm_to_json(arm.model)}}


def _chain(header: dict[str, Any]) -> HandLattice:
    arm = header["arm"]
    arm |= {"model": arm_from_json(arm["model"]), "base": Base(**arm["base"])}
    return HandLattice(Chain(**arm), header["n"])


MAPS = ByKind(
    {
        PLANAR: MapKind(
            "gcm-learn/map@1",
            lambda chart: {"n": chart.n, "upper_arm": chart.upper_arm, "elbow": chart.elbow},
            lambda header: Lattice(header["n"], header["upper_arm"], header["elbow"]),
            lambda arm, chart: arm.hand,
            WaveParams(),
        ),
        SPATIAL: MapKind(
            "gcm-learn/map@2",
            _space_header,
            _space,
            lambda arm, chart: chart.hand,
            IN_SPACE,
        ),
        CHAIN: MapKind(
            "gcm-learn/map@3", _chain_header, _chain, lambda arm, chart: chart.hand, IN_SPACE
        ),
    },
    who="a map",
)


def header_of(chart: Chart) -> dict[str, Any]:
    """Return the header of a file for a chart."""
    kind = MAPS.of(chart.kind)
    return {"format": kind.format} | kind.header(chart)


def chart_from(header: dict[str, Any]) -> Chart:
    """Return the chart of a file's header.

    Raises
    ------
    FileFormatError
        If the format is none of the formats of maps.
    """
    for kind in MAPS.entries():
        if kind.format == header["format"]:
            return kind.chart(header)
    known = " or ".join(repr(kind.format) for kind in MAPS.entries())
    raise FileFormatError(f"format is {header['format']!r}, expected {known}")


@dataclass(frozen=True)
class Interception:
    """Place and time at which the front met a target first."""

    cell: tuple[int, ...]
    """Index of the node in the chart's shape: (iy, ix) or (iz, iy, ix) of a lattice."""
    position: tuple[float, ...]
    """Hand at that node, the centre of the cell [forearm lengths]."""
    time: float
    """[s]"""
    body: str
    """Name of the target."""


@dataclass(frozen=True)
class CognitiveMap:
    """Arrival times over hand-space, with the obstacles and the target as the front met them.

    Arrays have the chart's shape: (n, n), indexed [iy, ix], over a `Lattice`.
    """

    chart: Chart
    hand: tuple[float, ...]
    """Hand at t = 0 in the chart's frame, that of the arm's plane or base."""
    arrival: np.ma.MaskedArray
    """(...) float: when the hand can be in a cell [s]; masked where the front never came and
    inside effective obstacles."""
    effective_obstacles: np.ndarray
    """(...) bool: cells in which the front froze on an obstacle (Omega of Eq. 11)."""
    effective_target: np.ndarray
    """(...) bool: cells in which the front met a target."""
    interception: Interception | None
    """The first of them; None if the front missed all targets."""
    kappa: float
    """Seconds per unit of mental time: t = kappa tau."""
    engine: str
    """"wave", "marching" or "layered"."""
    later: np.ma.MaskedArray | None = None
    """(m, ...) float: earliest arrivals in a cell's second, third, ... safe interval that can be
    reached [s]; only layered maps, in which the hand may wait, have such sheets."""
    via: np.ndarray | None = None
    """(...) int: node from which the front came to another, -1 where it set out. None over a
    lattice in the plane, on which the gradient says it."""
    joints: np.ndarray | None = None
    """(nodes, dof) float: postures that the front found, NaN elsewhere; None in the plane."""

    def __post_init__(self) -> None:
        shape = self.chart.shape
        for name in ("arrival", "effective_obstacles", "effective_target"):
            if getattr(self, name).shape != shape:
                raise ValueError(f"{name} must be {shape}, got {getattr(self, name).shape}")

    @property
    def lattice(self) -> Lattice:
        """Chart of a map of the plane; another is refused by an ArmKindError."""
        return lattice_of(self.chart)

    @property
    def arrival_tau(self) -> np.ma.MaskedArray:
        """Arrival in mental time, c_ij of the paper (...) [tau]."""
        return self.arrival / self.kappa

    @property
    def interception_tau(self) -> float | None:
        """Mental time of the interception, as in the figures' captions."""
        return None if self.interception is None else self.interception.time / self.kappa

    @property
    def sheets(self) -> np.ma.MaskedArray:
        """All sheets of arrivals (1 + m, ...) [s]; a first-arrival map has one."""
        first = self.arrival[None]
        return first if self.later is None else np.ma.concatenate([first, self.later])

    @property
    def met(self) -> int:
        """Node in which a target was met, -1 if none."""
        if self.interception is None:
            return -1
        return int(np.ravel_multi_index(self.interception.cell, self.chart.shape))

    def postures(self, nodes: np.ndarray) -> np.ndarray:
        """Return the postures (m, dof) of nodes (m,); only for arms that move in their joints."""
        assert self.joints is not None
        return self.joints[nodes]

    def save(self, path: str | Path) -> Path:
        """Write the map to an .npz file, whole or not at all; return the file's path."""
        path = Path(path).with_suffix(".npz")
        header = header_of(self.chart) | {
            "hand": self.hand,
            "kappa": self.kappa,
            "engine": self.engine,
            "contact": None if self.interception is None else vars(self.interception),
        }
        arrays = {
            "header": np.array(json.dumps(header)),
            "arrival": self.arrival.filled(-1.0),
            "effective_obstacles": self.effective_obstacles,
            "effective_target": self.effective_target,
        }
        if self.later is not None:
            arrays["later"] = self.later.filled(-1.0)
        if self.via is not None:
            arrays["via"] = self.via
        if self.joints is not None:
            arrays["joints"] = self.joints
        with whole_file(path) as place:
            np.savez_compressed(place, allow_pickle=False, **arrays)
        return path

    @classmethod
    def load(cls, path: str | Path) -> CognitiveMap:
        """Read a map written by `save`; raises FileFormatError if the file is something else."""
        try:
            with np.load(path, allow_pickle=False) as data:
                return cls._from_arrays(json.loads(str(data["header"])), data)
        except FileNotFoundError:
            raise
        except Exception as error:
            raise FileFormatError(f"{path}: not a cognitive map ({error})") from error

    @classmethod
    def _from_arrays(cls, header: dict[str, Any], data: Any) -> CognitiveMap:
        contact = header["contact"]
        if contact is not None:
            contact = Interception(
                tuple(contact["cell"]), tuple(contact["position"]), contact["time"], contact["body"]
            )
        arrival = data["arrival"]
        return cls(
            chart=chart_from(header),
            hand=tuple(header["hand"]),
            arrival=np.ma.MaskedArray(arrival, mask=arrival < 0.0),
            effective_obstacles=data["effective_obstacles"],
            effective_target=data["effective_target"],
            interception=contact,
            kappa=header["kappa"],
            engine=header["engine"],
            later=np.ma.MaskedArray(data["later"], mask=data["later"] < 0.0)
            if "later" in data
            else None,
            via=data.get("via"),
            joints=data.get("joints"),
        )
