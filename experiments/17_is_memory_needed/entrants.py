"""Methods that are asked, each made in its turn."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

import numpy as np
from answers import CHECKS, Answer, Ask, Entrant, among_equals, by
from lessons import drawn_from, experience
from regressor import by_regressor, regressor, told
from trainings import FEW, PROTOTYPES, REST, SEEDS, SIZES, STILL, WHOLE

from experiments.common.questions import Question
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


def equal(
    records: Dataset, out: Path, seeds: Sequence[int] = SEEDS, sizes: Sequence[int] = SIZES
) -> Iterator[Entrant]:
    """Yield the same N catches, filed by their own encoder, by raw parameters and at random."""
    for seed in seeds:
        for size in sizes:
            filed = partial(_filed, records, size, seed)
            yield Entrant(f"raw-{size}", seed, partial(filed, "raw"))
            if seed == seeds[0]:
                yield Entrant(f"random-{size}", seed, partial(filed, RandomIndex()))
            yield encoded(f"learned-{size}", out, f"strict-{size}", seed)


def _filed(records: Dataset, size: int, seed: int, index: Index | str) -> Ask:
    return by(remember(experience(drawn_from(records, size), size, seed), index))


def encoded(method: str, out: Path, name: str, seed: int, index: Index | None = None) -> Entrant:
    """Return the memories that an encoder was trained on, filed by it or by another index."""
    folder = out / "encoders" / f"{name}-{seed}"
    return Entrant(method, seed, lambda: by(paths_of(folder, index)))


def needed(records: Dataset, out: Path) -> Iterator[Entrant]:
    """Yield substitutes for a memory, learned from the same labels."""
    for seed in FEW:
        name = f"prototypes-{PROTOTYPES}"
        yield encoded("prototypes", out, name, seed)
        yield encoded("prototypes, random", out, name, seed, RandomIndex())
        yield Entrant("regressor", seed, partial(_regressor, out, seed))


def resting(records: Dataset, out: Path) -> Iterator[Entrant]:
    """Yield encoders and memories of situations at rest, and of the same amount in motion."""
    for seed in REST:
        yield encoded("at rest", out, f"still-{STILL}", seed)
        yield encoded("in motion", out, f"strict-{STILL}", seed)


def shipped(records: Dataset, out: Path) -> Iterator[Entrant]:
    """Yield the memory that is shipped and its controls."""
    yield from with_controls(shipped_memory("recall"))
    yield Entrant("splines", None, lambda: splines)


def with_controls(memory: Memory) -> Iterator[Entrant]:
    """Yield a memory, and the same filed otherwise."""
    raw = RawIndex.fit(memory.situations())
    family = partial(among_equals, memory, lambda q: q.family, 0)
    both = partial(among_equals, memory, lambda q: f"{q.family}/{q.stratum}", -1)
    yield Entrant("shipped", None, lambda: by(memory))
    yield Entrant("shipped-raw", None, lambda: by(memory.refiled(raw)))
    yield Entrant("shipped-random", None, lambda: by(memory.refiled(RandomIndex())))
    yield Entrant("shipped-family", None, family)
    yield Entrant("shipped-family-stratum", None, both)


def splines(question: Question, checks: int) -> Answer:
    """Try random movements; all are checked if none is valid."""
    return Answer(SplinesPlanner(checks).plan(question.situation), CHECKS)


def paths_of(folder: Path, by_other: Index | None = None) -> Memory:
    """Return the memories that an encoder was trained on, filed by it or by another index."""
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
