"""``gcm-learn train-encoder``: an encoder for recall, from a dataset."""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Annotated, Literal

from tyro.conf import Positional, arg

from gcm_learn.cli.failures import CommandFailure, dataset_package, why
from gcm_learn.cli.progress import Cluster, Progress, check_workers

if TYPE_CHECKING:
    from gcm_learn.dataset import Dataset
    from gcm_learn.processes import Crew

PARTS = 1000  # of the training, for the line that shows how far it has come
WORK = "work.tmp"  # folder of what it takes to go on


@dataclass(frozen=True)
class TrainEncoder:
    """Train the encoder that recall asks its memories with.

    Stopped by Ctrl-C or otherwise, it goes on from its last checkpoint when it is called again.
    """

    dataset: Annotated[Positional[str], arg(metavar="DATASET")]
    """folder of a dataset, see gcm-learn generate; its records for training become memories"""

    out: Annotated[Path, arg(metavar="DIR")]
    """folder for the model; one that is there is replaced once the new one is complete"""

    minutes: Annotated[float, arg(metavar="M")] = 40.0
    """how long to train, reading the dataset not counted"""

    turns: Annotated[
        int | None, arg(metavar="N", help_behavior_hint="(default: as many as fit the minutes)")
    ] = None
    """train for N lessons instead, which gives the same encoder every time"""

    start: Annotated[
        Path | None, arg(metavar="DIR", help_behavior_hint="(default: weights drawn at random)")
    ] = None
    """folder of an encoder whose weights to start from"""

    dim: Annotated[int, arg(metavar="N")] = 32
    """numbers of an embedding"""

    memory: Literal["trace", "map", "both"] = "trace"
    """what a memory is embedded by: its way, its situation's cognitive map, or both"""

    synthetic: bool = False
    """learn from random movements to the targets in place of catches, as long as these: a
    control; see gcm-learn remember --synthetic"""

    most: Annotated[int | None, arg(metavar="N", help_behavior_hint="(default: all)")] = None
    """records that are read at most"""

    seed: Annotated[int, arg(metavar="N")] = 0
    """of weights and lessons"""

    workers: Annotated[int, arg(metavar="N")] = 1
    """processes on this machine that read records and make labels"""

    cluster: Cluster = None
    """a Dask scheduler whose workers do that instead, tcp://HOST:PORT"""

    def run(self) -> int:
        """Train, write the model and say how good it is."""
        from gcm_learn.processes import crew_of

        self._check()
        records, trainers = dataset_package().open(self.dataset), _training()
        with crew_of(self.workers, self.cluster) as crew:
            return self._train(records, trainers, crew)

    def _check(self) -> None:
        if not self.minutes > 0.0:
            raise CommandFailure(f"--minutes {self.minutes}: must be positive")
        for name, value in (("turns", self.turns), ("most", self.most)):
            if value is not None and value < 1:
                raise CommandFailure(f"--{name} {value}: must be at least 1")
        check_workers(self.workers)

    def _train(self, records: Dataset, trainers: ModuleType, crew: Crew) -> int:
        from gcm_learn.recall import EncoderConfig, TransferLabels, load_encoder, write_model

        config = EncoderConfig(
            dim=self.dim, memory=self.memory, seed=self.seed, arm=records.spec.kind.name
        )
        total = len(records.where(split="train"))
        with Progress(min(total, self.most or total), "records read") as reading:
            labels = TransferLabels(
                records,
                self.seed,
                most=self.most,
                maps=config.uses_maps,
                synthetic=self.synthetic,
                crew=crew,
                progress=reading.advance,
            )
        try:
            effort = trainers.Effort(self.minutes, self.turns)
            start = None if self.start is None else load_encoder(self.start)
            trainer = trainers.Trainer(config, labels, self.out / WORK, effort, start)
            with Progress(PARTS, "parts of the training") as progress:
                trainer.run(lambda share: progress.advance(int(share * PARTS) - progress.done))
            marks = trainer.validate()
            named = f"{self.dataset} --synthetic" if self.synthetic else self.dataset
            write_model(self.out, trainer, records, named, marks)
        except OSError as error:
            raise CommandFailure(f"--out {self.out}: {why(error)}") from None
        scores = ", ".join(f"{name} {value:.0%}" for name, value in marks.items())
        print(f"{self.out}: {trainer.turn} lessons, key {trainer.encoder.key}; {scores}")
        return 0


def _training() -> ModuleType:
    """The module that needs torch."""
    try:
        return importlib.import_module("gcm_learn.recall.training")
    except ImportError as error:
        raise CommandFailure(
            f"train-encoder needs {error.name}: pip install 'gcm_learn[learn,data]'"
        ) from None
