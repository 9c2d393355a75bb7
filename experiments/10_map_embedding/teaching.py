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
)

AVERAGE = 0.98
"""Of the weights over the steps: the package's average is for long runs, and would here still hold
much of the random weights that training starts from."""
Given = dict[int, Labels]


class Same:
    """Training data that give all encoders the same labels, unless these are about their own order.

    Parameters
    ----------
    source : TransferLabels
    pictures : (m, n) ndarray, optional
        Features of memories besides their paths.
    given : dict
        Batches that have been given.
    """

    def __init__(self, source: TransferLabels, pictures: np.ndarray | None, given: Given) -> None:
        self.source, self.given = source, given
        self.path_features, self.map_features = source.path_features, pictures

    @property
    def situation_counts(self) -> tuple[int, int]:
        """Features of a situation's context, and of an obstacle."""
        return self.source.situation_counts

    def labels(self, index: int, best: Best | None) -> Labels:
        """Batch number `index`, made at the first call."""
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
        trainer = Trainer(config, data, Path(folder), Effort(turns=turns), average=AVERAGE)
        encoder = trainer.run()
    print(config, f"{time.process_time() - began:.0f} s", flush=True)
    return encoder


def filed(index: Index, places: np.ndarray, source: TransferLabels) -> Memory:
    """The source's memories at known places."""
    kind = source.spec.kind
    return Memory.of(index, places, source.knots, source.goals, search="exact", kind=kind)
