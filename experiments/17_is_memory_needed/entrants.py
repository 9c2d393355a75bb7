"""Everybody who is asked, by name; made when it is their turn."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import numpy as np
from answers import CHECKS, Answer, Ask, among_equals, by
from lessons import drawn_from, experience
from regressor import by_regressor, regressor, told
from trainings import FEW, LONG, PROTOTYPES, REST, SEEDS, SIZES, STILL, WHOLE

from experiments.common.questions import Question
from gcm_learn import dataset
from gcm_learn.dataset import Dataset
from gcm_learn.recall import (
    Index,
    LearnedIndex,
    Memory,
    RandomIndex,
    RawIndex,
    SplinesPlanner,
    Waypoints,
    load_encoder,
    remember,
    shipped_memory,
)

STEPS = 750  # of the regressor's optimiser: as many as an encoder takes
Make = Callable[[], Ask]


def equal(records: Dataset, out: Path) -> Iterator[tuple[str, Make]]:
    """The same N catches, asked by the encoder that saw no others, by raw parameters, at random."""
    for seed in SEEDS:
        for size in SIZES:
            some = partial(_catches, records, size, seed)
            yield f"raw-{size}-{seed}", lambda some=some: by(remember(some(), "raw"))
            if seed == SEEDS[0]:
                yield f"random-{size}-{seed}", lambda some=some: by(remember(some(), RandomIndex()))
            folder = out / "encoders" / f"strict-{size}-{seed}"
            yield f"learned-{size}-{seed}", lambda folder=folder: by(paths_of(folder))


def longer(records: Dataset, out: Path) -> Iterator[tuple[str, Make]]:
    """Encoders that learned five times as long, beside the same catches by the others."""
    for seed in REST:
        for size in LONG:
            some = partial(_catches, records, size, seed)
            yield f"raw-{size}-{seed}", lambda some=some: by(remember(some(), "raw"))
            for name, kind in (("learned", "strict"), ("long", "long")):
                folder = out / "encoders" / f"{kind}-{size}-{seed}"
                yield f"{name}-{size}-{seed}", lambda folder=folder: by(paths_of(folder))


def _catches(records: Dataset, size: int, seed: int) -> Dataset:
    return experience(drawn_from(records, size), size, seed)


def needed(records: Dataset, out: Path) -> Iterator[tuple[str, Make]]:
    """Substitutes for a memory, learned from the same labels."""
    for seed in FEW:
        folder = out / "encoders" / f"prototypes-{PROTOTYPES}-{seed}"
        yield folder.name, lambda folder=folder: by(paths_of(folder))
        yield f"{folder.name}-random", lambda folder=folder: by(paths_of(folder, RandomIndex()))
    for seed in FEW:
        yield f"regressor-{WHOLE}-{seed}", lambda seed=seed: _regressor(out, seed)


def resting(records: Dataset, out: Path) -> Iterator[tuple[str, Make]]:
    """Encoders and memories of situations in which nothing moves, and of those as they were."""
    for seed in REST:
        name = f"still-{STILL}-{seed}"
        yield name, lambda name=name: by(paths_of(out / "encoders" / name))
        twin = f"strict-{STILL}-{seed}"
        yield f"moving-{STILL}-{seed}", lambda twin=twin: by(paths_of(out / "encoders" / twin))


def shipped(records: Dataset, out: Path) -> Iterator[tuple[str, Make]]:
    """The memory that is shipped and its controls."""
    yield from with_controls(shipped_memory("recall"))
    yield "splines", lambda: splines


def with_controls(memory: Memory) -> Iterator[tuple[str, Make]]:
    """A memory, and the same asked otherwise."""
    yield "shipped", lambda: by(memory)
    yield "shipped-raw", lambda: by(memory.refiled(RawIndex.fit(memory.situations())))
    yield "shipped-random", lambda: by(memory.refiled(RandomIndex()))
    yield "shipped-family", lambda: among_equals(memory, lambda q: q.family, 0)
    both = among_equals(memory, lambda q: f"{q.family}/{q.stratum}", -1)
    yield "shipped-family-stratum", lambda: both


def splines(question: Question, checks: int) -> Answer:
    """Random movements; they are all checked if none is valid."""
    return Answer(SplinesPlanner(checks).plan(question.situation), CHECKS)


def paths_of(folder: Path, by_other: Index | None = None) -> Memory:
    """The memories that an encoder was trained on, filed by it; their situations are not kept."""
    index = by_other or LearnedIndex(load_encoder(folder))
    with np.load(folder / "paths.npz") as file:
        knots, goals = file["knots"], file["goals"]
    paths = [Waypoints(k, g) for k, g in zip(knots, goals, strict=True)]
    return Memory.of(index, index.embed_memories([], paths), knots, goals)


def _regressor(out: Path, seed: int) -> Ask:
    name = f"strict-{WHOLE}-{seed}"
    with np.load(out / "encoders" / name / "paths.npz") as file:
        paths = told(file["knots"], file["goals"])
    return by_regressor(regressor(out / "work" / name, paths, seed, STEPS))


def opened(folder: Path) -> Dataset:
    """The records."""
    return dataset.open(folder)
