"""The generalized cognitive map: a dynamic situation made static (Eq. 12)."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gcm_learn.charts import Chart, Lattice, lattice_of
from gcm_learn.errors import FileFormatError
from gcm_learn.maps.kinds import chart_from, header_of
from gcm_learn.storage import whole_file


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
    """(nodes, dof) float: postures that the front found; None over charts with a rule for them."""

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

    def save(self, path: str | Path) -> Path:
        """Write a map over a lattice to an .npz file (whole or not at all); returns its path."""
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
