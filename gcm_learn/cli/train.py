"""``gcm-learn train``: policies that act in the arena, and encoders for recall."""

from __future__ import annotations

import importlib
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Annotated, Literal

from tyro.conf import Positional, arg

from gcm_learn.cli import options
from gcm_learn.cli.failures import CommandFailure, dataset_package, say, why
from gcm_learn.cli.files import made_folder, refuse_missing
from gcm_learn.cli.progress import Progress
from gcm_learn.errors import MissingExtraError

if TYPE_CHECKING:
    from gcm_learn.dataset import Dataset
    from gcm_learn.processes import Crew

PARTS = 1000  # of the training, for the line that shows how far it has come
WORK = "work.tmp"  # folder of what it takes to go on


@dataclass(frozen=True)
class Policy:
    """Train a policy in the arena, or go on where an earlier run of the same command stopped."""

    config: Annotated[Positional[Path], arg(metavar="CONFIG")]
    """a .yml file of hyperparameters in the form of rl_zoo3; `gcm-learn demo --copy ppo.yml` copies
    one, `gcm-learn demo --list` lists others"""

    out: options.Folder
    """folder for the policy, its checkpoints, its log and its card"""

    seed: Annotated[int | None, options.WHOLE, options.given("N", "the file's")] = None
    """of everything random"""

    steps: Annotated[int | None, options.COUNT, options.given("N", "the file's")] = None
    """of all arms together; more than before goes on with a finished run"""

    def run(self) -> int:
        """Train, and say how good the policy is."""
        refuse_missing(self.config)
        try:
            from gcm_learn.policies import read_plan, train
        except ModuleNotFoundError as error:
            raise MissingExtraError("train policy", str(error.name), "rl") from None
        plan = read_plan(self.config)
        plan = plan if self.seed is None else replace(plan, seed=self.seed)
        plan = plan if self.steps is None else replace(plan, n_timesteps=self.steps)
        scores = train(plan, made_folder(self.out, option="--out"), say)
        print(f"{self.out}: {scores['caught']:.1%} caught, {scores['touched']:.1%} touched")
        return 0


@dataclass(frozen=True)
class Encoder:
    """Train the encoder that recall asks its memories with.

    Stopped by Ctrl-C or otherwise, it goes on from its last checkpoint when it is called again.
    """

    dataset: Annotated[Positional[str], arg(metavar="DATASET")]
    """folder of a dataset, see gcm-learn generate; its records for training become memories"""

    out: options.Folder
    """folder for the model"""

    time: Annotated[float, options.TIME, options.given("TIME", "40min")] = 2400.0
    """how long to train, reading the dataset not counted"""

    turns: Annotated[int | None, options.COUNT, options.given("N", "as many as fit the time")] = (
        None
    )
    """train for N lessons instead, which gives the same encoder every time"""

    start: Annotated[Path | None, options.given("DIR", "weights drawn at random")] = None
    """folder of an encoder whose weights to start from"""

    dim: options.Count = 32
    """numbers of an embedding"""

    memory: Literal["trace", "map", "both"] = "trace"
    """what a memory is embedded by: its way, its situation's cognitive map, or both"""

    synthetic: bool = False
    """learn from random movements to the targets in place of catches, as long as these: a
    control; see gcm-learn memory make --synthetic"""

    most: options.All = None
    """records that are read at most"""

    seed: options.Number = 0
    """of weights and lessons"""

    workers: options.Workers = 1
    """processes on this machine that read records and make labels"""

    cluster: options.Cluster = None
    """a Dask scheduler whose workers do that instead, tcp://HOST:PORT"""

    def run(self) -> int:
        """Train the encoder, write the model and print its scores."""
        refuse_missing(self.dataset)
        from gcm_learn.processes import crew_of

        records, trainers = dataset_package().open(self.dataset), _training()
        with crew_of(self.workers, self.cluster) as crew:
            return self._train(records, trainers, crew)

    def _train(self, records: Dataset, trainers: ModuleType, crew: Crew) -> int:
        from gcm_learn.recall import EncoderConfig, TransferLabels, load_encoder, write_model

        config = EncoderConfig(
            dim=self.dim, memory=self.memory, seed=self.seed, arm=records.spec.kind.name
        )
        total = len(records.where(split="train"))
        with Progress(min(total, self.most or total), "records read") as reading:
            labels = TransferLabels(
                records, self.seed, most=self.most, maps=config.uses_maps,
                synthetic=self.synthetic, crew=crew, progress=reading.advance,
            )  # fmt: skip
        try:
            effort = trainers.Effort(self.time / 60.0, self.turns)
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
    """Return the module that needs torch."""
    try:
        return importlib.import_module("gcm_learn.recall.training")
    except ImportError as error:
        raise MissingExtraError("train encoder", str(error.name), "learn,data") from None
