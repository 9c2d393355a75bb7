"""What an encoder learns from, and who gives it.

The labels come from trying memories on situations, which is memory's business and stands above this
folder; here is only the form in which they are handed over.
"""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np

from gcm_learn.recall.clearance_features import Looks
from gcm_learn.storage import write_whole

Best = Callable[[Looks, int], np.ndarray]
"""From looks at n situations and a number k, the memories (n, k) that fit best by what is known so
far, the best first."""


class Lesson(NamedTuple):
    """Situations, memories, and which of them hold."""

    looks: Looks
    """Of n situations."""
    rows: np.ndarray
    """Memories that were tried: (m,) int64 on all situations, or (n, m) on each its own."""
    holds: np.ndarray
    """(n, m) bool"""
    own: np.ndarray
    """(n,) int64: column of a situation's own memory, -1 for those without."""

    def save(self, path: Path) -> None:
        """Write it into a file."""
        stream = io.BytesIO()
        looks, *rest = self
        np.savez(stream, *looks, *rest)
        write_whole(path, stream.getvalue())

    @classmethod
    def load(cls, path: Path) -> Lesson:
        """Read it from a file."""
        with np.load(path) as file:
            arrays = [file[f"arr_{k}"] for k in range(len(file.files))]
        size = len(Looks._fields)
        return cls(Looks(*arrays[:size]), *arrays[size:])


class Teacher(Protocol):
    """Gives lessons about memories, and examines."""

    @property
    def ways(self) -> np.ndarray:
        """Features (m, f) float32 of the memories' ways, see `ways.ways`."""

    @property
    def pictures(self) -> np.ndarray | None:
        """Features (m, pictures.COUNT) float32 of their maps; None if none are wanted."""

    def lesson(self, index: int, best: Best | None) -> Lesson:
        """Lesson number `index`; on the memories that seem best if `best` is given."""

    def exam(self, best: Best) -> dict[str, float]:
        """Marks by name, on situations that no lesson has."""
