"""Training of encoders: labels are made while the encoder learns from earlier labels.

Turns follow each other: a batch is made, then the optimiser takes some steps on batches drawn from
all so far. Later batches ask about the memories that the encoder itself puts first, on which it
is judged; weights that have learned before ask about these only. At the end it only repeats.
A tower of maps that starts from an encoder of paths first learns to place a memory's map where that
encoder places the path.
Random numbers depend on seed, batch and step, so a run that was stopped goes on unchanged.

An encoder is kept as a model: its files, its training, and a card with its origin.
"""

from __future__ import annotations

import io
import json
import math
import shutil
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch.optim.swa_utils import AveragedModel, get_ema_multi_avg_fn

from gcm_learn import seeding
from gcm_learn.dataset import Dataset
from gcm_learn.errors import EncoderError
from gcm_learn.recall.encoder import Encoder, EncoderConfig, config_to_json, save_encoder
from gcm_learn.recall.features import STEPS, FeatureBatch
from gcm_learn.recall.networks import EncoderNet, Inputs, binary, contrast, imitate, listwise
from gcm_learn.recall.transfer_labels import TrainingData, ValidMemories
from gcm_learn.storage import write_whole

WARM = 200  # steps in which the learning rate rises
OPEN = 0.2  # share of the time in which labels are about any memories
FINE = 0.4  # of the learning rate, for weights that have learned before
REPEAT = 0.15  # share at the end in which no labels are made
SURVEYED = 30_000  # memories at most among which the best are looked for
AVERAGE = 0.998  # of the weights over the steps
VALIDATED = 240.0  # time between validations [s]
SAVED = 60.0  # time between checkpoints [s]
LARGEST_GRADIENT = 1.0
CHECKPOINT, LOG = "checkpoint.pt", "log.jsonl"


@dataclass(frozen=True)
class Effort:
    """Length of training: a time, or a number of turns for a repeatable result."""

    minutes: float = 40.0
    turns: int | None = None

    def done(self, turn: int, elapsed: float) -> float:
        """Return the share of the training that is done, from 0 to 1."""
        share = elapsed / (60.0 * self.minutes) if self.turns is None else turn / self.turns
        return min(share, 1.0)


@dataclass
class Trainer:
    """Training of an encoder, which can be stopped and resumed.

    Parameters
    ----------
    config : EncoderConfig
    data : TrainingData
    folder : Path
        For checkpoints, labels and the log. Training of the same configuration there is resumed.
    effort : Effort
    start : Encoder, optional
        Encoder of the same size whose weights are the first; by default weights are drawn.
    average : float
        Share of the averaged weights that a step keeps.
    """

    config: EncoderConfig
    data: TrainingData
    folder: Path
    effort: Effort = field(default_factory=Effort)
    start: Encoder | None = None
    average: float = AVERAGE

    def __post_init__(self) -> None:
        self.folder.mkdir(parents=True, exist_ok=True)
        self.turn, self.step, self.elapsed = 0, 0, 0.0
        self.batches: list[ValidMemories] = []
        self._paths = torch.from_numpy(self.data.path_features)
        maps = self.data.map_features
        self._maps = None if maps is None else torch.from_numpy(maps)
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(self.config.seed)
            pictures = 0 if maps is None else maps.shape[1]
            inputs = Inputs(*self.data.situation_counts, self._paths.shape[1], pictures)
            self.net = EncoderNet(self.config, inputs)
        if self.start is None:
            self._highest = self.config.rate
            self._fit_scales()
        else:
            self._highest = FINE * self.config.rate
            self.net.take_over(self.start)
            if self.config.memory == "map" and not (self.folder / CHECKPOINT).exists():
                self._imitate(self.start)
        self.mean = AveragedModel(self.net, multi_avg_fn=self._averaged)
        self._optimiser = torch.optim.AdamW(
            self.net.parameters(), self.config.rate, weight_decay=self.config.decay
        )
        self._board = _tensorboard(self.folder)
        self._take_up()

    def _averaged(self, mean: Any, now: Any, count: Any) -> None:
        """Average weights over the last steps, over few of them while there are few."""
        get_ema_multi_avg_fn(min(self.average, float((1 + count) / (10 + count))))(mean, now, count)

    @property
    def encoder(self) -> Encoder:
        """The encoder trained so far."""
        net: EncoderNet = self.mean.module
        return Encoder(self.config, net.arrays())

    def run(self, progress: Callable[[float], None] = lambda share: None) -> Encoder:
        """Train to the end; `progress` is called with the share that is done."""
        validated, saved = self.elapsed, self.elapsed
        while (share := self.effort.done(self.turn, self.elapsed)) < 1.0:
            began = time.monotonic()
            if share < 1.0 - REPEAT or not self.batches:
                self._attend(share)
            losses = [self._learn(share) for _ in range(self.config.steps)]
            scores = {name: float(np.mean([loss[name] for loss in losses])) for name in losses[0]}
            self.turn += 1
            self.elapsed += time.monotonic() - began
            if self.elapsed - validated >= VALIDATED:
                scores |= self.validate()
                validated = self.elapsed
            self._note(scores)
            if self.elapsed - saved >= SAVED:
                self.save()
                saved = self.elapsed
            progress(share)
        self._note(self.validate())
        self.save()
        return self.encoder

    def validate(self) -> dict[str, float]:
        """Return the validation scores of the encoder trained so far."""
        rows = np.arange(len(self._paths))
        return self.data.validate(lambda features, k: self._best(features, k, rows))

    def _attend(self, share: float) -> None:
        """Make the next batch of labels, save it and keep it."""
        k = len(self.batches)
        rng = seeding.rng(self.config.seed, 0, k)
        if self.start is None and (share < OPEN or rng.random() >= self.config.hard):
            batch = self.data.labels(k, None)
        else:
            rows = rng.permutation(len(self._paths))[:SURVEYED]
            batch = self.data.labels(k, lambda features, n: self._best(features, n, rows))
        batch.save(self._batch_file(k))
        self.batches.append(batch)

    def _learn(self, share: float) -> dict[str, float]:
        """Take one step of the optimiser; return the losses by name."""
        rng = seeding.rng(self.config.seed, 1, self.step)
        batch = self.batches[int(rng.integers(len(self.batches)))]
        for group in self._optimiser.param_groups:
            group["lr"] = self._rate(share)
        valid, own = torch.from_numpy(batch.valid), torch.from_numpy(batch.own)
        scores, bias = self._scores(batch)
        parts = {
            "binary": binary(scores, bias, valid),
            "listwise": listwise(scores, valid),
            "contrast": contrast(scores, valid, own),
        }
        loss = parts["binary"] + self.config.listwise * parts["listwise"]
        loss = loss + self.config.contrast * parts["contrast"]
        self._optimiser.zero_grad(set_to_none=True)
        loss.backward()
        torch.nn.utils.clip_grad_norm_(self.net.parameters(), LARGEST_GRADIENT)
        self._optimiser.step()
        self.mean.update_parameters(self.net)
        self.step += 1
        return {name: float(part.detach()) for name, part in parts.items()}

    def _rate(self, share: float) -> float:
        wave = 0.5 + 0.5 * math.cos(math.pi * share)
        return self._highest * min(1.0, (self.step + 1) / WARM) * (0.01 + 0.99 * wave)

    def _scores(self, batch: ValidMemories) -> tuple[torch.Tensor, torch.Tensor]:
        """Inner products (n, m) of a batch's situations and memories; the situations' bias."""
        queries = self.net.queries(batch.features)
        if batch.rows.ndim == 1:
            scores = queries @ self._memories(self.net, batch.rows).T
        else:
            unique, where = np.unique(batch.rows, return_inverse=True)
            memories = self._memories(self.net, unique)[torch.from_numpy(where.ravel())]
            memories = memories.reshape(*batch.rows.shape, -1)
            scores = torch.einsum("nd,nmd->nm", queries, memories)
        return scores, self.net.hope(queries)

    def _memories(self, net: EncoderNet, rows: np.ndarray) -> torch.Tensor:
        chosen = torch.from_numpy(rows)
        maps = None if self._maps is None else self._maps[chosen]
        return net.memories(self._paths[chosen], maps)

    @torch.no_grad()
    def _best(self, features: FeatureBatch, k: int, rows: np.ndarray) -> np.ndarray:
        """The best k of some memories for each situation, by the averaged weights."""
        net: EncoderNet = self.mean.module
        queries = net.queries(features)
        memories = torch.cat([self._memories(net, part) for part in _parts(rows)])
        best = torch.topk(queries @ memories.T, min(k, len(rows)), dim=1).indices
        found: np.ndarray = rows[best.numpy()]
        return found

    def _fit_scales(self) -> None:
        """Take the inputs' scales from the first batch and from the memories."""
        features = self.data.labels(0, None).features
        self.net.situation.fit_scale(features.context)
        cells = features.cells.astype(np.float32) / STEPS
        self.net.body.fit_scale(np.hstack([features.context[features.whose], cells]))
        if self.config.uses_traces:
            self.net.trace.fit_scale(self.data.path_features)
        if self.config.uses_maps and self.data.map_features is not None:
            self.net.map.fit_scale(self.data.map_features)

    def _imitate(self, start: Encoder) -> None:
        """Let the tower of maps learn the places that an encoder gives the memories' paths."""
        maps, rng = self.data.map_features, seeding.rng(self.config.seed, 2)
        if start.config.uses_traces and maps is not None:
            self.net.map.fit_scale(maps)
            wanted = start.embed_paths(self.data.path_features)
            imitate(self.net.map, maps, wanted, self.config, rng)

    def save(self) -> None:
        """Write a checkpoint."""
        stream = io.BytesIO()
        torch.save(self._state(), stream)
        write_whole(self.folder / CHECKPOINT, stream.getvalue(), durable=True)

    def _state(self) -> dict[str, Any]:
        return {
            "config": config_to_json(self.config),
            "memories": len(self._paths),
            "turn": self.turn,
            "step": self.step,
            "elapsed": self.elapsed,
            "lessons": len(self.batches),
            "net": self.net.state_dict(),
            "mean": self.mean.state_dict(),
            "optimiser": self._optimiser.state_dict(),
        }

    def _take_up(self) -> None:
        """Resume from the checkpoint if there is one, else remove the log."""
        path = self.folder / CHECKPOINT
        if not path.exists():
            (self.folder / LOG).unlink(missing_ok=True)
            return
        state = torch.load(path, weights_only=True)
        if state["config"] != config_to_json(self.config) or state["memories"] != len(self._paths):
            raise EncoderError(f"{path}: of another configuration or dataset; remove it to restart")
        self.turn, self.step, self.elapsed = state["turn"], state["step"], state["elapsed"]
        self.net.load_state_dict(state["net"])
        self.mean.load_state_dict(state["mean"])
        self._optimiser.load_state_dict(state["optimiser"])
        self.batches = [ValidMemories.load(self._batch_file(k)) for k in range(state["lessons"])]
        lines = (self.folder / LOG).read_text("utf-8").splitlines(keepends=True)
        kept = [line for line in lines if json.loads(line)["turn"] <= self.turn]
        write_whole(self.folder / LOG, "".join(kept))

    def _batch_file(self, k: int) -> Path:
        return self.folder / f"lesson-{k:05d}.npz"

    def _note(self, scores: dict[str, float]) -> None:
        """Write a line of the log."""
        line = {"turn": self.turn, "step": self.step, "seconds": round(self.elapsed, 1), **scores}
        with open(self.folder / LOG, "a", encoding="utf-8") as stream:
            stream.write(json.dumps({k: _short(v) for k, v in line.items()}) + "\n")
        if self._board is not None:
            for name, value in scores.items():
                self._board.add_scalar(name, value, self.step)


def _parts(rows: np.ndarray, size: int = 8192) -> list[np.ndarray]:
    return [rows[k : k + size] for k in range(0, len(rows), size)]


def _short(value: float) -> float:
    return round(value, 5) if isinstance(value, float) else value


def _tensorboard(folder: Path) -> Any:
    """A writer for TensorBoard, if that is installed."""
    with suppress(ImportError):
        from torch.utils.tensorboard import SummaryWriter

        return SummaryWriter(str(folder / "tensorboard"))
    return None


METRICS, CARD = "metrics.json", "card.md"


def write_model(
    folder: Path, trainer: Trainer, records: Dataset, dataset: str, scores: Mapping[str, float]
) -> None:
    """Write a trained encoder, its metrics, log and card; remove the trainer's folder.

    Parameters
    ----------
    folder : Path
    trainer : Trainer
    records : Dataset
        Dataset of the training.
    dataset : str
        Name by which the dataset was given.
    scores : mapping
        Shares of held-out situations by name, see `TransferLabels.validate`.
    """
    encoder = trainer.encoder
    save_encoder(encoder, folder)
    about = {
        "key": encoder.key,
        "seed": trainer.config.seed,
        "lessons": len(trainer.batches),
        "steps": trainer.step,
        "seconds": round(trainer.elapsed, 1),
        "memories": len(trainer.data.path_features),
        "dataset": {"name": records.spec.name, **_origin(records)},
        "validation": {name: round(value, 4) for name, value in scores.items()},
    }
    write_whole(folder / METRICS, json.dumps(about, indent=1) + "\n")
    write_whole(folder / LOG, (trainer.folder / LOG).read_bytes())
    write_whole(folder / CARD, _card(trainer, records, dataset, scores))
    shutil.rmtree(trainer.folder, ignore_errors=True)


def _origin(records: Dataset) -> dict[str, str]:
    """Return the hashes of the specification and, of a finished dataset, of the dataset."""
    manifest = records.manifest
    origin = {"spec": records.spec.digest}
    if manifest is not None and manifest["complete"]:
        origin["hash"] = manifest["hash"]
    return origin


def _start(trainer: Trainer) -> str:
    start = trainer.start
    return "weights at random" if start is None else f"the weights of encoder `{start.key}`"


def _card(trainer: Trainer, records: Dataset, dataset: str, scores: Mapping[str, float]) -> str:
    config, encoder = trainer.config, trainer.encoder
    effort = trainer.effort
    length = f"--time {effort.minutes:g}min" if effort.turns is None else f"--turns {effort.turns}"
    origin = ", ".join(f"{name} `{value}`" for name, value in _origin(records).items())
    rows = "\n".join(f"| {name} | {value:.1%} |" for name, value in scores.items())
    return f"""# Encoder `{encoder.key}`

Embeds situations, from what is known at t = 0, and memories, by their {config.memory}, in
{config.dim} numbers: the larger the inner product, the more likely the memory, adapted to the
situation, catches in it.

| | |
|---|---|
| command | `gcm-learn train encoder {dataset} --out DIR {length} --dim {config.dim} \
--memory {config.memory} --seed {config.seed}` |
| starts from | {_start(trainer)} |
| data | dataset `{records.spec.name}`, {origin}; {len(trainer.data.path_features)} memories |
| training | {len(trainer.batches)} lessons, {trainer.step} steps, {trainer.elapsed / 60:.0f} min |
| seed | {config.seed} |

Share of held-out situations (split `validation`) in which one of the first memories is valid, of
those that it was trained on, nothing left out of the list as a twin of a failure:

| stratum and place | share |
|---|---|
{rows}

**Limits.** It knows the families of that dataset and {config.kind.plural} like those there; the
nearest target only. What it proposes is verified before it is acted on.
"""
