"""The learned index: situations ask by what they look like, memories are filed by their ways."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Self

import numpy as np

from gcm_learn.errors import EncoderError, RecallError
from gcm_learn.recall import Encoder, load_encoder, save_encoder
from gcm_learn.recall.kernels import KNOTS
from gcm_learn.recall.waypoints import Trace
from gcm_learn.scene.scene import Scene
from gcm_learn.situation import Situation


@dataclass(frozen=True)
class LearnedIndex:
    """Places situations and memories by a trained encoder.

    Examples
    --------
    >>> index = LearnedIndex(load_encoder("models/encoder"))  # doctest: +SKIP
    >>> memory = remember(records, index)                     # doctest: +SKIP
    """

    encoder: Encoder
    name: ClassVar[str] = "learned"

    @property
    def key(self) -> str:
        """Hash of the encoder's weights."""
        return self.encoder.key

    @property
    def dim(self) -> int:
        """Numbers of an embedding."""
        return self.encoder.dim

    def embed_query(self, situation: Situation, scene: Scene | None = None) -> np.ndarray:
        """Embedding of a situation."""
        return self.encoder.embed_situation(situation, scene)

    def embed_memory(self, situation: Situation, trace: Trace) -> np.ndarray:
        """Embedding of a memory."""
        return self.embed_memories([situation], [trace])[0]

    def embed_memories(
        self, situations: Sequence[Situation], traces: Sequence[Trace]
    ) -> np.ndarray:
        """Embeddings of memories."""
        knots = np.array([t.knots for t in traces], np.float32).reshape(-1, KNOTS, 4)
        goals = np.array([t.goal for t in traces], np.float32).reshape(-1, 2)
        return self.encoder.embed_memories(situations, knots, goals)

    def save(self, folder: Path) -> None:
        """Write the encoder."""
        save_encoder(self.encoder, folder)

    @classmethod
    def load(cls, folder: Path) -> Self:
        """Read the encoder."""
        try:
            return cls(load_encoder(folder))
        except EncoderError as error:
            raise RecallError(str(error)) from None

    @classmethod
    def fit(cls, situations: Sequence[Situation], seed: int = 0) -> Self:
        """Refused: this one takes training."""
        raise RecallError("index 'learned': has to be trained first, see gcm-learn train-encoder")
