"""Covers: a box of parameters cut into cells, with a stored catch for every proven cell."""

from __future__ import annotations

import json
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from gcm_learn.cover.catches import StoredCatch
from gcm_learn.cover.families import ParametricFamily, parametric_family
from gcm_learn.errors import CoverError
from gcm_learn.storage import content_hash, whole_file, write_whole

FORMAT = "gcm-learn/cover@1"
MANIFEST = "cover.json"
OPEN, CLOSED = -1, -2
"""In place of a stored catch: still to be examined, and given up."""
_PER_CATCH = ("anchor", "gain", "body")
_PER_SAMPLE = ("time", "way", "ramp")


@dataclass(slots=True)  # there may be millions
class Cell:
    """Part of the box of parameters; a cell that is cut has two halves, which are cells too."""

    low: np.ndarray
    """(K,) float: lowest values of the parameters."""
    high: np.ndarray
    """(K,) float: highest values."""
    trial: int = -1
    """Index of a catch that was planned for the whole of which this is a half; -1 if none was."""
    axis: int = -1
    """Parameter along which the cell is cut in the middle; -1 if it is not."""
    first: int = -1
    """Index of the lower half; the upper half comes next."""
    held: int = OPEN
    """Index of the stored catch, OPEN or CLOSED."""
    reason: str = ""
    """Why the cell was not proven, when it was examined."""
    cut: float = field(init=False)
    """Middle of the parameter along which it is cut."""

    def __post_init__(self) -> None:
        self.cut_in(self.axis, self.first)

    def cut_in(self, axis: int, first: int) -> None:
        """Note the cut in the middle along a parameter, and the index of the lower half."""
        self.axis, self.first = axis, first
        self.cut = 0.5 * float(self.low[axis] + self.high[axis])


@dataclass
class Cover:
    """Cells of a family's box, and the catches that hold in them."""

    family: ParametricFamily
    cells: list[Cell] = field(default_factory=list)
    catches: list[StoredCatch] = field(default_factory=list)
    curve: list[tuple[int, int, float, float]] = field(default_factory=list)
    """Growth: cells examined, catches that are held, share covered, time on the wall [s]."""

    def __post_init__(self) -> None:
        if not self.cells:
            self.cells.append(Cell(self.family.low.copy(), self.family.high.copy()))

    @property
    def examined(self) -> int:
        """Number of cells that have been examined."""
        return self.curve[-1][0] if self.curve else 0

    @property
    def seconds(self) -> float:
        """Time on the wall that the growth took so far [s]."""
        return self.curve[-1][3] if self.curve else 0.0

    @property
    def share(self) -> float:
        """Share of the box that proven cells cover."""
        return float(sum(self.size(cell) for cell in self.leaves() if cell.held >= 0))

    @cached_property
    def used(self) -> set[int]:
        """Indices of the catches that hold in some cell; `hold` adds to them."""
        return {cell.held for cell in self.cells if cell.held >= 0}

    def hold(self, cell: Cell, index: int) -> None:
        """Note that a stored catch holds in a cell."""
        cell.held = index
        self.used.add(index)

    def leaves(self) -> Iterator[Cell]:
        """Iterate over the cells that are not cut."""
        return (cell for cell in self.cells if cell.axis < 0)

    def size(self, cell: Cell) -> float:
        """Return the share of the box that a cell takes."""
        return float(np.prod((cell.high - cell.low) / (self.family.high - self.family.low)))

    def missing(self) -> dict[str, float]:
        """Return the shares of the box that are not covered, by reason, the largest first."""
        shares: dict[str, float] = {}
        for cell in self.leaves():
            if cell.held < 0:
                reason = cell.reason if cell.held == CLOSED else "not examined"
                shares[reason] = shares.get(reason, 0.0) + self.size(cell)
        return dict(sorted(shares.items(), key=lambda item: -item[1]))

    def find(self, theta: list[float]) -> Cell | None:
        """Return the cell in which parameters lie; None if they are outside of the box."""
        cell = self.cells[0]
        for value, low, high in zip(theta, cell.low.tolist(), cell.high.tolist(), strict=True):
            if not low <= value <= high:
                return None
        cells = self.cells
        while cell.axis >= 0:
            cell = cells[cell.first + (theta[cell.axis] > cell.cut)]
        return cell

    def save(self, folder: Path) -> None:
        """Write the cover into a folder; an older cover there is replaced once all is written."""
        folder.mkdir(parents=True, exist_ok=True)
        kept = sorted({*self.used, *(c.trial for c in self.leaves() if c.held == OPEN)} - {-1})
        arrays = _arrays_of(self.cells, [self.catches[k] for k in kept], kept)
        reasons = sorted({cell.reason for cell in self.cells})
        arrays["reason"] = np.array([reasons.index(cell.reason) for cell in self.cells])
        data = folder / _file_of(arrays)
        with whole_file(data) as place:
            np.savez(place, **arrays)  # type: ignore[arg-type]
        about = {
            "format": FORMAT,
            "family": self.family.name,
            "free": len(self.family.parameters),
            "digest": self.family.digest,
            "data": data.name,
            "reasons": reasons,
            "curve": self.curve,
        }
        write_whole(folder / MANIFEST, json.dumps(about) + "\n", durable=True)
        for old in folder.glob("cells-*.npz"):
            if old != data:
                old.unlink()


def _file_of(arrays: dict[str, np.ndarray]) -> str:
    """Return the name of the file of arrays, which has their hash."""
    return f"cells-{content_hash(*(array.tobytes() for array in arrays.values()))[:16]}.npz"


def _arrays_of(
    cells: list[Cell], catches: list[StoredCatch], kept: list[int]
) -> dict[str, np.ndarray]:
    """Return cells and catches as arrays; the index of a catch becomes its position in `kept`."""
    place = {old: new for new, old in enumerate(kept)}
    arrays = {name: np.array([getattr(c, name) for c in cells]) for name in ("axis", "first")}
    arrays |= {name: np.array([getattr(c, name) for c in cells]) for name in ("low", "high")}
    arrays["held"] = np.array([place.get(c.held, c.held) for c in cells])
    arrays["trial"] = np.array([place.get(c.trial, -1) for c in cells])
    arrays["counts"] = np.array([len(c.time) for c in catches], dtype=int)
    if catches:
        arrays |= {name: np.array([getattr(c, name) for c in catches]) for name in _PER_CATCH}
        arrays |= {
            name: np.concatenate([getattr(c, name) for c in catches]) for name in _PER_SAMPLE
        }
    if catches and catches[0].span is not None:
        arrays["span"] = np.array([c.span for c in catches])
        arrays["rates"] = np.concatenate([c.rates for c in catches])
    return arrays


def is_cover(folder: Path) -> bool:
    """Return whether a folder holds a cover."""
    return (folder / MANIFEST).is_file()


def load_cover(folder: Path) -> Cover:
    """Read a cover.

    Raises
    ------
    CoverError
        If the folder lacks it, it is damaged, or its family has changed since.
    """
    path = folder / MANIFEST
    try:
        about = json.loads(path.read_text("utf-8"))
        if about["format"] != FORMAT:
            raise CoverError(f"{path}: format must be {FORMAT!r} (got {about['format']!r})")
        family = parametric_family(about["family"]).free(about["free"])
        with np.load(folder / about["data"]) as stored:
            arrays = {name: stored[name] for name in stored.files}
        if about["digest"] != family.digest:
            raise CoverError(f"{path}: family {family.name!r} has changed; make the cover anew")
        if about["data"] != _file_of(arrays):
            raise CoverError(f"{folder / about['data']}: is damaged, or was changed by hand")
        cells, catches = _cells_of(arrays, about["reasons"]), _catches_of(arrays)
        curve = [(int(n), int(held), *map(float, rest)) for n, held, *rest in about["curve"]]
        return Cover(family, cells, catches, curve)  # type: ignore[arg-type]
    except FileNotFoundError as error:
        missing = Path(error.filename).name
        raise CoverError(f"{folder}: no cover there ({missing} is missing)") from None
    except (BadZipFile, zlib.error) as error:
        raise CoverError(f"{folder / about['data']}: is damaged ({error})") from None
    except (OSError, EOFError, ValueError, KeyError, TypeError, IndexError) as error:
        raise CoverError(f"{path}: not a cover ({error})") from None


def _cells_of(arrays: dict[str, np.ndarray], reasons: list[str]) -> list[Cell]:
    lists: dict[str, Any] = {
        name: arrays[name].tolist() for name in ("trial", "axis", "first", "held", "reason")
    }
    rows = zip(arrays["low"], arrays["high"], *lists.values(), strict=True)
    return [
        Cell(low, high, trial, axis, first, held, reasons[reason])
        for low, high, trial, axis, first, held, reason in rows
    ]


def _catches_of(arrays: dict[str, np.ndarray]) -> list[StoredCatch]:
    ends = np.cumsum(arrays["counts"]).tolist()
    made = []
    for k, (count, end) in enumerate(zip(arrays["counts"].tolist(), ends, strict=True)):
        time, way, ramp = (arrays[name][end - count : end] for name in _PER_SAMPLE)
        anchor, gain, body = (arrays[name][k] for name in _PER_CATCH)
        made.append(StoredCatch(anchor, time, way, ramp, gain, int(body)))
        if "span" in arrays:
            rates, span = arrays["rates"][end - count : end], arrays["span"][k].tolist()
            made[-1] = replace(made[-1], rates=rates, span=tuple(span))
    return made
