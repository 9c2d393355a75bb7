"""Trainings of encoders: all take the same number of turns, one after the other."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
from lessons import (
    MOST,
    Prototypes,
    Still,
    Strict,
    drawn_from,
    experience,
    medoids,
    trained,
    with_validation,
)

from gcm_learn import dataset
from gcm_learn.recall import TransferLabels

TURNS = 25
SIZES = (1000, 3000, 10_000, 30_000)
WHOLE = 10_000  # catches of memories that others stand in for
SEEDS = (0, 1, 2, 3, 4)
PROTOTYPES = 100
STILL = 3000
FEW = (0, 1)  # seeds of what is no claim of its own
REST = (0, 1, 2)  # of what learns at rest


def names() -> list[str]:
    """Return all trainings, what matters most first."""
    small, middle, large, most = SIZES
    strict = [(large, 0), (middle, 0), (small, 0)]
    strict += [(size, seed) for seed in (1, 2) for size in (large, small)]
    strict += [(large, 3), (large, 4), (middle, 1), (middle, 2)]
    rest = [(size, seed) for seed in (3, 4) for size in (small, middle)]
    found = [f"strict-{size}-{seed}" for size, seed in strict]
    found += [f"prototypes-{PROTOTYPES}-0", *(f"still-{STILL}-{seed}" for seed in REST)]
    found += [f"strict-{size}-{seed}" for size, seed in rest]
    found += [f"prototypes-{PROTOTYPES}-{seed}" for seed in FEW[1:]]
    return found + [f"strict-{most}-{seed}" for seed in SEEDS]


def data_of(name: str, records: dataset.Dataset) -> TransferLabels:
    """Return the lessons of a training."""
    kind, size, seed = name.split("-")
    count = {"still": MOST, "prototypes": WHOLE}.get(kind, int(size))
    some = drawn_from(records, count)
    seen = with_validation(experience(some, count, int(seed)), some)
    if kind == "still":
        return Still(seen, int(seed), int(size))
    if kind == "prototypes":
        whole = Strict(seen, int(seed))
        kept = medoids(whole.path_features, int(size), int(seed))
        return Prototypes(seen, int(seed), kept)
    return Strict(seen, int(seed))


def train(name: str, folder: Path, out: Path, turns: int = TURNS) -> None:
    """Train one of them, and keep the memories that it was trained on."""
    data = data_of(name, dataset.open(folder))
    place = out / "encoders" / name
    trained(data, int(name.split("-")[2]), place, turns, out / "work" / name)
    np.savez(place / "paths.npz", knots=data.knots, goals=data.goals)


def train_all(folder: Path, out: Path) -> None:
    """Train what is missing, each in a process of its own."""
    script = ("-m", "experiments", Path(__file__).parent.name)
    for name in names():
        if not (out / "encoders" / name / "paths.npz").exists():
            call = [sys.executable, *script, str(folder), "train", "--name", name]
            subprocess.run(call, check=True)
