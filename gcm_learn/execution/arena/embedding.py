"""How the encoder among the models embeds a situation, by what is known at t = 0."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from gcm_learn import artifacts
from gcm_learn.errors import EncoderError
from gcm_learn.situation import Situation

if TYPE_CHECKING:
    from gcm_learn.recall import Encoder

FARTHEST = 100.0  # number of an embedding


@cache
def encoder() -> Encoder:
    """The one among the models."""
    from gcm_learn.recall import CONFIG, load_encoder

    folder = artifacts.model("encoder", CONFIG)
    if folder is None:
        make = f"gcm-learn train-encoder DATASET --out {artifacts.own('models') / 'encoder'}"
        raise EncoderError(artifacts.missing("models", "encoder", make))
    return load_encoder(folder)


def embeddings_of(situations: Sequence[Situation]) -> np.ndarray:
    """Embeddings (s, dim) float32 of situations."""
    found = np.array([encoder().embed_situation(situation) for situation in situations])
    return np.clip(found, -FARTHEST, FARTHEST)
