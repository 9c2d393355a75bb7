"""Encoders that are trained for a short time on the same labels, and memories that they file."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

import numpy as np

from gcm_learn.recall import (
    Best,
    Effort,
    Encoder,
    EncoderConfig,
    Index,
    Labels,
    Memory,
    Trainer,
    TransferLabels,
    training,
)

# Of the weights over the steps: the package's average is for long runs, and would here still hold
# much of the weights at random that training starts from.
training.AVERAGE = 0.98
Given = dict[int, Labels]


class Same:
    """Training data that give all encoders the same labels, unless these are about what they think.

    Parameters
    ----------
    source : TransferLabels
    pictures : (m, COUNT) ndarray, optional
        What memories look like besides their paths.
    given : dict
        Batches that have been given.
    """

    def __init__(self, source: TransferLabels, pictures: np.ndarray | None, given: Given) -> None:
        self.source, self.given = source, given
        self.path_features, self.map_features = source.path_features, pictures

    def labels(self, index: int, best: Best | None) -> Labels:
        """Batch number `index`, made when it is first asked for."""
        if best is not None:
            return self.source.labels(index, best)
        if index not in self.given:
            self.given[index] = self.source.labels(index, None)
        return self.given[index]

    def validate(self, best: Best) -> dict[str, float]:
        """None: questions are asked later, of memories."""
        return {}


def trained(
    source: TransferLabels,
    config: EncoderConfig,
    turns: int,
    pictures: np.ndarray | None,
    given: Given,
) -> Encoder:
    """An encoder after some turns."""
    began = time.process_time()
    with tempfile.TemporaryDirectory() as folder:
        data = Same(source, pictures, given)
        trainer = Trainer(config, data, Path(folder), Effort(turns=turns))
        encoder = trainer.run()
    print(config, f"{time.process_time() - began:.0f} s", flush=True)
    return encoder


def filed(index: Index, places: np.ndarray, source: TransferLabels) -> Memory:
    """The source's memories at known places; their situations are not kept."""
    memory, count = Memory(index, "exact"), len(places)
    columns = {
        "embeddings": places.astype(np.float32),
        "traces": source.knots,
        "goals": source.goals,
        "labels": np.zeros((count, 2), np.int16),
        "uses": np.zeros(count, np.int32),
        "lengths": np.zeros(count, np.int32),
    }
    memory._append(columns, [b""] * count)
    return memory
