"""Sizes of the batches of labels that encoders learn from."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

ALONE = 0.4  # share of a batch: situations of it again, with one of their obstacles alone


class Sizes(NamedTuple):
    """Sizes of a batch of labels."""

    situations: int = 512
    any: int = 160
    """Memories of a batch about any memories."""
    top: int = 40
    """First memories of a batch about the best."""
    wide: int = 16
    """Memories drawn from the best that follow."""

    @property
    def alone(self) -> int:
        """Situations with one obstacle alone."""
        return int(ALONE * self.situations)

    @property
    def others(self) -> int:
        """Situations with all of their obstacles."""
        return self.situations - self.alone

    def hard(self, found: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """Choose the first of the best memories (n, k) and some that follow (n, top + wide)."""
        top = min(self.top, found.shape[1])
        rest = found.shape[1] - top
        wide = min(self.wide, rest)
        after = top + np.argsort(rng.random((len(found), rest)), axis=1)[:, :wide]
        rows = np.hstack([found[:, :top], np.take_along_axis(found, after, axis=1)])
        return np.ascontiguousarray(rows, dtype=np.int64)
