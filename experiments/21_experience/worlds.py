"""Worlds in which stored catches and synthetic movements are compared."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

from experiments.common.freezing import frozen_seed
from experiments.common.questions import Question
from gcm_learn import dataset

HERE = Path(__file__).resolve().parent
SPECS = HERE.parents[1] / "data" / "specs"
OUT = HERE / "out"
FROZEN = HERE / "frozen.json"
"""Commits that froze code and generator, and the seeds that their hashes give."""
AS_TRAINED = ("train", "validation", "test")  # splits: whatever a seed draws, no memory has seen
STRATA = ("W", "Q")
CHOSEN_ON = 60  # situations of W for the time that planning without memory takes


@dataclass(frozen=True)
class World:
    """One kind of situations.

    Parameters
    ----------
    name : str
    spec : str
        File of `data/specs`.
    records : int
        Draws whose catches are remembered.
    draws : int
        Fresh draws, in which situations are looked for.
    each : int
        Situations of W, and of Q, that are asked at most.
    seeds : int
        Trainings of every encoder.
    """

    name: str
    spec: str
    records: int
    draws: int
    each: int
    seeds: int

    @property
    def seed(self) -> int:
        """Seed of the fresh draws."""
        return frozen_seed(FROZEN, self.name)

    @property
    def records_folder(self) -> Path:
        """Folder of the records that are remembered."""
        return OUT / "records" / self.spec

    @property
    def fresh_folder(self) -> Path:
        """Folder of the fresh draws."""
        return OUT / f"fresh-{self.seed}" / self.spec

    def draw(self, workers: int) -> None:
        """Draw what is missing of records and fresh situations."""
        spec = replace(dataset.read_spec(SPECS / f"{self.spec}.toml"), audit=0.0)
        dataset.generate(replace(spec, count=self.records), self.records_folder, workers)
        fresh = replace(spec, count=self.draws, seed=self.seed)
        dataset.generate(fresh, self.fresh_folder, workers)

    @cached_property
    def records_of_memory(self) -> dataset.Dataset:
        """Records of training."""
        return dataset.open(self.records_folder)[: self.records].where(split="train")

    def fresh(self) -> Iterator[Question]:
        """Yield fresh situations of W and Q, at most `each` of both, in the order of their draw."""
        yield from self._asked(dataset.open(self.fresh_folder), AS_TRAINED, self.each)

    def known(self) -> Iterator[Question]:
        """Yield some situations of W among the records, for methods without memory."""
        asked = self._asked(self.records_of_memory, ("train",), CHOSEN_ON)
        yield from (question for question in asked if question.stratum == "W")

    def _asked(
        self, records: dataset.Dataset, splits: tuple[str, ...], each: int
    ) -> Iterator[Question]:
        left = dict.fromkeys(STRATA, each)
        for record in records.where(split=splits, stratum=STRATA):
            if left[record.stratum] > 0:
                left[record.stratum] -= 1
                yield Question(record.stratum, record.family, record.index, record.situation)


WORLDS = {
    world.name: world
    for world in (
        World("space, limits", "space-accelerated", 4000, 18_500, 300, 5),
        World("space", "space", 4000, 3000, 150, 2),
        World("plane", "recall", 4000, 4000, 150, 2),
        World("panda", "recall-panda", 2500, 1500, 150, 2),
        World("panda, limits", "panda-accelerated", 2500, 1500, 150, 2),
    )
}
