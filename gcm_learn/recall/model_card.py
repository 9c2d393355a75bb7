"""An encoder as a model: its files, how it learned, and a card that tells where it comes from."""

from __future__ import annotations

import json
import shutil
from collections.abc import Mapping
from pathlib import Path

from gcm_learn.dataset import Dataset
from gcm_learn.recall.encoder_files import save_encoder
from gcm_learn.recall.training import LOG, Trainer
from gcm_learn.storage import write_whole

METRICS, CARD = "metrics.json", "card.md"


def write_model(
    folder: Path,
    trainer: Trainer,
    records: Dataset,
    dataset: str,
    marks: Mapping[str, float],
) -> None:
    """Write a trained encoder, its log and its card; what it took to go on is removed.

    Parameters
    ----------
    folder : Path
    trainer : Trainer
    records : Dataset
        What it was trained on.
    dataset : str
        How that was named.
    marks : mapping
        Shares of held-out situations by name, see `School.exam`.
    """
    encoder = trainer.encoder
    save_encoder(encoder, folder)
    about = {
        "key": encoder.key,
        "seed": trainer.config.seed,
        "lessons": len(trainer.lessons),
        "steps": trainer.step,
        "seconds": round(trainer.elapsed, 1),
        "memories": len(trainer.teacher.ways),
        "dataset": {"name": records.spec.name, **_origin(records)},
        "validation": {name: round(value, 4) for name, value in marks.items()},
    }
    write_whole(folder / METRICS, json.dumps(about, indent=1) + "\n")
    write_whole(folder / LOG, (trainer.folder / LOG).read_bytes())
    write_whole(folder / CARD, _card(trainer, records, dataset, marks))
    shutil.rmtree(trainer.folder, ignore_errors=True)


def _origin(records: Dataset) -> dict[str, str]:
    """Hashes that tell which dataset it was; one that is not finished has none of its own."""
    manifest = records.manifest
    origin = {"spec": records.spec.digest}
    if manifest is not None and manifest["complete"]:
        origin["hash"] = manifest["hash"]
    return origin


def _start(trainer: Trainer) -> str:
    start = trainer.start
    return "weights at random" if start is None else f"the weights of encoder `{start.key}`"


def _card(trainer: Trainer, records: Dataset, dataset: str, marks: Mapping[str, float]) -> str:
    config, encoder = trainer.config, trainer.encoder
    effort = trainer.effort
    length = f"--minutes {effort.minutes:g}" if effort.turns is None else f"--turns {effort.turns}"
    origin = ", ".join(f"{name} `{value}`" for name, value in _origin(records).items())
    rows = "\n".join(f"| {name} | {value:.1%} |" for name, value in marks.items())
    return f"""# Encoder `{encoder.key}`

Embeds situations, from what is known at t = 0, and memories, by their {config.memory}, in
{config.dim} numbers: the larger the inner product, the more likely the memory, bent to the
situation, catches in it.

| | |
|---|---|
| command | `gcm-learn train-encoder {dataset} --out DIR {length} --dim {config.dim} \
--memory {config.memory} --seed {config.seed}` |
| starts from | {_start(trainer)} |
| data | dataset `{records.spec.name}`, {origin}; {len(trainer.teacher.ways)} memories |
| training | {len(trainer.lessons)} lessons, {trainer.step} steps, {trainer.elapsed / 60:.0f} min |
| seed | {config.seed} |

Share of held-out situations (split `validation`) in which one of the first memories holds, of the
memories that it was trained on, nothing left out of the list as a twin of a failure:

| stratum and place | share |
|---|---|
{rows}

**Limits.** It knows the families of that dataset and arms without joint limits; the nearest target
only. What it proposes is verified before it is acted on.
"""
