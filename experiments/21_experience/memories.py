"""Stored catches and synthetic movements, each in three orders, before the same search."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from worlds import OUT, World

from gcm_learn.arms import PLANAR
from gcm_learn.planners import TreeSearch, get_planner
from gcm_learn.recall import (
    EncoderConfig,
    HybridPlanner,
    LearnedIndex,
    Memory,
    RandomIndex,
    RecallPlanner,
    Sizes,
    TransferLabels,
    load_encoder,
    remember,
    save_encoder,
    shipped_memory,
)
from gcm_learn.recall.training import Effort, Trainer

TURNS = 12  # lessons of every encoder
LESSON = Sizes(256, 80)  # of labels; a try is dear under limits of acceleration
SOURCES = ("stored", "synthetic")
SEED = 0  # of synthetic movements, and of the random order


class Method(NamedTuple):
    """Planner of a comparison."""

    name: str
    seed: int
    """Seed of the training, 0 without one."""
    planner: Any
    hurried: bool
    """True if it is also asked with the smaller budget."""


def encoder_folder(world: World, source: str, seed: int) -> Path:
    """Return the folder of an encoder."""
    return OUT / "encoders" / world.spec / f"{source}-{seed}"


def train(world: World, source: str, seed: int) -> None:
    """Train an encoder on the movements of one source alone."""
    folder, records = encoder_folder(world, source, seed), world.records_of_memory
    config = EncoderConfig(seed=seed, arm=records.spec.kind.name)
    labels = TransferLabels(records, seed, synthetic=source == "synthetic", sizes=LESSON)
    trainer = Trainer(config, labels, folder / "work.tmp", Effort(turns=TURNS))
    trainer.run()
    save_encoder(trainer.encoder, folder)


def train_all(world: World) -> None:
    """Train the encoders that are missing."""
    for seed in range(1, world.seeds + 1):
        for source in SOURCES:
            if not (encoder_folder(world, source, seed) / "config.json").exists():
                train(world, source, seed)
                print(world.name, source, seed, flush=True)


def without_memory(world: World) -> Any:
    """Return the fastest search of a world's arm."""
    return get_planner("layered") if world.records_of_memory.spec.kind is PLANAR else TreeSearch()


@cache
def movements(world: World) -> dict[str, Memory]:
    """Return as many synthetic movements as stored catches, in no order yet."""
    some = world.records_of_memory
    found = {
        source: remember(some, RandomIndex(), synthetic=source == "synthetic", seed=SEED)
        for source in SOURCES
    }
    least = min(map(len, found.values()))
    for memory in found.values():
        drawn = np.random.default_rng(SEED).permutation(len(memory))
        memory.forget(np.sort(drawn[least:]))
    return found


def methods(world: World) -> Iterator[Method]:
    """Yield all methods of a world; only movements and their order differ."""
    search, shipped = without_memory(world), shipped_memory("recall", world_kind(world))
    yield Method("search", 0, search, True)
    for source, memory in movements(world).items():
        yield Method(f"{source}, random", 0, _before(search, memory), True)
        order = memory.refiled(shipped.index)
        yield Method(f"{source}, shipped", 0, _before(search, order), False)
        for seed in range(1, world.seeds + 1):
            encoder = load_encoder(encoder_folder(world, source, seed))
            order = memory.refiled(LearnedIndex(encoder))
            yield Method(f"{source}, learned", seed, _before(search, order), seed == 1)


def world_kind(world: World) -> Any:
    """Return the kind of a world's arm."""
    return world.records_of_memory.spec.kind


def _before(search: Any, memory: Memory) -> HybridPlanner:
    return HybridPlanner(RecallPlanner(memory), fallback=search)
