"""Charts of hand-space: cubes of cells in which a hand can be, and over which fronts run."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterable
from typing import ClassVar

import numpy as np

from gcm_learn.arms import Kind

SMALLEST_LATTICE = 16


class Chart(ABC):
    """A square or a cube of cells about the shoulder, n along a side, with nodes in them."""

    half_diagonal: ClassVar[float]
    """At least half the diagonal of a cell [cells]."""

    @property
    @abstractmethod
    def kind(self) -> Kind:
        """Kind of the arm whose hand-space the chart covers."""

    @property
    @abstractmethod
    def n(self) -> int:
        """Cells along a side."""

    @property
    @abstractmethod
    def shape(self) -> tuple[int, ...]:
        """Shape of arrays over the nodes."""

    @property
    @abstractmethod
    def reach(self) -> float:
        """Half a side: no hand is farther from the shoulder."""

    @property
    @abstractmethod
    def centres(self) -> np.ndarray:
        """Coordinates (n,) of the cells' centres along an axis."""

    @property
    @abstractmethod
    def hands(self) -> np.ndarray:
        """Centre (nodes, d) of every node's cell."""

    @abstractmethod
    def hand_at(self, node: int) -> tuple[float, ...]:
        """Return the centre of one node's cell."""

    @property
    def size(self) -> int:
        """Number of nodes."""
        return math.prod(self.shape)

    @property
    def spacing(self) -> float:
        """Side h of a cell."""
        return 2.0 * self.reach / self.n

    def cell_of(self, place: Iterable[float]) -> tuple[int, ...]:
        """Return the index (iy, ix) or (iz, iy, ix) of the cell at a place, clipped to the chart.

        Parameters
        ----------
        place : (d,) iterable of float
            The coordinates x and y, in space also z.
        """
        reach, h = self.reach, self.spacing
        return tuple(min(max(int((c + reach) / h), 0), self.n - 1) for c in place)[::-1]
