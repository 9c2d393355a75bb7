"""Encoders that are trained for a short time on the same lessons, and memories that they file."""

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
    Lesson,
    Memory,
    School,
    Trainer,
    training,
)

# Of the weights over the steps: the package's average is for long runs, and would here still hold
# much of the weights at random that training starts from.
training.AVERAGE = 0.98
Lessons = dict[int, Lesson]


class Same:
    """A teacher that gives all encoders the same lessons, unless these are about what they think.

    Parameters
    ----------
    school : School
    pictures : (m, pictures.COUNT) ndarray, optional
        What memories look like besides their ways.
    given : dict
        Lessons that have been given.
    """

    def __init__(self, school: School, pictures: np.ndarray | None, given: Lessons) -> None:
        self.school, self.given = school, given
        self.ways, self.pictures = school.ways, pictures

    def lesson(self, index: int, best: Best | None) -> Lesson:
        """Lesson number `index`, made when it is first asked for."""
        if best is not None:
            return self.school.lesson(index, best)
        if index not in self.given:
            self.given[index] = self.school.lesson(index, None)
        return self.given[index]

    def exam(self, best: Best) -> dict[str, float]:
        """None: questions are asked later, of memories."""
        return {}


def trained(
    school: School, config: EncoderConfig, turns: int, pictures: np.ndarray | None, given: Lessons
) -> Encoder:
    """An encoder after some turns."""
    began = time.process_time()
    with tempfile.TemporaryDirectory() as folder:
        teacher = Same(school, pictures, given)
        trainer = Trainer(config, teacher, Path(folder), Effort(turns=turns))
        encoder = trainer.run()
    print(config, f"{time.process_time() - began:.0f} s", flush=True)
    return encoder


def filed(index: Index, places: np.ndarray, school: School) -> Memory:
    """The school's memories at known places; their situations are not kept."""
    memory, count = Memory(index, "exact"), len(places)
    columns = {
        "embeddings": places.astype(np.float32),
        "traces": school.traces,
        "goals": school.goals,
        "labels": np.zeros((count, 2), np.int16),
        "uses": np.zeros(count, np.int32),
        "lengths": np.zeros(count, np.int32),
    }
    memory._append(columns, [b""] * count)
    return memory
