"""Equal experience in space: the catches are read once, encoders learn from N of them alone."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from lessons import PICK, Prototypes, Strict, medoids, trained

from gcm_learn import seeding
from gcm_learn.arms import SPATIAL
from gcm_learn.dataset import Dataset
from gcm_learn.processes import Here
from gcm_learn.recall import MEMORIES, raw_features
from gcm_learn.recall.growth import catch_of
from gcm_learn.recall.transfer_labels import EASY, Sizes, TransferLabels
from gcm_learn.storage import write_whole

MOVEMENTS = MEMORIES.of(SPATIAL)
SIZES_OF_BATCHES = Sizes(situations=256, any=64)
"""Half of the package's situations, and two fifths of its memories."""
TURNS = 24
SIZES = (1000, 3000, 10_000, 30_000)
SEEDS = (0, 1, 2, 3, 4)
PROTOTYPES, OF = 100, 10_000
"""Prototypes, and the catches that they are medoids of, whose situations their scorer sees."""
READ = 1000  # records that are read at once


class Catches(NamedTuple):
    """Catches of a dataset: all of split train that are not U, or some of them."""

    where: np.ndarray
    """Rows (n,) of the dataset."""
    knots: np.ndarray
    goals: np.ndarray
    raw: np.ndarray
    """Raw parameters of the situations (n, m)."""
    easy: np.ndarray
    """Mark (n,) bool of catches by a straight movement."""

    def part(self, count: int, seed: int) -> Catches:
        """`count` of them, drawn by a seed; fewer are among more."""
        order = seeding.rng(seed, PICK).permutation(len(self.where))[:count]
        return Catches(*(column[np.sort(order)] for column in self))


def catches_of(records: Dataset, file: Path) -> Catches:
    """Read the catches, or the file in which they are kept."""
    if not file.exists():
        rows = np.flatnonzero(
            (records.column("split") == "train") & (records.column("stratum") != "U")
        )
        parts = []
        for first in range(0, len(rows), READ):
            parts += _read(records, rows[first : first + READ])
        columns = [np.array(column) for column in zip(*parts, strict=True)]
        stream = io.BytesIO()
        np.savez(stream, *columns)
        file.parent.mkdir(parents=True, exist_ok=True)
        write_whole(file, stream.getvalue())
    with np.load(file) as kept:
        return Catches(*(kept[f"arr_{k}"] for k in range(len(Catches._fields))))


def _read(records: Dataset, rows: np.ndarray) -> list[tuple]:
    """Rows of `Catches`; some are caught by the yardstick alone, and are left out."""
    found = []
    for row, record in zip(rows.tolist(), records[rows], strict=True):
        path = catch_of(record)
        if path is not None:
            raw = raw_features(record.situation)
            found.append((row, path.knots, path.goal, raw, record.stratum == "L"))
    return found


class Told(Strict):
    """`Strict` lessons of catches that were read before: only situations are left to read.

    Parameters
    ----------
    experience : (Dataset, Catches, list)
        Where the situations are, the catches to learn from, and what to validate with.
    seed : int
    """

    def __init__(self, experience: tuple[Dataset, Catches, list[Any]], seed: int) -> None:
        records, some, self._exam = experience
        self.spec, self.seed, self.crew, self.kind = records.spec, seed, Here(), MOVEMENTS
        self.sizes = SIZES_OF_BATCHES
        self.knots, self.goals = some.knots, some.goals
        self.path_features = MOVEMENTS.path_features(self.knots, self.goals)
        self.map_features = None
        lots = seeding.rng(seed, PICK, 1)
        self._order = np.flatnonzero(~some.easy | (lots.random(len(some.easy)) < EASY))
        self._again()
        used = np.unique(self._order[: TURNS * self.sizes.others])
        read = zip(used.tolist(), records[some.where[used]], strict=True)
        self.situations = {k: record.situation for k, record in read}  # type: ignore[assignment]


class Few(Prototypes, Told):
    """`Prototypes` of such catches."""


def names() -> list[str]:
    """All trainings, one seed after the other."""
    kinds = [*(f"strict-{size}" for size in SIZES), f"prototypes-{PROTOTYPES}"]
    return [f"{kind}-{seed}" for seed in SEEDS for kind in kinds]


def train_all(some: list[str], records: Dataset, out: Path) -> None:
    """Train what is missing of some, one after the other."""
    whole = catches_of(records, out / "catches.npz")
    held = Held(records)
    for name in some:
        if not (out / "encoders" / name / "paths.npz").exists():
            _train(name, (records, whole, held.exam), out)


class Held(TransferLabels):
    """Situations for validation, read once."""

    def __init__(self, records: Dataset) -> None:
        self._held = records.where(split="validation")
        self.exam = [(r.stratum, r.situation) for r in self._examined()]


def _train(name: str, experience: tuple[Dataset, Catches, list[Any]], out: Path) -> None:
    """Train one of them, and keep the memories that it was trained on."""
    kind, size, seed = name.split("-")
    records, whole, exam = experience
    if kind == "strict":
        data: Strict = Told((records, whole.part(int(size), int(seed)), exam), int(seed))
    else:
        some = whole.part(OF, int(seed))
        kept = medoids(MOVEMENTS.path_features(some.knots, some.goals), int(size), int(seed))
        data = Few((records, some, exam), int(seed), kept)
    place = out / "encoders" / name
    trained(data, int(seed), place, TURNS, out / "work" / name)
    np.savez(place / "paths.npz", knots=data.knots, goals=data.goals)
