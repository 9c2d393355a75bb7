"""Unlearned neighbours on the clearance features that the learned index sees: a control."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Self

import numpy as np

from gcm_learn.recall.hand_features import clearance_features
from gcm_learn.recall.index import nearest_query, nearest_rows
from gcm_learn.scene import Scene


@dataclass(frozen=True)
class ClearanceIndex:
    """Neighbours by the target's track, the arm, and the limb's clearance.

    A cell is that of the nearest obstacle. Numbers of the context are on their own scales; context
    and cells vary equally much in all.

    Parameters
    ----------
    mean, scale : (dim - 1,) ndarray
        Of the features; the scale multiplies.
    """

    mean: np.ndarray
    scale: np.ndarray
    name: ClassVar[str] = "clearance"
    key: ClassVar[str] = "clearance"

    @classmethod
    def fit(cls, situations: Sequence[Any], seed: int = 0) -> Self:
        """Learn the scales of the features."""
        numbers = np.array([_numbers(situation) for situation in situations])
        context, spread = len(clearance_features(situations[0]).context), numbers.std(axis=0)
        scale = np.zeros(len(spread))
        varies = spread[:context] > 0.0
        scale[:context][varies] = 1.0 / (spread[:context][varies] * np.sqrt(varies.sum()))
        scale[context:] = 1.0 / np.sqrt((spread[context:] ** 2).sum())
        return cls(numbers.mean(axis=0), scale)

    @property
    def dim(self) -> int:
        """Numbers of an embedding: the features, and one for their distance."""
        return len(self.mean) + 1

    def embed_query(self, situation: Any, scene: Scene | None = None) -> np.ndarray:
        """Return the embedding of a situation."""
        return nearest_query((_numbers(situation, scene) - self.mean) * self.scale)

    def embed_memories(self, situations: Sequence[Any], trajectories: Sequence[Any]) -> np.ndarray:
        """Return the embeddings of memories."""
        numbers = np.array([_numbers(situation) for situation in situations])
        return nearest_rows((numbers.reshape(-1, len(self.mean)) - self.mean) * self.scale)

    def save(self, folder: Path) -> None:
        """Refuse: it is fitted when it is asked."""
        raise NotImplementedError

    load = fit


def _numbers(situation: Any, scene: Scene | None = None) -> np.ndarray:
    """Return context and, for each cell, the least clearance that an obstacle leaves."""
    found = clearance_features(situation, scene)
    return np.concatenate([found.context, found.cells.max(axis=0, initial=0.0)]).astype(float)
